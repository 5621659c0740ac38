use super::free::{BLOCKS, FIRST, FRICTION_NM, Life, WORLDS, World, geared};
use crate::sensing::Drive;
use crate::sensing::detector::{Detector, Finding, ONSETS, Residual, Test, threshold};
use crate::sensing::friction::{Friction, Wander};

/// Slope of the softest contact of P70 in these scales, newton metre of motor torque per block.
pub(super) const SOFTEST_NM: f64 = 2.9e-3;

fn test(per_thousand: f32) -> Test {
    let least = (0.5 * SOFTEST_NM / 1024.0) as f32;
    Test {
        threshold: threshold(per_thousand, BLOCKS as f32),
        least_slope_nm_per_count: least,
        least_fall_nm_per_count: least,
        friction_nm: FRICTION_NM as f32,
    }
}

/// Closes with a load that depends on the number of the block; the number of the block at which something was found.
pub(super) fn close(
    life: &mut Life,
    record: &Friction,
    per_thousand: f32,
    load_nm: impl Fn(i32) -> f64,
) -> Option<(i32, Finding)> {
    let speed = 1024.0 * f64::from(geared().rad_per_count) / life.block_s();
    let mut detector = Detector::new(test(per_thousand), record.wander(speed as f32));
    (FIRST..FIRST + BLOCKS).find_map(|index| {
        let block = life.block(Drive::Closing, index, load_nm(index));
        let known = record.at(block.counts).expect("recorded");
        let finding = detector.push(&Residual {
            time_us: block.time_us,
            counts: block.counts,
            width_counts: block.width_counts,
            torque_nm: block.drive_torque_nm - known.torque_nm,
            variance_nm2: record.white_nm2(block.duration_s) + known.variance_nm2,
        });
        (finding != Finding::Free).then_some((index, finding))
    })
}

#[test]
fn false_contacts_are_as_rare_as_stated_whatever_the_friction_does() {
    // A rate that can be counted, with everything learned again for each closing: one record, one closing.
    const CLOSINGS: u64 = 150;
    const PER_THOUSAND: f32 = 20.0;
    let mut found = [0u64; 3];
    for (index, world) in WORLDS.iter().enumerate() {
        for seed in 0..CLOSINGS {
            let mut life = Life::new(*world, 1000 * index as u64 + seed);
            let record = life.record();
            match close(&mut life, &record, PER_THOUSAND, |_| 0.0) {
                Some((_, Finding::Contact(_))) => found[0] += 1,
                Some((_, Finding::Softer(_))) => found[1] += 1,
                Some(_) => found[2] += 1,
                None => {}
            }
        }
    }
    // 21 of 1,050 are expected; three deviations of chance more are 35.
    assert!(found[0] <= 35 && found[1] <= 35, "{found:?}");
    assert!(found[2] == 0, "{found:?}");
    // Not by being deaf.
    assert!(found[0] + found[1] >= 4, "{found:?}");
}

#[test]
fn a_thousand_free_closings_at_the_default_are_silent() {
    let per_thousand = crate::sensing::Settings::default().false_contacts_per_thousand;
    for (index, world) in WORLDS.iter().enumerate() {
        for seed in 0..24 {
            let mut life = Life::new(*world, 77_000 + 1000 * index as u64 + seed);
            let record = life.record();
            for closing in 0..6 {
                let found = close(&mut life, &record, per_thousand, |_| 0.0);
                assert_eq!(found, None, "{world:?} {seed} {closing}");
            }
        }
    }
}

#[test]
fn the_softest_contact_is_felt_soon_and_its_onset_known() {
    let per_thousand = crate::sensing::Settings::default().false_contacts_per_thousand;
    for world in &WORLDS {
        let (mut delays, mut z) = (Vec::new(), Vec::new());
        for seed in 0..40 {
            let mut life = Life::new(*world, seed);
            let record = life.record();
            let from = 120 + (seed % 100) as i32;
            // Half way through the block it begins.
            let load = |index: i32| SOFTEST_NM * (f64::from(index - from)).max(0.0);
            let (at, finding) = close(&mut life, &record, per_thousand, load).expect("felt");
            let Finding::Contact(onset) = finding else {
                panic!("{finding:?}");
            };
            assert!(at > from, "before the contact");
            delays.push(f64::from(at - from) * life.block_s());
            let true_counts = 1024.0 * f64::from(from) + 512.0;
            let spread = f64::from(onset.sigma_counts).hypot(512.0);
            z.push((f64::from(onset.counts) - true_counts) / spread);
        }
        delays.sort_by(f64::total_cmp);
        let (median, most) = (delays[delays.len() / 2], delays[delays.len() - 1]);
        // The wildest one, 3 % within a second, asks for more.
        let bound = if world.wander > 0.015 { 0.2 } else { 0.12 };
        assert!(
            median < bound && most < 2.0 * bound,
            "{world:?} {median} {most}"
        );
        let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        assert!(rms < 2.0, "{world:?} {rms}");
    }
}

/// Friction that wanders fast hides a contact that is hardly stiffer than the least for more blocks than the detector has onsets, but its
/// torque grows with the way and the wander with the way's root: it is felt in the end.
#[test]
fn a_slow_contact_is_not_forgotten() {
    let wander = Wander {
        rms_nm: 0.028,
        time_s: 4.0,
        level_sigma_nm: 0.04,
        trend_sigma_nm_per_s: 2.5e-3,
    };
    let mut detector = Detector::new(test(0.01), wander);
    let block_s = 0.0163;
    let ramp_nm = 0.55 * SOFTEST_NM;
    let found = (0..BLOCKS).find_map(|index| {
        let found = detector.push(&Residual {
            time_us: (f64::from(index) * block_s * 1e6) as u64,
            counts: 1024 * index,
            width_counts: 1024,
            torque_nm: (ramp_nm * f64::from((index - 50).max(0))) as f32,
            variance_nm2: 1e-5,
        });
        match found {
            Finding::Contact(onset) => Some((index - 50, onset)),
            _ => None,
        }
    });
    let (delay, onset) = found.expect("felt");
    println!("felt after {delay} blocks, {} since its onset", onset.since);
    assert!(delay > ONSETS as i32 && onset.since > ONSETS);
    assert!((onset.counts / 1024.0 - 50.0).abs() < 10.0, "{onset:?}");
    let ratio = f64::from(onset.slope_nm_per_count) * 1024.0 / ramp_nm;
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}

#[test]
fn a_fall_is_told_and_a_large_shift_asks_for_a_new_record() {
    let mut life = Life::new(WORLDS[1], 5);
    let record = life.record();
    let fall = |index: i32| -SOFTEST_NM * f64::from((index - 150).max(0));
    let found = close(&mut life, &record, 0.01, fall);
    assert!(
        matches!(found, Some((151..=162, Finding::Softer(_)))),
        "{found:?}"
    );
    // Half the friction is gone from the beginning on.
    let found = close(&mut life, &record, 0.01, |_| -0.5 * FRICTION_NM);
    assert!(
        matches!(found, Some((_, Finding::Stale { misfit_nm })) if misfit_nm < -0.04),
        "{found:?}"
    );
    // A record that is rougher than it says: an alternating misfit of many deviations is no ramp.
    let rough = |index: i32| if index % 2 == 0 { 5e-3 } else { -5e-3 };
    let found = close(&mut life, &record, 0.01, rough);
    assert!(
        matches!(found, Some((_, Finding::Stale { misfit_nm })) if misfit_nm > 1e-3),
        "{found:?}"
    );
}

#[test]
fn a_single_bad_block_is_no_contact() {
    let mut life = Life::new(WORLDS[1], 6);
    let record = life.record();
    for bad_nm in [0.01, 0.1, 10.0, 1e30, -0.01, -10.0, -1e30] {
        let spike = |index: i32| if index == 150 { bad_nm } else { 0.0 };
        assert_eq!(close(&mut life, &record, 0.01, spike), None, "{bad_nm}");
    }
}

#[test]
fn nonsense_is_ignored() {
    let wander = Wander {
        rms_nm: 1e-3,
        time_s: 2.0,
        level_sigma_nm: 0.016,
        trend_sigma_nm_per_s: 1e-3,
    };
    let mut detector = Detector::new(test(0.01), wander);
    let block = Residual {
        time_us: 0,
        counts: 0,
        width_counts: 1024,
        torque_nm: 0.0,
        variance_nm2: 1e-6,
    };
    for nonsense in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for broken in [
            Residual {
                torque_nm: nonsense,
                ..block
            },
            Residual {
                variance_nm2: nonsense,
                ..block
            },
        ] {
            assert_eq!(detector.push(&broken), Finding::Free);
        }
    }
    // Without any noise, standing still, and with a clock that goes back.
    let still = Wander {
        rms_nm: 0.0,
        time_s: 1e-9,
        level_sigma_nm: 0.0,
        trend_sigma_nm_per_s: 0.0,
    };
    let mut silent = Detector::new(test(0.01), still);
    for i in 0..3 * ONSETS as u64 {
        let same = Residual {
            time_us: 1_000_000 - i,
            variance_nm2: f32::MIN_POSITIVE,
            ..block
        };
        assert_eq!(silent.push(&same), Finding::Free);
    }
    assert!(silent.level().0.is_finite() && silent.level().1.is_finite());
}

#[test]
fn the_threshold_grows_with_what_is_asked() {
    let usual = threshold(0.01, 300.0);
    assert!((14.0..18.0).contains(&usual), "{usual}");
    assert!(threshold(0.001, 300.0) > usual && threshold(1.0, 300.0) < usual);
    assert!(threshold(0.01, 3000.0) > usual);
    for (rate, blocks) in [
        (0.0, 1.0),
        (f32::NAN, 300.0),
        (1e9, f32::NAN),
        (0.01, f32::INFINITY),
    ] {
        assert!((2.0..40.0).contains(&threshold(rate, blocks)));
    }
}

/// The same in f64 without any filter: the covariance of all residuals, its Cholesky factor; the largest for any onset, and for one of the
/// last half of [`ONSETS`], which the detector has all.
fn exact(residuals: &[f64], block_s: f64, white: f64, wander: &Wander, least: f64) -> [f64; 2] {
    let n = residuals.len();
    let square = |x: f32| f64::from(x) * f64::from(x);
    let phi = |elapsed: f64| f64::from(wander.correlation(block_s as f32)).powf(elapsed / block_s);
    let mut factor = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let (a, b) = (i as f64 * block_s, j as f64 * block_s);
            let covariance = square(wander.rms_nm) * phi(a - b)
                + square(wander.level_sigma_nm)
                + square(wander.trend_sigma_nm_per_s) * a * b
                + if i == j { white } else { 0.0 };
            let sum: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            factor[i][j] = if i == j {
                (covariance - sum).sqrt()
            } else {
                (covariance - sum) / factor[j][j]
            };
        }
    }
    let whiten = |values: &dyn Fn(usize) -> f64| {
        let mut white = vec![0.0; n];
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| factor[i][k] * white[k]).sum();
            white[i] = (values(i) - sum) / factor[i][i];
        }
        white
    };
    let e = whiten(&|i| residuals[i]);
    let ratio = |onset: usize| {
        let signal = |i: usize| 1024.0 * (i as f64 - onset as f64 + 0.5).max(0.0);
        let g = whiten(&signal);
        let correlation: f64 = g.iter().zip(&e).map(|(g, e)| g * e).sum();
        let energy: f64 = g.iter().map(|g| g * g).sum();
        let slope = (correlation / energy).max(least);
        slope * correlation - 0.5 * slope * slope * energy
    };
    [0, n.saturating_sub(ONSETS / 2)].map(|first| {
        let ratios = (first..n).map(ratio);
        ratios.fold(f64::NEG_INFINITY, f64::max)
    })
}

#[test]
fn the_filter_in_single_precision_is_the_exact_likelihood_ratio() {
    for (seed, world) in WORLDS.iter().enumerate() {
        let World { white_nm, .. } = *world;
        let mut life = Life::new(*world, seed as u64);
        let wander = Wander {
            rms_nm: (world.wander.max(1e-3) * FRICTION_NM * 1.4) as f32,
            time_s: world.time_s as f32,
            level_sigma_nm: (0.1 * FRICTION_NM) as f32,
            trend_sigma_nm_per_s: 1e-3,
        };
        let never = Test {
            threshold: 1e9,
            ..test(0.01)
        };
        let mut detector = Detector::new(never, wander);
        let mut residuals = Vec::new();
        for index in 0..BLOCKS {
            let load = SOFTEST_NM * f64::from((index - 150).clamp(0, 3));
            let block = life.block(Drive::Closing, FIRST + index, load);
            let torque_nm =
                block.drive_torque_nm - super::free::curve(f64::from(block.counts)) as f32;
            residuals.push(f64::from(torque_nm));
            detector.push(&Residual {
                time_us: (f64::from(index) * life.block_s() * 1e6) as u64,
                counts: block.counts,
                width_counts: block.width_counts,
                torque_nm,
                variance_nm2: (white_nm * white_nm) as f32,
            });
            if [5, 40, 152, 156, 289].contains(&index) {
                let told = f64::from(detector.suspect().expect("a ramp").ln_ratio);
                let least = f64::from(test(0.01).least_slope_nm_per_count);
                let [of_any, of_last] = exact(
                    &residuals,
                    life.block_s(),
                    white_nm * white_nm,
                    &wander,
                    least,
                );
                // Up to then it follows every block; later the contact's is among the last.
                let least = if index < ONSETS as i32 {
                    of_any
                } else {
                    of_last
                };
                let off = 0.02 + 2e-3 * of_any.abs();
                assert!(
                    (least - off..of_any + off).contains(&told),
                    "{world:?} {index}: {told} {of_last} {of_any}"
                );
            }
        }
    }
}
