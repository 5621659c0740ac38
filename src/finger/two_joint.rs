//! Two joints held by one contact on the second phalanx: K_c (18) in closed form and its inverse
//! (docs/MECHANICS.md#contact-stiffness).
//!
//! With three phalanges and the contact on phalanx 2, the third joint is eliminated and the same problem remains.

use crate::numeric::{Bounded, bisect_quadratic, sqrt};

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

/// p_1 x_2 - p_2 over the moment arms p of a contact at `k_m`, where joint 1 has `c_m` more of arm than joint 2.
///
/// Grouped so that `c_m`, not the arm of joint 1, is multiplied: near e_2 the two terms cancel.
pub(super) fn lever(x2: f32, c_m: f32, k_m: f32) -> f32 {
    x2 * c_m - (1.0 - x2) * k_m
}

/// e_2 = c x_2 / (1 - x_2) (27), where that vanishes; `None` where there is no such place ahead of the joint.
pub(super) fn rigid_m(x2: f32, c_m: f32) -> Option<f32> {
    let e2 = c_m * x2 / (1.0 - x2);
    (e2.is_finite() && e2 > 0.0).then_some(e2)
}

/// Positive and finite, in one comparison: such numbers are ordered as their bits are.
fn ahead(k: f32) -> bool {
    k.to_bits().wrapping_sub(1) < f32::INFINITY.to_bits() - 1
}

impl TwoJointContact {
    /// p_1 x_2 - p_2, over the contact's moment arms p: the motion that the contact leaves, as the input link sees it.
    fn lever(&self, k: f32) -> f32 {
        lever(self.x2, self.c_m, k)
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
        rigid_m(self.x2, self.c_m)
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

    /// The places where a closing finger presses, out of [0, `length_m`]; `None` where there are none.
    fn pressing_range(&self, length_m: f32) -> Option<(f32, f32)> {
        let pressing = self.h22 + self.k1 * self.x2;
        let (mut low, mut high) = (0.0, length_m);
        if !(pressing > 0.0 && self.c_m >= 0.0) {
            // Where pressing begins on a folded finger (c < 0), or ends on one whose x_2 is negative.
            let border = -self.c_m * (self.h22 / pressing);
            if pressing > 0.0 {
                low = border;
            } else if self.c_m < 0.0 {
                return None;
            } else if border > 0.0 {
                high = border.at_most(length_m);
            }
        }
        (low < high && high < f32::INFINITY).then_some((low, high))
    }

    /// Both roots on a phalanx of length `length_m` by bisection: what the firmware asks.
    ///
    /// The residual lever^2 - C energy is bounded, positive where the finger is softer than asked and negative where it is
    /// stiffer. Either side of e_2 it is monotone over the places where a closing finger presses: each side is a bracket,
    /// and nothing is divided by what vanishes at e_2. From y = k + c K_2'/(K_1 + K_2') the energy is a sum of two squares,
    /// (K_1 + K_2') y^2 + c^2 K_1 K_2'/(K_1 + K_2'), and the residual a product of two linear factors less a constant.
    /// Counted from where the smaller factor vanishes, which is the place itself where K_1 = 0, it keeps its digits near e_2
    /// (docs/MECHANICS.md#single-precision).
    pub fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        let Self {
            c_m: c,
            x2,
            k1,
            h22,
        } = *self;
        let mut roots = Roots::default();
        let Some((low, high)) = self.pressing_range(length_m) else {
            return roots;
        };
        if !(0.0..f32::MAX).contains(&compliance) {
            return roots;
        }
        let (rest, sum) = (1.0 - x2, k1 + h22);
        let shift = c * (h22 / sum);
        // lever = level - rest y; the factors are lever -+ sqrt(C (K_1 + K_2')) y.
        let level = c * ((h22 + k1 * x2) / sum);
        let spread = sqrt(compliance * sum);
        let (steep, flat) = (rest + spread, rest - spread);
        let constant = compliance * k1 * shift * c;
        let (from, to, rigid) = (low + shift, high + shift, level / rest);
        if compliance == 0.0 {
            // The two roots are one.
            roots.near_m = Some(rigid - shift).filter(|k| *k > low && *k <= high);
            roots.far_m = roots.near_m;
            return roots;
        }
        let factors = |y: f32| (level - steep * y, level - flat * y);
        let excess = |y: f32| {
            let (a, b) = factors(y);
            a * b - constant
        };
        // An end as stiff as asked is itself the place, but not the joint.
        let (low_is_softer, high_is_softer) = (excess(from) > 0.0, excess(to) >= 0.0);
        let low_is_near = rest >= 0.0;
        // Either side that has a root: whether that is the near one, and where the finger is softer and stiffer than asked.
        let sides = if from < rigid && rigid < to {
            [
                low_is_softer.then_some((low_is_near, from, rigid)),
                high_is_softer.then_some((!low_is_near, to, rigid)),
            ]
        } else {
            let is_near = low_is_near == (rigid >= to);
            match (low_is_softer, high_is_softer) {
                (true, false) => [Some((is_near, from, to)), None],
                (false, true) => [Some((is_near, to, from)), None],
                _ => [None; 2],
            }
        };
        // By reference: an array's own iterator moves it first.
        for side in &sides {
            let Some((is_near, inside, outside)) = *side else {
                continue;
            };
            let vanishing = level / if is_near { steep } else { flat };
            let is_between = (vanishing - inside) * (outside - vanishing) > 0.0;
            let origin = if is_between { vanishing } else { outside };
            let (a, b) = factors(origin);
            let (slope, bend) = (-(steep * b + flat * a), steep * flat);
            let u = bisect_quadratic(inside - origin, slope, bend, constant - a * b);
            let k = (origin + u - shift).at_most(high);
            let root = (k > low).then_some(k);
            if is_near {
                roots.near_m = root;
            } else {
                roots.far_m = root;
            }
        }
        roots
    }
}
