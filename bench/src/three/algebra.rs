//! A contact on phalanx 3 in polynomials of its distance k: the compliance is N(k)/D(k) with
//! N = (p x x)^T H (p x x), D = p^T adj(H) p, p = d + k (1, 1, 1) (docs/MECHANICS.md#contact-stiffness).

use super::ThreePhalanges;
use crate::candidate::{NOWHERE, Roots, on_phalanx};
use crate::two;
use palpate::numeric::sqrt;

/// Coefficients of 1, k, k^2.
pub type Quadratic = [f32; 3];

/// The two polynomials, and p^T adj(H) x = s_0 + s_1 k, positive where a contact presses.
pub struct Distal {
    /// N.
    pub numerator: Quadratic,
    /// D.
    pub denominator: Quadratic,
    /// s_0, s_1.
    pub pressing: [f32; 2],
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a^T M b for a symmetric M that couples joints 2 and 3 only: M_11, M_22, M_23, M_33.
#[inline(always)]
fn form(m: [f32; 4], a: [f32; 3], b: [f32; 3]) -> f32 {
    m[0] * a[0] * b[0] + a[1] * (m[1] * b[1] + m[2] * b[2]) + a[2] * (m[2] * b[1] + m[3] * b[2])
}

#[inline(always)]
fn square(m: [f32; 4], u: [f32; 3], w: [f32; 3]) -> Quadratic {
    [form(m, u, u), 2.0 * form(m, u, w), form(m, w, w)]
}

impl Distal {
    /// The polynomials of a finger.
    #[inline(always)]
    pub fn of(input: &ThreePhalanges) -> Self {
        let h = [input.stiffness1, input.h22, input.h23, input.h33];
        let adjoint = [
            input.h22 * input.h33 - input.h23 * input.h23,
            input.stiffness1 * input.h33,
            -input.stiffness1 * input.h23,
            input.stiffness1 * input.h22,
        ];
        let x = [1.0, input.x2, input.x3];
        let near = input.l[1] * input.cos3;
        let d = [near + input.l[0] * input.cos23, near, 0.0];
        let ones = [1.0; 3];
        Self {
            numerator: square(h, cross(d, x), cross(ones, x)),
            denominator: square(adjoint, d, ones),
            pressing: [form(adjoint, d, x), form(adjoint, ones, x)],
        }
    }

    /// N - C D, whose roots are the places looked for.
    #[inline(always)]
    pub fn residual(&self, compliance: f32) -> Quadratic {
        core::array::from_fn(|i| self.numerator[i] - compliance * self.denominator[i])
    }

    /// Keeps `k` where it lies on the phalanx and a contact there presses.
    #[inline(always)]
    pub fn physical(&self, k: f32, length: f32) -> f32 {
        if self.pressing[0] + self.pressing[1] * k > 0.0 {
            on_phalanx(k, length)
        } else {
            f32::NAN
        }
    }
}

/// The textbook formula on both phalanges.
#[inline(never)]
pub fn textbook(input: &ThreePhalanges) -> Roots {
    if input.phalanx == 2 {
        return match input.effective() {
            Some(pair) => two::textbook_k_part(&pair),
            None => NOWHERE,
        };
    }
    let distal = Distal::of(input);
    let [c, b, a] = distal.residual(input.compliance);
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return NOWHERE;
    }
    let root = sqrt(discriminant);
    [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)].map(|k| distal.physical(k, input.l[2]))
}
