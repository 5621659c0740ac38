// SPDX-License-Identifier: GPL-2.0-only
//! Compares a calibration's result with the values of the simulated world.

use palpate_plant::{Parameters, TrueCalibration};
use serde_json::{Value, json};

use crate::log::Line;

/// What the firmware computes with before it is calibrated, worm and gearhead (scenes/common/defaults.toml); `show` lists it.
const NOMINAL_EFFICIENCY: f64 = 0.434 * 0.73;
/// Speed at which the finger closes, radian per second.
const SPEED_RAD_PER_S: f64 = 0.3;
/// A value that was found, with its claimed deviation, and the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// As the firmware logged it.
    pub value: f64,
    /// Claimed standard deviation.
    pub sigma: f64,
    /// From the plant's parameters.
    pub truth: f64,
}

impl Found {
    /// Error in claimed deviations.
    #[must_use]
    pub fn deviations(&self) -> f64 {
        (self.value - self.truth) / self.sigma
    }

    fn json(&self) -> Value {
        json!({
            "found": self.value, "sigma": self.sigma, "true": self.truth, "deviations": self.deviations(),
        })
    }

    fn text(&self, name: &str) -> String {
        format!(
            "{name:<24} {:>9.4} +- {:<9.4} {:>9.4}  {:+.1} sigma\n",
            self.value,
            self.sigma,
            self.truth,
            self.deviations()
        )
    }
}

/// Torque factor and cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Efficiency over spring stiffness, as a factor on what the firmware assumes.
    pub torque_factor: Found,
    /// Elastic twist of the cable per torque as the firmware computes it, milliradian per newton metre.
    pub cable_mrad_per_nm: Found,
}

impl Calibration {
    /// The last one that the log tells of.
    #[must_use]
    pub fn of(lines: &[Line], parameters: &Parameters) -> Option<Self> {
        let line = lines
            .iter()
            .rev()
            .find(|line| line.event().name == "calibrated")?;
        let event = line.event();
        let nominal = Parameters::of(&parameters.scene).ok()?;
        let truth = TrueCalibration::of(
            parameters,
            NOMINAL_EFFICIENCY,
            nominal.motor.torque_constant_nm_per_a,
            SPEED_RAD_PER_S,
        );
        let value = event.number("torque_factor")?;
        Some(Self {
            torque_factor: Found {
                value,
                // The deviation is one of the logarithm.
                sigma: value * event.number("torque_factor_sigma")?,
                truth: truth.torque_factor,
            },
            cable_mrad_per_nm: Found {
                value: event.number("cable_mrad_per_nm")?,
                sigma: event.number("cable_sigma_mrad_per_nm")?,
                truth: 1e3 * truth.cable_rad_per_nm,
            },
        })
    }

    /// For a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let head = format!(
            "{:<24} {:>9}    {:<9} {:>9}\n",
            "calibration", "found", "", "true"
        );
        head + &self.torque_factor.text("torque factor")
            + &self.cable_mrad_per_nm.text("cable, mrad/(N m)")
    }

    /// One object.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({
            "type": "calibration", "torque_factor": self.torque_factor.json(),
            "cable_mrad_per_nm": self.cable_mrad_per_nm.json(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::scene::Scene;
    use palpate_scenes::P70;

    /// The truth is told as a factor on what the firmware assumes: both must be the scenes' own.
    #[test]
    fn efficiency_and_speed_are_those_of_the_scenes() {
        assert!((NOMINAL_EFFICIENCY - f64::from(P70::EFFICIENCY)).abs() < 1e-6);
        assert!((SPEED_RAD_PER_S - f64::from(P70::MOTION.closing_rad_per_s)).abs() < 1e-6);
    }
}
