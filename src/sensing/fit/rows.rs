//! The normal equations, row by row.

use super::model::Local;
use super::unknowns::{CABLE, CREEP, FACTOR, INERTIA, K, OFFSET, ONSET, RADIUS, Values};
use super::{Hypothesis, Place, Prior, UNKNOWNS};
use crate::numeric::{Bounded, sqrt};
use crate::sensing::curve::Point;
use crate::sensing::location::Series;
use crate::sensing::normal::Normal;
use core::marker::PhantomData;

/// Normal equations in the making, and what turns physical slopes into those of the whitened unknowns.
pub(super) struct Rows<X: Series> {
    pub(super) normal: Normal<UNKNOWNS, X>,
    k: f32,
    radius: f32,
    offset: f32,
    onset: f32,
    factor: f32,
    /// Of the cable, by the unknowns of the factor and of the cable.
    cable: [f32; 2],
    creep: f32,
    inertia: f32,
    series: PhantomData<X>,
}

impl<X: Series> Rows<X> {
    /// Adds a point.
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
            + values.cable * contact_torque_nm / (values.factor * values.factor);
        let twisted_by = excess_nm + values.creep * point.late_nm;
        let mut slopes = [0.0; UNKNOWNS];
        slopes[K] = path.rotation_by_k_rad_per_m * self.k;
        slopes[RADIUS] = path.rotation_by_radius_rad_per_m * self.radius;
        slopes[OFFSET] = -slope * self.offset;
        slopes[ONSET] = self.onset;
        slopes[FACTOR] = by_factor * self.factor;
        if X::FLEXIBLE {
            slopes[FACTOR] += twisted_by * self.cable[0];
            slopes[CABLE] = twisted_by * self.cable[1];
            slopes[CREEP] = values.cable * point.late_nm * self.creep;
        }
        slopes[INERTIA] = -slope * point.inertia_nm * self.inertia;
        self.normal
            .add(local.residual_rad, &slopes, 1.0 / local.variance_rad2);
    }
}

impl Hypothesis {
    /// Normal equations that hold the priors alone.
    pub(super) fn rows<X: Series>(&self, length_m: f32, prior: &Prior<X>) -> Rows<X> {
        let calibration = &prior.calibration;
        let rest = sqrt((1.0 - calibration.correlation * calibration.correlation).at_least(0.0));
        let (k, known) = match prior.place {
            Place::Anywhere => (length_m, false),
            Place::Known { sigma_m, .. } => (sigma_m, true),
        };
        // A proximal contact has neither place nor radius.
        let has_place = if self.is_proximal() { 0.0 } else { 1.0 };
        let mut rows = Rows {
            normal: Normal::EMPTY,
            k: has_place * k,
            radius: has_place * prior.radius_m.1,
            offset: prior.offset_sigma_nm,
            onset: prior.onset_rad.1,
            factor: calibration.torque_factor * calibration.torque_factor_sigma,
            cable: [calibration.correlation, rest].map(|x| x * calibration.cable_sigma_rad_per_nm),
            creep: prior.creep[1],
            inertia: prior.inertia_share,
            series: PhantomData,
        };
        for (unknown, &value) in self.x.iter().enumerate().take(Prior::<X>::UNKNOWNS) {
            let weight = if unknown != K || known {
                1.0
            } else if self.is_proximal() {
                12.0
            } else {
                // A uniform prior has a variance of 1/12; as a slope it says nothing.
                1e-3
            };
            let value = if unknown == K && !known { 0.0 } else { value };
            rows.normal.add_prior(unknown, value, weight);
        }
        rows
    }
}
