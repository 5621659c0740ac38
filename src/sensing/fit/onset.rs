//! The free finger at the onset, seen through the cable.

use super::{Hypothesis, Prior};
use crate::finger::{Free, Mechanics};
use crate::sensing::Calibration;
use crate::sensing::location::Series;

/// Posture and torque of the free finger at an angle measured before the cable: the torque that holds the finger twists
/// it, if there is a cable. `near` is where the search starts.
// Several kilobyte, wanted in several places.
#[inline(never)]
pub fn free_behind_cable<F: Mechanics, X: Series>(
    finger: &F,
    measured_rad: f32,
    calibration: &Calibration,
    creep: f32,
    near: &F::Configuration,
) -> Option<Free<F::Configuration>> {
    if !X::FLEXIBLE {
        return finger.free_at_angle(measured_rad, near);
    }
    let twist_rad_per_nm = calibration.cable_rad_per_nm * (1.0 + creep) / calibration.torque_factor;
    let mut free = finger.free_at_angle(measured_rad, near)?;
    // The twist is small beside the angle: each round takes the error down by the cable's share of the compliance.
    for _ in 0..3 {
        if free.torque_nm == 0.0 {
            break;
        }
        let angle_rad = measured_rad - twist_rad_per_nm * free.torque_nm;
        free = finger.free_at_angle(angle_rad, &free.configuration)?;
    }
    Some(free)
}

impl Hypothesis {
    pub(super) fn onset<F: Mechanics, X: Series>(
        finger: &F,
        onset_rad: f32,
        prior: &Prior<X>,
        near: &F::Configuration,
    ) -> Option<Free<F::Configuration>> {
        free_behind_cable::<F, X>(finger, onset_rad, &prior.calibration, prior.creep[0], near)
    }
}
