//! The library's own solvers, as the firmware links them.

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use palpate::finger::{Pair, Roots as Found};

impl TwoPhalanges {
    #[inline(always)]
    fn pair(&self) -> Pair {
        Pair {
            c_m: self.c(),
            x2: self.x2,
            k1: self.stiffness1,
            h22: self.stiffness2,
        }
    }
}

/// What the library found, kept to the phalanx.
#[inline(always)]
pub fn kept(found: Found, length: f32) -> Roots {
    [found.near_m, found.far_m].map(|root| root.map_or(f32::NAN, |k| on_phalanx(k, length)))
}

/// The stable closed form (MATH 5).
#[inline(never)]
pub fn closed(input: &TwoPhalanges) -> Roots {
    kept(input.pair().closed(input.compliance), input.l2)
}

/// Bisection to neighbouring numbers.
#[inline(never)]
pub fn bisected(input: &TwoPhalanges) -> Roots {
    kept(input.pair().bisected(input.compliance, input.l2), input.l2)
}
