//! The place of a contact from one finite step of torque (docs/MECHANICS.md#finite-torque-step).

use crate::finger::{Candidate, Contact, Mechanics};
use crate::joint_sensor::Side;
use crate::numeric::Bounded;
use crate::sensing::location::{SeriesElement, supports};
use heapless::Vec;

/// Additional starting places of the search, as shares of either side of the phalanx's stiffest place.
const START_SHARES: [f32; 3] = [0.05, 0.5, 0.95];
/// Two answers nearer than this share of the phalanx's length are the same.
const SAME_SHARE: f32 = 1e-4;

/// Rounding error of a rotation, as a share of the largest change of a joint.
const ROUNDING: f32 = 2e-6;

/// Largest number of places that one step can have: two on each phalanx beyond the first.
pub const MAX_PLACES: usize = 4;

/// One finite step after contact, as measured: differences, never absolute values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Rise of the input torque since contact, newton metre.
    pub rise_nm: f32,
    /// Rotation on the actuator's side since contact, radian.
    pub rotation_rad: f32,
    /// Effective contact radius, metre; 0 where it is not known (docs/MECHANICS.md#finite-torque-step says what that
    /// costs).
    pub radius_m: f32,
}

/// All places where a contact explains a finite step, by phalanx and in the order found.
///
/// The secant, rotation over rise, is inverted as if it were the tangent at contact; each place that this gives, and a
/// few more on each phalanx, start Newton's method on the finite step. Unlike the tangent's inverse the answers are not
/// biased by the size of the step. Empty where nothing on phalanx 2 or beyond explains the step, or a value is not finite.
pub fn places<M: Mechanics>(
    finger: &M,
    at: &M::Configuration,
    torque_nm: f32,
    step: &Measured,
    series: &impl SeriesElement,
    side: Option<Side>,
) -> Vec<Candidate, MAX_PLACES> {
    let Measured {
        rise_nm, radius_m, ..
    } = *step;
    let rotation_rad = step.rotation_rad - rise_nm * series.compliance_rad_per_nm();
    let mut found: Vec<Candidate, MAX_PLACES> = Vec::new();
    let secant = finger.locate(at, torque_nm, rotation_rad / rise_nm);
    let mut try_from = |phalanx: u8, k_m: f32, length: f32| {
        let path = |k_m: f32| {
            let contact = Contact {
                phalanx,
                k_m,
                radius_m,
            };
            finger.path(at, torque_nm, contact)
        };
        let Some(guess) = path(k_m) else { return };
        let Some((k_m, _)) = finger.place(&guess, rise_nm, rotation_rad) else {
            return;
        };
        // Newton's method may end on a branch that no rising torque leads to: the path from the place found must turn the
        // input link as measured.
        let followed = path(k_m).and_then(|mut path| finger.follow(&mut path, rise_nm));
        let Some(point) = followed else { return };
        let most = point
            .joints_rad
            .iter()
            .fold(0.0f32, |m, change| change.abs().at_least(m));
        if (point.rotation_rad - rotation_rad).abs()
            > SAME_SHARE * rotation_rad.abs() + ROUNDING * most
        {
            return;
        }
        let known = found
            .iter()
            .any(|f| f.phalanx == phalanx && (f.k_m - k_m).abs() <= SAME_SHARE * length);
        if !known {
            // Beyond the stiffest place the next joint opens as the torque rises.
            let next = usize::from(phalanx)
                .checked_sub(1)
                .and_then(|joint| point.joints_rad.get(joint));
            let beyond_stiffest = next.is_some_and(|change| *change < 0.0);
            let _ = found.push(Candidate {
                phalanx,
                k_m,
                beyond_stiffest,
            });
        }
    };
    for candidate in secant.candidates() {
        if let Some(length) = finger.phalanx_length_m(candidate.phalanx) {
            try_from(candidate.phalanx, candidate.k_m, length);
        }
    }
    for phalanx in 2u8.. {
        let Some(length) = finger.phalanx_length_m(phalanx) else {
            break;
        };
        let peak = finger
            .stiffest_m(at, torque_nm, phalanx)
            .filter(|k| *k > 0.0 && *k < length)
            .unwrap_or(length);
        for share in START_SHARES {
            try_from(phalanx, share * peak, length);
            try_from(phalanx, peak + share * (length - peak), length);
        }
    }
    let mut allowed = Vec::new();
    for candidate in found.iter().filter(|candidate| supports(side, candidate)) {
        // Has the capacity of `found`.
        let _ = allowed.push(*candidate);
    }
    if allowed.is_empty() { found } else { allowed }
}
