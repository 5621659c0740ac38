//! The library's own solvers, as the firmware links them.

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use palpate::finger::{Roots as Found, TwoJointContact};

impl TwoPhalanges {
    #[inline(always)]
    fn pair(&self) -> TwoJointContact {
        TwoJointContact {
            c_m: self.c(),
            x2: self.x2,
            k1: self.stiffness1,
            h22: self.stiffness2,
        }
    }
}

/// What the library found, kept to the phalanx: its closed form does not know where that ends.
#[inline(always)]
pub fn kept(found: Found, length: f32) -> Roots {
    let keep = |root: Option<f32>| match root {
        Some(k) => on_phalanx(k, length),
        None => f32::NAN,
    };
    [keep(found.near_m), keep(found.far_m)]
}

/// The stable closed form, to be part of another function.
#[inline(always)]
pub fn closed_part(input: &TwoPhalanges) -> Roots {
    kept(input.pair().closed(input.compliance), input.l2)
}

/// Bisection, to be part of another function.
#[inline(always)]
pub fn bisected_part(input: &TwoPhalanges) -> Roots {
    let found = input.pair().bisected(input.compliance, input.l2);
    [
        found.near_m.unwrap_or(f32::NAN),
        found.far_m.unwrap_or(f32::NAN),
    ]
}

/// The stable closed form (docs/MECHANICS.md#contact-stiffness).
#[inline(never)]
pub fn closed(input: &TwoPhalanges) -> Roots {
    closed_part(input)
}

/// Bisection, 24 steps a root.
#[inline(never)]
pub fn bisected(input: &TwoPhalanges) -> Roots {
    bisected_part(input)
}
