use crate::finger::Mechanics;
use crate::scene::{P70, Scene, Tendon2};
use crate::sensing::{Calibration, Directive, Drive, Event, Friction, Sample, Sensor};
use proptest::prelude::*;

pub(super) fn sensor() -> Sensor<<P70 as Scene>::Finger> {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    Sensor::new(finger, drivetrain, P70::settings(), P70::UNCALIBRATED)
}

/// Every number that an event carries, except a radius that the curve does not determine, and the force of a contact that
/// is lost.
fn numbers(event: &Event) -> Vec<f32> {
    match *event {
        Event::FrictionRecorded {
            closing_nm,
            opening_nm,
            residual_nm,
            coverage,
            wander_nm,
            wander_s,
        } => vec![
            closing_nm,
            opening_nm,
            residual_nm,
            coverage,
            wander_nm,
            wander_s,
        ],
        Event::FrictionNotRecorded { coverage } => vec![coverage],
        Event::FrictionStale { misfit_nm } => vec![misfit_nm],
        Event::Unusual {
            k_a_nm_per_rad,
            k_a_sigma_nm_per_rad,
            k_a_free_nm_per_rad,
        }
        | Event::Stiffness {
            k_a_nm_per_rad,
            k_a_sigma_nm_per_rad,
            k_a_free_nm_per_rad,
        } => vec![k_a_nm_per_rad, k_a_sigma_nm_per_rad, k_a_free_nm_per_rad],
        Event::Touch {
            theta_a_rad,
            torque_nm,
            ..
        } => vec![theta_a_rad, torque_nm],
        Event::Located {
            k_m,
            sigma_m,
            force_n,
            force_sigma_n,
            ..
        } => {
            let lost = force_n.is_nan() && force_sigma_n.is_nan();
            let force = if lost {
                [0.0; 2]
            } else {
                [force_n, force_sigma_n]
            };
            vec![k_m, sigma_m, force[0], force[1]]
        }
        Event::Ambiguous { k_m, sigma_m, .. } => [k_m, sigma_m].concat(),
        Event::NotLocated { torque_nm, .. } => vec![torque_nm],
        Event::Calibrated { calibration } => {
            vec![calibration.torque_factor, calibration.cable_rad_per_nm]
        }
        Event::CalibrationRefused { .. } => vec![],
    }
}

/// A motion of the input link at 0.3 rad/s with a current that a function of the angle tells.
pub(super) fn motion<F: Mechanics>(
    sensor: &mut Sensor<F>,
    time_us: &mut u64,
    range_rad: (f32, f32),
    current_a: impl Fn(f32) -> f32,
) -> Vec<Event> {
    // The same in all scenes.
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let (from, to) = range_rad;
    let drive = if to > from {
        Drive::Closing
    } else {
        Drive::Opening
    };
    let step = (to - from).signum() * 0.3e-3;
    let mut events = Vec::new();
    for i in 0..((to - from) / step) as i32 {
        let angle = from + step * i as f32;
        *time_us += 1000;
        let sample = Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (f64::from(angle) / f64::from(drivetrain.rad_per_count)) as i32,
            current_a: current_a(angle),
            drive,
            joint: (),
        };
        events.extend(sensor.update(&sample));
    }
    for _ in 0..400 {
        *time_us += 1000;
        let sample = Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (f64::from(to) / f64::from(drivetrain.rad_per_count)) as i32,
            current_a: 0.0,
            drive: Drive::Idle,
            joint: (),
        };
        events.extend(sensor.update(&sample));
    }
    events
}

pub(super) fn friction_a(angle: f32) -> f32 {
    0.015 + 0.001 * (20.0 * angle).cos()
}

pub(super) fn recorded() -> (Sensor<<P70 as Scene>::Finger>, u64) {
    let (mut sensor, mut time_us) = (sensor(), 0);
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 1.5), friction_a);
    motion(&mut sensor, &mut time_us, (1.5, 0.0), |a| -friction_a(a));
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 0.05), friction_a);
    assert!(
        matches!(told[..], [Event::FrictionRecorded { coverage, .. }] if coverage > 0.9),
        "{told:?}"
    );
    motion(&mut sensor, &mut time_us, (0.05, 0.0), |a| -friction_a(a));
    (sensor, time_us)
}

#[test]
fn a_free_closing_tells_its_stiffness_only() {
    let (mut sensor, mut time_us) = recorded();
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.45), friction_a);
    let [Event::Stiffness { .. }] = told[..] else {
        panic!("{told:?}");
    };
    let [k_a, sigma, free] = numbers(&told[0])[..] else {
        panic!("{told:?}");
    };
    assert_eq!(free, 0.0);
    assert!(k_a.abs() < 3.0 * sigma && sigma < 0.01, "{told:?}");
}

#[test]
fn what_is_free_of_a_closing_improves_the_record() {
    let (mut sensor, mut time_us) = recorded();
    assert_eq!(sensor.friction().map(Friction::passes), Some(1));
    for closings in 2..5 {
        sensor.direct(Directive::Watch);
        let told = motion(&mut sensor, &mut time_us, (0.0, 1.4), |angle| {
            // The third one touches.
            let contact = if closings == 4 { 0.02 } else { 0.0 };
            friction_a(angle) + contact * (angle - 1.2).max(0.0)
        });
        let touched = told
            .iter()
            .any(|event| matches!(event, Event::Touch { .. }));
        assert_eq!(touched, closings == 4, "{told:?}");
        motion(&mut sensor, &mut time_us, (1.4, 0.0), |a| -friction_a(a));
        assert_eq!(sensor.friction().map(Friction::passes), Some(closings));
    }
    // Nothing of the contact went into it.
    let friction = sensor.friction().expect("recorded");
    let per_ampere = P70::drivetrain(sensor.finger()).torque_per_ampere_nm;
    let rad_per_count = friction.rad_per_count;
    for angle in [0.3f32, 0.8, 1.1, 1.19, 1.25, 1.35] {
        let known = friction
            .at((angle / rad_per_count) as i32)
            .expect("recorded");
        let error = known.torque_nm - per_ampere * friction_a(angle);
        assert!(error.abs() < 1e-3, "{angle}: {error}");
    }
}

#[test]
fn a_softer_finger_is_unusual_and_no_contact() {
    let (mut sensor, mut time_us) = recorded();
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.4), |angle| {
        friction_a(angle) - 0.02 * (angle - 0.7).max(0.0)
    });
    let [
        Event::Unusual {
            k_a_nm_per_rad,
            k_a_free_nm_per_rad,
            ..
        },
        Event::Stiffness { .. },
    ] = told[..]
    else {
        panic!("{told:?}");
    };
    assert_eq!(k_a_free_nm_per_rad, 0.0);
    assert!(k_a_nm_per_rad < 0.0);
}

#[test]
fn of_a_contact_that_is_lost_no_force_is_told() {
    let closing = |end_rad: f32| {
        let (mut sensor, mut time_us) = recorded();
        sensor.direct(Directive::Watch);
        let drivetrain = P70::drivetrain(sensor.finger());
        let per_nm = 1.0 / (drivetrain.torque_per_ampere_nm * drivetrain.efficiency);
        // About as a contact in the middle of the distal phalanx; it slides off at 1.15 rad.
        let told = motion(&mut sensor, &mut time_us, (0.0, end_rad), |angle| {
            let contact_nm = 0.6 * (angle - 0.8).max(0.0);
            friction_a(angle)
                + if angle < 1.15 {
                    per_nm * contact_nm
                } else {
                    0.0
                }
        });
        let last = told.iter().rev().find_map(|event| match *event {
            Event::Located {
                k_m,
                force_n,
                settled: true,
                ..
            } => Some([k_m, force_n]),
            _ => None,
        });
        last.unwrap_or_else(|| panic!("{told:?}"))
    };
    // Nothing but the contact balances joint 1: the torque over the force's arm about it, k + l_1 cos theta_2, of a finger bent by up to 1 rad, at the
    // last verdict or some blocks before.
    let [k_m, held_n] = closing(1.14);
    let (torque_nm, l_1) = (0.6 * (1.14 - 0.8), 0.09);
    let [least_n, most_n] = [0.0f32, 1.0].map(|theta_2| torque_nm / (k_m + l_1 * theta_2.cos()));
    assert!(
        held_n > 0.9 * least_n && held_n < most_n,
        "{held_n}: {least_n} to {most_n}"
    );
    let [_, lost_n] = closing(1.3);
    assert!(lost_n.is_nan());
}

/// A finger with springs at both joints, whose free motion takes torque.
#[test]
fn a_spring_that_has_lost_its_hold_is_unusual() {
    let finger = Tendon2::MECHANISM;
    let drivetrain = Tendon2::drivetrain(&finger);
    let mut sensor = Sensor::new(
        finger,
        drivetrain,
        Tendon2::settings(),
        Tendon2::UNCALIBRATED,
    );
    // Its global stiffness without contact, newton metre per radian.
    let k_a = 0.061;
    let per_rad = k_a / (drivetrain.efficiency * drivetrain.torque_per_ampere_nm);
    let spring_a = |angle: f32, share: f32| friction_a(angle) + share * per_rad * angle;
    let mut time_us = 0;
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 2.0), |a| spring_a(a, 1.0));
    motion(&mut sensor, &mut time_us, (2.0, 0.0), |a| -friction_a(a));
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.9), |a| spring_a(a, 1.0));
    assert!(
        matches!(
            told[..],
            [Event::FrictionRecorded { .. }, Event::Stiffness { .. }]
        ),
        "{told:?}"
    );
    motion(&mut sensor, &mut time_us, (1.9, 0.0), |a| -friction_a(a));
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.9), |a| spring_a(a, 0.2));
    let [Event::Unusual { .. }, Event::Stiffness { .. }] = told[..] else {
        panic!("{told:?}");
    };
    let [measured, sigma, free] = numbers(&told[1])[..] else {
        panic!("{told:?}");
    };
    let lost = free - measured;
    assert!((lost - 0.8 * k_a).abs() < 0.003, "{told:?}");
    assert!(lost > 5.0 * sigma, "{told:?}");
}

#[test]
fn without_a_record_nothing_is_claimed() {
    let (mut sensor, mut time_us) = (sensor(), 0);
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.4), |angle| {
        0.015 + 0.1 * (angle - 0.7).max(0.0)
    });
    assert_eq!(told, []);
}

#[test]
fn what_was_kept_is_taken_only_if_valid() {
    let (recorded, _) = recorded();
    let mut other = sensor();
    let mut damaged = recorded.friction().unwrap().clone();
    damaged.travel_counts = 0;
    assert!(!other.set_friction(damaged) && other.friction().is_none());
    assert!(other.set_friction(recorded.friction().unwrap().clone()));
    assert_eq!(other.friction(), recorded.friction());
    assert!(other.restore_friction(recorded.friction().unwrap().clone()));
    let before = *other.calibration();
    assert!(!other.set_calibration(Calibration {
        torque_factor: f32::NAN,
        ..before
    }));
    assert_eq!(*other.calibration(), before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever a closing shows, the sensor answers with numbers and does not panic.
    #[test]
    fn any_current_gives_sound_events(
        slopes in proptest::collection::vec(-0.5f32..1.0, 4),
        jumps in proptest::collection::vec((0.2f32..1.4, -0.2f32..0.2), 0..3),
        directive in 0u8..3,
        nonsense in 0usize..4,
        after_restart: bool,
    ) {
        let (mut sensor, mut time_us) = recorded();
        if after_restart {
            let kept = sensor.friction().cloned().expect("recorded");
            prop_assert!(sensor.restore_friction(kept));
        }
        sensor.direct(match directive {
            0 => Directive::Watch,
            1 => Directive::Calibrate { phalanx: 2, k_m: 0.02 },
            _ => Directive::CalibrateCable,
        });
        let told = motion(&mut sensor, &mut time_us, (0.0, 1.45), |angle| {
            let bend: f32 = slopes.iter().enumerate()
                .map(|(i, slope)| slope * (angle - 0.3 * (i + 1) as f32).max(0.0)).sum();
            let jump: f32 = jumps.iter().filter(|(at, _)| angle > *at).map(|(_, by)| by).sum();
            let broken = nonsense == 3 && (0.8..0.82).contains(&angle);
            if broken { f32::NAN } else { friction_a(angle) + bend + jump }
        });
        for event in &told {
            prop_assert!(numbers(event).iter().all(|n| n.is_finite()), "{event:?}");
        }
        prop_assert!(sensor.calibration().is_valid());
    }

    /// Samples without any sense: no panic, nothing unsound.
    #[test]
    fn any_samples_are_survived(
        samples in proptest::collection::vec((any::<u32>(), any::<i32>(), any::<f32>(), 0u8..3), 0..400),
        after_restart: bool,
    ) {
        let (mut sensor, _) = recorded();
        if after_restart {
            let kept = sensor.friction().cloned().expect("recorded");
            prop_assert!(sensor.restore_friction(kept));
        }
        let mut time_us = 1 << 40;
        for (i, (gap, counts, current_a, drive)) in samples.into_iter().enumerate() {
            time_us += u64::from(gap % 3000);
            let sample = Sample {
                emf_v: f32::NAN,
                time_us,
                position_counts: counts,
                current_a,
                drive: [Drive::Closing, Drive::Opening, Drive::Idle][usize::from(drive)],
                joint: (),
            };
            if let Some(event) = sensor.update(&sample) {
                prop_assert!(numbers(&event).iter().all(|n| n.is_finite()), "{event:?}");
            }
            if i % 50 == 0 {
                sensor.direct(Directive::RecordFriction);
            }
        }
    }
}
