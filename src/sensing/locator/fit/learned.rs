//! Calibration from a fit.

use super::Fit;
use crate::finger::Mechanics;
use crate::numeric::{Bounded, clamp, sqrt};
use crate::sensing::calibration::independence;
use crate::sensing::locator::Learned;
use crate::sensing::locator::prior::{BEND, CABLE, FACTOR, JOINT, Place, Prior, Scaling, strain};
use crate::sensing::{Calibration, SeriesElement};

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// Calibration from a fit at a known place or at the stop: torque factor and cable with their covariance. The misfit
    /// is the sum of squared residuals.
    pub(in super::super) fn learned(&mut self, prior: &Prior<X>) -> Option<Learned> {
        let scaling = Scaling::of::<F, X>(prior, self.hypothesis.length_m);
        let values = scaling.values(&self.x);
        let factor = self.normal.factor(0.0)?;
        let by_factor = factor.covariance(FACTOR);
        let before = &prior.calibration;
        let strain = match prior.place {
            Place::Known { .. } => {
                let variance = |unknown: usize| factor.variance(unknown);
                let [beside_normal, _] = prior.beside_normal::<F>(self.x[JOINT]);
                strain(&self.x, beside_normal, before.contacts == 0, variance)
            }
            _ => 1.0,
        };
        let ff = by_factor[FACTOR].at_least(0.0);
        let before_joint = (prior.joint_nm[1], before.joint_correlation);
        let coupled = |unknown: usize, (sigma, r): (f32, f32)| {
            coupled([ff, by_factor[unknown], factor.variance(unknown)], sigma, r)
        };
        let (joint_sigma_nm, joint_correlation) = coupled(JOINT, before_joint);
        let mut learned = Calibration {
            joint_nm: before.joint_nm + values[JOINT] - prior.joint_nm[0],
            joint_sigma_nm,
            joint_correlation,
            worm_rad: self.worm_rad,
            torque_factor: values[FACTOR],
            // Kept relative to the new value.
            torque_factor_sigma: before.torque_factor_sigma * sqrt(ff) * before.torque_factor
                / values[FACTOR],
            ..*before
        };
        if X::FLEXIBLE {
            learned.cable_rad_per_nm = values[CABLE].at_least(0.0);
            learned.stiffening_per_nm = values[BEND].at_least(0.0);
            learned.stiffening_sigma_per_nm =
                before.stiffening_sigma_per_nm * sqrt(factor.variance(BEND));
            (learned.cable_sigma_rad_per_nm, learned.correlation) =
                coupled(CABLE, (before.cable_sigma_rad_per_nm, before.correlation));
        }
        Some(Learned {
            calibration: learned,
            misfit: self.chi_square,
            strain,
        })
    }
}

/// Standard deviation of a value that was correlated with the factor, and the correlation, after a fit. Of the covariance in units of
/// the prior: the factor's variance, its covariance with the value's own part, and that part's variance.
#[inline(never)]
fn coupled([ff, fc, cc]: [f32; 3], sigma: f32, r: f32) -> (f32, f32) {
    let rest = independence(r);
    let variance = r * r * ff + 2.0 * r * rest * fc + rest * rest * cc;
    let deviation = sqrt(variance.at_least(f32::MIN_POSITIVE));
    let both = (sqrt(ff) * deviation).at_least(f32::MIN_POSITIVE);
    let correlation = clamp((r * ff + rest * fc) / both, -0.999, 0.999);
    (sigma * deviation, correlation)
}
