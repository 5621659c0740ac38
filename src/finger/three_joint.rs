//! Three joints held by one contact on the third phalanx (docs/MECHANICS.md#contact-stiffness).
//!
//! With p the contact's moment arms and p x x a cross product, C = (p x x)^T H (p x x) / p^T adj(H) p; it also holds
//! without a spring at joint 1, where H has no inverse.

use super::two_joint::Roots;
use crate::numeric::{Bounded, bisect_quadratic, sqrt};

/// The stiffness problem of a contact on phalanx 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeJointContact {
    /// Moment arm of joint 1 beyond that of joint 3: l_1 cos(theta_2 + theta_3) + l_2 cos theta_3, metre.
    pub d1_m: f32,
    /// Moment arm of joint 2 beyond that of joint 3: l_2 cos theta_3, metre.
    pub d2_m: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// Transmission factor x_3.
    pub x3: f32,
    /// Stiffness K_1 = H_11; may be 0.
    pub k1: f32,
    /// H_22.
    pub h22: f32,
    /// H_23.
    pub h23: f32,
    /// H_33.
    pub h33: f32,
}

/// A discriminant this small, as a share of its first term, has lost digits that matter.
const NEAR_DOUBLE: f32 = 0.03;

/// Rounding of softness and energy.
const ROUNDING: f32 = 5e-7;

/// Quadratic q_0 + 2 q_1 k + q_2 k^2.
type Quadratic = [f32; 3];

impl ThreeJointContact {
    /// u^T adj(H') v, over joints 2 and 3.
    fn adj(&self, u: [f32; 2], v: [f32; 2]) -> f32 {
        self.h33 * u[0] * v[0] - self.h23 * (u[0] * v[1] + u[1] * v[0]) + self.h22 * u[1] * v[1]
    }

    /// u^T H' v, over joints 2 and 3.
    fn form(&self, u: [f32; 2], v: [f32; 2]) -> f32 {
        self.h22 * u[0] * v[0] + self.h23 * (u[0] * v[1] + u[1] * v[0]) + self.h33 * u[1] * v[1]
    }

    /// det(H'), over joints 2 and 3; positive where the finger is stable.
    pub fn determinant(&self) -> f32 {
        self.h22 * self.h33 - self.h23 * self.h23
    }

    /// p x x at `k`: grouped so that k multiplies a difference of transmission factors.
    fn motion(&self, k: f32) -> [f32; 3] {
        let Self {
            d1_m: d1,
            d2_m: d2,
            x2,
            x3,
            ..
        } = *self;
        [
            d2 * x3 + k * (x3 - x2),
            k * (1.0 - x3) - d1 * x3,
            (d1 * x2 - d2) + k * (x2 - 1.0),
        ]
    }

    /// (p x x)^T H (p x x) at `k`.
    fn softness(&self, k: f32) -> f32 {
        let [v1, v2, v3] = self.motion(k);
        self.k1 * v1 * v1 + self.form([v2, v3], [v2, v3])
    }

    /// p^T adj(H) p at `k`.
    fn energy(&self, k: f32) -> f32 {
        let (p1, p) = (self.d1_m + k, [self.d2_m + k, k]);
        self.determinant() * p1 * p1 + self.k1 * self.adj(p, p)
    }

    /// Compliance 1/K_c of a contact at `k_m` (18); `None` for values that do not give one.
    pub fn compliance(&self, k_m: f32) -> Option<f32> {
        let (softness, energy) = (self.softness(k_m), self.energy(k_m));
        let compliance = softness / energy;
        (compliance.is_finite() && compliance >= 0.0 && energy > 0.0).then_some(compliance)
    }

    /// p^T adj(H) x at `k`: positive where a closing finger presses (df/dT_a > 0).
    fn pressing(&self) -> [f32; 2] {
        let (x, m) = ([self.x2, self.x3], self.determinant());
        let at_joint = m * self.d1_m + self.k1 * self.adj([self.d2_m, 0.0], x);
        [at_joint, m + self.k1 * self.adj([1.0, 1.0], x)]
    }

    /// A closing finger presses at `k_m`: df/dT_a > 0 (docs/MECHANICS.md#contact-stiffness).
    pub fn presses(&self, k_m: f32) -> bool {
        let [a0, a1] = self.pressing();
        a0 + a1 * k_m > 0.0
    }

    /// Place of the stiffest contact on phalanx 3, the counterpart of e_2: the one stationary point of C(k) where a
    /// closing finger presses. It may lie off the phalanx; `None` where C(k) has none.
    pub fn stiffest_m(&self) -> Option<f32> {
        let (l0, l1) = self.slope();
        let k = -l0 / l1;
        k.is_finite().then_some(k)
    }

    /// dC/dk = -(l0 + l1 k) times something positive wherever a closing finger presses.
    ///
    /// C_free - C = (p^T adj(H) x)^2 / (det(H) p^T adj(H) p) is the squared cosine between x and the line of p in the
    /// metric of H^-1: along a line it has one peak. K_1 is divided out, so that the limit K_1 = 0 stays.
    fn slope(&self) -> (f32, f32) {
        let (d1, x) = (self.d1_m, [self.x2, self.x3]);
        let (d, one) = ([self.d2_m, 0.0], [1.0, 1.0]);
        let away = [d[0] - d1, -d1];
        let m = self.determinant();
        let l0 = m * self.adj(away, [d[0] - d1 * x[0], -d1 * x[1]])
            + self.k1 * (self.adj(one, x) * self.adj(d, d) - self.adj(d, x) * self.adj(d, one));
        let l1 = m * self.adj(away, [1.0 - x[0], 1.0 - x[1]])
            + self.k1 * (self.adj(one, x) * self.adj(d, one) - self.adj(d, x) * self.adj(one, one));
        (l0, l1)
    }

    /// The compliance misses that of the stiffest place by no more than rounding: that place is the double root.
    fn grazes(&self, compliance: f32, peak: f32) -> bool {
        let softness = self.softness(peak);
        let missing = softness - compliance * self.energy(peak);
        missing >= 0.0 && missing <= ROUNDING * softness
    }

    /// softness - C energy, expanded in k - `about`.
    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let v0 = self.motion(about);
        let v1 = [self.x3 - self.x2, 1.0 - self.x3, self.x2 - 1.0];
        let (tail0, tail1) = ([v0[1], v0[2]], [v1[1], v1[2]]);
        let (p1, p, one) = (self.d1_m + about, [self.d2_m + about, about], [1.0, 1.0]);
        let (m, k1) = (self.determinant(), self.k1);
        [
            k1 * v0[0] * v0[0] + self.form(tail0, tail0)
                - compliance * (m * p1 * p1 + k1 * self.adj(p, p)),
            k1 * v0[0] * v1[0] + self.form(tail0, tail1)
                - compliance * (m * p1 + k1 * self.adj(p, one)),
            k1 * v1[0] * v1[0] + self.form(tail1, tail1)
                - compliance * (m + k1 * self.adj(one, one)),
        ]
    }

    /// softness - C energy as a quadratic, and the place that it is expanded about.
    #[inline]
    fn expanded(&self, compliance: f32) -> (f32, Quadratic) {
        let quadratic = self.residual(compliance, 0.0);
        // Near a double root the discriminant cancels; counted from the peak between the roots it does not.
        let [q0, q1, q2] = quadratic;
        let middle = -q1 / q2;
        let nearly_double = |peak: &f32| {
            q1 * q1 - q0 * q2 < NEAR_DOUBLE * q1 * q1 && (peak - middle).abs() < 0.5 * middle.abs()
        };
        match self.stiffest_m().filter(nearly_double) {
            Some(peak) => (peak, self.residual(compliance, peak)),
            None => (0.0, quadratic),
        }
    }

    /// Both roots in closed form, whether on the phalanx or not, sorted by the side of the stiffest place.
    pub fn closed(&self, compliance: f32) -> Roots {
        let (l0, l1) = self.slope();
        let (about, quadratic) = self.expanded(compliance);
        let Some([a, b]) = roots(quadratic) else {
            let peak = self
                .stiffest_m()
                .filter(|peak| self.grazes(compliance, *peak));
            return Roots {
                near_m: peak.filter(|k| *k > 0.0 && self.presses(*k)),
                far_m: None,
            };
        };
        let accept = |k: f32| (k.is_finite() && k > 0.0 && self.presses(k)).then_some(k);
        let (a, b) = (accept(about + a), accept(about + b));
        let side = |beyond: bool| move |k: &f32| (l0 + l1 * k < 0.0) == beyond;
        let pick = |beyond| a.filter(side(beyond)).or(b.filter(side(beyond)));
        match (a, b) {
            // A double root to rounding: two numbers on the same side of the peak are the two sides of it.
            (Some(a), Some(b)) if (l0 + l1 * a < 0.0) == (l0 + l1 * b < 0.0) => Roots {
                near_m: Some(a.min(b)),
                far_m: Some(a.max(b)),
            },
            _ => Roots {
                near_m: pick(false),
                far_m: pick(true),
            },
        }
    }

    /// The places where a closing finger presses, out of [0, `length_m`]; `None` where there are none.
    fn pressing_range(&self, length_m: f32) -> Option<(f32, f32)> {
        let [at_joint, slope] = self.pressing();
        let border = -at_joint / slope;
        let (low, high) = match (at_joint > 0.0, slope > 0.0) {
            (true, true) => (0.0, length_m),
            (true, false) if border > 0.0 => (0.0, border.at_most(length_m)),
            (true, false) => (0.0, length_m),
            (false, true) => (border, length_m),
            (false, false) => return None,
        };
        (low < high && high.is_finite()).then_some((low, high))
    }

    /// Both roots on a phalanx of length `length_m` by bisection, one either side of the stiffest place: what the firmware
    /// asks. There softness - C energy, a quadratic in k, changes sign once, and nothing is divided by what vanishes.
    pub fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        let Some((low, high)) = self.pressing_range(length_m) else {
            return Roots::default();
        };
        if !(0.0..f32::MAX).contains(&compliance) {
            return Roots::default();
        }
        let (about, [q0, q1, q2]) = self.expanded(compliance);
        let excess = |k: f32| q0 + (k - about) * (2.0 * q1 + (k - about) * q2);
        let place = |inside: f32, outside: f32| {
            // Counted from the stiffer end.
            let u = outside - about;
            let (slope, bound) = (2.0 * (q1 + u * q2), -(q0 + u * (2.0 * q1 + u * q2)));
            let k = (outside + bisect_quadratic(inside - outside, slope, q2, bound)).at_most(high);
            (k > low && self.presses(k)).then_some(k)
        };
        let (at_low, at_high) = (excess(low), excess(high));
        let stiffest = self.stiffest_m();
        if let Some(peak) = stiffest.filter(|peak| *peak > low && *peak < high) {
            if excess(peak) >= 0.0 {
                // No place is so stiff; within rounding the stiffest one is.
                return Roots {
                    near_m: Some(peak).filter(|peak| self.grazes(compliance, *peak)),
                    far_m: None,
                };
            }
            return Roots {
                near_m: if at_low > 0.0 { place(low, peak) } else { None },
                far_m: if at_high >= 0.0 {
                    place(high, peak)
                } else {
                    None
                },
            };
        }
        let only = if at_low > 0.0 && at_high <= 0.0 {
            place(low, high)
        } else if at_low < 0.0 && at_high >= 0.0 {
            place(high, low)
        } else {
            None
        };
        let (l0, l1) = self.slope();
        if l0 + l1 * 0.5 * (low + high) < 0.0 {
            Roots {
                near_m: None,
                far_m: only,
            }
        } else {
            Roots {
                near_m: only,
                far_m: None,
            }
        }
    }
}

/// Roots of a quadratic: the larger without cancellation, the other by their product. None where they are not real.
fn roots([q0, q1, q2]: Quadratic) -> Option<[f32; 2]> {
    let square = q1 * q1 - q0 * q2;
    let real = square >= 0.0;
    if !real {
        return None;
    }
    let large = -(q1 + sqrt(square).copysign(q1));
    Some([large / q2, q0 / large])
}
