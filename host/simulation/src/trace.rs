//! Trace of a motion, once a millisecond: measurements and truth.

use palpate::drive::convert;
use palpate::drive::io::Outputs;
use palpate::sample::Sample;
use palpate_plant::Truth;

/// A line of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time since reset, second.
    pub time_s: f64,
    /// Encoder position, counts from the opening stop once homed.
    pub encoder_counts: i32,
    /// Motor current as measured, ampere, closing positive.
    pub current_a: f32,
    /// Share of the supply at the motor, closing positive.
    pub duty: f32,
    /// Angle of the input link, radian.
    pub true_theta_a_rad: f64,
    /// Joint angles, radian; zero beyond the last.
    pub true_joint_rad: [f64; 3],
    /// Torque of the cable at the input link, newton metre.
    pub true_torque_nm: f64,
    /// Winding current, ampere.
    pub true_current_a: f64,
    /// Phalanx that presses hardest; 0 for none.
    pub true_phalanx: u8,
    /// Where it touches, metre.
    pub true_k_m: f64,
    /// Its force, newton.
    pub true_force_n: f64,
    /// Phalanges that press on the object, a bit each, the first the lowest; not in the table.
    pub true_pressing: u8,
}

/// Names of the columns of [`Row::csv`].
pub const HEADER: &str = "time_s,encoder_counts,current_a,duty,true_theta_a_rad,true_theta_1_rad,true_theta_2_rad,\
true_theta_3_rad,true_torque_nm,true_current_a,true_phalanx,true_k_m,true_force_n";

impl Row {
    /// From a sample and the truth at its end.
    #[must_use]
    pub fn new<J>(sample: &Sample<J>, outputs: Outputs, truth: &Truth) -> Self {
        let contact = truth.strongest();
        Self {
            time_s: truth.time_s,
            encoder_counts: sample.position_counts,
            current_a: sample.current_a,
            duty: convert::applied(outputs),
            true_theta_a_rad: truth.theta_a_rad,
            true_joint_rad: truth.joint_rad,
            true_torque_nm: truth.torque_nm,
            true_current_a: truth.motor_current_a,
            true_phalanx: contact.map_or(0, |c| c.phalanx),
            true_k_m: contact.map_or(0.0, |c| c.k_m),
            true_force_n: contact.map_or(0.0, |c| c.force_n),
            true_pressing: (truth.contacts.iter())
                .fold(0, |pressing, contact| pressing | 1 << (contact.phalanx - 1)),
        }
    }

    /// A line of a table under [`HEADER`].
    #[must_use]
    pub fn csv(&self) -> String {
        let [theta_1, theta_2, theta_3] = self.true_joint_rad;
        format!(
            "{:.6},{},{:.6},{:.5},{:.7},{theta_1:.7},{theta_2:.7},{theta_3:.7},{:.7},{:.7},{},{:.6},{:.5}",
            self.time_s,
            self.encoder_counts,
            self.current_a,
            self.duty,
            self.true_theta_a_rad,
            self.true_torque_nm,
            self.true_current_a,
            self.true_phalanx,
            self.true_k_m,
            self.true_force_n,
        )
    }
}
