//! What a sensor of joint 2 adds to a fit: at a given torque the change of the joint depends on the place where the stiffness does not
//! (docs/MECHANICS.md#joint-sensor).

use super::Fit;
use crate::finger::{Free, Mechanics};
use crate::joint_sensor::JointChange;
use crate::numeric::ln;
use crate::sensing::SeriesElement;
use crate::sensing::locator::model::Model;
use crate::sensing::locator::prior::{FACTOR, FRICTION, K, ONSET, Prior, Scaling, UNKNOWNS};
use crate::sensing::locator::{Data, onset};

/// Degrees of freedom of the reading's distribution (Student's t): from a start far off, an error counts for less (chosen).
const FREEDOMS: f32 = 7.0;
/// What it costs to take a reading for wrong, as twice a logarithm of odds: a sensor is wrong in one of fifty contacts, and tells any angle
/// of 1.5 rad then (chosen). So a sensor that is wrong does not decide alone.
const WRONG: f32 = 17.0;
/// Step for the derivatives, in lengths of the phalanx or in deviations.
const STEP: f32 = 0.02;

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
        let torque_nm = values[FACTOR] * change.excess_nm + change.free_nm;
        let since = |x: &[f32; UNKNOWNS]| {
            Model::<F, X>::new(
                finger,
                (data.origin_rad, data.drivetrain),
                &scaling.values(x),
                prior,
                self.hypothesis.hold,
                &onset,
            )?
            .joint_2_rad(finger, torque_nm)
        };
        let Some(pass) = &mut self.pass else { return };
        // A contact that slides off its phalanx turns the joint no further.
        let end_rad = pass.model.end().joints_rad[1];
        let turned_rad = since(&self.trial).unwrap_or(end_rad);
        let mut slopes = [0.0; UNKNOWNS];
        // About in proportion to the torque.
        slopes[FACTOR] = turned_rad / values[FACTOR] * scaling.deviation[FACTOR];
        let by = |unknown: usize, step: f32| {
            let mut beside = self.trial;
            beside[unknown] += step;
            since(&beside).map_or(0.0, |other| (other - turned_rad) / step)
        };
        if self.hypothesis.has_place() {
            let step = if self.trial[K] < 0.5 { STEP } else { -STEP };
            slopes[K] = by(K, step);
            slopes[FRICTION] = by(FRICTION, STEP);
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
