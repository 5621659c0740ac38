//! The library's own solvers, as the firmware links them: a pair of joints for phalanx 2, three for phalanx 3.

use super::ThreePhalanges;
use crate::candidate::{NOWHERE, Roots};
use crate::two::library as pair;
use palpate::finger::ThreeJointContact;

impl ThreePhalanges {
    #[inline(always)]
    fn triple(&self) -> ThreeJointContact {
        let d2_m = self.l[1] * self.cos3;
        ThreeJointContact {
            d1_m: self.l[0] * self.cos23 + d2_m,
            d2_m,
            x2: self.x2,
            x3: self.x3,
            k1: self.stiffness1,
            h22: self.h22,
            h23: self.h23,
            h33: self.h33,
        }
    }
}

/// The stable closed forms (docs/MECHANICS.md#contact-stiffness).
#[inline(never)]
pub fn closed(input: &ThreePhalanges) -> Roots {
    if input.phalanx == 2 {
        return input
            .effective()
            .map_or(NOWHERE, |two| pair::closed_part(&two));
    }
    pair::kept(input.triple().closed(input.compliance), input.l[2])
}

/// Bisection, 24 steps a root.
#[inline(never)]
pub fn bisected(input: &ThreePhalanges) -> Roots {
    if input.phalanx == 2 {
        return input
            .effective()
            .map_or(NOWHERE, |two| pair::bisected_part(&two));
    }
    let found = input.triple().bisected(input.compliance, input.l[2]);
    [
        found.near_m.unwrap_or(f32::NAN),
        found.far_m.unwrap_or(f32::NAN),
    ]
}
