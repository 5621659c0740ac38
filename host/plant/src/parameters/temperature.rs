//! What temperature does to a motor's constants.

use super::Motor;

/// Temperature for which a data sheet states a motor's constants, degree Celsius.
const STATED_C: f64 = 25.0;

impl Motor {
    /// Resistance of a winding that is warmer than the air by `rise_k`, relative to the stated one.
    pub(crate) fn copper(&self, rise_k: f64) -> f64 {
        self.over_stated(self.copper_temperature_coefficient_per_k, rise_k)
    }

    /// Torque constant with magnets that are warmer than the air by `rise_k`, relative to the stated one.
    pub(crate) fn magnets(&self, rise_k: f64) -> f64 {
        self.over_stated(self.magnet_temperature_coefficient_per_k, rise_k)
    }

    fn over_stated(&self, per_k: f64, rise_k: f64) -> f64 {
        1.0 + per_k * (self.ambient_c - STATED_C + rise_k)
    }
}
