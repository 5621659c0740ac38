//! One closing after another: what the next one must not inherit of the last.

use super::sensor::{friction_a, motion, recorded, sensor};
use crate::finger::Mechanics;
use crate::scene::{P70, Scene};
use crate::sensing::{Directive, Event, Friction, Refusal, Sensor};

type Recorded = Sensor<<P70 as Scene>::Finger>;

/// A closing on something at 0.9 rad, of an encoder whose zero lies a shift from the record's.
fn touching_a(angle: f32, shift_rad: f32) -> f32 {
    friction_a(angle + shift_rad) + 0.15 * (angle - 0.9).max(0.0)
}

fn touches(told: &[Event]) -> usize {
    let touch = |event: &&Event| matches!(event, Event::Touch { .. });
    told.iter().filter(touch).count()
}

/// A free closing tells its stiffness and nothing else.
#[track_caller]
fn is_free(told: &[Event]) {
    assert!(matches!(told, [Event::Stiffness { .. }]), "{told:?}");
}

/// Whether the finger opened unseen, as in a sequence, or under the same directive.
#[test]
fn after_a_contact_the_next_closing_is_searched() {
    for rests in [true, false] {
        let (mut sensor, mut time_us) = recorded();
        sensor.direct(Directive::Watch);
        for closing in 0..3 {
            if rests {
                sensor.direct(Directive::Watch);
            }
            let told = motion(&mut sensor, &mut time_us, (0.0, 1.2), |angle| {
                touching_a(angle, 0.0)
            });
            assert_eq!(touches(&told), 1, "{rests} {closing}: {told:?}");
            if rests {
                sensor.direct(Directive::Rest);
            }
            motion(&mut sensor, &mut time_us, (1.2, 0.0), |a| -friction_a(a));
        }
    }
}

/// Both for a record that was kept and for one whose zero has moved: found in the first closing, and in force for the next.
#[test]
fn a_record_of_another_zero_is_aligned_by_the_first_closing() {
    let kept = recorded().0.friction().cloned().expect("recorded");
    for shift_rad in [-0.02, 0.02] {
        let mut restarted = sensor();
        assert!(restarted.restore_friction(kept.clone()));
        let (mut moved, _) = recorded();
        moved.realign();
        for mut sensor in [restarted, moved] {
            let mut time_us = 1 << 40;
            let shifted = |angle: f32| friction_a(angle + shift_rad);
            for _ in 0..2 {
                sensor.direct(Directive::Watch);
                is_free(&motion(&mut sensor, &mut time_us, (0.0, 1.4), shifted));
                sensor.direct(Directive::Rest);
                motion(&mut sensor, &mut time_us, (1.4, 0.0), |a| -shifted(a));
            }
            // What both have taught lies where the record has it.
            let friction = sensor.friction().expect("recorded");
            let per_ampere = P70::drivetrain(sensor.finger()).torque_per_ampere_nm;
            for angle in [0.4f32, 0.7, 1.1] {
                let counts = (angle / friction.rad_per_count) as i32;
                let known = friction.at(counts).expect("recorded");
                let error_nm = known.torque_nm - per_ampere * friction_a(angle);
                assert!(error_nm.abs() < 1e-3, "{angle}: {error_nm}");
            }
            // A new record has the zero of today.
            sensor.direct(Directive::RecordFriction);
            motion(&mut sensor, &mut time_us, (0.0, 1.5), shifted);
            motion(&mut sensor, &mut time_us, (1.5, 0.0), |a| -shifted(a));
            sensor.direct(Directive::Watch);
            let told = motion(&mut sensor, &mut time_us, (0.0, 1.2), |angle| {
                touching_a(angle, shift_rad)
            });
            assert!(
                matches!(told[..], [Event::FrictionRecorded { .. }, Event::Touch { theta_a_rad, .. }, ..]
                    if (theta_a_rad - 0.9).abs() < 0.05),
                "{told:?}"
            );
        }
    }
}

/// The finger opens then, and friction is recorded anew.
#[test]
fn a_finger_that_is_not_free_while_its_record_is_aligned_says_so() {
    let kept = recorded().0.friction().cloned().expect("recorded");
    let (mut sensor, mut time_us) = (sensor(), 0);
    assert!(sensor.restore_friction(kept));
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.2), |angle| {
        friction_a(angle) + 0.15 * (angle - 0.15).max(0.0)
    });
    assert!(
        matches!(told[..], [Event::FrictionStale { .. }, Event::FrictionNotRecorded { coverage }, ..]
            if coverage == 0.0),
        "{told:?}"
    );
}

/// A motion that is unusual is no free one: its friction would be taken off from then on.
#[test]
fn a_softer_closing_is_not_learned() {
    let (mut sensor, mut time_us) = recorded();
    let before = sensor.friction().map(Friction::passes);
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.4), |angle| {
        friction_a(angle) - 0.02 * (angle - 0.7).max(0.0)
    });
    assert!(matches!(told[..], [Event::Unusual { .. }, ..]), "{told:?}");
    motion(&mut sensor, &mut time_us, (1.4, 0.0), |a| -friction_a(a));
    assert_eq!(sensor.friction().map(Friction::passes), before);
}

/// Whoever gives a place that the finger does not have is told so, and nothing is learned.
#[test]
fn a_place_that_the_finger_does_not_have_calibrates_nothing() {
    let calibrates = |sensor: &mut Recorded, time_us: &mut u64, phalanx, k_m| {
        sensor.direct(Directive::Calibrate { phalanx, k_m });
        let told = motion(sensor, time_us, (0.0, 1.2), |angle| touching_a(angle, 0.0));
        assert_eq!(touches(&told), 1, "{told:?}");
        sensor.direct(Directive::Rest);
        motion(sensor, time_us, (1.2, 0.0), |a| -friction_a(a));
        told.iter().find_map(|event| match event {
            Event::CalibrationRefused { why } => Some(*why),
            _ => None,
        })
    };
    let (mut sensor, mut time_us) = recorded();
    let before = *sensor.calibration();
    let length_m = sensor.finger().phalanx_length_m(2).expect("two phalanges");
    for (phalanx, k_m) in [(1, 0.03), (2, length_m + 1e-3), (2, 0.0), (2, f32::NAN)] {
        let why = calibrates(&mut sensor, &mut time_us, phalanx, k_m);
        assert_eq!(why, Some(Refusal::NoSuchPlace), "{phalanx} {k_m}");
        assert_eq!(*sensor.calibration(), before);
    }
    let why = calibrates(&mut sensor, &mut time_us, 2, 0.5 * length_m);
    assert_ne!(why, Some(Refusal::NoSuchPlace));
}

/// A contact that is met at the same place again and again does not become friction, though it is felt some blocks after it began.
#[test]
fn what_is_met_again_and_again_is_not_learned() {
    let (mut sensor, mut time_us) = recorded();
    for _ in 0..8 {
        sensor.direct(Directive::Watch);
        let told = motion(&mut sensor, &mut time_us, (0.0, 1.25), |angle| {
            friction_a(angle) + 0.01 * (angle - 0.9).max(0.0)
        });
        assert_eq!(touches(&told), 1, "{told:?}");
        motion(&mut sensor, &mut time_us, (1.25, 0.0), |a| -friction_a(a));
    }
    let friction = sensor.friction().expect("recorded");
    let per_ampere = P70::drivetrain(sensor.finger()).torque_per_ampere_nm;
    for step in 0..40 {
        let angle = 0.85 + 0.005 * step as f32;
        let counts = (angle / friction.rad_per_count) as i32;
        let known = friction.at(counts).expect("recorded");
        let error_nm = known.torque_nm - per_ampere * friction_a(angle);
        assert!(error_nm.abs() < 0.1e-3, "{angle}: {error_nm}");
    }
}
