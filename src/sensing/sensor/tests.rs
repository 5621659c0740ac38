//! Readings of joint 2 that go with blocks, and what a curve is judged with.

use super::search::{CorrectedBlock, Detection};
use super::{Sensor, Stage};
use crate::joint_sensor::HallSensor;
use crate::scene::{P70, Scene};
use crate::sensing::detector::Onset;
use crate::sensing::friction::Wander;
use crate::sensing::{Directive, Drive, Sample, Settings};

type Seeing = Sensor<<P70 as Scene>::Finger, HallSensor>;

/// Turns the input link from one angle to another at 0.3 rad/s; joint 2 turns by half as much.
fn turn(sensor: &mut Seeing, time_us: &mut u64, [from_rad, to_rad]: [f32; 2]) {
    let rad_per_count = sensor.drivetrain().rad_per_count;
    let direction = (to_rad - from_rad).signum();
    for step in 0..((to_rad - from_rad).abs() / 0.3e-3) as u32 {
        let angle_rad = from_rad + direction * 0.3e-3 * step as f32;
        *time_us += 1000;
        sensor.update(&Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (angle_rad / rad_per_count) as i32,
            current_a: direction * 0.015,
            drive: if direction > 0.0 {
                Drive::Closing
            } else {
                Drive::Opening
            },
            joint: Some(0.5 * angle_rad),
        });
    }
}

/// Stands at an angle.
fn stand(sensor: &mut Seeing, time_us: &mut u64, angle_rad: f32) {
    let rad_per_count = sensor.drivetrain().rad_per_count;
    for _ in 0..10 {
        *time_us += 1000;
        sensor.update(&Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (angle_rad / rad_per_count) as i32,
            current_a: 0.0,
            drive: Drive::Idle,
            joint: Some(0.5 * angle_rad),
        });
    }
}

/// What was recorded of friction, before a closing.
fn recorded() -> (Seeing, u64) {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let mut sensor: Seeing = Sensor::new(finger, drivetrain, P70::settings(), P70::UNCALIBRATED);
    let mut time_us = 0;
    sensor.direct(Directive::RecordFriction);
    for way in [[0.0, 1.5], [1.5, 0.0]] {
        turn(&mut sensor, &mut time_us, way);
        stand(&mut sensor, &mut time_us, way[1]);
    }
    sensor.direct(Directive::Watch);
    (sensor, time_us)
}

/// A turn that makes no block leaves the next one without a reading: that before it is of an angle farther back.
#[test]
fn a_block_after_a_gap_has_no_reading() {
    let (mut sensor, mut time_us) = recorded();
    turn(&mut sensor, &mut time_us, [0.0, 0.15]);
    time_us += 10_000;
    turn(&mut sensor, &mut time_us, [0.153, 0.3]);
    let Stage::Searching(search) = &sensor.stage else {
        panic!("no search");
    };
    let drivetrain = sensor.drivetrain();
    let mut without = 0;
    for block in &search.history {
        let middle_rad = 0.5 * drivetrain.rotation_rad(0, block.counts);
        match block.reading {
            Some(reading_rad) => assert!(
                (reading_rad - middle_rad).abs() < 0.2e-3,
                "{block:?} {middle_rad}"
            ),
            None => without += 1,
        }
    }
    assert_eq!(
        without, 2,
        "the first of the motion, and that after the gap"
    );
}

/// The reading of a block is the mean of those at its ends. The first block of a motion has none: the reading before it is of the last
/// motion.
#[test]
fn the_first_block_of_a_motion_has_no_reading() {
    let (mut sensor, mut time_us) = recorded();
    let drivetrain = *sensor.drivetrain();
    for way in [[0.0, 0.15], [0.15, 0.3]] {
        turn(&mut sensor, &mut time_us, way);
        let Stage::Searching(search) = &sensor.stage else {
            panic!("{way:?}");
        };
        let mut blocks = search.history.iter();
        let first = blocks.next().expect("a block");
        assert_eq!(first.reading, None, "{way:?}");
        assert!(blocks.len() > 5);
        for block in blocks {
            let middle_rad = 0.5 * drivetrain.rotation_rad(0, block.counts);
            let reading_rad = block.reading.expect("a reading");
            assert!(
                (reading_rad - middle_rad).abs() < 0.2e-3,
                "{block:?} {middle_rad}"
            );
        }
        stand(&mut sensor, &mut time_us, way[1]);
    }
}

/// A pin's error stays with every place after it: where nobody states the worm's error, pins and presses are judged as of a poor wheel.
#[test]
fn pins_are_judged_with_an_error_of_the_worm_that_nobody_states() {
    let (mut sensor, _) = recorded();
    let pin = Directive::Calibrate {
        phalanx: 2,
        k_m: 0.03,
    };
    let detection = Detection {
        onset: Onset {
            since: 4,
            counts: 0.0,
            sigma_counts: 100.0,
            slope_nm_per_count: 1e-5,
            ln_ratio: 20.0,
            level_nm: 0.0,
        },
        wander: Wander {
            rms_nm: 1e-3,
            time_s: 3.0,
            level_sigma_nm: 1e-3,
            trend_sigma_nm_per_s: 1e-4,
        },
    };
    let first = CorrectedBlock {
        time_us: 0,
        counts: 0,
        width_counts: 4096,
        residual_nm: 0.0,
        free_nm: 0.0,
        variance_nm2: 1e-8,
        beyond_counts: 0.0,
        inertia_nm: 0.0,
        overspeed: 0.0,
        reading: None,
    };
    let mut judged_rad = |stated_rad: f32, directive: Directive| {
        sensor.set_settings(Settings {
            worm_error_rad: stated_rad,
            ..*sensor.settings()
        });
        sensor.direct(directive);
        let state = &sensor.state;
        let collector = state.collector(&detection, &first);
        state.prior(&collector).noise.worm_error_rad
    };
    for stated_rad in [0.0, 0.2e-3, 1e-3, 3e-3] {
        assert_eq!(judged_rad(stated_rad, Directive::Watch), stated_rad);
        for directive in [pin, Directive::CalibrateCable] {
            let wanted_rad = if stated_rad > 0.0 { stated_rad } else { 1.5e-3 };
            assert_eq!(judged_rad(stated_rad, directive), wanted_rad);
        }
    }
}
