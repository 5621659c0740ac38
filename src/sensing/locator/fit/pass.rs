//! A pass over the curve at a trial's unknowns, a few points at a time, because samples must not wait.

use super::{Fit, Progress};
use crate::finger::Mechanics;
use crate::numeric::ln;
use crate::sensing::SeriesElement;
use crate::sensing::locator::model::Model;
use crate::sensing::locator::noise::{Row, Whitening};
use crate::sensing::locator::prior::{
    CABLE, FACTOR, JOINT, K, ONSET, Of, Place, Prior, Scaling, UNKNOWNS,
};
use crate::sensing::locator::{Data, onset};
use crate::sensing::normal::{Normal, Unknowns};

/// Points of the curve per call (cost: docs/RESULTS.md#speed-and-size). With three phalanges each costs more, now and then twenty times.
const fn points_a_step(phalanges: usize) -> usize {
    if phalanges > 2 { 5 } else { 8 }
}

/// A pass over the curve: cost and normal equations of the points so far.
#[derive(Clone, Debug)]
pub(super) struct Pass<F: Mechanics, X: SeriesElement> {
    pub(super) model: Model<F, X>,
    pub(super) whitening: Whitening,
    /// Index of the next point.
    next: usize,
    pub(super) squares: f32,
    pub(super) logarithms: f32,
    pub(super) normal: Normal<UNKNOWNS, Of<F, X>>,
}

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// Begins a pass at the trial's unknowns, if there is such a contact.
    #[inline(never)]
    pub(super) fn begin(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        scaling: &Scaling,
    ) {
        let values = scaling.values(&self.trial);
        let Some(onset) = onset::at::<F, X>(finger, values[ONSET], prior, near) else {
            return;
        };
        let model = Model::new(
            finger,
            (data.origin_rad, data.drivetrain),
            &values,
            prior,
            self.hypothesis.hold,
            &onset,
        );
        let mut normal = Normal::of_priors(&self.trial);
        let joint = self.trial[JOINT];
        normal.set_prior(JOINT, joint, prior.beside_normal::<F>(joint)[1]);
        if !matches!(prior.place, Place::Known { .. }) {
            // A uniform prior adds no gradient.
            let weight = if self.hypothesis.has_place() {
                1e-3
            } else {
                1.0
            };
            normal.set_prior(K, 0.0, weight);
        }
        self.pass = model.map(|model| Pass {
            model,
            whitening: Whitening::new(
                &prior.noise,
                data.drivetrain,
                data.origin_rad,
                prior.calibration.worm_rad,
            ),
            next: 0,
            squares: 0.0,
            logarithms: 0.0,
            normal,
        });
    }

    /// Evaluates the next points: converged after the last one, failed if there is no contact path.
    #[inline(never)]
    pub(super) fn go_on(&mut self, finger: &F, data: &Data, scaling: &Scaling) -> Progress {
        let onset_rad = scaling.values(&self.trial)[ONSET];
        let has_place = self.hypothesis.has_place();
        let Some(pass) = &mut self.pass else {
            return Progress::Failed;
        };
        let end = (pass.next + const { points_a_step(F::PHALANGES) }).min(data.points.len());
        for point in data.points.get(pass.next..end).unwrap_or_default() {
            if point.blocks == 0 {
                continue;
            }
            let Some(prediction) = pass.model.next(finger, point) else {
                return Progress::Failed;
            };
            let mut row = Row {
                residual: point.excess_nm - prediction.excess_nm,
                slopes: prediction.slopes,
                variance: prediction.variance_nm2,
                nm_per_rad: prediction.slopes[ONSET],
            };
            if !has_place {
                row.slopes[K] = 0.0;
            }
            for (slope, deviation) in row.slopes.iter_mut().zip(&scaling.deviation) {
                *slope *= deviation;
            }
            row.slopes[FACTOR] += prediction.slopes[JOINT] * scaling.joint_by_factor;
            if X::FLEXIBLE {
                row.slopes[FACTOR] += prediction.slopes[CABLE] * scaling.cable_by_factor;
            }
            let past_rad = data.end_rad(point) - onset_rad;
            (pass.whitening).whiten(point, past_rad, UNKNOWNS - Of::<F, X>::MISSING, &mut row);
            let weight = 1.0 / row.variance;
            pass.squares += row.residual * row.residual * weight;
            pass.logarithms += ln(row.variance);
            pass.normal.add(row.residual, &row.slopes, weight);
        }
        pass.next = end;
        if pass.next < data.points.len() {
            return Progress::UnderWay;
        }
        if pass.squares.is_finite() {
            Progress::Converged
        } else {
            Progress::Failed
        }
    }
}
