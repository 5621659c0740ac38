//! The matrix equation (18) as it is printed, [J* (K - G); Gamma^T] theta' = [J* x; 0], solved by a 2x2 elimination at
//! every trial location.

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use crate::solver;

const WIDTH: f32 = 6e-8;
/// beta = 1 + c/k has no value at the joint: brackets begin at this share of the length.
const NEAREST: f32 = 1e-6;

/// theta_1', theta_2' per torque with a contact at `k`.
#[inline(always)]
fn slopes(input: &TwoPhalanges, k: f32) -> [f32; 2] {
    let beta = 1.0 + input.c() / k;
    let matrix = [[input.stiffness1, -beta * input.stiffness2], [beta, 1.0]];
    let right = [1.0 - beta * input.x2, 0.0];
    // Elimination with the larger pivot first.
    let (first, second) = if matrix[0][0].abs() >= matrix[1][0].abs() {
        (0, 1)
    } else {
        (1, 0)
    };
    let factor = matrix[second][0] / matrix[first][0];
    let theta2 =
        (right[second] - factor * right[first]) / (matrix[second][1] - factor * matrix[first][1]);
    [
        (right[first] - matrix[first][1] * theta2) / matrix[first][0],
        theta2,
    ]
}

#[inline(always)]
fn both(input: &TwoPhalanges, find: impl Fn(f32, f32) -> f32) -> Roots {
    input.brackets().map(|(lo, hi)| {
        let lo = if lo > NEAREST * input.l2 {
            lo
        } else {
            NEAREST * input.l2
        };
        // Written so that the NaN of an empty bracket fails.
        let k = if lo < hi { find(lo, hi) } else { f32::NAN };
        if input.presses(k, slopes(input, k)[1]) {
            on_phalanx(k, input.l2)
        } else {
            f32::NAN
        }
    })
}

#[inline(always)]
fn residual(input: &TwoPhalanges, k: f32) -> f32 {
    let [theta1, theta2] = slopes(input, k);
    theta1 + input.x2 * theta2 - input.compliance
}

/// By bisection, 28 steps a bracket.
#[inline(never)]
pub fn bisection(input: &TwoPhalanges) -> Roots {
    both(input, |lo, hi| {
        solver::bisect(|k| residual(input, k), lo, hi, 28)
    })
}

/// By Chandrupatla's method.
#[inline(never)]
pub fn chandrupatla(input: &TwoPhalanges) -> Roots {
    both(input, |lo, hi| {
        solver::chandrupatla(|k| residual(input, k), lo, hi, WIDTH * input.l2)
    })
}
