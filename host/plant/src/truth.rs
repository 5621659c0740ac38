//! The truth, known to the simulation only.

use crate::{Parameters, Pins, worm_efficiency};

/// Middle of a probing: current, duty and torque at the input link, where curves of the sense and of the cable are taken for
/// straight.
const MIDDLE_A: f64 = 0.06;
const MIDDLE_DUTY: f64 = 0.4;
const MIDDLE_NM: f64 = 0.17;

/// What a calibration is about, in the terms of the library's `Calibration`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueCalibration {
    /// Efficiency over spring stiffness, as a factor on the scene's.
    pub torque_factor: f64,
    /// Elastic twist of the cable, radian per newton metre computed with the scene's values.
    pub cable_rad_per_nm: f64,
}

impl TrueCalibration {
    /// Of a world, for a scene that counts on an efficiency and a torque constant, at the speed of the input link at which the
    /// finger closes: the worm's friction depends on it.
    #[must_use]
    pub fn of(
        parameters: &Parameters,
        efficiency: f64,
        torque_constant_nm_per_a: f64,
        closing_rad_per_s: f64,
    ) -> Self {
        let motor = &parameters.motor;
        let constant =
            motor.torque_constant_nm_per_a * motor.magnets(0.0) / torque_constant_nm_per_a;
        let current = parameters.sensed_share(MIDDLE_A, MIDDLE_DUTY);
        let passed_on = parameters.gearhead.efficiency
            * worm_efficiency(parameters, closing_rad_per_s)
            / (1.0 + parameters.transmission.hysteresis_share);
        // Torque at the input link for one computed from the measured current with the scene's values.
        let torque = constant * passed_on / efficiency / current;
        Self {
            torque_factor: torque / (1.0 + parameters.mechanism.spring_error),
            cable_rad_per_nm: torque
                / parameters.cable_stiffness_nm_per_rad()
                / (1.0 + parameters.cable.stiffening_per_nm * MIDDLE_NM),
        }
    }
}

/// One point where the finger presses on the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Phalanx, from 1.
    pub phalanx: u8,
    /// Place along the phalanx's axis from its joint, metre.
    pub k_m: f64,
    /// Normal force, newton.
    pub force_n: f64,
    /// Whether it is on the dorsal side.
    pub back: bool,
}

/// First contact with an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstContact {
    /// Time since the plant was made, second.
    pub time_s: f64,
    /// Place, and force at the end of that step.
    pub contact: Contact,
    /// Joint angles then, radian.
    pub joint_rad: [f64; 3],
    /// Input-link angle then, radian.
    pub theta_a_rad: f64,
    /// Torque at the input link then, newton metre.
    pub torque_nm: f64,
}

/// The hidden state of the plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Second since the plant was made.
    pub time_s: f64,
    /// How many phalanges the finger has; joints beyond are zero.
    pub phalanges: usize,
    /// Relative joint angles, radian.
    pub joint_rad: [f64; 3],
    /// Input-link angle, theta_1 plus what the transmission adds, radian.
    pub theta_a_rad: f64,
    /// The same at the opening stop.
    pub opening_stop_rad: f64,
    /// The same at the closing stop.
    pub closing_stop_rad: f64,
    /// Torque of the cable at the input link, newton metre, closing positive.
    pub torque_nm: f64,
    /// Winding current, ampere, closing positive.
    pub motor_current_a: f64,
    /// Motor speed, radian per second, closing positive.
    pub motor_speed_rad_per_s: f64,
    /// Motor angle, radian since the plant was made.
    pub motor_angle_rad: f64,
    /// Supply voltage at the bridge.
    pub supply_v: f64,
    /// Winding temperature, degree Celsius.
    pub winding_c: f64,
    /// Levels on the pins in the last step.
    pub pins: Pins,
    /// Where the finger presses on the object now.
    pub contacts: Vec<Contact>,
    /// First contact since the object was placed.
    pub first_contact: Option<FirstContact>,
    /// Kinetic energy, springs, stops, contacts and cable, joule.
    pub stored_energy_j: f64,
}

impl Truth {
    /// The contact with the largest force.
    #[must_use]
    pub fn strongest(&self) -> Option<&Contact> {
        self.contacts
            .iter()
            .max_by(|a, b| a.force_n.total_cmp(&b.force_n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parameters: &Parameters) -> TrueCalibration {
        let constant = Parameters::default().motor.torque_constant_nm_per_a;
        TrueCalibration::of(parameters, 0.317, constant, 0.3)
    }

    #[test]
    fn the_true_calibration_follows_the_hidden_values() {
        let base = Parameters::default();
        let nominal = of(&base);
        // The efficiency that scenes count on is a round number, the plant's follows from its worm.
        assert!((nominal.torque_factor - 1.0).abs() < 0.1, "{nominal:?}");
        let mut other = base.clone();
        other.motor.torque_constant_nm_per_a *= 1.1;
        other.mechanism.spring_error = 0.25;
        other.cable.stiffness_n_per_m *= 2.0;
        let found = of(&other);
        let ratio = found.torque_factor / nominal.torque_factor;
        assert!((ratio - 1.1 / 1.25).abs() < 1e-9, "{ratio}");
        let ratio = found.cable_rad_per_nm / nominal.cable_rad_per_nm;
        assert!((ratio - 1.1 / 2.0).abs() < 1e-9, "{ratio}");
    }
}
