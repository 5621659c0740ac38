//! Force control while holding: the motor current that holds a wanted contact force.
//!
//! In single contact the force is proportional to the torque above friction, and that to the current above what free motion
//! took. A force below the one that probing has reached is not released: the worm locks.

use crate::numeric::Bounded;

/// Weight of a new sample in the mean of the free current: a time constant of 0.1 s.
const GAIN: f32 = 0.01;

/// The current that free closing takes, and with it the current for a force.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceHold {
    free_a: f32,
    probing_a: f32,
    /// The last word on the contact has set the current that holds.
    settled: bool,
}

impl ForceHold {
    /// Takes the current of a sample while closing. A contact adds little to the mean until it is detected.
    pub fn closing(&mut self, current_a: f32) {
        self.settled = false;
        self.free_a += GAIN * (current_a - self.free_a);
    }

    /// Takes the current while probing. Once the motor holds, its current says nothing of the force: the worm stands.
    pub fn probing(&mut self, current_a: f32) {
        // A motor that is braked holds nothing, and must not open the finger.
        self.probing_a = current_a.at_least(0.0);
    }

    /// The current that probing ended with.
    pub fn probed_a(&self) -> f32 {
        self.probing_a
    }

    /// The last word on the contact sets the current that holds.
    pub fn settle(&mut self) {
        self.settled = true;
    }

    /// Whether it has done so since the closing.
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// The current that holds `wanted_n`, whatever its limit, given that probing has reached the contact force `force_n`. None
    /// where the two do not determine it: no force, or no current above that of free motion.
    pub fn current_a(&self, force_n: f32, wanted_n: f32) -> Option<f32> {
        let load_a = self.probing_a - self.free_a;
        // A NaN is not greater than zero.
        (load_a > 0.0 && force_n > 0.0)
            .then(|| (self.free_a + load_a * wanted_n / force_n).at_least(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_current_above_free_motion_is_proportional_to_the_force() {
        let mut hold = ForceHold {
            free_a: 0.015,
            ..ForceHold::default()
        };
        hold.probing(0.065);
        let held_a = |force_n, wanted_n| hold.current_a(force_n, wanted_n);
        assert!((held_a(1.0, 1.5).expect("told") - 0.09).abs() < 1e-6);
        assert!(held_a(0.1, 1.5).expect("told") > 0.7, "whatever its limit");
        for force_n in [0.0, -1.0, f32::NAN] {
            assert_eq!(held_a(force_n, 1.5), None);
        }
        hold.probing(0.01);
        assert_eq!(hold.current_a(1.0, 1.5), None);
    }

    #[test]
    fn the_free_current_is_a_mean_over_a_tenth_of_a_second() {
        let mut hold = ForceHold::default();
        for _ in 0..100 {
            hold.closing(0.02);
        }
        assert!((0.012..0.013).contains(&hold.free_a), "{}", hold.free_a);
    }
}
