//! Properties of the inverse: forward then inverse, and the shape of the compliance that makes it unique.

use palpate::finger::{Class, Contact};
use palpate::sensing::location::{Cable, SeriesElement};
use palpate::sensing::step;
use proptest::prelude::*;

use super::setup::{AnyFinger, preshaped, presses, risen};

/// Forward then inverse returns the place, by both solvers; every candidate presses and lies on its phalanx.
pub fn round_trip<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    phalanx: u8,
    at: f32,
) -> Result<(), TestCaseError> {
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(phalanx)
        .expect("it has that phalanx");
    let k_m = at * length;
    if !presses(finger, &posture, torque, phalanx, k_m) {
        return Err(TestCaseError::reject("does not press there"));
    }
    let compliance = finger
        .contact_compliance(&posture, torque, phalanx, k_m)
        .expect("a contact that presses");
    let peak = finger
        .stiffest_m(&posture, torque, phalanx)
        .unwrap_or(f32::INFINITY);
    // Around the stiffest place of phalanx 3 and of an eliminated joint, C has a smooth minimum: k is only as good as
    // the root of the rounding there.
    let tolerance = if N == 3 && (k_m - peak).abs() < 0.05 * length {
        0.05
    } else {
        2e-3
    };
    for answer in [
        finger.locate(&posture, torque, compliance),
        finger.locate_closed(&posture, torque, compliance),
    ] {
        for candidate in answer.candidates() {
            let on = finger
                .phalanx_length_m(candidate.phalanx)
                .expect("a phalanx it has");
            prop_assert!(candidate.k_m > 0.0 && candidate.k_m <= on);
            prop_assert!(
                presses(finger, &posture, torque, candidate.phalanx, candidate.k_m),
                "{candidate:?} does not press"
            );
            let again = finger
                .contact_compliance(&posture, torque, candidate.phalanx, candidate.k_m)
                .expect("a value");
            let proximal = finger
                .proximal_compliance(&posture, torque)
                .expect("a value");
            prop_assert!(
                (again - compliance).abs() <= 2e-5 * proximal.max(compliance),
                "{again} {compliance}"
            );
        }
        if answer.class() == Class::Proximal {
            continue;
        }
        let found = answer
            .candidates()
            .iter()
            .any(|c| c.phalanx == phalanx && (c.k_m - k_m).abs() <= tolerance * length);
        prop_assert!(found, "{k_m} on {phalanx} not in {answer:?}");
    }
    Ok(())
}

/// C falls from the joint to the stiffest place and rises beyond; C_prox at the joint; never above C_free.
pub fn monotone<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    phalanx: u8,
) -> Result<(), TestCaseError> {
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(phalanx)
        .expect("it has that phalanx");
    let peak = finger.stiffest_m(&posture, torque, phalanx);
    let proximal = finger
        .proximal_compliance(&posture, torque)
        .expect("stable");
    let mut before = None;
    let mut pressed = 0;
    for i in 1..=60u8 {
        let k_m = length * f32::from(i) / 60.0;
        if !presses(finger, &posture, torque, phalanx, k_m) {
            before = None;
            continue;
        }
        let c = finger
            .contact_compliance(&posture, torque, phalanx, k_m)
            .expect("it presses");
        if let Some(free) = finger.free_compliance(&posture, torque) {
            prop_assert!(c <= free * 1.00001, "{c} above the free finger's {free}");
        }
        if let (Some((k_before, c_before)), Some(peak)) = (before, peak) {
            let slack = 3e-6 * proximal;
            let falls: bool = k_m <= peak;
            let rises: bool = k_before >= peak;
            prop_assert!(
                !(falls && peak > 0.0) || c <= c_before + slack,
                "rises before {peak} at {k_m}"
            );
            prop_assert!(
                !(rises && peak > 0.0) || c >= c_before - slack,
                "falls beyond {peak} at {k_m}"
            );
        }
        before = Some((k_m, c));
        pressed += 1;
    }
    prop_assert!(pressed > 0, "no place presses");
    Ok(())
}

/// A step made by the path is located by the estimator, with radius and cable.
pub fn step_round_trip<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError> {
    let (start, rise_nm, point) = risen(finger, share, contact, 0.15)?;
    let (posture, torque) = (start.posture, start.torque_nm);
    let (length, contact) = (start.length_m, start.contact);
    let peak = finger
        .stiffest_m(&posture, torque, contact.phalanx)
        .unwrap_or(f32::INFINITY);
    // There the rotation has its minimum over k: rounding decides whether the measured one is reached at all.
    if (contact.k_m - peak).abs() < if N == 3 { 0.1 } else { 0.02 } * length {
        return Err(TestCaseError::reject("the stiffest place"));
    }
    let cable = Cable::new(4.0).expect("in range");
    let rotation_rad = point.rotation_rad + rise_nm * cable.compliance_rad_per_nm();
    let measured = step::Measured {
        rise_nm,
        rotation_rad,
        radius_m: contact.radius_m,
    };
    let found = step::places(finger, &posture, torque, &measured, &cable, None);
    let near = |k: f32| (k - contact.k_m).abs() <= 2e-3 * length;
    prop_assert!(
        found
            .iter()
            .any(|c| c.phalanx == contact.phalanx && near(c.k_m)),
        "{contact:?} not in {found:?}"
    );
    Ok(())
}
