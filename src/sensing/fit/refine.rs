//! One step towards the minimum.

use super::model::Pass;
use super::rows::Rows;
use super::unknowns::{K, Values};
use super::{Data, Hypothesis, LEAST_POINTS, Place, Prior, UNKNOWNS};
use crate::finger::Mechanics;
use crate::numeric::Bounded;
use crate::sensing::curve::BINS;
use crate::sensing::location::Series;

/// Sum of squares, logarithms of variances and priors.
fn cost<X: Series>(pass: &Pass, x: &[f32; UNKNOWNS], prior: &Prior<X>) -> f32 {
    let mut priors = 0.0;
    for (unknown, value) in x.iter().enumerate().take(Prior::<X>::UNKNOWNS) {
        if unknown != K || matches!(prior.place, Place::Known { .. }) {
            priors += value * value;
        }
    }
    pass.squares + pass.logarithms + priors
}

impl Hypothesis {
    /// One step of Levenberg and Marquardt: two paths, about 16 points each. `near` is a posture near the onset.
    pub fn refine<F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
    ) {
        self.steps = self.steps.saturating_add(1);
        let points = data.points.get(..BINS).unwrap_or(data.points);
        let data = Data { points, ..*data };
        let Some((cost, step)) = self.linearise(finger, &data, prior, near) else {
            return;
        };
        let mut trial = self.x;
        for (value, step) in trial.iter_mut().zip(step) {
            *value += step;
        }
        self.clamp(&mut trial, finger, prior);
        match self.cost_of(&trial, finger, &data, prior, near) {
            Some(trial_cost) if trial_cost < cost => {
                self.x = trial;
                self.damping *= 0.2;
                if self.damping < 1e-4 {
                    self.damping = 0.0;
                }
                self.settled_steps = if cost - trial_cost < 0.05 {
                    self.settled_steps.saturating_add(1)
                } else {
                    0
                };
            }
            _ => {
                self.damping = (10.0 * self.damping).at_least(0.01);
                // Nothing better even close by: this is the minimum.
                if self.damping > 10.0 {
                    self.settled_steps = self.settled_steps.saturating_add(1);
                    self.damping = 1.0;
                }
            }
        }
    }

    /// What the fit tells where it stands, its cost there, and the step that looks best; None where there is none.
    #[inline(never)]
    fn linearise<F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
    ) -> Option<(f32, [f32; UNKNOWNS])> {
        let length = finger.phalanx_length_m(self.phalanx).unwrap_or(0.0);
        let values = self.values(&self.x, finger, prior);
        let Some(onset) = Self::onset(finger, values.onset_rad, prior, near) else {
            self.fail();
            return None;
        };
        let mut rows = self.rows(length, prior);
        let here = self.follow(finger, &onset, &values, data, Some(&mut rows));
        if here.reached < LEAST_POINTS {
            self.retreat(prior);
            return None;
        }
        self.stand(length, prior, &values, &here, &mut rows)
    }

    /// As [`Hypothesis::linearise`], from the normal equations.
    // Not inlined: what is needed here does not lie in the frame from which the path is followed.
    #[inline(never)]
    fn stand<X: Series>(
        &mut self,
        length_m: f32,
        prior: &Prior<X>,
        values: &Values,
        here: &Pass,
        rows: &mut Rows<X>,
    ) -> Option<(f32, [f32; UNKNOWNS])> {
        let cost = cost(here, &self.x, prior);
        self.share = values.k_m / length_m;
        let mut step = None;
        self.best = rows.normal.factor(0.0).map(|factor| {
            step = Some(factor.step());
            self.best(length_m, prior, values, here, cost, &factor)
        });
        if self.damping > 0.0 {
            step = rows.normal.factor(self.damping).map(|factor| factor.step());
        }
        if step.is_none() {
            self.fail();
        }
        Some((cost, step?))
    }

    /// Cost of other values of the unknowns.
    #[inline(never)]
    fn cost_of<F: Mechanics, X: Series>(
        &self,
        x: &[f32; UNKNOWNS],
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
    ) -> Option<f32> {
        let values = self.values(x, finger, prior);
        let onset = Self::onset(finger, values.onset_rad, prior, near)?;
        let pass = self.follow(finger, &onset, &values, data, None::<&mut Rows<X>>);
        Some(cost(&pass, x, prior))
    }
}
