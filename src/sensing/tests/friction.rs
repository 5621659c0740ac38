use super::Noise;
use crate::sensing::block::Block;
use crate::sensing::friction::{Aligned, Alignment, Friction, Recorder};
use crate::sensing::{Drive, Drivetrain, sensor};

const TRAVEL: i32 = 256_000;
const WORM: u32 = 64_000;

fn truth(counts: f32) -> f32 {
    let turn = std::f32::consts::TAU * counts / WORM as f32;
    0.17 + 0.01 * turn.cos() + 0.005 * counts / TRAVEL as f32
}

fn block(drive: Drive, counts: i32, torque_nm: f32) -> Block {
    Block {
        time_us: 0,
        drive,
        counts,
        width_counts: 1000,
        drive_torque_nm: torque_nm,
        inertia_nm: 0.0,
        overspeed: 0.0,
    }
}

fn record(passes: usize, sigma: f32, seed: u64) -> Recorder {
    let mut noise = Noise(seed);
    let mut recorder = Recorder::new(TRAVEL);
    for _ in 0..passes {
        for i in 4..250 {
            let counts = 1000 * i;
            let torque = truth(counts as f32) + sigma * noise.normal();
            recorder.push(&block(Drive::Closing, counts, torque));
        }
        recorder.end_run();
        for i in (4..250).rev() {
            let counts = 1000 * i;
            let torque = -truth(counts as f32) + sigma * noise.normal();
            recorder.push(&block(Drive::Opening, counts, torque));
        }
        recorder.end_run();
    }
    recorder
}

#[test]
fn a_record_follows_the_friction_in_both_directions() {
    let friction = record(1, 0.0, 1).finish().cloned().unwrap();
    for counts in (12_000..240_000).step_by(333) {
        let error = friction.at(Drive::Closing, counts).unwrap() - truth(counts as f32);
        // A bin is 1/32 of the wave: the line between bins misses its crest by 0.5 % of 10 mN m, and a bin averages.
        assert!(error.abs() < 1.5e-4, "{counts}: {error}");
        let error = friction.at(Drive::Opening, counts).unwrap() + truth(counts as f32);
        assert!(error.abs() < 1.5e-4, "{counts}: {error}");
    }
    assert_eq!(friction.at(Drive::Idle, 100_000), None);
    assert_eq!(friction.at(Drive::Closing, -1), None);
    assert_eq!(friction.at(Drive::Closing, TRAVEL), None);
    assert!(friction.is_valid());
}

#[test]
fn its_noise_is_that_of_the_motion_and_the_table() {
    // White noise of 1 mN m in blocks of 1000 counts: 1e-6 * 1000, and as much for the table.
    for (passes, seed) in [(1, 3), (2, 4)] {
        let friction = record(passes, 1e-3, seed).finish().cloned().unwrap();
        let noise = friction.noise_nm2_counts(Drive::Closing).unwrap();
        assert!((1.4e-3..2.8e-3).contains(&noise), "{passes}: {noise}");
        let residual = friction.residual_nm();
        assert!((0.5e-3..1.0e-3).contains(&residual), "{residual}");
    }
    // Two passes that differ tell what one cannot.
    let mut recorder = record(1, 0.0, 5);
    for i in 4..250 {
        let counts = 1000 * i;
        let slow = 2e-3 * (counts as f32 / 20_000.0).sin();
        recorder.push(&block(Drive::Closing, counts, truth(counts as f32) + slow));
    }
    let noise = recorder
        .finish()
        .cloned()
        .unwrap()
        .noise_nm2_counts(Drive::Closing)
        .unwrap();
    assert!(noise > 1.5e-3, "{noise}");
}

#[test]
fn beyond_its_end_friction_goes_on_with_the_worm() {
    let friction = record(1, 0.0, 1).finish().cloned().unwrap();
    for counts in (250_000..300_000).step_by(1000) {
        let (torque, beyond) = friction.beyond(Drive::Closing, counts, WORM).unwrap();
        assert!(beyond > 0.0);
        let error = torque - truth(counts as f32);
        assert!(error.abs() < 5e-4, "{counts}: {error}");
        // Without the period the end's value stays.
        let (flat, _) = friction.beyond(Drive::Closing, counts, 0).unwrap();
        assert_eq!(flat, friction.beyond(Drive::Closing, 299_000, 0).unwrap().0);
    }
    let (first, beyond) = friction.beyond(Drive::Closing, -5000, WORM).unwrap();
    assert!((first - truth(5000.0)).abs() < 1e-3 && beyond == 0.0);
}

#[test]
fn the_end_of_a_run_and_nonsense_are_left_out() {
    let mut recorder = record(1, 0.0, 1);
    for i in 4..100 {
        // Slowing down in the last two blocks.
        let torque = if i < 98 {
            truth(1000.0 * i as f32)
        } else {
            0.0
        };
        recorder.push(&block(Drive::Closing, 1000 * i, torque));
    }
    recorder.end_run();
    for i in 100..140 {
        recorder.push(&block(Drive::Closing, 1000 * i, f32::NAN));
    }
    let friction = recorder.finish().cloned().unwrap();
    for counts in (12_000..240_000).step_by(777) {
        let error = friction.at(Drive::Closing, counts).unwrap() - truth(counts as f32);
        assert!(error.abs() < 1.5e-4, "{counts}: {error}");
    }
    assert!(Recorder::new(TRAVEL).finish().is_none());
    assert!(Recorder::new(0).finish().is_none());
}

#[test]
fn a_record_with_nonsense_in_it_is_not_valid() {
    let friction = record(1, 1e-3, 9).finish().cloned().unwrap();
    assert!(friction.is_valid());
    let mut mad = friction.clone();
    mad.opening.torque_nm[3] = f32::NAN;
    assert!(!mad.is_valid());
    let mut mad = friction;
    mad.closing.noise_nm2_counts = -1.0;
    assert!(!mad.is_valid());
    assert!(size_of::<sensor::Sensor<crate::finger::Finger<2, crate::finger::Tendon<2>>>>() < 8192);
}

/// Blocks of a closing on the scale of another zero, `shift` counts beside the record's, until the alignment has an answer.
fn align(friction: &Friction, shift: i32, sigma: f32, extra: impl Fn(i32) -> f32) -> Aligned {
    let drivetrain = Drivetrain {
        rad_per_count: 1.6 / TRAVEL as f32,
        ..super::drivetrain()
    };
    let (mut noise, mut alignment) = (Noise(7), Alignment::default());
    for i in 8..200 {
        let counts = 1000 * i;
        let torque = truth((counts + shift) as f32) + sigma * noise.normal() + extra(counts);
        let told = alignment.push(
            friction,
            &block(Drive::Closing, counts, torque),
            &drivetrain,
        );
        if told != Aligned::Pending {
            return told;
        }
    }
    Aligned::Pending
}

#[test]
fn a_record_is_found_again_at_any_shift() {
    let sigma = 3e-4;
    let friction = record(1, sigma, 3).finish().cloned().unwrap();
    // 4000 counts are 25 mrad.
    for shift in [-4000, -2500, -1000, -170, 0, 330, 1200, 2000, 4000] {
        // A level that is off, as after a change of temperature, is no shift.
        for level in [0.0, 0.004, -0.004] {
            let Aligned::By(found) = align(&friction, shift, sigma, |_| level) else {
                panic!("{shift}");
            };
            // What is left of the ripple is less than the noise of a block.
            let left = (20_000..TRAVEL)
                .step_by(1000)
                .map(|counts| truth((counts + found) as f32) - truth((counts + shift) as f32))
                .fold(0.0, |most: f32, left| most.max(left.abs()));
            assert!(left < sigma, "{found} instead of {shift}: {left} N m");
        }
    }
}

#[test]
fn what_is_no_free_motion_fits_nowhere() {
    let sigma = 3e-4;
    let friction = record(1, sigma, 3).finish().cloned().unwrap();
    let pressing = |counts: i32| 0.1 * (counts - 20_000).max(0) as f32 / 20_000.0;
    let told = align(&friction, 500, sigma, pressing);
    assert!(
        matches!(told, Aligned::Nowhere { misfit_nm } if misfit_nm > 0.001),
        "{told:?}"
    );
    // A number that is none is no block.
    for nonsense in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(align(&friction, 0, sigma, |_| nonsense), Aligned::Pending);
    }
    let spike = |counts: i32| if counts == 20_000 { f32::MAX } else { 0.0 };
    let told = align(&friction, 0, sigma, spike);
    assert!(
        matches!(told, Aligned::Nowhere { misfit_nm } if misfit_nm.is_finite()),
        "{told:?}"
    );
    // Off the record nothing is compared.
    let empty = Friction::empty(TRAVEL);
    assert_eq!(align(&empty, 0, sigma, |_| 0.0), Aligned::Pending);
}

#[test]
fn friction_without_a_ripple_is_taken_as_it_lies() {
    // Nothing tells the shift: what homings differ by usually counts, and the record is not refused.
    let sigma = 3e-4;
    let mut friction = record(1, sigma, 3).finish().cloned().unwrap();
    friction.closing.torque_nm.fill(0.17);
    for shift in [-2000, 0, 2000] {
        let even = |counts: i32| 0.17 - truth((counts + shift) as f32);
        let Aligned::By(found) = align(&friction, shift, sigma, even) else {
            panic!("{shift}");
        };
        // 8 mrad are 1280 counts.
        assert!(found.abs() <= 1280, "{found}");
    }
}
