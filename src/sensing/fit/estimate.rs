//! What a fit tells: values with their deviations, its evidence, and what it teaches about the drivetrain.

use super::model::Pass;
use super::unknowns::{CABLE, FACTOR, K, ONSET, RADIUS, Values, Whitening};
use super::{Hypothesis, Place, Prior, UNKNOWNS};
use crate::finger::MAX_PHALANGES;
use crate::numeric::{Bounded, ln, sqrt};
use crate::sensing::Calibration;
use crate::sensing::location::Series;
use crate::sensing::normal::Factor;

/// Result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Phalanx.
    pub phalanx: u8,
    /// Its length, metre.
    pub length_m: f32,
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
    /// Sum of squared residuals over their variances.
    pub chi_square: f32,
    /// Points that the path reached.
    pub reached: usize,
    /// Contact force at the end of the curve, newton.
    pub force_n: f32,
    /// Change of each joint's angle from the onset to there, radian.
    pub joints_rad: [f32; MAX_PHALANGES],
}

/// Nearer to a joint than this share of the phalanx, a contact is one on the joint.
const JOINT_SHARE: f32 = 0.02;

impl Estimate {
    /// Whether it is on the proximal phalanx or on the very joint of phalanx 2: as compliant as a contact anywhere on
    /// phalanx 1 (docs/MECHANICS.md#contact-stiffness), and nearer to the joint than either phalanx is thick.
    pub fn is_without_place(&self) -> bool {
        self.phalanx <= 1 || (self.phalanx == 2 && self.k_m < JOINT_SHARE * self.length_m)
    }

    /// Mean square residual, in variances.
    pub fn misfit(&self) -> f32 {
        self.chi_square / (self.reached as f32 - 2.0).at_least(1.0)
    }

    /// Whether both are one place for all that their deviations tell.
    pub(in crate::sensing) fn is_as(&self, other: &Self) -> bool {
        self.phalanx == other.phalanx
            && (self.k_m - other.k_m).abs() < self.k_sigma_m + other.k_sigma_m
    }

    /// The same, less sure: `spread` is by how much the residuals exceed what was expected, as a variance ratio.
    pub(in crate::sensing) fn swollen(&self, spread: f32) -> Self {
        let swell = sqrt(spread);
        Self {
            k_sigma_m: swell * self.k_sigma_m,
            radius_sigma_m: swell * self.radius_sigma_m,
            ..*self
        }
    }
}

/// All that is kept of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) estimate: Estimate,
    /// Sum of squares, priors and logarithms of variances.
    cost: f32,
    /// Logarithm of the determinant of the inverse covariance.
    ln_determinant: f32,
    /// Whitened covariance of factor and cable, where the place is known: of the first, of both, of the second.
    learned: [f32; 3],
}

impl Hypothesis {
    /// What the fit tells at some values of its unknowns.
    pub(super) fn best<X: Series>(
        &self,
        prior: &Prior<X>,
        whitening: &Whitening,
        values: &Values,
        pass: &Pass,
        cost: f32,
        factor: &Factor<UNKNOWNS, X>,
    ) -> Best {
        let deviation = |unknown: usize| {
            let variance = factor.covariance(unknown)[unknown];
            whitening.deviation[unknown] * sqrt(variance.at_least(0.0))
        };
        let mut learned = [0.0; 3];
        if let Place::Known { .. } = prior.place {
            let by_factor = factor.covariance(FACTOR);
            learned[0] = by_factor[FACTOR];
            if X::FLEXIBLE {
                learned[1] = by_factor[CABLE];
                learned[2] = factor.covariance(CABLE)[CABLE];
            }
        }
        let estimate = Estimate {
            phalanx: self.phalanx,
            length_m: self.length_m,
            k_m: values[K],
            k_sigma_m: deviation(K),
            radius_m: values[RADIUS],
            radius_sigma_m: deviation(RADIUS),
            onset_rad: values[ONSET],
            torque_factor: values[FACTOR],
            cable_rad_per_nm: values[CABLE],
            chi_square: pass.squares,
            reached: pass.reached,
            force_n: pass.end.force_n,
            joints_rad: pass.end.joints_rad,
        };
        Best {
            estimate,
            cost,
            ln_determinant: factor.ln_determinant(),
            learned,
        }
    }

    /// Logarithm of how well the hypothesis explains the curve, all values of its unknowns together (Laplace's
    /// approximation of the evidence): what has more freedom pays for it. `spread` is by how much the residuals of the
    /// best hypothesis exceed what was expected; it makes all of them less sure.
    pub fn ln_evidence(&self, spread: f32) -> f32 {
        let Some(best) = &self.best else {
            return f32::NEG_INFINITY;
        };
        let mut determinant = best.ln_determinant;
        let mut flat = 0.0;
        if self.is_proximal() {
            // The unknown that it does not have.
            determinant -= ln(12.0);
        } else {
            flat = 0.5 * ln(core::f32::consts::TAU);
        }
        -0.5 * best.cost / spread.at_least(1.0) - 0.5 * determinant + flat
    }

    /// What a fit at a known place teaches: torque factor and cable, with their covariance. Meaningless elsewhere.
    pub fn learned<X: Series>(&self, prior: &Prior<X>) -> Option<Calibration> {
        let Best {
            estimate,
            learned: [ff, fc, cc],
            ..
        } = self.best?;
        let before = &prior.calibration;
        let torque_factor = estimate.torque_factor;
        if !X::FLEXIBLE {
            return Some(Calibration {
                torque_factor,
                torque_factor_sigma: before.torque_factor_sigma
                    * sqrt(ff.at_least(0.0))
                    * before.torque_factor
                    / torque_factor,
                ..*before
            });
        }
        let rest = before.independence();
        let r = before.correlation;
        let cable_variance = r * r * ff + 2.0 * r * rest * fc + rest * rest * cc;
        let covariance = r * ff + rest * fc;
        let (sf, sc) = (sqrt(ff.at_least(0.0)), sqrt(cable_variance.at_least(0.0)));
        let correlation = covariance / (sf * sc);
        Some(Calibration {
            torque_factor: estimate.torque_factor,
            // Kept relative to the new value.
            torque_factor_sigma: before.torque_factor_sigma * sf * before.torque_factor
                / estimate.torque_factor,
            cable_rad_per_nm: estimate.cable_rad_per_nm.at_least(0.0),
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
