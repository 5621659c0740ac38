//! The wander of friction: its likelihood against the whole covariance, the rate that is found, evidence of any size.

use super::free::{Life, WORLDS, assess, geared};
use super::friction::TRAVEL;
use crate::sensing::Drive;
use crate::sensing::friction::{Assessment, Evidence, Friction, Hypothesis, Pass, RATES, TIMES};

/// Cholesky's factor, f64.
fn cholesky(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = matrix.len();
    let mut factor = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            factor[i][j] = if i == j {
                (matrix[i][i] - sum).sqrt()
            } else {
                (matrix[i][j] - sum) / factor[j][j]
            };
        }
    }
    factor
}

fn solve_lower(factor: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
    let mut solved = Vec::new();
    for i in 0..values.len() {
        let sum: f64 = (0..i).map(|k| factor[i][k] * solved[k]).sum();
        solved.push((values[i] - sum) / factor[i][i]);
    }
    solved
}

/// Restricted likelihood with the whole covariance matrix, f64: bins of three blocks, 13 regressors. What means over bins lack of the
/// wander's variance is the rational function, as on the chip: it is tested by itself. The first sixteenth of the bins is
/// left out.
fn exact(values: &[f64], white: (f64, f64), block_s: f64, point: Hypothesis) -> f64 {
    // Positions count on all bins.
    let last = values.len() - 1;
    let skipped = last / 16;
    let values = &values[skipped..];
    let n = values.len();
    let growth = f64::from(point.rate_per_s2) * block_s * block_s;
    let time = f64::from(point.time_s);
    let stationary = 0.5 * growth * time / block_s;
    let phi = (1.0 - 1.5 * block_s / time) / (1.0 + 1.5 * block_s / time);
    let averaged = 3.0 * block_s / time;
    let own = 1.0 / 3.0 - stationary * averaged / (3.0 + averaged);
    let covariance: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| {
                    stationary * phi.powi(i.abs_diff(j) as i32) + if i == j { own } else { 0.0 }
                })
                .collect()
        })
        .collect();
    let factor = cholesky(&covariance);
    let columns: Vec<Vec<f64>> = (0..13)
        .map(|c| {
            let column: Vec<f64> = (0..n)
                .map(|i| {
                    let bin = (skipped + i) as f64;
                    let x = 2.0 * bin / last as f64 - 1.0;
                    let worm = std::f64::consts::TAU * 3.0 * bin / 64.0;
                    match c {
                        0..=4 => x.powi(c),
                        _ if c % 2 == 1 => (f64::from((c - 3) / 2) * worm).cos(),
                        _ => (f64::from((c - 4) / 2) * worm).sin(),
                    }
                })
                .collect();
            solve_lower(&factor, &column)
        })
        .collect();
    let y = solve_lower(&factor, values);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let normal: Vec<Vec<f64>> = columns
        .iter()
        .map(|a| columns.iter().map(|b| dot(a, b)).collect())
        .collect();
    let right: Vec<f64> = columns.iter().map(|a| dot(a, &y)).collect();
    let inner = cholesky(&normal);
    let explained = solve_lower(&inner, &right);
    let ln_determinants: f64 = (0..n).map(|i| 2.0 * factor[i][i].ln()).sum::<f64>()
        + (0..13).map(|i| 2.0 * inner[i][i].ln()).sum::<f64>();
    let (square, freedoms) = white;
    let seen = 1.0 + growth / 6.0;
    let all = n as f64 - 13.0 + freedoms;
    let sum = dot(&y, &y) - dot(&explained, &explained) + freedoms * square / seen;
    -0.5 * (all * (sum / all).ln() + ln_determinants + freedoms * seen.ln())
}

#[test]
fn the_likelihood_in_steps_is_that_of_the_whole_covariance() {
    for (seed, world) in WORLDS.iter().enumerate() {
        let mut life = Life::new(*world, 40 + seed as u64);
        let block_s = life.block_s();
        let friction = Friction::empty(TRAVEL, &geared());
        assert_eq!(friction.bin_counts, 3 * 1024);
        // From the first whole bin on; the last two blocks are held back.
        let mut pass = Pass::new(Drive::Closing);
        let (mut blocks, bins) = (Vec::new(), 90);
        for index in 18..18 + 3 * bins + 2 {
            let block = life.block(Drive::Closing, index, 0.0);
            pass.push(&friction, block.counts, &block, 0.0);
            blocks.push(f64::from(block.drive_torque_nm));
        }
        blocks.truncate(3 * bins as usize);
        let values: Vec<f64> = blocks
            .chunks(3)
            .map(|bin| bin.iter().sum::<f64>() / 3.0)
            .collect();
        let squares: Vec<f64> = blocks
            .windows(3)
            .map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0)
            .collect();
        let white = squares.iter().sum::<f64>() / squares.len() as f64;
        let white = (white, squares.len() as f64 * 18.0 / 35.0);
        let mut assessment = Assessment::new(pass, &friction).unwrap();
        while !assessment.step(&friction) {}
        let told = assessment.evidence().ln_likelihood;
        let exact: Vec<f64> = (0..RATES * TIMES)
            .map(|index| exact(&values, white, block_s, Hypothesis::of(index)))
            .collect();
        for index in 0..RATES * TIMES {
            let told = f64::from(told[index] - told[0]);
            let exact = exact[index] - exact[0];
            assert!(
                (told - exact).abs() < 0.03 + 1e-3 * exact.abs(),
                "{world:?} {index}: {told} {exact}"
            );
        }
    }
}

#[test]
fn the_rate_of_the_wander_is_found_from_one_closing_and_opening() {
    for world in &WORLDS {
        // Of the variance of the difference of two blocks, the share that is the wander's.
        let each = |seed: u64| {
            let record = Life::new(*world, 9000 + seed).record();
            let mean = record.evidence.mean();
            f64::from(mean.rate_per_s2 * record.white_nm2_s).ln()
        };
        let rates: Vec<f64> = (0..24).map(each).collect();
        let found = rates.iter().sum::<f64>() / 24.0;
        let squares = rates.iter().map(|rate| (rate - found).powi(2));
        let scatter = (squares.sum::<f64>() / 24.0).sqrt();
        let size = world.wander * super::free::FRICTION_NM;
        let truth = (2.0 * size * size / world.time_s).max(1e-12).ln();
        // The mean of a posterior lies above: false contacts cost more than milliseconds.
        if world.wander > 0.015 {
            // Much less than the grid's steps, the logarithm of four.
            assert!(scatter < 0.3, "{world:?}: {scatter}");
        }
        if world.wander > 0.0 {
            // The mean of 24; single ones scatter by 0.2 to 0.8.
            assert!(
                (-0.1..0.4).contains(&(found - truth)),
                "{world:?}: {found} {truth}"
            );
        } else {
            assert!(found < (2.0 * 3e-4f64.powi(2)).ln(), "{world:?}: {found}");
        }
    }
}

#[test]
fn evidence_grows_with_passes_and_survives_nonsense() {
    let mut life = Life::new(WORLDS[4], 3);
    let mut record = life.record();
    for _ in 0..6 {
        let pass = life.pass(Drive::Closing, &record);
        assess(pass, &mut record);
    }
    assert_eq!(record.passes(), 7);
    assert!(record.is_valid());
    let size = 0.03 * super::free::FRICTION_NM;
    let wander = record.wander(0.3);
    let rate = f64::from(wander.rms_nm).powi(2) / f64::from(wander.time_s);
    let truth = size * size * (1.0 + 1.0 / 7.0);
    assert!((0.5..2.0).contains(&(rate / truth)), "{rate} {truth}");
    let before = record.evidence;
    record.evidence.add(&Evidence {
        ln_likelihood: [f32::NAN; RATES * TIMES],
    });
    assert_eq!(before, record.evidence);
}

#[test]
fn any_evidence_has_a_mean_within_its_grid() {
    let mut noise = super::Noise(77);
    for round in 0..20_000u32 {
        // From flat ones to the largest numbers, smooth and not.
        let size = 10.0f32.powf((round % 40) as f32 - 2.0);
        let mut level = 0.0;
        let smooth = round % 2 == 0;
        let ln_likelihood = core::array::from_fn(|_| {
            let step = size * noise.normal();
            level = if smooth { level + step } else { step };
            level.clamp(-f32::MAX, f32::MAX)
        });
        let mean = Evidence { ln_likelihood }.mean();
        let [least, most] = [Hypothesis::of(0), Hypothesis::of(RATES * TIMES - 1)];
        let rates = 0.5 * least.rate_per_s2..2.0 * most.rate_per_s2;
        let times = 0.999 * least.time_s..1.001 * most.time_s;
        assert!(
            rates.contains(&mean.rate_per_s2) && times.contains(&mean.time_s),
            "{ln_likelihood:?}: {mean:?}"
        );
    }
}
