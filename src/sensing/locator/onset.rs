//! The free finger where a contact begins.

use super::prior::Prior;
use crate::finger::{Free, Mechanics};
use crate::sensing::{Calibration, SeriesElement};

/// The free finger at an angle measured on the actuator's side of the cable, with its weight.
pub(super) fn at<F: Mechanics, X: SeriesElement>(
    finger: &F,
    measured_rad: f32,
    prior: &Prior<X>,
    near: &F::Configuration,
) -> Option<Free<F::Configuration>> {
    let free = free_behind_cable::<F, X>(finger, measured_rad, &prior.calibration, near)?;
    if prior.weight[0] == 0.0 {
        return Some(free);
    }
    Some(
        finger
            .weighed(&free, prior.weight[0], prior.preload_nm)
            .map_or(free, |(weighed, _)| weighed),
    )
}

/// Posture and torque of the free finger at an angle measured on the actuator's side of the cable, which the torque twists.
/// `near` is the start value.
// Not inlined: several kilobytes, called from several places.
#[inline(never)]
pub fn free_behind_cable<F: Mechanics, X: SeriesElement>(
    finger: &F,
    measured_rad: f32,
    calibration: &Calibration,
    near: &F::Configuration,
) -> Option<Free<F::Configuration>> {
    let mut free = finger.closing_at_angle(measured_rad, near)?;
    if !X::FLEXIBLE {
        return Some(free);
    }
    let twist_rad_per_nm = calibration.cable_rad_per_nm / calibration.torque_factor;
    // The twist is small compared with the angle: each iteration reduces the error by the cable's share of the compliance.
    for _ in 0..3 {
        if free.torque_nm == 0.0 {
            break;
        }
        let angle_rad = measured_rad - twist_rad_per_nm * free.torque_nm;
        free = finger.closing_at_angle(angle_rad, &free.configuration)?;
    }
    Some(free)
}
