//! The truth, known to the simulation only.

use crate::Pins;

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
