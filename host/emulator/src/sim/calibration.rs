// SPDX-License-Identifier: GPL-2.0-only
//! Compares a calibration's result with the values of the simulated world.

use palpate::app::console::settings::{Overrides, Setting};
use palpate::app::grasp::values::closing_rad_per_s;
use palpate::scene::Scene;
use palpate_plant::{Parameters, TrueCalibration};
use serde_json::{Value, json};

use crate::log::Line;

/// Efficiency of the gears that a scene's firmware computes with before it is calibrated, and the speed at which it closes, radian per
/// second, with these settings.
fn assumed<S: Scene>(set: &Overrides) -> [f64; 2] {
    let efficiency = set.get(Setting::Efficiency).unwrap_or(S::EFFICIENCY);
    [efficiency, closing_rad_per_s::<S>(set)].map(f64::from)
}

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
    /// The last one that the log tells of, with the settings in force then: the firmware tells a factor on the efficiency that is set, and
    /// the cable's twist per torque computed with it, and the worm's efficiency is that at the speed of the closing.
    #[must_use]
    pub fn of(lines: &[Line], parameters: &Parameters, set: &Overrides) -> Option<Self> {
        let line = lines
            .iter()
            .rev()
            .find(|line| line.event().name == "calibrated")?;
        let event = line.event();
        let nominal = Parameters::of(&parameters.scene).ok()?;
        let [efficiency, speed_rad_per_s] =
            palpate_scenes::for_scene!(parameters.scene.as_str(), |S| assumed::<S>(set))?;
        let truth = TrueCalibration::of(
            parameters,
            efficiency,
            nominal.motor.torque_constant_nm_per_a,
            speed_rad_per_s,
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

    fn found(scene: &str, set: &Overrides) -> Calibration {
        let message = "calibrated torque_factor=0.9 torque_factor_sigma=0.1 cable_mrad_per_nm=800 cable_sigma_mrad_per_nm=20";
        let line = Line {
            fetched_s: 0.0,
            timestamp: String::new(),
            level: "info".into(),
            message: message.into(),
            location: String::new(),
        };
        let parameters = Parameters::of(scene).expect("a scene of this project");
        Calibration::of(&[line], &parameters, set).expect("a calibration")
    }

    /// The truth is told as a factor on what the firmware of that scene assumes: within 3 %, what the plant's worm loses besides.
    #[test]
    fn a_finger_as_its_scene_has_it_has_a_factor_of_one() {
        for scene in palpate_scenes::NAMES {
            let factor = found(scene, &Overrides::default()).torque_factor;
            assert!((factor.truth - 1.0).abs() < 0.03, "{scene}: {factor:?}");
            assert!((factor.sigma - 0.09).abs() < 1e-12);
        }
    }

    fn with(setting: Setting, value_si: f32) -> Calibration {
        let mut set = Overrides::default();
        set.set(setting, value_si).expect("in range");
        found("p70", &set)
    }

    /// The firmware computes torques with the efficiency that is set.
    #[test]
    fn the_truth_is_in_units_of_the_efficiency_that_is_set() {
        let plain = found("p70", &Overrides::default());
        let other = with(Setting::Efficiency, 0.4);
        let share = f64::from(palpate_scenes::P70::EFFICIENCY) / 0.4;
        for (other, plain) in [
            (other.torque_factor, plain.torque_factor),
            (other.cable_mrad_per_nm, plain.cable_mrad_per_nm),
        ] {
            let ratio = other.truth / plain.truth;
            assert!((ratio - share).abs() < 1e-6, "{ratio} instead of {share}");
        }
    }

    /// A worm slides with less friction the faster it turns.
    #[test]
    fn the_truth_is_that_at_the_speed_that_is_set() {
        let truth = |speed| with(Setting::ClosingSpeed, speed).torque_factor.truth;
        let plain = found("p70", &Overrides::default()).torque_factor.truth;
        assert!(truth(0.1) < 0.97 * plain && plain < 0.97 * truth(0.8));
    }
}
