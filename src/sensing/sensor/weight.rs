//! The finger's weight: what the difference between closing and opening in the friction record tells of it, and contacts that take it
//! over.

use super::search::{CorrectedBlock, History};
use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::detector::Onset;
use crate::sensing::location::SeriesElement;

/// Standard deviation of the torque with which the weight turns joint 2, as a share of it.
const TURNING_SIGMA: f32 = 0.3;
/// Largest fall of the motor's torque while an object takes over the weight that closes the finger, as a share of the weight's
/// torque at the input link: 1 / eta - 2 with the efficiency eta of the worm, which is 0.38 at least, over that of the other gears
/// (docs/SENSING.md#a-weight-that-closes-the-finger).
const CARRIED: f32 = 0.85;
/// Standard deviation of the way on which an object takes it over, as a share of the way: the slope of the torque's rise
/// tells it, and rises have a curvature (R, chosen).
const HIDDEN_SIGMA: f32 = 0.5;
/// A fall of the motor's torque by more, in deviations of a block, tells the onset (chosen: with less the blocks before it are worth more,
/// for the level).
const SHOWN_SIGMAS: f32 = 12.0;
/// A block whose torque has fallen by less than this share of that lies before the onset (chosen).
const BEGUN: f32 = 0.25;
/// Least share of the rise's slope by which the contact gains on the free finger (chosen).
const LEAST_GAIN: f32 = 0.3;
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
        let share = self.drivetrain.weight_share * self.calibration.torque_factor;
        let [weight_nm, per_rad] = friction.asymmetry(place).map(|nm| share * nm);
        self.free(self.drivetrain.closing_rad(counts))
            .and_then(|free| self.finger.weighed(&free, weight_nm, preload_nm))
            .map_or(none, |(_, stop_nm)| ([weight_nm, per_rad], stop_nm))
    }

    /// By how much the torque of the motor may fall while an object takes over what closes the finger
    /// (docs/SENSING.md#a-weight-that-closes-the-finger), newton metre; 0 of a finger that the motor has to close.
    pub(super) fn carried_nm(&self, at: &CorrectedBlock<H::Reading>) -> f32 {
        let needed_nm = if F::WEIGHS {
            at.free_nm
        } else {
            self.weight(at.counts).0[0]
        };
        (-CARRIED * needed_nm).at_least(0.0)
    }

    /// The onset of a contact that took over the weight that closes the finger before its torque rose: on the way on which the contact
    /// gains on the free finger what that lacks to zero where the rise begins. Where the motor's torque has fallen far, the beginning of
    /// that fall is the onset, and the history is cut before its lowest block, whose torque is the new level: what the motor takes during
    /// the fall is no point of the contact's path.
    pub(super) fn before_weight(
        &self,
        mut onset: Onset,
        history: &mut History<H::Reading>,
        last: &CorrectedBlock<H::Reading>,
    ) -> Onset {
        let rad_per_count = self.drivetrain.rad_per_count;
        // Torque that the free finger takes there, and its slope.
        let (needed_nm, needed_nm_per_count) = if F::WEIGHS {
            let first = history.front().unwrap_or(last);
            let way_counts = last.counts.wrapping_sub(first.counts).max(1) as f32;
            let slope = (last.free_nm - first.free_nm) / way_counts;
            let back_counts = last.counts as f32 - onset.counts;
            (last.free_nm - slope * back_counts, slope)
        } else {
            let ([weight_nm, per_rad], _) = self.weight(onset.counts as i32);
            (weight_nm, per_rad * rad_per_count)
        };
        let share = self.drivetrain.efficiency * self.calibration.torque_factor;
        let nm_per_count = share * onset.slope_nm_per_count;
        let gain = (nm_per_count - needed_nm_per_count).at_least(LEAST_GAIN * nm_per_count);
        let hidden_counts = -needed_nm.at_most(0.0) / gain;
        let sigma_counts = HIDDEN_SIGMA * hidden_counts;
        onset.counts -= hidden_counts;
        onset.sigma_counts =
            sqrt(onset.sigma_counts * onset.sigma_counts + sigma_counts * sigma_counts);
        onset.since += (hidden_counts / last.width_counts.max(1) as f32) as usize;
        let residuals = history.iter().map(|block| block.residual_nm);
        let lowest_nm = residuals.fold(f32::MAX, f32::at_most);
        let shown_nm = SHOWN_SIGMAS * sqrt(last.variance_nm2);
        let level_nm = onset.level_nm;
        if needed_nm < 0.0 && level_nm - lowest_nm > shown_nm {
            onset.level_nm = lowest_nm;
            while let Some(first) = history.pop_front() {
                if level_nm - first.residual_nm < BEGUN * shown_nm {
                    onset.counts = first.counts as f32;
                    onset.sigma_counts = first.width_counts as f32;
                } else if first.residual_nm <= lowest_nm {
                    let _ = history.push_front(first);
                    break;
                }
            }
        }
        onset
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
