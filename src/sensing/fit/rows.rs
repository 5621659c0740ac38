//! The normal equations, row by row.

use super::model::Local;
use super::unknowns::{CABLE, CREEP, FACTOR, INERTIA, K, OFFSET, ONSET, RADIUS, Values, Whitening};
use super::{Hypothesis, Place, Prior, UNKNOWNS};
use crate::sensing::curve::Point;
use crate::sensing::location::Series;
use crate::sensing::normal::Normal;

/// Normal equations in the making.
pub(super) struct Rows<'a, X: Series> {
    pub(super) normal: Normal<UNKNOWNS, X>,
    whitening: &'a Whitening,
    /// 0 for a proximal contact, which has neither place nor radius, else 1.
    has_place: f32,
}

impl<X: Series> Rows<'_, X> {
    /// Adds a point.
    // Not inlined: what is needed here does not lie in the frame from which the path is followed.
    #[inline(never)]
    pub(super) fn add(
        &mut self,
        point: &Point,
        values: &Values,
        contact_torque_nm: f32,
        local: &Local,
    ) {
        let Local {
            torque_nm,
            excess_nm,
            path,
            slope_rad_per_nm: slope,
            ..
        } = local;
        let by_factor = torque_nm * path.compliance_rad_per_nm
            + values[CABLE] * contact_torque_nm / (values[FACTOR] * values[FACTOR]);
        let twisted_by = excess_nm + values[CREEP] * point.late_nm;
        let mut slopes = const { [0.0; UNKNOWNS] };
        slopes[K] = self.has_place * path.rotation_by_k_rad_per_m;
        slopes[RADIUS] = self.has_place * path.rotation_by_radius_rad_per_m;
        slopes[OFFSET] = -slope;
        slopes[ONSET] = 1.0;
        slopes[FACTOR] = by_factor;
        slopes[INERTIA] = -slope * point.inertia_nm;
        if X::FLEXIBLE {
            slopes[CABLE] = twisted_by;
            slopes[CREEP] = values[CABLE] * point.late_nm;
        }
        for (slope, deviation) in slopes.iter_mut().zip(&self.whitening.deviation) {
            *slope *= deviation;
        }
        if X::FLEXIBLE {
            slopes[FACTOR] += twisted_by * self.whitening.cable_by_factor;
        }
        self.normal
            .add(local.residual_rad, &slopes, 1.0 / local.variance_rad2);
    }
}

impl Hypothesis {
    /// Normal equations that hold the priors alone.
    pub(super) fn rows<'a, X: Series>(
        &self,
        prior: &Prior<X>,
        whitening: &'a Whitening,
    ) -> Rows<'a, X> {
        let mut normal = Normal::EMPTY;
        for unknown in 0..Prior::<X>::UNKNOWNS {
            let (value, weight) = if unknown != K || matches!(prior.place, Place::Known { .. }) {
                (self.x[unknown], 1.0)
            } else if self.is_proximal() {
                (0.0, 12.0)
            } else {
                // A uniform prior has a variance of 1/12; as a slope it says nothing.
                (0.0, 1e-3)
            };
            normal.add_prior(unknown, value, weight);
        }
        Rows {
            normal,
            whitening,
            has_place: if self.is_proximal() { 0.0 } else { 1.0 },
        }
    }
}
