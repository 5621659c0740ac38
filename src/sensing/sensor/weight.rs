//! The finger's weight, from the difference between closing and opening in the friction record.

use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::sensing::location::SeriesElement;

/// Torque of the finger's weight over the difference between closing and opening: half of it, because a worm's friction cancels,
/// less the gearhead's losses (docs/MECHANICS.md#real-fingers).
const WEIGHT_SHARE: f32 = 0.4;
/// A smaller value is attributed to friction that differs between directions, newton metre (R, chosen).
const LEAST_WEIGHT_NM: f32 = 0.5e-3;

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
        let weight_nm = WEIGHT_SHARE * friction.asymmetry_nm(place);
        let per_rad = WEIGHT_SHARE * friction.asymmetry_nm[1]
            / (friction.travel_counts as f32 * self.drivetrain.rad_per_count);
        if weight_nm.abs() < LEAST_WEIGHT_NM {
            return NONE;
        }
        self.free(self.drivetrain.closing_rad(counts))
            .and_then(|free| self.finger.weighed(&free, weight_nm))
            .map_or(NONE, |(_, held_nm)| ([weight_nm, per_rad], held_nm))
    }
}
