//! Contacts at known places one after the other.

use super::Noise as Random;
use super::locator::{CALIBRATION, HALF_THICKNESS_M, curve, locate, prior};
use super::sensor::{friction_a, motion, recorded};
use crate::finger::{Contact, Mechanics};
use crate::scene::{P70, Scene, Tendon2};
use crate::sensing::locator::{Estimate, LocatorResult, Place, Prior};
use crate::sensing::{Cable, Calibration, Directive, Event, Refusal};

/// What a pin at `true_m` teaches who is told that it is at `told_m`.
fn taught(
    before: &Calibration,
    told_m: f32,
    true_m: f32,
    random: &mut Random,
) -> Result<Calibration, Refusal> {
    let finger = P70::MECHANISM;
    let radius_m = HALF_THICKNESS_M + 0.005;
    let contact = Contact {
        phalanx: 2,
        k_m: true_m,
        radius_m,
    };
    let points = curve(&finger, 0.8, contact, random);
    let prior = Prior {
        place: Place::Known {
            phalanx: 2,
            k_m: told_m,
            sigma_m: 3e-4,
            radius_m,
        },
        calibration: *before,
        ..prior(0.8)
    };
    let learned = locate(&finger, 0.8, &points, &prior)
        .learned(&prior)
        .unwrap();
    before.with_contact(&learned.calibration, learned.misfit, learned.strain)
}

/// After a press, before any pin.
fn pressed() -> Calibration {
    Calibration {
        torque_factor_sigma: 0.115,
        cable_sigma_rad_per_nm: 0.02,
        contacts: 0,
        ..CALIBRATION
    }
}

#[test]
fn pins_that_contradict_each_other_are_refused_with_the_reason() {
    let mut random = Random(43);
    let mut agreed = 0;
    for _ in 0..10 {
        let first = taught(&pressed(), 0.021, 0.021, &mut random).unwrap();
        assert!(first.torque_factor_sigma < 0.06, "{first:?}");
        // A second pin further out is welcome, if it adds anything.
        let second = taught(&first, 0.035, 0.035, &mut random);
        assert!(
            matches!(second, Ok(_) | Err(Refusal::Uninformative)),
            "{second:?}"
        );
        agreed += usize::from(second.is_ok());
        // One that is not where it is said to be is not averaged in.
        for (told_m, true_m) in [(0.035, 0.048), (0.035, 0.022)] {
            let refused = taught(&first, told_m, true_m, &mut random);
            assert!(
                matches!(refused, Err(Refusal::Implausible | Refusal::Misfit)),
                "{told_m} {true_m}: {refused:?}"
            );
        }
    }
    assert!(agreed > 3, "{agreed}");
}

/// A place that is 3 mm wrong is within what a finger may differ by: it may be taken, but then both deviations together cover the shift.
#[test]
fn a_pin_that_contradicts_another_is_refused_or_both_deviations_cover_the_shift() {
    let mut random = Random(53);
    let mut moved = 0;
    for _ in 0..6 {
        let first = taught(&pressed(), 0.021, 0.021, &mut random).unwrap();
        for (told_m, true_m) in [(0.033, 0.030), (0.027, 0.030)] {
            let second = match taught(&first, told_m, true_m, &mut random) {
                Ok(second) => second,
                Err(why) => {
                    assert_eq!(why, Refusal::Implausible);
                    continue;
                }
            };
            let shift = (second.torque_factor / first.torque_factor - 1.0).abs();
            // What the first one's deviation does not explain of the shift, the second one's does.
            let [before, now] = [first, second].map(|told| told.torque_factor_sigma);
            assert!(shift <= 1.001 * before.hypot(now), "{second:?}");
            moved += usize::from(shift > before);
        }
    }
    assert!(moved > 3, "{moved}");
}

#[test]
fn a_factor_that_a_later_pin_moves_by_many_deviations_is_refused() {
    let first = Calibration {
        torque_factor_sigma: 0.03,
        correlation: 0.6,
        contacts: 1,
        ..pressed()
    };
    let moved = |before: &Calibration, deviations: f32| {
        let sigma = before.torque_factor_sigma;
        let found = Calibration {
            torque_factor: before.torque_factor * (1.0 + deviations * sigma),
            torque_factor_sigma: 0.7 * sigma,
            ..*before
        };
        before.with_contact(&found, 0.5, 1.0)
    };
    for deviations in [-2.4f32, -1.0, -0.1, 0.1, 1.0, 2.4] {
        let learned = moved(&first, deviations).unwrap();
        // By the pin alone, with 0.7 together, it would be 0.98.
        let unexplained = (deviations * deviations - 1.0).max(0.0);
        let share = learned.torque_factor_sigma / first.torque_factor_sigma;
        let expected = (0.96 + unexplained).sqrt();
        assert!(
            (share / expected - 1.0).abs() < 0.1,
            "{deviations}: {share}"
        );
        // What is unsure for a reason of its own depends less on the cable.
        let correlation = 0.6 * 0.98 / expected;
        assert!(
            (learned.correlation - correlation).abs() < 0.06,
            "{learned:?}"
        );
    }
    for deviations in [-2.8, 2.8] {
        assert_eq!(moved(&first, deviations), Err(Refusal::Implausible));
        // What only a data sheet told may be as wrong.
        assert!(moved(&pressed(), deviations).is_ok());
    }
}

/// What is wrong with all pins alike does not average out.
#[test]
fn further_pins_are_no_surer_than_the_best_of_them() {
    let first = Calibration {
        torque_factor_sigma: 0.03,
        contacts: 1,
        ..pressed()
    };
    let taught = |sigma: f32| {
        let found = Calibration {
            torque_factor_sigma: sigma,
            ..first
        };
        first.with_contact(&found, 0.5, 1.0).unwrap()
    };
    // Another one as good, and one that alone would have 0.015.
    let (same, better) = (taught(0.03 / core::f32::consts::SQRT_2), taught(0.0134164));
    assert!((same.torque_factor_sigma - 0.03).abs() < 1e-5, "{same:?}");
    assert!(
        (better.torque_factor_sigma - 0.015).abs() < 1e-5,
        "{better:?}"
    );
}

/// What a pin alone says of the factor: its information is what the fit has more than before, and only its own residuals make it unsure.
#[test]
fn what_a_pin_alone_says_of_the_factor_has_its_own_residuals_and_the_unit_of_the_new_factor() {
    let first = Calibration {
        torque_factor_sigma: 0.03,
        contacts: 1,
        ..pressed()
    };
    let taken = |factor: f32, alone: f32, misfit: f32| {
        let both = 1.0 / (1.0 / (alone * alone) + 1.0 / (0.03f32 * 0.03)).sqrt();
        let found = Calibration {
            torque_factor: factor,
            torque_factor_sigma: both / factor,
            ..first
        };
        (first.with_contact(&found, misfit, 1.0).unwrap()).torque_factor_sigma
    };
    for (factor, alone, misfit, expected) in [
        (0.98, 0.026, 0.5, 0.026 / 0.98),
        (1.02, 0.026, 0.5, 0.026 / 1.02),
        (1.0, 0.012, 2.0, 0.012 * core::f32::consts::SQRT_2),
        (1.0, 0.012, 4.0, 0.024),
    ] {
        let sigma = taken(factor, alone, misfit);
        assert!(
            (sigma - expected).abs() < 1e-5,
            "{factor} {misfit}: {sigma}"
        );
    }
}

#[test]
fn a_strained_fit_is_taken_with_a_wider_deviation() {
    let before = pressed();
    let found = Calibration {
        torque_factor: 0.95,
        torque_factor_sigma: 0.02,
        ..before
    };
    let sigma = |strain| {
        before
            .with_contact(&found, 0.5, strain)
            .map(|learned| learned.torque_factor_sigma)
    };
    assert_eq!(sigma(1.0), Ok(0.02));
    assert!((sigma(4.0).unwrap() - 0.04).abs() < 1e-6);
    assert_eq!(sigma(17.0), Err(Refusal::Implausible));
    // Never less sure than before it.
    let little = Calibration {
        torque_factor_sigma: 0.1,
        ..found
    };
    let taken = before.with_contact(&little, 0.5, 9.0).unwrap();
    assert_eq!(taken.torque_factor_sigma, before.torque_factor_sigma);
}

/// Where joint 2 stands at 90 degrees, a contact anywhere on the distal phalanx of a tendon finger is as stiff as anywhere
/// else on it (docs/MECHANICS.md#observability).
#[test]
fn where_the_stiffness_does_not_depend_on_the_place_it_is_not_claimed() {
    let finger = Tendon2::MECHANISM;
    let mut random = Random(47);
    let onset_rad = (1..400)
        .map(|i| finger.input_angle_rad(&finger.rest()) + 0.01 * i as f32)
        .find(|angle_rad| {
            let free = finger.free_at_angle(*angle_rad, &finger.rest());
            free.and_then(|free| finger.joint_rad(&free.configuration, 2))
                .is_some_and(|joint_rad| joint_rad >= core::f32::consts::FRAC_PI_2)
        })
        .expect("a posture with joint 2 at a right angle");
    let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let measured_rad = onset_rad + CALIBRATION.cable_rad_per_nm * free.torque_nm;
    let length_m = finger.phalanx_length_m(2).unwrap();
    let mut judged = [0, 0];
    for k_m in [0.015, 0.03, 0.045] {
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: HALF_THICKNESS_M + 0.005,
        };
        let points = curve(&finger, onset_rad, contact, &mut random);
        // A beginning of the rise, where the tangent alone speaks, and all of it.
        let most_nm = points.iter().fold(0.0f32, |top, p| top.max(p.excess_nm));
        for share in [0.05, 1.0] {
            let points: Vec<_> = points
                .iter()
                .copied()
                .filter(|point| point.excess_nm <= share * most_nm)
                .collect();
            let prior: Prior<Cable> = prior(measured_rad);
            let verdict = locate(&finger, measured_rad, &points, &prior).verdict(&prior);
            let LocatorResult::At(estimate @ Estimate { phalanx: 2, .. }) = verdict else {
                continue;
            };
            judged[usize::from(share == 1.0)] += 1;
            // So vague a place is told as unobservable by the sensor.
            let vague = estimate.k_sigma_m >= 0.25 * length_m;
            assert!(vague || share == 1.0, "{k_m} {share}: {estimate:?}");
            // The path leads away from the right angle, and tells what it can.
            let off_m = (estimate.k_m - k_m).abs();
            assert!(
                vague || off_m < 3.0 * estimate.k_sigma_m,
                "{k_m}: {estimate:?}"
            );
        }
    }
    assert_eq!(judged, [3, 3]);
}

#[test]
fn a_pin_that_the_finger_misses_is_told() {
    let (mut sensor, mut time_us) = recorded();
    sensor.direct(Directive::Calibrate {
        phalanx: 2,
        k_m: 0.03,
    });
    let mut told = motion(&mut sensor, &mut time_us, (0.0, 1.4), friction_a);
    sensor.direct(Directive::Rest);
    told.extend(motion(&mut sensor, &mut time_us, (1.4, 1.3), |a| {
        -friction_a(a)
    }));
    let why = Refusal::NoContact;
    assert!(
        matches!(told[..], [Event::Stiffness { .. }, Event::CalibrationRefused { why: told }] if told == why),
        "{told:?}"
    );
}
