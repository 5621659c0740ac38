//! Places on fingers with springs at all joints, and on those whose leverage is uncertain.

use super::Noise as Random;
use super::locator::{CALIBRATION, curve, judged, locate, prior};
use crate::finger::{Contact, Mechanics};
use crate::scene::{Linkage3, P70, Scene, Tendon2};
use crate::sensing::Calibration;
use crate::sensing::locator::{Estimate, LocatorResult, Prior};

#[test]
fn sprung_fingers_work_the_same() {
    let mut random = Random(29);
    let check = |found: LocatorResult, k_m: f32| {
        let LocatorResult::At(estimate @ Estimate { phalanx: 2, .. }) = found else {
            panic!("{k_m}: {found:?}");
        };
        assert!(
            (estimate.k_m - k_m).abs() < 3.0 * estimate.k_sigma_m,
            "{k_m}: {estimate:?}"
        );
    };
    let finger = Tendon2::MECHANISM;
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.4;
    for k_m in [0.012, 0.025, 0.035] {
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: 0.014,
        };
        let points = curve(&finger, onset_rad, contact, &mut random);
        // The cable is twisted before the contact, too: the angle that was measured is larger.
        let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
        let measured = onset_rad + CALIBRATION.cable_rad_per_nm * free.torque_nm;
        check(judged(&finger, measured, &points), k_m);
    }
}

/// Deviation of a place on phalanx 2, whose torque factor is hardly known before, with a deviation of the leverage; metre.
fn sigma_with_leverage<F: Mechanics>(finger: &F, k_m: f32, leverage_sigma: f32) -> f32 {
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.4;
    let contact = Contact {
        phalanx: 2,
        k_m,
        radius_m: 0.014,
    };
    let points = curve(finger, onset_rad, contact, &mut Random(43));
    let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let measured_rad = onset_rad + CALIBRATION.cable_rad_per_nm * free.torque_nm;
    let prior = Prior {
        leverage_sigma,
        calibration: Calibration {
            torque_factor_sigma: 0.25,
            ..CALIBRATION
        },
        ..prior(measured_rad)
    };
    match locate(finger, measured_rad, &points, &prior).verdict(&prior) {
        LocatorResult::At(estimate) => estimate.k_sigma_m,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_factor_that_the_curve_tells_is_that_of_its_own_leverage() {
    for k_m in [0.02, 0.03] {
        let sigma_m = |leverage| sigma_with_leverage(&Tendon2::MECHANISM, k_m, leverage);
        let [none_m, some_m, more_m] = [0.0, 0.1, 0.2].map(sigma_m);
        assert!(some_m > 1.01 * none_m, "{k_m}: {none_m} {some_m}");
        // Variances add.
        let [some, more] = [some_m, more_m].map(|m| m * m - none_m * none_m);
        assert!((3.0..4.2).contains(&(more / some)), "{k_m}: {some} {more}");
        // One stage of long levers has the leverage that its lengths say.
        let even_m = |leverage| sigma_with_leverage(&P70::MECHANISM, k_m, leverage);
        assert_eq!(even_m(0.0), even_m(0.2));
    }
}

#[test]
fn three_phalanges_tell_the_phalanx_and_how_sure_that_is() {
    let finger = Linkage3::MECHANISM;
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.3;
    let mut random = Random(37);
    for (phalanx, k_m) in [(2, 0.02), (2, 0.045), (3, 0.015), (3, 0.03)] {
        let contact = Contact {
            phalanx,
            k_m,
            radius_m: 0.014,
        };
        let points = curve(&finger, onset_rad, contact, &mut random);
        let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
        let measured = onset_rad + CALIBRATION.cable_rad_per_nm * free.torque_nm;
        let verdict = judged(&finger, measured, &points);
        let near = |estimate: &Estimate| {
            estimate.phalanx == phalanx && (estimate.k_m - k_m).abs() < 3.0 * estimate.k_sigma_m
        };
        let right = match &verdict {
            LocatorResult::At(estimate) => near(estimate),
            LocatorResult::Either(both) => {
                let sum: f32 = both.iter().map(|e| e.p_phalanx).sum();
                assert!(sum > 0.5, "{both:?}");
                both.iter().any(near)
            }
            _ => false,
        };
        assert!(right, "{phalanx} {k_m}: {verdict:?}");
    }
}
