// SPDX-License-Identifier: GPL-2.0-only
//! Which finger, and what it is going to meet.

use palpate_plant::{FingerKind, Grasp, Parameters, Shape};

/// The finger a firmware is built for, by the name of its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Scene {
    /// The prototype: two phalanges, linkage.
    P70,
    /// The same without a cable.
    P70Rigid,
    /// Two phalanges, tendon.
    Tendon2,
    /// The same with a Hall sensor at joint 2.
    Tendon2Hall,
    /// Three phalanges, tendon.
    Tendon3,
    /// Three phalanges, linkage.
    Linkage3,
}

impl Scene {
    /// Its world, given the parameters that all scenes share.
    #[must_use]
    pub fn world(self, shared: &Parameters) -> Parameters {
        match self {
            Self::P70Rigid => shared.without_cable(),
            _ => shared.clone(),
        }
    }

    /// The plant's name for it.
    #[must_use]
    pub fn finger(self) -> FingerKind {
        match self {
            Self::P70 | Self::P70Rigid => FingerKind::P70,
            Self::Tendon2 | Self::Tendon2Hall => FingerKind::Tendon2,
            Self::Tendon3 => FingerKind::Tendon3,
            Self::Linkage3 => FingerKind::Linkage3,
        }
    }
}

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
