//! What a fit tells: values with their deviations, its evidence, and what it teaches about the drivetrain.

use super::model::Pass;
use super::unknowns::{CABLE, FACTOR, K, RADIUS, Values};
use super::{Hypothesis, Place, Prior};
use crate::finger::{Mechanics, PathPoint};
use crate::numeric::{ln, sqrt};
use crate::sensing::Calibration;

/// Result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Location at first contact, metre.
    pub k_m: f32,
    /// Its standard deviation, metre.
    pub k_sigma_m: f32,
    /// Effective contact radius, metre.
    pub radius_m: f32,
    /// Its standard deviation, metre.
    pub radius_sigma_m: f32,
    /// Angle of the input link at the onset, radian.
    pub onset_rad: f32,
    /// Torque factor.
    pub torque_factor: f32,
    /// Cable's twist, radian per newton metre of nominal torque.
    pub cable_rad_per_nm: f32,
    /// Offset of the torque, newton metre.
    pub offset_nm: f32,
    /// Sum of squared residuals over their variances.
    pub chi_square: f32,
    /// Points that the path reached.
    pub reached: usize,
    /// End of the path.
    pub end: PathPoint,
}

impl Hypothesis {
    pub(super) fn report<F: Mechanics>(
        &self,
        finger: &F,
        prior: &Prior,
        values: &Values,
        chi_square: f32,
        pass: &Pass,
    ) -> Option<Estimate> {
        let factor = self.factor.as_ref()?;
        let length = finger.phalanx_length_m(self.phalanx)?;
        let k_scale = match prior.place {
            Place::Anywhere => length,
            Place::Known { sigma_m, .. } => sigma_m,
        };
        let deviation = |unknown: usize| {
            let variance = factor
                .covariance(unknown)
                .get(unknown)
                .copied()
                .unwrap_or(0.0);
            sqrt(variance.max(0.0))
        };
        Some(Estimate {
            k_m: values.k_m,
            k_sigma_m: k_scale * deviation(K),
            radius_m: values.radius_m,
            radius_sigma_m: prior.radius_m.1 * deviation(RADIUS),
            onset_rad: values.onset_rad,
            torque_factor: values.factor,
            cable_rad_per_nm: values.cable,
            offset_nm: values.offset_nm,
            chi_square,
            reached: pass.reached,
            end: pass.end,
        })
    }

    /// Logarithm of how well the hypothesis explains the curve, all values of its unknowns together (Laplace's
    /// approximation of the evidence): what has more freedom pays for it. `spread` is by how much the residuals of the
    /// best hypothesis exceed what was expected; it makes all of them less sure.
    pub fn ln_evidence(&self, spread: f32) -> f32 {
        let Some(factor) = &self.factor else {
            return f32::NEG_INFINITY;
        };
        let mut determinant = factor.ln_determinant();
        let mut flat = 0.0;
        if self.is_proximal() {
            // The unknown that it does not have.
            determinant -= ln(12.0);
        } else {
            flat = 0.5 * ln(core::f32::consts::TAU);
        }
        -0.5 * self.cost / spread.max(1.0) - 0.5 * determinant + flat
    }

    /// What a fit at a known place teaches: torque factor and cable, with their covariance.
    pub fn learned(&self, prior: &Prior) -> Option<Calibration> {
        let estimate = self.best.as_ref()?;
        let factor = self.factor.as_ref()?;
        let before = &prior.calibration;
        let rest = sqrt((1.0 - before.correlation * before.correlation).max(0.0));
        let by_factor = factor.covariance(FACTOR);
        let by_cable = factor.covariance(CABLE);
        let (ff, fc, cc) = (by_factor[FACTOR], by_factor[CABLE], by_cable[CABLE]);
        let r = before.correlation;
        let cable_variance = r * r * ff + 2.0 * r * rest * fc + rest * rest * cc;
        let covariance = r * ff + rest * fc;
        let (sf, sc) = (sqrt(ff.max(0.0)), sqrt(cable_variance.max(0.0)));
        let correlation = covariance / (sf * sc);
        Some(Calibration {
            torque_factor: estimate.torque_factor,
            // Kept relative to the new value.
            torque_factor_sigma: before.torque_factor_sigma * sf * before.torque_factor
                / estimate.torque_factor,
            cable_rad_per_nm: estimate.cable_rad_per_nm.max(0.0),
            cable_sigma_rad_per_nm: before.cable_sigma_rad_per_nm * sc,
            correlation: if correlation.is_finite() {
                correlation.clamp(-0.999, 0.999)
            } else {
                0.0
            },
            ..*before
        })
    }
}
