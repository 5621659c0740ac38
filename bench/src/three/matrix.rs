//! The matrix equation (18) as it is printed, by a 3x3 elimination at every trial location. It does not show where
//! the compliance has its extrema: brackets come from a scan of the phalanx.

use super::ThreePhalanges;
use crate::candidate::{NOWHERE, Roots, on_phalanx};
use crate::solver;

const WIDTH: f32 = 6e-8;
/// Stretches of the scan.
pub const SCAN: u32 = 16;
/// The equation divides by k: the scan begins at this share of the length.
pub const NEAREST: f32 = 1e-6;

/// Elimination with partial pivoting.
#[inline(always)]
fn solve(mut m: [[f32; 4]; 3]) -> [f32; 3] {
    for column in 0..2 {
        for row in column + 1..3 {
            if m[row][column].abs() > m[column][column].abs() {
                m.swap(row, column);
            }
        }
        let pivot = m[column];
        for row in m.iter_mut().skip(column + 1) {
            let factor = row[column] / pivot[column];
            for (entry, above) in row.iter_mut().zip(pivot) {
                *entry -= factor * above;
            }
        }
    }
    let z = m[2][3] / m[2][2];
    let y = (m[1][3] - m[1][2] * z) / m[1][1];
    [(m[0][3] - m[0][1] * y - m[0][2] * z) / m[0][0], y, z]
}

/// theta' per torque with a contact at `k`.
#[inline(always)]
fn slopes(input: &ThreePhalanges, k: f32) -> [f32; 3] {
    let ThreePhalanges {
        stiffness1,
        h22,
        h23,
        h33,
        x2,
        x3,
        ..
    } = *input;
    if input.phalanx == 2 {
        let beta2 = 1.0 + input.l[0] * input.cos2 / k;
        return solve([
            [stiffness1, -beta2 * h22, -beta2 * h23, 1.0 - beta2 * x2],
            [0.0, h23, h33, x3],
            [beta2, 1.0, 0.0, 0.0],
        ]);
    }
    let beta3 = 1.0 + input.l[1] * input.cos3 / k;
    let arm = beta3 + input.l[0] * input.cos23 / k;
    solve([
        [stiffness1, -arm * h23, -arm * h33, 1.0 - arm * x3],
        [0.0, h22 - beta3 * h23, h23 - beta3 * h33, x2 - beta3 * x3],
        [arm, beta3, 1.0, 0.0],
    ])
}

/// Whether the contact force grows with the torque.
#[inline(always)]
fn presses(input: &ThreePhalanges, [_, theta2, theta3]: [f32; 3]) -> bool {
    if input.phalanx == 2 {
        input.x2 - input.h22 * theta2 - input.h23 * theta3 > 0.0
    } else {
        input.x3 - input.h23 * theta2 - input.h33 * theta3 > 0.0
    }
}

#[inline(always)]
fn residual(input: &ThreePhalanges, k: f32) -> f32 {
    let [one, two, three] = slopes(input, k);
    one + input.x2 * two + input.x3 * three - input.compliance
}

#[inline(always)]
fn scan(input: &ThreePhalanges, find: impl Fn(f32, f32) -> f32) -> Roots {
    let length = input.length();
    let mut roots = NOWHERE;
    let mut lo = NEAREST * length;
    let mut was_positive = residual(input, lo) > 0.0;
    for stretch in 1..=SCAN {
        let hi = length * stretch as f32 / SCAN as f32;
        let is_positive = residual(input, hi) > 0.0;
        if is_positive != was_positive {
            let k = find(lo, hi);
            if presses(input, slopes(input, k)) {
                roots = [roots[1], on_phalanx(k, length)];
            }
        }
        (lo, was_positive) = (hi, is_positive);
    }
    roots
}

/// By bisection, 28 steps.
#[inline(never)]
pub fn bisection(input: &ThreePhalanges) -> Roots {
    scan(input, |lo, hi| {
        solver::bisect(|k| residual(input, k), lo, hi, 28)
    })
}

/// By Chandrupatla's method.
#[inline(never)]
pub fn chandrupatla(input: &ThreePhalanges) -> Roots {
    scan(input, |lo, hi| {
        solver::chandrupatla(|k| residual(input, k), lo, hi, WIDTH * input.length())
    })
}
