//! The model's derivatives, and the normal equations that follow from them.

use super::model::Pass;
use super::unknowns::{
    CABLE, CREEP, FACTOR, INERTIA, K, OFFSET, ONSET, RADIUS, RADIUS_MAX_M, Values,
};
use super::{Data, Hypothesis, Place, Prior, UNKNOWNS};
use crate::finger::{Free, Mechanics};
use crate::numeric::sqrt;
use crate::sensing::normal::Normal;

impl Hypothesis {
    /// Normal equations at the present values.
    pub(super) fn linearise<F: Mechanics>(
        &self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        onset: &Free<F::Configuration>,
        values: &Values,
        here: &Pass,
    ) -> Option<Normal<UNKNOWNS>> {
        let length = finger.phalanx_length_m(self.phalanx)?;
        let calibration = &prior.calibration;
        let rest = sqrt((1.0 - calibration.correlation * calibration.correlation).max(0.0));
        let (k_scale, known) = match prior.place {
            Place::Anywhere => (length, false),
            Place::Known { sigma_m, .. } => (sigma_m, true),
        };
        // Differences towards the inside, so that both ends of a step exist.
        let k_step = if values.k_m > 0.5 * length {
            -0.006
        } else {
            0.006
        } * length;
        let radius_step = if values.radius_m > 0.5 * RADIUS_MAX_M {
            -0.001
        } else {
            0.001
        };
        let (by_k, by_radius) = if self.is_proximal() {
            (None, None)
        } else {
            let moved = Values {
                k_m: values.k_m + k_step,
                ..*values
            };
            let by_k = self.follow(finger, onset, &moved, data.points);
            let moved = Values {
                radius_m: values.radius_m + radius_step,
                ..*values
            };
            (
                Some(by_k),
                Some(self.follow(finger, onset, &moved, data.points)),
            )
        };
        let reached = [by_k.as_ref(), by_radius.as_ref()]
            .into_iter()
            .flatten()
            .fold(here.reached, |least, pass| least.min(pass.reached));
        let mut normal = Normal::EMPTY;
        for (index, point) in data.points.iter().enumerate().take(reached) {
            let (Some(&rotation), Some(&compliance)) =
                (here.rotation.get(index), here.compliance.get(index))
            else {
                break;
            };
            let (residual, variance, slope) =
                Self::residual(data, point, values, onset.torque_nm, rotation, compliance);
            let torque = values.torque_nm(point);
            let excess = torque - onset.torque_nm / values.factor;
            let derivative = |pass: &Option<Pass>, step: f32| {
                pass.as_ref()
                    .and_then(|pass| pass.rotation.get(index))
                    .map_or(0.0, |moved| (moved - rotation) / step)
            };
            let by_factor = torque * compliance
                + values.cable * onset.torque_nm / (values.factor * values.factor);
            let mut slopes = [0.0; UNKNOWNS];
            slopes[K] = derivative(&by_k, k_step) * k_scale;
            slopes[RADIUS] = derivative(&by_radius, radius_step) * prior.radius_m.1;
            slopes[OFFSET] = -slope * prior.offset_sigma_nm;
            slopes[ONSET] = prior.onset_rad.1;
            let cable_sigma = calibration.cable_sigma_rad_per_nm;
            slopes[FACTOR] = by_factor
                * calibration.torque_factor
                * calibration.torque_factor_sigma
                + (excess + values.creep * point.late_nm) * cable_sigma * calibration.correlation;
            let late = values.creep * point.late_nm;
            slopes[CABLE] = (excess + late) * cable_sigma * rest;
            slopes[INERTIA] = -slope * point.inertia_nm * prior.inertia_share;
            slopes[CREEP] = values.cable * point.late_nm * prior.creep[1];
            normal.add(residual, &slopes, 1.0 / variance);
        }
        for (unknown, &value) in self.x.iter().enumerate() {
            let weight = if unknown != K || known {
                1.0
            } else if self.is_proximal() {
                12.0
            } else {
                // A uniform prior has a variance of 1/12; as a slope it says nothing.
                1e-3
            };
            let value = if unknown == K && !known { 0.0 } else { value };
            normal.add_prior(unknown, value, weight);
        }
        Some(normal)
    }
}
