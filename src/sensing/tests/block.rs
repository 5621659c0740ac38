use super::{drivetrain, settings};
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::{Drive, Sample};

/// Runs a motion of `milliseconds` at 30 counts a millisecond and collects its blocks.
fn blocks(
    averager: &mut BlockAverager,
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
            emf_v: f32::NAN,
            time_us: start.0 + 1000 * (i + 1),
            position_counts: counts,
            current_a: current_a(counts.wrapping_sub(step / 2)),
            drive,
            joint: (),
        };
        if let BlockUpdate::Block(block) = averager.push(&sample, &drivetrain(), &settings()) {
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
    let found = blocks(
        &mut BlockAverager::default(),
        (0, 0),
        1500,
        Drive::Closing,
        ripple,
    );
    assert!(found.len() > 20);
    for pair in found.windows(2) {
        assert_eq!(pair[1].counts - pair[0].counts, 1000);
    }
    // At the same positions in every motion.
    assert_eq!(found[0].counts % 1000, 500);
    for block in &found {
        assert_eq!(block.width_counts, 1000);
        // 10 N m/A times 20 mA; the ripple is half of that and must all but vanish.
        assert!((block.drive_torque_nm - 0.2).abs() < 2e-4, "{block:?}");
        assert!(block.overspeed.abs() < 1e-3 && block.inertia_nm.abs() < 1e-3);
    }
}

#[test]
fn nothing_of_a_start_a_reversal_or_the_dead_band_becomes_a_block() {
    let mut averager = BlockAverager::default();
    let first = blocks(&mut averager, (0, 0), 500, Drive::Closing, |_| 0.02);
    // 0.08 rad are 8000 counts; then a block for the speed before.
    assert!((9000..11_000).contains(&(first[0].counts - 500)));
    let back = blocks(
        &mut averager,
        (500_000, 15_000),
        500,
        Drive::Opening,
        |_| -0.02,
    );
    assert!((9000..11_000).contains(&(15_000 - (back[0].counts + 500))));
    assert!(back.iter().all(|b| b.drive == Drive::Opening));
    assert!(back.iter().all(|b| (b.drive_torque_nm + 0.2).abs() < 1e-3));
    let rest = blocks(&mut averager, (1_000_000, 0), 50, Drive::Idle, |_| 0.0);
    assert!(rest.is_empty());
    // Gears with more play than that are waited for.
    let loose = crate::sensing::Drivetrain {
        backlash_rad: 0.1,
        ..drivetrain()
    };
    let mut averager = BlockAverager::default();
    for i in 0..600 {
        let sample = Sample {
            emf_v: f32::NAN,
            time_us: 1000 * i,
            position_counts: 30 * i as i32,
            current_a: 0.02,
            drive: Drive::Closing,
            joint: (),
        };
        if let BlockUpdate::Block(block) = averager.push(&sample, &loose, &settings()) {
            assert!(block.counts >= 15_000 + 1000, "{block:?}");
        }
    }
}

#[test]
fn gears_that_stick_for_a_moment_end_no_motion() {
    // Runs closing, stands still for some samples, and goes on; whether the motion ended, and the blocks of its second half.
    let interrupted = |idle: u64| {
        let mut averager = BlockAverager::default();
        blocks(&mut averager, (0, 0), 600, Drive::Closing, |_| 0.02);
        let mut ended = false;
        for i in 0..idle {
            let sample = Sample {
                emf_v: f32::NAN,
                time_us: 600_000 + 1000 * (i + 1),
                position_counts: 18_000,
                // What flows there must not count.
                current_a: 5.0,
                drive: Drive::Idle,
                joint: (),
            };
            ended |= averager.push(&sample, &drivetrain(), &settings()) == BlockUpdate::Ended;
        }
        let start = (600_000 + 1000 * idle, 18_000);
        let found = blocks(&mut averager, start, 200, Drive::Closing, |_| 0.02);
        (ended, found)
    };
    for idle in [1, 8] {
        let (ended, found) = interrupted(idle);
        assert!(!ended, "{idle}");
        // The block that was interrupted is dropped, and the next one tells the speed.
        assert!((19_000..21_500).contains(&found[0].counts), "{found:?}");
        assert!(
            found
                .iter()
                .all(|block| (block.drive_torque_nm - 0.2).abs() < 1e-3)
        );
    }
    let (ended, found) = interrupted(9);
    // A new motion: the first 0.08 rad, 8000 counts, are not used, and that is longer than the way left.
    assert!(ended && found.is_empty(), "{found:?}");
}

/// A recording begins while the finger backs off from a press on its opening stop: only the way beyond the stop counts.
#[test]
fn the_way_on_which_a_stop_is_left_does_not_count() {
    let first_rad = |leave: bool| {
        let mut averager = BlockAverager::default();
        let start_counts = -(0.05 / drivetrain().rad_per_count) as i32;
        let back_ms = start_counts.unsigned_abs() / 30;
        let current = |_: i32| 0.02;
        let mut found = blocks(
            &mut averager,
            (0, start_counts),
            u64::from(back_ms),
            Drive::Closing,
            current,
        );
        if leave {
            averager.leave_stop();
        }
        let stop = (
            1000 * u64::from(back_ms),
            start_counts + 30 * back_ms as i32,
        );
        found.append(&mut blocks(
            &mut averager,
            stop,
            2000,
            Drive::Closing,
            current,
        ));
        found.first().expect("blocks").counts as f32 * drivetrain().rad_per_count
    };
    let settle_rad = settings().settle_rad;
    assert!((settle_rad - 0.05..settle_rad).contains(&first_rad(false)));
    assert!((settle_rad..settle_rad + 0.03).contains(&first_rad(true)));
}

/// Blocks of a closing whose position is a function of the milliseconds.
fn closing(milliseconds: u64, counts: impl Fn(u64) -> i32) -> Vec<Block> {
    let mut averager = BlockAverager::default();
    let samples = (0..milliseconds).map(|i| Sample {
        emf_v: f32::NAN,
        time_us: 1000 * i,
        position_counts: counts(i),
        current_a: 0.02,
        drive: Drive::Closing,
        joint: (),
    });
    samples
        .filter_map(
            |sample| match averager.push(&sample, &drivetrain(), &settings()) {
                BlockUpdate::Block(block) => Some(block),
                _ => None,
            },
        )
        .collect()
}

#[test]
fn any_steady_speed_gives_blocks_and_one_that_slows_down_none() {
    for speed in [10, 20, 50, 80] {
        let found = closing(3000, |i| speed * i as i32);
        assert!(found.len() > 15, "{speed}: {}", found.len());
        let overspeed = speed as f32 / 30.0 - 1.0;
        assert!(found.iter().all(|b| (b.overspeed - overspeed).abs() < 0.01));
        assert!(
            found
                .iter()
                .all(|b| (b.duration_s * speed as f32 - 1.0).abs() < 0.05)
        );
    }
    // Slower by a third after two seconds: a load, and worms rub differently then.
    let found = closing(4000, |i| {
        30 * i.min(2000) as i32 + 20 * i.saturating_sub(2000) as i32
    });
    assert!(found.iter().all(|b| b.counts < 61_000) && found.len() > 40);
    // Faster after a slow beginning: that is the run's speed.
    let found = closing(4000, |i| {
        10 * i.min(1500) as i32 + 30 * i.saturating_sub(1500) as i32
    });
    assert!(found.iter().filter(|b| b.counts > 26_000).count() > 40);
}

#[test]
fn a_slight_change_of_speed_is_accounted_for() {
    // From 30 to 31.5 counts a millisecond within a second: 0.015 rad/s2 of 0.01 kg m2.
    let mut averager = BlockAverager::default();
    let mut last = None;
    for i in 0..1000u64 {
        let seconds = i as f64 * 1e-3;
        let sample = Sample {
            emf_v: f32::NAN,
            time_us: 1000 * i,
            position_counts: (30_000.0 * seconds + 750.0 * seconds * seconds) as i32,
            current_a: 0.02,
            drive: Drive::Closing,
            joint: (),
        };
        if let BlockUpdate::Block(block) = averager.push(&sample, &drivetrain(), &settings()) {
            last = Some(block);
        }
    }
    let last = last.unwrap();
    assert!((last.overspeed - 0.049).abs() < 2e-3, "{last:?}");
    assert!((last.inertia_nm - 1.5e-4).abs() < 1.5e-4, "{last:?}");
}

#[test]
fn gaps_repetitions_nonsense_and_wrapping_do_no_harm() {
    let mut averager = BlockAverager::default();
    let near_end = i32::MAX - 6000;
    let before = blocks(&mut averager, (0, near_end), 400, Drive::Closing, |_| 0.02);
    assert!(
        before
            .windows(2)
            .all(|p| p[1].counts.wrapping_sub(p[0].counts) == 1000)
    );
    // A repeated and an older sample change nothing.
    for time_us in [400_000, 399_000] {
        let sample = Sample {
            emf_v: f32::NAN,
            time_us,
            position_counts: 0,
            current_a: 9.0,
            drive: Drive::Closing,
            joint: (),
        };
        assert_eq!(
            averager.push(&sample, &drivetrain(), &settings()),
            BlockUpdate::Pending
        );
    }
    // After a gap of 20 ms a block starts again; the first only tells the speed.
    let start = near_end.wrapping_add(12_000 + 600);
    let after = blocks(&mut averager, (420_000, start), 100, Drive::Closing, |_| {
        0.02
    });
    assert!(after[0].counts.wrapping_sub(start) >= 1500);
    let nan = blocks(
        &mut averager,
        (520_000, start + 3000),
        200,
        Drive::Closing,
        |_| f32::NAN,
    );
    assert!(nan.is_empty());
    let sound = blocks(
        &mut averager,
        (720_000, start + 9000),
        200,
        Drive::Closing,
        |_| 0.02,
    );
    assert!(sound.iter().all(|b| b.drive_torque_nm.is_finite()) && !sound.is_empty());
}
