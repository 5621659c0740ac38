//! Formulas: the textbook quadratic, in beta = 1 + c/k and in k.

use super::TwoPhalanges;
use crate::candidate::{NOWHERE, Roots, on_phalanx};
use palpate::numeric::sqrt;

/// Whether a contact there would press: the sign of d f / d T_a with theta_2' = beta (beta x_2 - 1) / (K_1 + beta^2 K_2')
/// multiplied by the positive denominator.
#[inline(always)]
fn physical(input: &TwoPhalanges, k: f32) -> f32 {
    let p = k + input.c();
    // theta_2' (K_1 k^2 + K_2' p^2) = p (p x_2 - k), and x_2 - K_2' theta_2' keeps the sign of what follows.
    let sign = input.x2 * input.stiffness1 * k + input.stiffness2 * p;
    if sign > 0.0 {
        on_phalanx(k, input.l2)
    } else {
        f32::NAN
    }
}

/// Both roots of a x^2 + b x + c = 0 as a textbook has them.
#[inline(always)]
fn textbook(a: f32, b: f32, c: f32) -> [f32; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return NOWHERE;
    }
    let root = sqrt(discriminant);
    [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
}

/// (x_2^2 - C K_2') beta^2 - 2 x_2 beta + 1 - C K_1 = 0, then k = c / (beta - 1).
#[inline(never)]
pub fn textbook_beta(input: &TwoPhalanges) -> Roots {
    let compliance = input.compliance;
    textbook(
        input.x2 * input.x2 - compliance * input.stiffness2,
        -2.0 * input.x2,
        1.0 - compliance * input.stiffness1,
    )
    .map(|beta| physical(input, input.c() / (beta - 1.0)))
}

/// ((1 - x_2) k - c x_2)^2 = C (K_1 k^2 + K_2' (k + c)^2), multiplied out.
#[inline(never)]
pub fn textbook_k(input: &TwoPhalanges) -> Roots {
    textbook_k_part(input)
}

/// The same to be part of another function.
#[inline(always)]
pub fn textbook_k_part(input: &TwoPhalanges) -> Roots {
    let (c, rest) = (input.c(), 1.0 - input.x2);
    let soft2 = input.compliance * input.stiffness2;
    textbook(
        rest * rest - input.compliance * input.stiffness1 - soft2,
        -2.0 * c * (rest * input.x2 + soft2),
        c * c * (input.x2 * input.x2 - soft2),
    )
    .map(|k| physical(input, k))
}
