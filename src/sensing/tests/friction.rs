use super::Noise;
use super::free::{BLOCKS, FIRST, Life, WORLDS, assess, curve, geared};
use crate::sensing::block::Block;
use crate::sensing::friction::{
    Assessment, Evidence, Friction, HARMONICS, Hypothesis, Pass, RATES, TIMES,
};
use crate::sensing::{Drive, sensor};

pub(super) const TRAVEL: i32 = 312_890;

pub(super) fn block(drive: Drive, counts: i32, torque_nm: f32) -> Block {
    Block {
        emf_v: f32::NAN,
        time_us: 0,
        drive,
        counts,
        width_counts: 1024,
        way_counts: i32::MAX,
        duration_s: 0.0164,
        drive_torque_nm: torque_nm,
        inertia_nm: 0.0,
        overspeed: 0.0,
    }
}

/// Blocks of a pass as a function of the position has them.
fn pass_of(record: &Friction, drive: Drive, torque_nm: impl Fn(f64) -> f64) -> Pass {
    let mut pass = Pass::new(drive);
    for index in FIRST..FIRST + BLOCKS {
        let counts = 1024 * index + 512;
        let torque_nm = torque_nm(f64::from(counts)) as f32;
        // What is recorded is the closing's.
        let known = record.at(counts).filter(|_| drive == Drive::Closing);
        let known = known.map_or(0.0, |known| known.torque_nm);
        pass.push(record, counts, &block(drive, counts, torque_nm), known);
    }
    pass
}

pub(super) fn record(sigma: f64, seed: u64) -> Friction {
    let mut record = Friction::empty(TRAVEL, &geared());
    let noise = std::cell::RefCell::new(Noise(seed));
    let torque = |counts: f64| curve(counts) + sigma * f64::from(noise.borrow_mut().normal());
    let pass = pass_of(&record, Drive::Closing, torque);
    assess(pass, &mut record);
    record
}

#[test]
fn what_closing_takes_more_than_opening_is_found() {
    let mut record = Friction::empty(TRAVEL, &geared());
    let rad_per_count = f64::from(record.rad_per_count);
    let rad = |counts: f64| counts * rad_per_count;
    let more = |counts: f64| 0.02 * rad(counts).cos() - 0.03 * rad(counts).sin();
    let closing = pass_of(&record, Drive::Closing, |counts| {
        curve(counts) + more(counts)
    });
    assess(closing, &mut record);
    // What opens the finger is measured against the motion.
    let opening = pass_of(&record, Drive::Opening, |counts| -curve(counts));
    assess(opening, &mut record);
    for counts in middles() {
        let error = f64::from(record.asymmetry(counts)[0]) - more(f64::from(counts));
        assert!(error.abs() < 3e-4, "{counts}: {error}");
    }
}

fn middles() -> impl Iterator<Item = i32> {
    (1024 * (FIRST + 2)..1024 * (FIRST + BLOCKS - 4)).step_by(333)
}

#[test]
fn a_record_follows_the_friction() {
    let friction = record(0.0, 1);
    for counts in middles() {
        let error = f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 2e-4, "{counts}: {error}");
    }
    assert_eq!(friction.at(-1), None);
    assert_eq!(friction.at(TRAVEL), None);
    assert!(friction.is_valid());
    let speed = 1024.0 * geared().rad_per_count / 0.0164;
    assert!((friction.speed_rad_per_s / speed - 1.0).abs() < 1e-3);
}

/// Digits of the adjugate cancel most at the ends, where all bins lie on one side of the place.
#[test]
fn a_quadratic_is_kept_to_the_ends() {
    let mut record = Friction::empty(TRAVEL, &geared());
    (record.speed_rad_per_s, record.white_nm2_s) = (0.3, 1e-8);
    let bin = f64::from(record.bin_counts);
    let quadratic = |counts: f64| {
        let x = counts / f64::from(TRAVEL);
        0.055 + 0.03 * x - 0.1 * x * x
    };
    for index in 5..100 {
        record.closing_nm.mean[index] = quadratic((index as f64 + 0.5) * bin) as f32;
        record.closing_nm.count[index] = 3;
    }
    for counts in ((5.5 * bin) as i32 + 1..(99.5 * bin) as i32).step_by(37) {
        let found = f64::from(record.at(counts).unwrap().torque_nm);
        let off = found - quadratic(f64::from(counts));
        assert!(off.abs() < 1e-5 * 0.055, "{counts}: {off}");
    }
    // Two bins only have a mean, one its own value.
    record.closing_nm.count[7..].fill(0);
    let middle = record.at((6.0 * bin) as i32).unwrap().torque_nm;
    assert!((middle - 0.5 * (record.closing_nm.mean[5] + record.closing_nm.mean[6])).abs() < 1e-6);
    record.closing_nm.count[6] = 0;
    let alone = record.at((5.5 * bin) as i32).unwrap().torque_nm;
    assert!((alone - record.closing_nm.mean[5]).abs() < 1e-8);
}

#[test]
fn its_deviation_is_told_truly() {
    let (mut square, mut count, mut told) = (0.0, 0.0, 0.0);
    for seed in 0..60 {
        let friction = record(1.4e-3, 100 + seed);
        for counts in middles().step_by(40) {
            let known = friction.at(counts).unwrap();
            let error = f64::from(known.torque_nm) - curve(f64::from(counts));
            square += error * error / f64::from(known.variance_nm2);
            told += f64::from(known.variance_nm2);
            count += 1.0;
        }
    }
    // The curve itself bends within the smoothing; the record is four times as sharp as a block.
    let rms = (square / count).sqrt();
    assert!((0.75..1.25).contains(&rms), "{rms}");
    assert!((told / count).sqrt() < 1.4e-3 / 3.0);
}

#[test]
fn beyond_its_end_friction_goes_on_with_the_worm() {
    let friction = record(0.0, 1);
    for counts in (TRAVEL..TRAVEL + 40_000).step_by(1000) {
        let found = friction.beyond(counts).unwrap();
        assert!(found.beyond_counts > 0.0);
        let error = f64::from(found.torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 2e-3, "{counts}: {error}");
    }
    // A spring of the finger pulls on beyond.
    let spring = |counts: f64| curve(counts) + 1e-6 * counts;
    let mut sprung = Friction::empty(TRAVEL, &geared());
    assess(pass_of(&sprung, Drive::Closing, spring), &mut sprung);
    for counts in (TRAVEL..TRAVEL + 40_000).step_by(1000) {
        let error = f64::from(sprung.beyond(counts).unwrap().torque_nm) - spring(f64::from(counts));
        assert!(error.abs() < 2e-3, "{counts}: {error}");
    }
    // Before its beginning nothing was steady.
    assert_eq!(friction.beyond(5000), None);
    assert_eq!(Friction::empty(TRAVEL, &geared()).beyond(1000), None);
}

#[test]
fn what_is_not_free_is_left_out() {
    let mut friction = record(1e-3, 1);
    let before = friction.clone();
    // Slowing down in the last two blocks.
    let stop = f64::from(1024 * (FIRST + BLOCKS - 2));
    let slowing = |counts: f64| curve(counts) * if counts > stop { 0.0 } else { 1.0 };
    assess(pass_of(&before, Drive::Closing, slowing), &mut friction);
    // A contact that begins at 200,000 counts, cut off in time.
    let contact = |counts: f64| curve(counts) + 3e-6 * (counts - 200_000.0).max(0.0);
    let mut pass = pass_of(&friction, Drive::Closing, contact);
    pass.cut(&friction, 198_000);
    assess(pass, &mut friction);
    // Nonsense.
    let pass = pass_of(&friction, Drive::Closing, |_| f64::NAN);
    assert!(Assessment::new(pass, &friction).is_none());
    for counts in middles() {
        let error = f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 8e-4, "{counts}: {error}");
    }
    assert_eq!(friction.passes(), 3);
}

#[test]
fn a_pass_that_ends_early_leaves_no_step() {
    let mut friction = record(0.0, 1);
    // Friction has risen by 5 %, and the closing ends half way.
    let mut pass = pass_of(&friction, Drive::Closing, |counts| curve(counts) + 8e-3);
    pass.cut(&friction, 190_000);
    assess(pass, &mut friction);
    let shift =
        |counts: i32| f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
    for counts in middles() {
        assert!(
            (shift(counts) - 4e-3).abs() < 2e-4,
            "{counts}: {}",
            shift(counts)
        );
    }
}

#[test]
fn a_pass_that_is_too_short_teaches_nothing() {
    let friction = record(1e-3, 1);
    let mut pass = pass_of(&friction, Drive::Closing, curve);
    pass.cut(&friction, 60_000);
    assert!(Assessment::new(pass, &friction).is_none());
    assert!(Assessment::new(Pass::new(Drive::Closing), &friction).is_none());
}

#[test]
fn a_record_with_nonsense_in_it_is_not_valid() {
    let friction = record(1e-3, 9);
    assert!(friction.is_valid());
    let damages: [fn(&mut Friction); 6] = [
        |friction| friction.closing_nm.mean[3] = f32::NAN,
        |friction| friction.white_nm2_s = -1.0,
        |friction| friction.worm_nm[2 * HARMONICS - 1] = f32::INFINITY,
        |friction| friction.evidence.ln_likelihood[0] = f32::NAN,
        |friction| friction.speed_rad_per_s = 0.0,
        |friction| friction.bin_counts = 0,
    ];
    for damage in damages {
        let mut damaged = friction.clone();
        damage(&mut damaged);
        assert!(!damaged.is_valid());
    }
    assert!(
        size_of::<sensor::Sensor<crate::finger::Finger<2, crate::finger::Tendon<2>>>>() < 10_240
    );
}

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

/// Restricted likelihood with the whole covariance matrix, f64: bins of three blocks, 13 regressors.
fn exact(values: &[f64], white: (f64, f64), block_s: f64, point: Hypothesis) -> f64 {
    let n = values.len();
    let growth = f64::from(point.rate_per_s2) * block_s * block_s;
    let time = f64::from(point.time_s);
    let stationary = 0.5 * growth * time / block_s;
    let phi = (1.0 - 1.5 * block_s / time) / (1.0 + 1.5 * block_s / time);
    let covariance: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| {
                    stationary * phi.powi(i.abs_diff(j) as i32)
                        + if i == j { 1.0 / 3.0 } else { 0.0 }
                })
                .collect()
        })
        .collect();
    let factor = cholesky(&covariance);
    let columns: Vec<Vec<f64>> = (0..13)
        .map(|c| {
            let column: Vec<f64> = (0..n)
                .map(|i| {
                    let x = 2.0 * i as f64 / (n - 1) as f64 - 1.0;
                    let worm = std::f64::consts::TAU * 3.0 * i as f64 / 64.0;
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
    let seen = 1.0 + growth / 3.0;
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
        if world.wander > 0.005 {
            assert!(
                (-0.7..1.4).contains(&(found - truth)),
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
