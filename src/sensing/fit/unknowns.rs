//! The unknowns: whitened by their priors inside the fit, physical values outside.

use super::{Hypothesis, Place, Prior};
use crate::finger::Mechanics;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::curve::Point;
use crate::sensing::location::Series;

/// Number of unknowns behind a cable.
pub const FLEXIBLE_UNKNOWNS: usize = 8;
/// Number of unknowns without one.
pub const RIGID_UNKNOWNS: usize = 6;
/// Room for them.
pub const UNKNOWNS: usize = FLEXIBLE_UNKNOWNS;
pub(super) const K: usize = 0;
pub(super) const RADIUS: usize = 1;
pub(super) const OFFSET: usize = 2;
pub(super) const ONSET: usize = 3;
pub(super) const FACTOR: usize = 4;
pub(super) const INERTIA: usize = 5;
pub(super) const CABLE: usize = 6;
pub(super) const CREEP: usize = 7;

/// Largest effective contact radius thought of, metre.
pub(super) const RADIUS_MAX_M: f32 = 0.045;
/// Least k/l thought of: nearer to the joint a contact is a proximal one for all that the curve tells.
pub(super) const LEAST_SHARE: f32 = 0.004;

/// Physical values of the unknowns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    pub(super) k_m: f32,
    pub(super) radius_m: f32,
    pub(super) offset_nm: f32,
    pub(super) onset_rad: f32,
    pub(super) factor: f32,
    pub(super) cable: f32,
    pub(super) creep: f32,
    pub(super) inertia: f32,
}

impl Values {
    /// Torque of a point without offset and error of the inertia, newton metre.
    pub(super) fn torque_nm(&self, point: &Point) -> f32 {
        point.torque_nm - self.offset_nm - self.inertia * point.inertia_nm
    }
}

impl Hypothesis {
    pub(super) fn values<F: Mechanics, X: Series>(
        &self,
        x: &[f32; UNKNOWNS],
        finger: &F,
        prior: &Prior<X>,
    ) -> Values {
        let length = finger.phalanx_length_m(self.phalanx).unwrap_or(0.0);
        let (radius, radius_sigma) = prior.radius_m;
        let calibration = &prior.calibration;
        let (cable, creep) = if X::FLEXIBLE {
            let correlation = calibration.correlation;
            let rest = sqrt((1.0 - correlation * correlation).at_least(0.0));
            let deviation = correlation * x[FACTOR] + rest * x[CABLE];
            (
                calibration.cable_rad_per_nm + calibration.cable_sigma_rad_per_nm * deviation,
                prior.creep[0] + prior.creep[1] * x[CREEP],
            )
        } else {
            (0.0, 0.0)
        };
        Values {
            k_m: match prior.place {
                Place::Anywhere => x[K] * length,
                Place::Known { k_m, sigma_m, .. } => k_m + sigma_m * x[K],
            },
            radius_m: radius + radius_sigma * x[RADIUS],
            offset_nm: prior.offset_sigma_nm * x[OFFSET],
            onset_rad: prior.onset_rad.0 + prior.onset_rad.1 * x[ONSET],
            factor: calibration.torque_factor * (1.0 + calibration.torque_factor_sigma * x[FACTOR]),
            cable,
            creep,
            inertia: prior.inertia_share * x[INERTIA],
        }
    }

    /// Keeps the unknowns where they mean something. (With computed bounds `clamp` would panic on a NaN.)
    pub(super) fn clamp<F: Mechanics, X: Series>(
        &self,
        x: &mut [f32; UNKNOWNS],
        finger: &F,
        prior: &Prior<X>,
    ) {
        let length = finger.phalanx_length_m(self.phalanx).unwrap_or(0.0);
        x[K] = match prior.place {
            Place::Anywhere => x[K].clamp(LEAST_SHARE, 1.0),
            Place::Known { k_m, sigma_m, .. } => {
                let sigma = sigma_m.at_least(f32::MIN_POSITIVE);
                let low = (LEAST_SHARE * length - k_m) / sigma;
                x[K].at_least(low)
                    .at_most(((length - k_m) / sigma).at_least(low))
            }
        };
        let (radius, radius_sigma) = prior.radius_m;
        let sigma = radius_sigma.at_least(f32::MIN_POSITIVE);
        let low = -radius.at_least(0.0) / sigma;
        x[RADIUS] = x[RADIUS]
            .at_least(low)
            .at_most(((RADIUS_MAX_M - radius) / sigma).at_least(low));
        let [_, _, others @ ..] = x;
        for value in others {
            *value = value.clamp(-6.0, 6.0);
        }
        // A factor near zero would be a motor that does nothing.
        let sigma = prior
            .calibration
            .torque_factor_sigma
            .at_least(f32::MIN_POSITIVE);
        x[FACTOR] = x[FACTOR].at_least(-0.8 / sigma);
    }
}
