//! A finger of two phalanges that a preloaded return cable opens in place of springs: what a contact changes there
//! (docs/FINGERS.md#return-cable).
//!
//! The cable runs over a pulley at each joint to one spring. It holds joint 2 at its opening stop while joint 1 closes. A contact on
//! phalanx 2 makes the finger rigid until a break-away torque ([`super::StoppedContact`]); then both joints turn.

use super::build::BaseJoint;
use super::error::{check_range, try_const};
use super::inverse::Solver;
use super::two_joint::{lever, rigid_m};
use super::{Base, Candidate, Class, ConfigError, Inverse, Parameter, Roots};
use crate::numeric::{bisect, sqrt};

/// Limits of torque and stiffness about joint 1, and of the pulleys' ratio: beyond, products of two leave the range of f32.
const RANGE: [f32; 2] = [1e-9, 1e9];

/// A return cable as the joints feel it. A [`BaseJoint`]: such a finger has no springs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReturnCable {
    /// Radius of its pulley at joint 2 over that at joint 1.
    pub ratio: f32,
    /// Torque about joint 1 with both joints at rest, newton metre.
    pub torque_nm: f32,
    /// Growth of that torque with the angle of joint 1, newton metre per radian.
    pub stiffness_nm_per_rad: f32,
}

impl BaseJoint for ReturnCable {
    const BASE: Base = Base::ReturnCable;
    const HOLDS: bool = true;
    // 0.29 of what pulleys are off by (docs/FINGERS.md#return-cable), and more for losses that differ from place to place.
    const PINS_LEAVE: f32 = 0.4;

    fn return_cable(&self) -> Option<&ReturnCable> {
        Some(self)
    }
}

impl ReturnCable {
    /// Refuses what is not finite or outside its range; a ratio of `least` or less would not hold joint 2 at its stop.
    pub(super) const fn check(self, least: f32) -> Result<Self, ConfigError> {
        let [min, max] = RANGE;
        // The next number beyond `least`, which is positive.
        let above = f32::from_bits(least.to_bits() + 1);
        try_const!(check_range(Parameter::ReturnRatio, self.ratio, above, max));
        try_const!(check_range(
            Parameter::ReturnTorque,
            self.torque_nm,
            min,
            max
        ));
        try_const!(check_range(
            Parameter::ReturnStiffness,
            self.stiffness_nm_per_rad,
            min,
            max
        ));
        Ok(self)
    }

    /// Lever of the cable about each joint, over that about joint 1.
    pub(super) fn factors<const N: usize>(&self) -> [f32; N] {
        core::array::from_fn(|joint| if joint == 0 { 1.0 } else { self.ratio })
    }

    /// Torque about joint 1 with that joint turned by an angle from rest and joint 2 at its stop.
    pub(super) fn torque_at(&self, from_rest_rad: f32) -> f32 {
        self.torque_nm + self.stiffness_nm_per_rad * from_rest_rad
    }
}

/// Statics of a contact on phalanx 2 of such a finger while joint 2 stands at its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReturnedContact {
    /// l_1 cos theta_2: what joint 1 has more of moment arm than joint 2, metre.
    pub c_m: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// What opens the finger.
    pub cable: ReturnCable,
}

impl ReturnedContact {
    /// Lever of the closing tendon over the motion that the contact leaves.
    pub(super) fn lever(&self, k_m: f32) -> f32 {
        lever(self.x2, self.c_m, k_m)
    }

    /// The same of the return cable.
    pub(super) fn return_lever(&self, k_m: f32) -> f32 {
        lever(self.cable.ratio, self.c_m, k_m)
    }

    /// Compliance of the finger once joint 2 has left its stop, radian per newton metre; 0 from e_2 on, where it does not.
    pub fn compliance(&self, k_m: f32) -> Option<f32> {
        let lever = self.lever(k_m);
        if lever <= 0.0 {
            return Some(0.0);
        }
        let share = lever / self.return_lever(k_m);
        let compliance = share * (share / self.cable.stiffness_nm_per_rad);
        (compliance.is_finite() && share > 0.0).then_some(compliance)
    }

    /// The same with a contact on phalanx 1, anywhere: the limit for k -> 0.
    pub fn proximal(&self) -> Option<f32> {
        let share = self.x2 / self.cable.ratio;
        let compliance = share * (share / self.cable.stiffness_nm_per_rad);
        (compliance.is_finite() && share > 0.0).then_some(compliance)
    }

    /// e_2 (27), from which on joint 2 does not leave its stop; `None` where there is no such place ahead of the joint.
    pub fn stiffest_m(&self) -> Option<f32> {
        rigid_m(self.x2, self.c_m)
    }

    /// The place of a compliance after break-away in closed form, whether on the phalanx or not: the root of what is squared in it
    /// is a quotient of two linear functions of the place.
    pub(super) fn closed(&self, compliance: f32) -> Roots {
        let Self { c_m, x2, cable } = self;
        let share = sqrt(compliance * cable.stiffness_nm_per_rad);
        let k_m = c_m * (x2 - share * cable.ratio) / ((1.0 - x2) - share * (1.0 - cable.ratio));
        Roots {
            near_m: Some(k_m).filter(|k_m| *k_m > 0.0 && *k_m < f32::INFINITY),
            far_m: None,
        }
    }

    /// The same on a phalanx of length `length_m` by bisection: what the firmware asks.
    pub(super) fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        let share = sqrt(compliance * self.cable.stiffness_nm_per_rad);
        let root = bisect(0.0, length_m, |k_m| {
            self.lever(k_m) - share * self.return_lever(k_m)
        });
        Roots {
            near_m: root.filter(|k_m| *k_m > 0.0),
            far_m: None,
        }
    }

    /// See [`super::Mechanics::locate`].
    pub(super) fn places<S: Solver>(&self, compliance: f32, length_m: f32) -> Inverse {
        let Some(proximal) = self.proximal().filter(|_| compliance >= 0.0) else {
            return Inverse::of(heapless::Vec::new(), Class::Invalid);
        };
        let root = S::returned(self, compliance, length_m).near_m;
        let free = self.cable.stiffness_nm_per_rad;
        explained(compliance, root, length_m, proximal, free)
    }
}

/// What explains a compliance after break-away, with its root on phalanx 2 wherever that lies. Nothing is softer than joint 1 turned
/// alone, whose stiffness is `free_nm_per_rad`: a root there lies where both levers are negative, and joint 2 stays at its stop.
pub(super) fn explained(
    compliance: f32,
    root_m: Option<f32>,
    length_m: f32,
    proximal: f32,
    free_nm_per_rad: f32,
) -> Inverse {
    let mut candidates = heapless::Vec::new();
    let is_too_soft = compliance * free_nm_per_rad > 1.0;
    if let Some(k_m) = root_m.filter(|k_m| *k_m <= length_m && !is_too_soft) {
        // Room for two places a phalanx.
        let _ = candidates.push(Candidate {
            phalanx: 2,
            k_m,
            beyond_stiffest: false,
        });
    }
    let class = if is_too_soft {
        Class::TooSoft
    } else if compliance >= proximal {
        Class::Gap
    } else {
        Class::TooStiff
    };
    Inverse::of(candidates, class)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finger::inverse::{Bisection, ClosedForm};

    /// Where the return cable has a short lever about joint 2 both levers are negative on the outer half of the phalanx.
    #[test]
    fn what_is_softer_than_the_free_finger_has_no_place_beyond_the_stiffest_one() {
        let contact = ReturnedContact {
            c_m: 0.02,
            x2: 0.5,
            cable: ReturnCable {
                ratio: 0.6,
                torque_nm: 0.1,
                stiffness_nm_per_rad: 0.2,
            },
        };
        assert_eq!(contact.stiffest_m(), Some(0.02));
        assert_eq!(contact.compliance(0.05), Some(0.0));
        let share = contact.lever(0.05) / contact.return_lever(0.05);
        let too_soft = share * share / contact.cable.stiffness_nm_per_rad;
        for inverse in [
            contact.places::<Bisection>(too_soft, 0.07),
            contact.places::<ClosedForm>(too_soft, 0.07),
        ] {
            assert_eq!(inverse.class(), Class::TooSoft);
            assert!(inverse.candidates().is_empty(), "{inverse:?}");
        }
        let there = contact.compliance(0.01).expect("a compliance");
        let inverse = contact.places::<Bisection>(there, 0.07);
        assert_eq!(inverse.class(), Class::Unique);
        assert!((inverse.candidates()[0].k_m - 0.01).abs() < 1e-6);
    }
}
