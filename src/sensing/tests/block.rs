use super::{drivetrain, settings};
use crate::sensing::block::{Block, Gate, Step};
use crate::sensing::{Drive, Sample};

/// Runs a motion of `milliseconds` at 30 counts a millisecond and collects its blocks.
fn blocks(
    gate: &mut Gate,
    start: (u64, i32),
    milliseconds: u64,
    drive: Drive,
    current_a: impl Fn(i32) -> f32,
) -> Vec<Block> {
    let step = match drive {
        Drive::Closing => 30,
        Drive::Opening => -30,
        Drive::Idle => 0,
    };
    let mut found = Vec::new();
    for i in 0..milliseconds {
        let counts = start.1.wrapping_add(step * (i as i32 + 1));
        let sample = Sample {
            time_us: start.0 + 1000 * (i + 1),
            position_counts: counts,
            current_a: current_a(counts.wrapping_sub(step / 2)),
            drive,
            joint: (),
        };
        if let Step::Block(block) = gate.push(&sample, &drivetrain(), &settings()) {
            found.push(block);
        }
    }
    found
}

#[test]
fn a_block_is_one_turn_of_the_motor_and_averages_what_repeats_with_it() {
    let ripple = |counts: i32| {
        let turn = std::f32::consts::TAU * counts.rem_euclid(1000) as f32 / 1000.0;
        0.02 + 0.01 * turn.cos() + 0.005 * (2.0 * turn).sin()
    };
    let found = blocks(&mut Gate::default(), (0, 0), 1000, Drive::Closing, ripple);
    assert!(found.len() > 20);
    for pair in found.windows(2) {
        assert_eq!(pair[1].counts - pair[0].counts, 1000);
    }
    for block in &found {
        assert_eq!(block.width_counts, 1000);
        // 10 N m/A times 20 mA; the ripple is half of that and must all but vanish.
        assert!((block.drive_torque_nm - 0.2).abs() < 2e-4, "{block:?}");
        assert!(block.overspeed.abs() < 1e-3 && block.inertia_nm.abs() < 1e-3);
    }
}

#[test]
fn nothing_of_a_start_a_reversal_or_the_dead_band_becomes_a_block() {
    let mut gate = Gate::default();
    let first = blocks(&mut gate, (0, 0), 400, Drive::Closing, |_| 0.02);
    // Dead band of 1.5 times 1000 counts, then 60 ms, then a block for the speed before.
    assert!(first[0].counts - 500 >= 1500 + 60 * 30 + 1000 - 60);
    let back = blocks(&mut gate, (400_000, 12_000), 400, Drive::Opening, |_| -0.02);
    assert!(12_000 - (back[0].counts + 500) >= 1500 + 60 * 30 + 1000 - 60);
    assert!(back.iter().all(|b| b.drive == Drive::Opening));
    assert!(back.iter().all(|b| (b.drive_torque_nm + 0.2).abs() < 1e-3));
    // Going on in the same direction after a rest costs no dead band.
    let rest = blocks(&mut gate, (800_000, 0), 50, Drive::Idle, |_| 0.0);
    assert!(rest.is_empty());
    let on = blocks(&mut gate, (850_000, 0), 400, Drive::Opening, |_| -0.02);
    assert!(-on[0].counts < 60 * 30 + 1500 + 60);
}

#[test]
fn another_speed_gives_no_block_and_a_slight_change_is_accounted_for() {
    let mut gate = Gate::default();
    let mut found = 0;
    for i in 0..600u64 {
        let sample = Sample {
            time_us: 1000 * i,
            position_counts: 20 * i as i32,
            current_a: 0.02,
            drive: Drive::Closing,
            joint: (),
        };
        found += usize::from(matches!(
            gate.push(&sample, &drivetrain(), &settings()),
            Step::Block(_)
        ));
    }
    assert_eq!(found, 0);
    // From 30 to 31.5 counts a millisecond within a second: 0.015 rad/s2 of 0.01 kg m2.
    let mut gate = Gate::default();
    let mut last = None;
    for i in 0..1000u64 {
        let seconds = i as f64 * 1e-3;
        let sample = Sample {
            time_us: 1000 * i,
            position_counts: (30_000.0 * seconds + 750.0 * seconds * seconds) as i32,
            current_a: 0.02,
            drive: Drive::Closing,
            joint: (),
        };
        if let Step::Block(block) = gate.push(&sample, &drivetrain(), &settings()) {
            last = Some(block);
        }
    }
    let last = last.unwrap();
    assert!((last.overspeed - 0.049).abs() < 2e-3, "{last:?}");
    assert!((last.inertia_nm - 1.5e-4).abs() < 1.5e-4, "{last:?}");
}

#[test]
fn gaps_repetitions_nonsense_and_wrapping_do_no_harm() {
    let mut gate = Gate::default();
    let near_end = i32::MAX - 6000;
    let before = blocks(&mut gate, (0, near_end), 400, Drive::Closing, |_| 0.02);
    assert!(
        before
            .windows(2)
            .all(|p| p[1].counts.wrapping_sub(p[0].counts) == 1000)
    );
    // A repeated and an older sample change nothing.
    for time_us in [400_000, 399_000] {
        let sample = Sample {
            time_us,
            position_counts: 0,
            current_a: 9.0,
            drive: Drive::Closing,
            joint: (),
        };
        assert_eq!(
            gate.push(&sample, &drivetrain(), &settings()),
            Step::Pending
        );
    }
    // After a gap of 20 ms a block starts anew; the first only tells the speed.
    let start = near_end.wrapping_add(12_000 + 600);
    let after = blocks(&mut gate, (420_000, start), 100, Drive::Closing, |_| 0.02);
    assert!(after[0].counts.wrapping_sub(start) >= 1500);
    let nan = blocks(
        &mut gate,
        (520_000, start + 3000),
        200,
        Drive::Closing,
        |_| f32::NAN,
    );
    assert!(nan.is_empty());
    let sound = blocks(
        &mut gate,
        (720_000, start + 9000),
        200,
        Drive::Closing,
        |_| 0.02,
    );
    assert!(sound.iter().all(|b| b.drive_torque_nm.is_finite()) && !sound.is_empty());
}
