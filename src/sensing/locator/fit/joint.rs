//! What a sensor of joint 2 adds to a fit: at a given torque the change of the joint depends on the place where the stiffness does not
//! (docs/MECHANICS.md#joint-sensor).

use super::Fit;
use crate::finger::{Free, Mechanics};
use crate::joint_sensor::JointChange;
use crate::numeric::ln;
use crate::sensing::SeriesElement;
use crate::sensing::locator::prior::{FACTOR, FRICTION, K, ONSET, Prior, Scaling, UNKNOWNS};
use crate::sensing::locator::{Data, onset};

/// Degrees of freedom of the reading's distribution (Student's t): from a start far off, an error counts for less (chosen).
const FREEDOMS: f32 = 7.0;
/// What it costs to take a reading for wrong, as twice a logarithm of odds: a sensor is wrong in one of fifty contacts, and tells any angle
/// of 1.5 rad then (chosen). So a sensor that is wrong does not decide alone.
const WRONG: f32 = 17.0;

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// Adds the reading to a complete pass. The torque counts as known: its error is small beside the reading's.
    #[inline(never)]
    pub(super) fn weigh_joint(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        change: &JointChange,
    ) {
        if !change.sigma_rad.is_finite() {
            if let Some(pass) = &mut self.pass {
                pass.logarithms += WRONG;
            }
            return;
        }
        let scaling = Scaling::of(prior, self.hypothesis.length_m);
        let values = scaling.values(&self.trial);
        let free = |rad: f32| onset::at::<F, X>(finger, rad, prior, near);
        let (Some(origin), Some(onset)) = (free(data.origin_rad), free(values[ONSET])) else {
            return;
        };
        let rad = |free: &Free<F::Configuration>| finger.joint_rad(&free.configuration, 2);
        let (Some(origin_rad), Some(onset_rad)) = (rad(&origin), rad(&onset)) else {
            return;
        };
        let Some(pass) = &mut self.pass else { return };
        let torque_nm = values[FACTOR] * change.excess_nm + change.free_nm;
        let Some((joint, turned_rad)) = pass.model.joint_2(finger, torque_nm) else {
            return;
        };
        let mut slopes = [0.0; UNKNOWNS];
        slopes[FACTOR] = joint.by_torque_rad_per_nm * change.excess_nm;
        if self.hypothesis.has_place() {
            slopes[K] = joint.by_k_rad_per_m;
        }
        slopes[FRICTION] = joint.by_friction_rad;
        for (slope, deviation) in slopes.iter_mut().zip(&scaling.deviation) {
            *slope *= deviation;
        }
        let residual = change.rad - (onset_rad - origin_rad) - turned_rad;
        let deviation = residual / change.sigma_rad;
        let squares = deviation * deviation;
        pass.logarithms += (FREEDOMS + 1.0) * ln(1.0 + squares / FREEDOMS);
        let weight = (FREEDOMS + 1.0) / (FREEDOMS + squares);
        pass.normal.add(
            residual,
            &slopes,
            weight / (change.sigma_rad * change.sigma_rad),
        );
    }
}
