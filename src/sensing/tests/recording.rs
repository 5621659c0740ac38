//! Recordings of friction that end too early, and presses that do.

use super::sensor::{friction_a, motion, recorded};
use crate::scene::{P70, Scene};
use crate::sensing::{Directive, Event, Refusal};

#[test]
fn a_motion_that_is_too_short_leaves_the_old_record() {
    let (mut sensor, mut time_us) = recorded();
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 0.5), friction_a);
    sensor.direct(Directive::Rest);
    let told = motion(&mut sensor, &mut time_us, (0.5, 0.49), friction_a);
    assert!(
        matches!(told[..], [Event::FrictionNotRecorded { coverage }] if coverage < 0.4),
        "{told:?}"
    );
    assert!(sensor.friction().is_some(), "the old record stands");
}

/// There and back, but not far enough: most of the travel would be without friction.
#[test]
fn a_recording_of_a_short_way_is_none() {
    let (mut sensor, mut time_us) = recorded();
    let before = sensor.friction().cloned();
    sensor.direct(Directive::RecordFriction);
    let mut told = motion(&mut sensor, &mut time_us, (0.0, 0.85), friction_a);
    told.extend(motion(&mut sensor, &mut time_us, (0.85, 0.0), |a| {
        -friction_a(a)
    }));
    sensor.direct(Directive::Rest);
    told.extend(motion(&mut sensor, &mut time_us, (0.0, 0.01), friction_a));
    assert!(
        matches!(told[..], [Event::FrictionNotRecorded { coverage }] if coverage < 0.6),
        "{told:?}"
    );
    assert_eq!(sensor.friction().cloned(), before);
}

/// Something stood in the way: what it took would be subtracted as friction from then on.
#[test]
fn a_recording_that_ends_while_the_finger_closes_is_none() {
    for reached in [1.1, 1.3] {
        let (mut sensor, mut time_us) = recorded();
        sensor.direct(Directive::RecordFriction);
        motion(&mut sensor, &mut time_us, (0.0, reached), |angle| {
            friction_a(angle) + 0.02 * (angle - 0.9).max(0.0)
        });
        sensor.direct(Directive::Rest);
        let told = motion(&mut sensor, &mut time_us, (reached, reached - 0.05), |a| {
            -friction_a(a)
        });
        assert!(
            matches!(told[..], [Event::FrictionNotRecorded { coverage }] if coverage > 0.6),
            "{told:?}"
        );
        let friction = sensor.friction().expect("the old record stands");
        let counts = (1.2 / P70::drivetrain(sensor.finger()).rad_per_count) as i32;
        let recorded = friction.at(counts).expect("within the record");
        let nm = friction.mean_nm().expect("recorded");
        assert!(
            recorded.torque_nm < 1.15 * nm,
            "{}",
            recorded.torque_nm / nm
        );
    }
}

/// The gears stuck for a while: without its beginning a record would feel nothing there, and beyond an interruption there is nothing to
/// compare with.
#[test]
fn a_recording_that_is_interrupted_is_none() {
    for at_rad in [0.35, 0.95] {
        let (mut sensor, mut time_us) = recorded();
        let before = sensor.friction().cloned();
        sensor.direct(Directive::RecordFriction);
        for way in [(0.0, at_rad), (at_rad, 1.5)] {
            motion(&mut sensor, &mut time_us, way, friction_a);
        }
        motion(&mut sensor, &mut time_us, (1.5, 0.0), |a| -friction_a(a));
        sensor.direct(Directive::Rest);
        let told = motion(&mut sensor, &mut time_us, (0.0, 0.01), friction_a);
        assert!(
            matches!(told[..], [Event::FrictionNotRecorded { .. }]),
            "{at_rad}: {told:?}"
        );
        assert_eq!(sensor.friction().cloned(), before);
    }
}

/// A pin that was left in the way yields with the finger: taken for the stop it would make the cable too soft.
#[test]
fn what_is_met_before_the_stop_is_not_pressed_on_as_the_stop() {
    let (mut sensor, mut time_us) = recorded();
    let before = *sensor.calibration();
    sensor.direct(Directive::CalibrateCable);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.1), |angle| {
        friction_a(angle) + 0.3 * (angle - 0.9).max(0.0)
    });
    let refused = Event::CalibrationRefused {
        why: Refusal::Misfit,
    };
    assert!(told.contains(&refused), "{told:?}");
    assert_eq!(*sensor.calibration(), before);
}
