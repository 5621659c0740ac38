//! One step towards the minimum.

use super::{Data, Hypothesis, LEAST_POINTS, Prior};
use crate::finger::Mechanics;
use crate::sensing::curve::BINS;

impl Hypothesis {
    /// One step of Levenberg and Marquardt: four paths, about 16 points each. `near` is a posture near the onset.
    pub fn refine<F: Mechanics>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        near: &F::Configuration,
    ) {
        self.steps = self.steps.saturating_add(1);
        let points = data.points.get(..BINS).unwrap_or(data.points);
        let data = Data { points, ..*data };
        let x = self.x;
        let values = self.values(&x, finger, prior);
        let Some(onset) = Self::onset(finger, values.onset_rad, prior, near) else {
            self.fail();
            return;
        };
        let here = self.follow(finger, &onset, &values, points);
        if here.reached < LEAST_POINTS {
            self.retreat(prior);
            return;
        }
        let (cost, chi_square) = self.cost(&x, &data, &values, onset.torque_nm, &here, prior);
        let Some(normal) = self.linearise(finger, &data, prior, &onset, &values, &here) else {
            self.fail();
            return;
        };
        self.cost = cost;
        self.factor = normal.factor(0.0);
        self.share = values.k_m / finger.phalanx_length_m(self.phalanx).unwrap_or(values.k_m);
        self.best = self.report(finger, prior, &values, chi_square, &here);
        let Some(factor) = normal.factor(self.damping) else {
            self.fail();
            return;
        };
        let mut trial = x;
        for (value, step) in trial.iter_mut().zip(normal.step(&factor)) {
            *value += step;
        }
        self.clamp(&mut trial, finger, prior);
        let trial_values = self.values(&trial, finger, prior);
        let trial_cost = Self::onset(finger, trial_values.onset_rad, prior, near).map(|onset| {
            let pass = self.follow(finger, &onset, &trial_values, points);
            self.cost(&trial, &data, &trial_values, onset.torque_nm, &pass, prior)
                .0
        });
        match trial_cost {
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
                self.damping = (10.0 * self.damping).max(0.01);
                // Nothing better even close by: this is the minimum.
                if self.damping > 10.0 {
                    self.settled_steps = self.settled_steps.saturating_add(1);
                    self.damping = 1.0;
                }
            }
        }
    }
}
