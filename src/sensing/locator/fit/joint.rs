//! What a sensor of joint 2 adds to a fit: at a given torque the change of the joint depends on the place where the stiffness does not
//! (docs/MECHANICS.md#joint-sensor).

use super::Fit;
use crate::finger::Mechanics;
use crate::joint_sensor::JointChange;
use crate::numeric::ln;
use crate::sensing::SeriesElement;
use crate::sensing::locator::prior::{
    FACTOR, FRICTION, JOINT, K, LOSS, ONSET, Prior, Scaling, UNKNOWNS, fits_loss,
};
use crate::sensing::locator::{Data, onset};

/// Degrees of freedom of the reading's distribution (Student's t): from a start far off, an error counts for less (chosen).
const FREEDOMS: f32 = 7.0;
/// Least way of the free finger from the curve's origin to the onset that gives joint 2's slope on it, radian.
const LEAST_WAY_RAD: f32 = 1e-3;
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
        scaling: &Scaling,
    ) {
        let expected = change
            .sigma_rad
            .is_finite()
            .then(|| self.expected(finger, data, prior, near, change, scaling))
            .flatten();
        let Some(pass) = &mut self.pass else { return };
        let Some((rad, slopes)) = expected else {
            // Taken for wrong, or without a prediction: both cost the same, so that neither is chosen for saying nothing.
            pass.logarithms += WRONG;
            return;
        };
        let residual = change.rad - rad;
        let deviation = residual / change.sigma_rad;
        let squares = deviation * deviation;
        pass.logarithms += (FREEDOMS + 1.0) * ln(1.0 + squares / FREEDOMS);
        let weight = (FREEDOMS + 1.0) / (FREEDOMS + squares);
        pass.normal.add(
            residual,
            &slopes,
            weight / (change.sigma_rad * change.sigma_rad),
        );
        // Do not fit the losses: near the stiffest place they would explain any reading, and the reading alone tells the place there
        // (docs/SENSING.md#losses-as-an-unknown-of-the-fit).
        if fits_loss::<F, X>() {
            pass.normal.hold(LOSS);
        }
    }

    /// The change of joint 2 that the trial's unknowns predict, radian, with its derivatives by them. It does not depend on the cable, nor,
    /// but by the torque, on the object's compliance.
    fn expected(
        &self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        change: &JointChange,
        scaling: &Scaling,
    ) -> Option<(f32, [f32; UNKNOWNS])> {
        let values = scaling.values(&self.trial);
        let model = &self.pass.as_ref()?.model;
        let torque_nm = values[FACTOR] * change.excess_nm + change.free_nm;
        let joint = model.joint_2(finger, torque_nm)?;
        // What it turned before the contact.
        let origin = onset::at::<F, X>(finger, data.origin_rad, prior, near)?;
        let before_rad = joint.at_contact_rad - finger.joint_rad(&origin.configuration, 2)?;
        let mut slopes = [0.0; UNKNOWNS];
        slopes[FACTOR] = joint.by_torque_rad_per_nm * change.excess_nm;
        slopes[JOINT] = joint.by_joint_friction_rad_per_nm;
        slopes[FRICTION] = joint.by_friction_rad;
        let way_rad = values[ONSET] - data.origin_rad;
        if way_rad.abs() > LEAST_WAY_RAD {
            slopes[ONSET] =
                before_rad / way_rad - joint.by_torque_rad_per_nm * model.contact_by_onset();
        }
        if self.hypothesis.has_place() {
            slopes[K] = joint.by_k_rad_per_m;
        }
        for (slope, deviation) in slopes.iter_mut().zip(&scaling.deviation) {
            *slope *= deviation;
        }
        slopes[FACTOR] += joint.by_joint_friction_rad_per_nm * scaling.joint_by_factor;
        Some((before_rad + joint.rad, slopes))
    }
}
