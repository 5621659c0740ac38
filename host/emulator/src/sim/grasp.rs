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
