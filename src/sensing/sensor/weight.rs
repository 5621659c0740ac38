//! The finger's weight, from the difference between closing and opening in the friction record.

use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::location::SeriesElement;

/// Torque of the finger's weight over the difference between closing and opening: half of it, because a worm's friction cancels,
/// less the gearhead's losses (docs/MECHANICS.md#real-fingers).
const WEIGHT_SHARE: f32 = 0.4;
/// Standard deviation of the torque with which the weight turns joint 2, as a share of it.
const TURNING_SIGMA: f32 = 0.3;
/// A torque far below any that holds a joint, newton metre: prevents a division by 0.
const NO_TORQUE_NM: f32 = 1e-6;

/// Estimates the torque that a contact has to overcome before joint 2 leaves its stop, newton metre: mean and deviation. `stop_nm` is
/// the torque that holds the joint there, negative where the weight has lifted it off already. That torque is uncertain, and only its
/// positive part has to be overcome. A hyperbola stands for the positive part of a normal distribution: mean and deviation are within
/// 0.14 deviations of it.
pub(super) fn held(stop_nm: f32, [preload_nm, preload_sigma_nm]: [f32; 2]) -> [f32; 2] {
    let turning_nm = TURNING_SIGMA * (preload_nm - stop_nm);
    let sigma_nm = sqrt(preload_sigma_nm * preload_sigma_nm + turning_nm * turning_nm);
    let root_nm = sqrt(stop_nm * stop_nm + sigma_nm * sigma_nm) + NO_TORQUE_NM;
    let mean_nm = 0.5 * (stop_nm + root_nm);
    [mean_nm, sigma_nm * mean_nm / root_nm]
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Mounts the finger as the settings say.
    pub(super) fn hang(&mut self) {
        #[cfg(not(weightless))]
        if let Some(mounting) = self.settings.mounting.filter(|_| F::WEIGHS) {
            self.finger = self.finger.mounted(mounting);
        }
    }

    /// Torque of the finger's weight at a position with its derivative by the angle, and the torque that then holds joint 2 at
    /// its stop, negative where the weight lifts it off; no weight for a finger whose weight cannot be distinguished from its
    /// springs.
    #[inline(never)]
    pub(super) fn weight(&self, counts: i32) -> ([f32; 2], f32) {
        let preload_nm = self.settings.preload_nm[0];
        let none = ([0.0; 2], preload_nm);
        let Some(friction) = &self.friction else {
            return none;
        };
        let place = counts.wrapping_add(self.shift_counts.unwrap_or(0));
        let share = WEIGHT_SHARE * self.calibration.torque_factor;
        let [weight_nm, per_rad] = friction.asymmetry(place).map(|nm| share * nm);
        self.free(self.drivetrain.closing_rad(counts))
            .and_then(|free| self.finger.weighed(&free, weight_nm, preload_nm))
            .map_or(none, |(_, stop_nm)| ([weight_nm, per_rad], stop_nm))
    }
}

#[cfg(test)]
mod tests {
    use super::held;

    #[test]
    fn a_stop_only_pushes() {
        let preload = [0.4e-3, 0.4e-3];
        let [mean_nm, sigma_nm] = held(0.4e-3, preload);
        assert!((0.4e-3..0.5e-3).contains(&mean_nm) && (0.3e-3..0.4e-3).contains(&sigma_nm));
        // Held by its weight as well: both count, and the deviation is the larger.
        let [more_nm, more_sigma_nm] = held(3.4e-3, preload);
        assert!((more_nm - 3.4e-3).abs() < 0.1 * 3.4e-3 && more_sigma_nm > 0.9e-3);
        // Lifted off by several times the preload: nothing is left to overcome.
        let [less_nm, less_sigma_nm] = held(-3.0e-3, preload);
        assert!((0.0..0.15e-3).contains(&less_nm) && (0.0..0.1e-3).contains(&less_sigma_nm));
        // A finger that nothing is known to hold.
        let [none_nm, none_sigma_nm] = held(0.0, [0.0; 2]);
        assert!((0.0..1e-6).contains(&none_nm) && none_sigma_nm == 0.0);
    }
}
