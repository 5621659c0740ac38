//! Two joints held by one contact on the second phalanx: K_c (18) in closed form and its inverse
//! (docs/MECHANICS.md#contact-stiffness).
//!
//! With three phalanges and the contact on phalanx 2, the third joint is eliminated and the same problem remains.

use crate::numeric::{Bounded, bisect, sqrt};

/// The stiffness problem of a contact on phalanx 2, reduced to four numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoJointContact {
    /// l_1 cos theta_2: what joint 1 has more of moment arm than joint 2, metre.
    pub c_m: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// Stiffness K_1, newton metre per radian; may be 0.
    pub k1: f32,
    /// H_22 = K_2 - G_22, newton metre per radian, positive.
    pub h22: f32,
}

/// Roots of the inverse on one phalanx: nearer than its stiffest point, and beyond; both are that point for C = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roots {
    /// Below e_2.
    pub near_m: Option<f32>,
    /// Beyond e_2.
    pub far_m: Option<f32>,
}

/// Positive and finite, in one comparison: such numbers are ordered as their bits are.
fn ahead(k: f32) -> bool {
    k.to_bits().wrapping_sub(1) < f32::INFINITY.to_bits() - 1
}

impl TwoJointContact {
    /// p_1 x_2 - p_2, over the contact's moment arms p: the motion that the contact leaves, as the input link sees it.
    fn lever(&self, k: f32) -> f32 {
        // Grouped so that c, not k + c, is multiplied: near e_2 the two terms cancel.
        self.x2 * self.c_m - (1.0 - self.x2) * k
    }

    /// Energy of that motion, K_1 p_2^2 + H_22 p_1^2.
    fn energy(&self, k: f32) -> f32 {
        let arm = self.c_m + k;
        self.k1 * k * k + self.h22 * arm * arm
    }

    /// Compliance 1/K_c of a contact at `k_m` (18); `None` for values that do not give one.
    pub fn compliance(&self, k_m: f32) -> Option<f32> {
        // One quotient of sizes near one, squared: no overflow where lengths or stiffnesses are large.
        let (lever, energy) = (self.lever(k_m), self.energy(k_m));
        let compliance = lever * (lever / energy);
        (compliance.is_finite() && energy > 0.0).then_some(compliance)
    }

    /// A closing finger presses at `k_m`: df/dT_a > 0 (docs/MECHANICS.md#contact-stiffness).
    pub fn presses(&self, k_m: f32) -> bool {
        self.h22 * (self.c_m + k_m) + self.k1 * self.x2 * k_m > 0.0
    }

    /// Compliance of a proximal contact, the limit for `k` -> 0 (docs/MECHANICS.md#contact-stiffness).
    pub fn proximal(&self) -> Option<f32> {
        let compliance = self.x2 * (self.x2 / self.h22);
        (compliance.is_finite() && self.h22 > 0.0).then_some(compliance)
    }

    /// e_2 = c x_2 / (1 - x_2) (27), where the finger is rigid; `None` where there is no such place ahead of the joint.
    pub fn stiffest_m(&self) -> Option<f32> {
        let e2 = self.c_m * self.x2 / (1.0 - self.x2);
        (e2.is_finite() && e2 > 0.0).then_some(e2)
    }

    /// Both roots in closed form, whether on the phalanx or not (docs/MECHANICS.md#contact-stiffness): forms without
    /// cancellation.
    #[inline]
    pub fn closed(&self, compliance: f32) -> Roots {
        let Self {
            c_m: c,
            x2,
            k1,
            h22,
        } = *self;
        let num = x2 * x2 - compliance * h22;
        let square = compliance * h22 + compliance * k1 * num;
        let real = square >= 0.0 && compliance >= 0.0;
        if !real {
            return Roots::default();
        }
        let s = sqrt(square);
        let rest = 1.0 - x2;
        let near = c * num / (x2 * rest + compliance * h22 + s);
        let far = c * (x2 + s) / (rest - compliance * k1 - s);
        // Below e_2 the lever is positive, beyond it negative; where it crosses zero on the way, the root nearer than e_2
        // is the softer half of the range from the proximal compliance down: that test keeps its sign near e_2. The finger
        // then presses anywhere ahead of the joint, which saves asking.
        let (is_near, is_far) = if c > 0.0 && x2 > 0.0 && x2 < 1.0 && h22 > 0.0 && k1 >= 0.0 {
            (num > 0.0, true)
        } else {
            // As `presses` and `lever`, what does not depend on the place worked out once.
            let (press, pressing) = (h22 * c, h22 + k1 * x2);
            let (at_joint, presses) = (x2 * c, |k: f32| press + pressing * k > 0.0);
            (
                presses(near) && at_joint >= rest * near,
                presses(far) && at_joint <= rest * far,
            )
        };
        Roots {
            near_m: (is_near && ahead(near)).then_some(near),
            far_m: (is_far && ahead(far)).then_some(far),
        }
    }

    /// Both roots on a phalanx of length `length_m` by bisection.
    ///
    /// The residual lever |lever| -+ C energy has the sign of the compliance's signed root less the one looked for:
    /// bounded, and monotone over the whole stretch on which a closing finger presses. The sign chosen says on which
    /// side of e_2 to look; nothing is ever divided by what vanishes there.
    pub fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        let pressing = self.h22 + self.k1 * self.x2;
        // Where pressing begins on a folded finger (c < 0), or ends on one whose x_2 is negative.
        let border = -self.c_m * (self.h22 / pressing);
        let (low, high) = match (pressing > 0.0, self.c_m < 0.0) {
            (true, false) => (0.0, length_m),
            (true, true) => (border, length_m),
            (false, false) => (
                0.0,
                if border > 0.0 {
                    border.at_most(length_m)
                } else {
                    length_m
                },
            ),
            (false, true) => return Roots::default(),
        };
        if !(low < high && (0.0..f32::MAX).contains(&compliance)) {
            return Roots::default();
        }
        // This is asked for at every step: what does not depend on `k` stays outside, and squares with their sign are
        // compared instead of taking the root.
        let (c, at_joint, rest) = (self.c_m, self.x2 * self.c_m, 1.0 - self.x2);
        let mut roots = [None; 2];
        // The compliance carries the sign of the side looked on.
        for (root, signed) in roots.iter_mut().zip([compliance, -compliance]) {
            let (soft1, soft2) = (signed * self.k1, signed * self.h22);
            let residual = |k: f32| {
                let (lever, arm) = (at_joint - rest * k, c + k);
                lever * lever.abs() - (soft1 * k * k + soft2 * arm * arm)
            };
            *root = bisect(low, high, residual)
                .filter(|k| *k > 0.0 && *k <= length_m && self.presses(*k));
        }
        let [near_m, far_m] = roots;
        Roots { near_m, far_m }
    }
}
