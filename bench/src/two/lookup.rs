//! Table look-up: 1/beta = k / (k + c) over x_2, K_1/(K_1 + K_2') and the signed root of the relative compliance, which
//! runs through both branches without a pole; trilinear between the points. Only for theta_2 below 90 degrees.

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use palpate::numeric::sqrt;

const SHARES: usize = 9;
const SIDES: usize = 17;

/// Largest x_2 and K_1/(K_1 + K_2') of the table.
const X2_MOST: f32 = 0.9;
const STIFFNESS_MOST: f32 = 0.9;

static TABLE: [[[f32; SIDES]; SHARES]; SHARES] = build();

/// Newton's iteration for the square root, for the compiler to run.
pub(crate) const fn root(x: f32) -> f32 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut y = if x > 1.0 { x } else { 1.0 };
    let mut step = 0;
    while step < 60 {
        y = 0.5 * (y + x / y);
        step += 1;
    }
    y
}

/// From beta: C K_2' = (1 - beta x_2)^2 / (kappa + beta^2) with kappa = K_1/K_2'; at a relative compliance sigma^2 of
/// C_prox K_2' = x_2^2 the quadratic (x_2^2 - C K_2') beta^2 - 2 x_2 beta + 1 - C K_1 = 0, its root on the side of sigma.
const fn inverse_beta(x2: f32, kappa: f32, sigma: f32) -> f32 {
    let soft2 = sigma * sigma * x2 * x2;
    let s = root(soft2 + soft2 * kappa * (x2 * x2 - soft2));
    // beta = (x_2 +- s) / (x_2^2 - C K_2'), upwards for the lower branch.
    let lower = (x2 * x2 - soft2) / (x2 + s);
    if sigma < 0.0 {
        lower
    } else {
        let rest = 1.0 - soft2 * kappa;
        // 1/beta = (x_2 + s) / (1 - C K_1) is the cancellation-free form of (x_2^2 - C K_2') / (x_2 - s).
        if rest > 0.0 { (x2 + s) / rest } else { 1.0 }
    }
}

const fn build() -> [[[f32; SIDES]; SHARES]; SHARES] {
    let mut table = [[[0.0; SIDES]; SHARES]; SHARES];
    let mut i = 0;
    while i < SHARES {
        let mut j = 0;
        while j < SHARES {
            let mut m = 0;
            while m < SIDES {
                let x2 = X2_MOST * i as f32 / (SHARES - 1) as f32;
                let share = STIFFNESS_MOST * j as f32 / (SHARES - 1) as f32;
                let sigma = 2.0 * m as f32 / (SIDES - 1) as f32 - 1.0;
                table[i][j][m] = inverse_beta(
                    if x2 > 0.0 { x2 } else { 1e-6 },
                    share / (1.0 - share),
                    sigma,
                );
                m += 1;
            }
            j += 1;
        }
        i += 1;
    }
    table
}

/// Cell and place within it.
#[inline(always)]
pub(crate) fn cell(x: f32, most: f32, points: usize) -> Option<(usize, f32)> {
    let scaled = x / most * (points - 1) as f32;
    if !(scaled >= 0.0 && scaled <= (points - 1) as f32) {
        return None;
    }
    let index = (scaled as usize).min(points - 2);
    Some((index, scaled - index as f32))
}

#[inline(always)]
fn interpolate(x2: f32, share: f32, sigma: f32) -> Option<f32> {
    let (i, u) = cell(x2, X2_MOST, SHARES)?;
    let (j, v) = cell(share, STIFFNESS_MOST, SHARES)?;
    let (m, w) = cell(sigma + 1.0, 2.0, SIDES)?;
    let line = |i: usize, j: usize| TABLE[i][j][m] + w * (TABLE[i][j][m + 1] - TABLE[i][j][m]);
    let face = |i: usize| line(i, j) + v * (line(i, j + 1) - line(i, j));
    Some(face(i) + u * (face(i + 1) - face(i)))
}

/// Both branches from the table.
#[inline(never)]
pub fn table(input: &TwoPhalanges) -> Roots {
    pair(input)
}

/// The same to be part of another function.
#[inline(always)]
pub(crate) fn pair(input: &TwoPhalanges) -> Roots {
    let sigma = sqrt(input.compliance * input.stiffness2) / input.x2;
    let share = input.stiffness1 / (input.stiffness1 + input.stiffness2);
    [-sigma, sigma].map(|sigma| match interpolate(input.x2, share, sigma) {
        Some(y) if input.c() > 0.0 => on_phalanx(input.c() * y / (1.0 - y), input.l2),
        _ => f32::NAN,
    })
}
