//! The cable that opens a finger in place of springs.

use super::{Finger, MAX, list};
use crate::parameters::Parameters;

/// A cable that opens the finger: it pulls at every joint by its pulley there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Returning {
    pub pulley: [f64; MAX],
    /// Tension where every joint is at its rest angle.
    tension: f64,
    pub stiffness: f64,
}

impl Returning {
    /// The cable of a finger that has one.
    pub fn of(parameters: &Parameters) -> Option<Self> {
        let (finger, mechanism) = (&parameters.finger, &parameters.mechanism);
        finger.return_pulley_m.first().map(|first| {
            // The error of the springs is this one's too, and it is preloaded over the pulley of joint 1.
            let made = 1.0 + mechanism.spring_error;
            let stretched = first * mechanism.preload_deg.to_radians();
            Self {
                pulley: list(&finger.return_pulley_m, |r| r),
                tension: made * (finger.return_tension_n + finger.return_n_per_m * stretched),
                stiffness: made * finger.return_n_per_m,
            }
        })
    }
}

impl Finger {
    /// Pull of the return cable in a posture, newton.
    fn return_pull(&self, cable: &Returning, angle: [f64; MAX]) -> f64 {
        let taken: f64 = (0..self.count)
            .map(|i| cable.pulley[i] * (angle[i] - self.rest[i]))
            .sum();
        self.springs_left * (cable.tension + cable.stiffness * taken).max(0.0)
    }

    /// Its torque at each joint, newton metre, closing positive.
    pub(super) fn return_torques(&self, angle: [f64; MAX]) -> [f64; MAX] {
        self.returning.map_or([0.0; MAX], |cable| {
            let pull = self.return_pull(&cable, angle);
            cable.pulley.map(|radius| -radius * pull)
        })
    }

    /// Energy in its spring, joule.
    pub(super) fn return_energy(&self) -> f64 {
        self.returning.map_or(0.0, |cable| {
            let pull = self.return_pull(&cable, self.angle);
            0.5 * pull * pull / (self.springs_left * cable.stiffness).max(f64::MIN_POSITIVE)
        })
    }
}
