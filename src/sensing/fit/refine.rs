//! One step towards the minimum.

use super::model::Pass;
use super::rows::Rows;
use super::unknowns::{K, ONSET, Values, Whitening};
use super::{Data, Hypothesis, LEAST_POINTS, Place, Prior, UNKNOWNS};
use crate::finger::Mechanics;
use crate::numeric::Bounded;
use crate::sensing::location::Series;
use crate::sensing::normal::Normal;

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
        let whitening = Whitening::of(prior, self.length_m);
        let mut trial = self.x;
        let Some(cost) = self.linearise(finger, data, prior, near, &whitening, &mut trial) else {
            return;
        };
        whitening.clamp(&mut trial, self.length_m);
        match self.cost_of(&whitening, &trial, finger, data, prior, near) {
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

    /// What the fit tells where it stands, and its cost there; None where there is none. `trial`, which stands there too,
    /// makes the step that looks best.
    #[inline(never)]
    fn linearise<F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        whitening: &Whitening,
        trial: &mut [f32; UNKNOWNS],
    ) -> Option<f32> {
        let values = whitening.values(&self.x);
        let Some(onset) = Self::onset(finger, values[ONSET], prior, near) else {
            self.fail();
            return None;
        };
        let mut rows = self.rows(prior, whitening);
        let here = self.follow(finger, &onset, &values, data, Some(&mut rows));
        if here.reached < LEAST_POINTS {
            self.retreat(prior);
            return None;
        }
        self.stand(prior, whitening, &values, &here, &mut rows.normal, trial)
    }

    /// As [`Hypothesis::linearise`], from the normal equations.
    fn stand<X: Series>(
        &mut self,
        prior: &Prior<X>,
        whitening: &Whitening,
        values: &Values,
        here: &Pass,
        normal: &mut Normal<UNKNOWNS, X>,
        trial: &mut [f32; UNKNOWNS],
    ) -> Option<f32> {
        let cost = cost(here, &self.x, prior);
        let mut factor = normal.factor(0.0);
        self.best = None;
        if let Some(factor) = &factor {
            self.best = Some(self.best(prior, whitening, values, here, cost, factor));
        }
        if self.damping > 0.0 {
            factor = normal.factor(self.damping);
        }
        let Some(factor) = factor else {
            self.fail();
            return None;
        };
        for (value, step) in trial.iter_mut().zip(&factor.step()) {
            *value += step;
        }
        Some(cost)
    }

    /// Cost of other values of the unknowns.
    fn cost_of<F: Mechanics, X: Series>(
        &self,
        whitening: &Whitening,
        x: &[f32; UNKNOWNS],
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
    ) -> Option<f32> {
        let values = whitening.values(x);
        let onset = Self::onset(finger, values[ONSET], prior, near)?;
        let pass = self.follow(finger, &onset, &values, data, None::<&mut Rows<X>>);
        Some(cost(&pass, x, prior))
    }
}
