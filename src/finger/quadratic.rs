//! Contacts whose compliance is a quotient of two quadratics in the contact's place: roots in closed form and by bisection.
//!
//! On the third phalanx and beyond C(k) = softness(k)/energy(k); the places of a compliance are the zeros of
//! softness - C energy, one either side of the stiffest place.

use super::two_joint::Roots;
use crate::numeric::{Bounded, bisect_quadratic, sqrt};

/// A discriminant this small, as a share of its first term, has lost digits that matter.
const NEAR_DOUBLE: f32 = 0.03;

/// Rounding of softness and energy.
const ROUNDING: f32 = 5e-7;

/// Quadratic q_0 + 2 q_1 k + q_2 k^2.
pub type Quadratic = [f32; 3];

/// A contact's stiffness problem, as two quadratics in its place.
pub trait QuadraticContact {
    /// Numerator of the compliance at `k`, not negative.
    fn softness(&self, k: f32) -> f32;

    /// Denominator of the compliance at `k`, positive where the finger is stable.
    fn energy(&self, k: f32) -> f32;

    /// Constant and slope over k of what is positive where a closing finger presses.
    fn pressing(&self) -> [f32; 2];

    /// l0 and l1 of dC/dk = -(l0 + l1 k) times something positive wherever a closing finger presses.
    fn slope(&self) -> (f32, f32);

    /// softness - C energy, expanded in k - `about`.
    fn residual(&self, compliance: f32, about: f32) -> Quadratic;

    /// Compliance 1/K_c of a contact at `k_m` (18); `None` for values that do not give one.
    fn compliance(&self, k_m: f32) -> Option<f32> {
        let (softness, energy) = (self.softness(k_m), self.energy(k_m));
        let compliance = softness / energy;
        (compliance.is_finite() && compliance >= 0.0 && energy > 0.0).then_some(compliance)
    }

    /// A closing finger presses at `k_m`: df/dT_a > 0 (docs/MECHANICS.md#contact-stiffness).
    fn presses(&self, k_m: f32) -> bool {
        let [a0, a1] = self.pressing();
        a0 + a1 * k_m > 0.0
    }

    /// The one stationary point of C(k) where a closing finger presses; `None` where C(k) has none.
    fn stiffest_m(&self) -> Option<f32> {
        stationary(self.slope())
    }

    /// The compliance misses that of the stiffest place by no more than rounding: that place is the double root.
    fn grazes(&self, compliance: f32, peak: f32) -> bool {
        let softness = self.softness(peak);
        let missing = softness - compliance * self.energy(peak);
        missing >= 0.0 && missing <= ROUNDING * softness
    }

    /// softness - C energy as a quadratic, and the place that it is expanded about; `stiffest` is the stationary point.
    #[inline]
    fn expanded(&self, compliance: f32, stiffest: Option<f32>) -> (f32, Quadratic) {
        let quadratic = self.residual(compliance, 0.0);
        // Near a double root the discriminant cancels; counted from the peak between the roots it does not.
        let [q0, q1, q2] = quadratic;
        let middle = -q1 / q2;
        let nearly_double = |peak: &f32| {
            q1 * q1 - q0 * q2 < NEAR_DOUBLE * q1 * q1 && (peak - middle).abs() < 0.5 * middle.abs()
        };
        match stiffest.filter(nearly_double) {
            Some(peak) => (peak, self.residual(compliance, peak)),
            None => (0.0, quadratic),
        }
    }

    /// Both roots in closed form, whether on the phalanx or not, sorted by the side of the stiffest place.
    fn closed(&self, compliance: f32) -> Roots {
        let (l0, l1) = self.slope();
        let stiffest = stationary((l0, l1));
        let (about, quadratic) = self.expanded(compliance, stiffest);
        let Some([a, b]) = roots(quadratic) else {
            let peak = stiffest.filter(|peak| self.grazes(compliance, *peak));
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

    /// The places where a closing finger presses, out of [0, `length_m`], by what is positive there; `None` where there are
    /// none.
    fn pressing_range([at_joint, slope]: [f32; 2], length_m: f32) -> Option<(f32, f32)> {
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
    fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        // Each once: pressing and slope are half of the cost beside the halvings.
        let pressing = self.pressing();
        let Some((low, high)) = Self::pressing_range(pressing, length_m) else {
            return Roots::default();
        };
        if !(0.0..f32::MAX).contains(&compliance) {
            return Roots::default();
        }
        let (l0, l1) = self.slope();
        let stiffest = stationary((l0, l1));
        let (about, [q0, q1, q2]) = self.expanded(compliance, stiffest);
        let excess = |k: f32| q0 + (k - about) * (2.0 * q1 + (k - about) * q2);
        let place = |inside: f32, outside: f32| {
            // Counted from the stiffer end.
            let u = outside - about;
            let (slope, bound) = (2.0 * (q1 + u * q2), -(q0 + u * (2.0 * q1 + u * q2)));
            let k = (outside + bisect_quadratic(inside - outside, slope, q2, bound)).at_most(high);
            (k > low && pressing[0] + pressing[1] * k > 0.0).then_some(k)
        };
        let (at_low, at_high) = (excess(low), excess(high));
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

/// Roots of a quadratic; `None` where they are not real.
fn roots([q0, q1, q2]: Quadratic) -> Option<[f32; 2]> {
    let square = q1 * q1 - q0 * q2;
    let real = square >= 0.0;
    real.then(|| roots_of([q0, q1, q2], square))
}

/// Roots of a quadratic with the discriminant `square` = q_1^2 - q_0 q_2 >= 0: the larger without cancellation, the other by
/// their product.
#[inline]
pub(super) fn roots_of([q0, q1, q2]: Quadratic, square: f32) -> [f32; 2] {
    let large = -(q1 + sqrt(square).copysign(q1));
    [large / q2, q0 / large]
}

/// Where dC/dk = -(l0 + l1 k) is zero.
fn stationary((l0, l1): (f32, f32)) -> Option<f32> {
    let k = -l0 / l1;
    k.is_finite().then_some(k)
}
