//! What the model predicts at a point of the curve, and its mean over a point in which the contact begins.

use crate::numeric::Bounded;
use crate::sensing::locator::prior::{ONSET, UNKNOWNS};

/// The model at a point.
#[derive(Clone, Copy, Debug)]
pub(in crate::sensing::locator) struct Prediction {
    /// Excess torque, newton metre.
    pub(in crate::sensing::locator) excess_nm: f32,
    /// Its derivatives by the physical unknowns.
    pub(in crate::sensing::locator) slopes: [f32; UNKNOWNS],
    /// Its variance.
    pub(in crate::sensing::locator) variance_nm2: f32,
}

pub(super) const NOTHING: Prediction = Prediction {
    excess_nm: 0.0,
    slopes: [0.0; UNKNOWNS],
    variance_nm2: 0.0,
};

impl Prediction {
    /// Takes the mean over a point in which the contact begins, for a finger without a cable. Nothing gives way there until the torque
    /// overcomes what holds the joints, so the torque rises in a step at the onset, and in a ramp from then on.
    pub(super) fn begin_with_step(&mut self, past_rad: f32, half_rad: f32) {
        let slope = -self.slopes[ONSET];
        let step_nm = self.excess_nm - slope * past_rad;
        let share = 0.5 * (past_rad / half_rad + 1.0);
        self.excess_nm = share * (step_nm + slope * share * half_rad);
        for slope_of in &mut self.slopes {
            *slope_of *= share;
        }
        self.slopes[ONSET] -= 0.5 * step_nm / half_rad;
    }

    /// Excess over half a point's width.
    pub(super) fn steepness(&self, half_rad: f32) -> f32 {
        // By the measured angle, which counts against the onset's.
        (-self.slopes[ONSET] * half_rad).at_least(f32::MIN_POSITIVE)
    }
}
