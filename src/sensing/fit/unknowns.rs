//! The unknowns: whitened by their priors inside the fit, physical values outside.

use super::{Place, Prior};
use crate::numeric::Bounded;
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

/// Least factor thought of, as a share of what is known: one near zero would be a motor that does nothing.
const LEAST_FACTOR: f32 = 0.2;
/// Deviations from its mean beyond which an unknown does not go.
const MOST_DEVIATIONS: f32 = 6.0;

/// Physical values of the unknowns, each in its place.
pub(super) type Values = [f32; UNKNOWNS];

/// Torque of a point without offset and error of the inertia, newton metre.
pub(super) fn torque_nm(values: &Values, point: &Point) -> f32 {
    point.torque_nm - values[OFFSET] - values[INERTIA] * point.inertia_nm
}

/// What turns whitened unknowns into physical values: value = mean + deviation x, and the cable's by the factor's, with
/// which it is correlated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whitening {
    mean: Values,
    pub(super) deviation: Values,
    pub(super) cable_by_factor: f32,
}

impl Whitening {
    /// By what is known before, for a phalanx of some length.
    pub(super) fn of<X: Series>(prior: &Prior<X>, length_m: f32) -> Self {
        let (mut mean, mut deviation) = (const { [0.0; UNKNOWNS] }, const { [0.0; UNKNOWNS] });
        let mut cable_by_factor = 0.0;
        (mean[K], deviation[K]) = match prior.place {
            Place::Anywhere => (0.0, length_m),
            Place::Known { k_m, sigma_m, .. } => (k_m, sigma_m),
        };
        (mean[RADIUS], deviation[RADIUS]) = prior.radius_m;
        deviation[OFFSET] = prior.offset_sigma_nm;
        (mean[ONSET], deviation[ONSET]) = prior.onset_rad;
        let calibration = &prior.calibration;
        mean[FACTOR] = calibration.torque_factor;
        deviation[FACTOR] = calibration.torque_factor * calibration.torque_factor_sigma;
        deviation[INERTIA] = prior.inertia_share;
        if X::FLEXIBLE {
            mean[CABLE] = calibration.cable_rad_per_nm;
            deviation[CABLE] = calibration.cable_sigma_rad_per_nm * calibration.independence();
            cable_by_factor = calibration.cable_sigma_rad_per_nm * calibration.correlation;
            [mean[CREEP], deviation[CREEP]] = prior.creep;
        }
        Self {
            mean,
            deviation,
            cable_by_factor,
        }
    }

    pub(super) fn values(&self, x: &[f32; UNKNOWNS]) -> Values {
        let mut values = self.mean;
        for unknown in 0..UNKNOWNS {
            values[unknown] += self.deviation[unknown] * x[unknown];
        }
        values[CABLE] += self.cable_by_factor * x[FACTOR];
        values
    }

    /// Keeps the unknowns where they mean something.
    pub(super) fn clamp(&self, x: &mut [f32; UNKNOWNS], length_m: f32) {
        let [_, _, others @ ..] = x;
        for x in others {
            *x = x.at_least(-MOST_DEVIATIONS).at_most(MOST_DEVIATIONS);
        }
        let hold = |x: &mut f32, mean: f32, deviation: f32, low: f32, high: f32| {
            let deviation = deviation.at_least(f32::MIN_POSITIVE);
            let low = (low - mean) / deviation;
            let high = (high - mean) / deviation;
            *x = x.at_least(low).at_most(high.at_least(low));
        };
        let Self {
            mean, deviation, ..
        } = self;
        hold(
            &mut x[K],
            mean[K],
            deviation[K],
            LEAST_SHARE * length_m,
            length_m,
        );
        hold(
            &mut x[RADIUS],
            mean[RADIUS],
            deviation[RADIUS],
            0.0,
            RADIUS_MAX_M,
        );
        let least = LEAST_FACTOR * mean[FACTOR];
        hold(
            &mut x[FACTOR],
            mean[FACTOR],
            deviation[FACTOR],
            least,
            f32::INFINITY,
        );
    }
}
