//! A change of slope, and what it says of the finger.

use crate::numeric::{Bounded, sqrt};

/// Within this share of the cable's stiffness the finger counts as rigid.
const RIGID_SHARE: f32 = 0.25;

/// A second contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeChange {
    /// Angle of the input link there, the cable's twist included, radian.
    pub theta_a_rad: f32,
    /// Torque above friction there, newton metre.
    pub torque_nm: f32,
    /// Slope of torque over angle before it, cable included, newton metre per radian.
    pub before_nm_per_rad: f32,
    /// The same after it.
    pub after_nm_per_rad: f32,
    /// Standard deviation of `after_nm_per_rad`.
    pub after_sigma_nm_per_rad: f32,
    /// How far apart the points of the curve are in which it was found, radian: one, two or four blocks.
    pub spacing_rad: f32,
}

impl SlopeChange {
    /// Compliance of the finger after the second contact and its deviation, the cable's taken off; radian per newton metre.
    /// For [`second_places`](crate::finger::Finger::second_places). At least 0.
    pub fn compliance(&self, cable_rad_per_nm: f32, cable_sigma_rad_per_nm: f32) -> (f32, f32) {
        let together = 1.0 / self.after_nm_per_rad;
        let share = together * together * self.after_sigma_nm_per_rad;
        (
            (together - cable_rad_per_nm).at_least(0.0),
            sqrt(share * share + cable_sigma_rad_per_nm * cable_sigma_rad_per_nm),
        )
    }

    /// Whether nothing but the cable gives way: the object is enveloped. Two phalanges that both touch are always so.
    pub fn is_rigid(&self, cable_rad_per_nm: f32, cable_sigma_rad_per_nm: f32) -> bool {
        let (left, sigma) = self.compliance(cable_rad_per_nm, cable_sigma_rad_per_nm);
        left <= RIGID_SHARE * cable_rad_per_nm + 2.0 * sigma
    }
}
