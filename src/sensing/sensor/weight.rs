//! The finger's weight, from the difference between closing and opening in the friction record.

use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::sensing::location::SeriesElement;

/// Torque of the finger's weight over the difference between closing and opening: half of it, because a worm's friction cancels,
/// less the gearhead's losses (docs/MECHANICS.md#real-fingers).
const WEIGHT_SHARE: f32 = 0.4;

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Torque of the finger's weight at a position with its derivative by the angle, and the torque with which a spring then
    /// holds joint 2; zero for a finger whose weight cannot be distinguished from its springs.
    #[inline(never)]
    pub(super) fn weight(&self, counts: i32) -> ([f32; 2], f32) {
        const NONE: ([f32; 2], f32) = ([0.0; 2], 0.0);
        let Some(friction) = &self.friction else {
            return NONE;
        };
        let place = counts.wrapping_add(self.shift_counts.unwrap_or(0));
        let share = WEIGHT_SHARE * self.calibration.torque_factor;
        let [weight_nm, per_rad] = friction.asymmetry(place).map(|nm| share * nm);
        self.free(self.drivetrain.closing_rad(counts))
            .and_then(|free| self.finger.weighed(&free, weight_nm))
            .map_or(NONE, |(_, held_nm)| ([weight_nm, per_rad], held_nm))
    }
}
