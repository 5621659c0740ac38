//! Calibration from a fit.

use super::Fit;
use crate::finger::Mechanics;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::locator::Learned;
use crate::sensing::locator::prior::{BEND, CABLE, FACTOR, Place, Prior, Scaling, strain};
use crate::sensing::{Calibration, SeriesElement};

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// Calibration from a fit at a known place or at the stop: torque factor and cable with their covariance. The misfit
    /// is the sum of squared residuals.
    pub(in super::super) fn learned(&mut self, prior: &Prior<X>) -> Option<Learned> {
        let scaling = Scaling::of(prior, self.hypothesis.length_m);
        let values = scaling.values(&self.x);
        let factor = self.normal.factor(0.0)?;
        let by_factor = factor.covariance(FACTOR);
        let before = &prior.calibration;
        let strain = match prior.place {
            Place::Known { .. } => {
                let variance = |unknown: usize| factor.covariance(unknown)[unknown];
                strain(&self.x, before.contacts == 0, variance)
            }
            _ => 1.0,
        };
        let ff = by_factor[FACTOR].at_least(0.0);
        let mut learned = Calibration {
            torque_factor: values[FACTOR],
            // Kept relative to the new value.
            torque_factor_sigma: before.torque_factor_sigma * sqrt(ff) * before.torque_factor
                / values[FACTOR],
            ..*before
        };
        if X::FLEXIBLE {
            let (fc, cc) = (by_factor[CABLE], factor.covariance(CABLE)[CABLE]);
            let (rest, r) = (before.independence(), before.correlation);
            let variance = r * r * ff + 2.0 * r * rest * fc + rest * rest * cc;
            let deviation = sqrt(variance.at_least(f32::MIN_POSITIVE));
            let correlation = (r * ff + rest * fc) / (sqrt(ff) * deviation);
            learned.cable_rad_per_nm = values[CABLE].at_least(0.0);
            learned.stiffening_per_nm = values[BEND].at_least(0.0);
            learned.stiffening_sigma_per_nm =
                before.stiffening_sigma_per_nm * sqrt(factor.covariance(BEND)[BEND].at_least(0.0));
            learned.cable_sigma_rad_per_nm = before.cable_sigma_rad_per_nm * deviation;
            learned.correlation = if correlation.is_finite() {
                correlation.clamp(-0.999, 0.999)
            } else {
                0.0
            };
        }
        Some(Learned {
            calibration: learned,
            misfit: self.chi_square,
            strain,
        })
    }
}
