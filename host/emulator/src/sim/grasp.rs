// SPDX-License-Identifier: GPL-2.0-only
//! The object in the finger's way.

use palpate_plant::{Grasp, Shape};

/// A cylinder that the freely closing finger meets at a wanted place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Phalanx, from 1.
    pub phalanx: u8,
    /// Place from that phalanx's joint.
    pub contact_mm: f64,
    /// Diameter.
    pub diameter_mm: f64,
    /// Angle of joint 1 when they meet.
    pub theta_1_deg: f64,
}

impl Default for Object {
    fn default() -> Self {
        Self {
            phalanx: 2,
            contact_mm: 30.0,
            diameter_mm: 10.0,
            theta_1_deg: 45.0,
        }
    }
}

impl Object {
    /// The pin of a calibration, at this distance from a phalanx's joint, metre; it is met where the wanted object would be.
    #[must_use]
    pub fn pin(phalanx: u8, k_m: f64, wanted: Option<Self>) -> Self {
        let pin = Self::default();
        Self {
            phalanx,
            // To a micrometre, as near as single precision has it.
            contact_mm: (1e6 * k_m).round() * 1e-3,
            theta_1_deg: wanted.map_or(pin.theta_1_deg, |wanted| wanted.theta_1_deg),
            ..pin
        }
    }

    /// As the plant wants it.
    #[must_use]
    pub fn grasp(&self) -> Grasp {
        let shape = Shape::Cylinder {
            diameter_m: 1e-3 * self.diameter_mm,
        };
        Grasp::touching(
            self.phalanx,
            1e-3 * self.contact_mm,
            self.theta_1_deg.to_radians(),
            shape,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_brings_its_own_pin() {
        assert_eq!(Object::pin(2, 0.03, None), Object::default());
        let wanted = Object {
            phalanx: 1,
            contact_mm: 20.0,
            diameter_mm: 12.0,
            theta_1_deg: 30.0,
        };
        let pin = Object {
            phalanx: 3,
            contact_mm: 40.0,
            diameter_mm: 10.0,
            ..wanted
        };
        assert_eq!(Object::pin(3, f64::from(0.04_f32), Some(wanted)), pin);
    }
}
