//! Bracketing methods on a residual that is bounded and monotone on each bracket (docs/MECHANICS.md#single-precision):
//! the square-root form
//! (1 - x_2) k - c x_2 -+ sqrt(C (K_1 k^2 + K_2' (k + c)^2)).

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use crate::solver;
use palpate::numeric::sqrt;

/// Of the length, about one unit in the last place of f32.
const WIDTH: f32 = 6e-8;

/// The residual and its derivative; `side` is -1 below the stiffest point and 1 beyond it.
#[inline(always)]
fn residual(input: &TwoPhalanges, side: f32, k: f32) -> (f32, f32) {
    let (c, rest) = (input.c(), 1.0 - input.x2);
    let p = k + c;
    let (a, b) = (input.stiffness1 * k, input.stiffness2 * p);
    let root = sqrt(input.compliance * (a * k + b * p));
    let slope = rest - side * input.compliance * (a + b) / root;
    (rest * k - c * input.x2 - side * root, slope)
}

/// Both brackets by one method.
#[inline(always)]
fn both(input: &TwoPhalanges, find: impl Fn(f32, f32, f32) -> f32) -> Roots {
    let [below, beyond] = input.brackets();
    [(-1.0, below), (1.0, beyond)].map(|(side, (lo, hi))| {
        if lo < hi {
            on_phalanx(find(side, lo, hi), input.l2)
        } else {
            f32::NAN
        }
    })
}

/// One function for all numbers of steps, as it would be in a firmware.
#[inline(never)]
fn bisect(input: &TwoPhalanges, steps: u32) -> Roots {
    both(input, |side, lo, hi| {
        solver::bisect(|k| residual(input, side, k).0, lo, hi, steps)
    })
}

macro_rules! methods {
    ($($(#[$doc:meta])* $name:ident: |$input:ident| $body:expr;)*) => {
        /// The same to be part of another function: three phalanges have their own copies, timed apart.
        pub mod part {
            use super::*;
            $(
                #[inline(always)]
                pub fn $name($input: &TwoPhalanges) -> Roots {
                    $body
                }
            )*
        }
        $(
            $(#[$doc])*
            #[inline(never)]
            pub fn $name(input: &TwoPhalanges) -> Roots {
                part::$name(input)
            }
        )*
    };
}

methods! {
    /// Bisection, 8 steps a bracket.
    bisection_8: |input| bisect(input, 8);
    /// Bisection, 12 steps a bracket.
    bisection_12: |input| bisect(input, 12);
    /// Bisection, 16 steps a bracket.
    bisection_16: |input| bisect(input, 16);
    /// Bisection, 20 steps a bracket.
    bisection_20: |input| bisect(input, 20);
    /// Bisection, 24 steps a bracket.
    bisection_24: |input| bisect(input, 24);
    /// Bisection, 28 steps a bracket.
    bisection_28: |input| bisect(input, 28);
    /// ITP.
    itp: |input| both(input, |side, lo, hi| {
        solver::itp(|k| residual(input, side, k).0, lo, hi, WIDTH * input.l2)
    });
    /// Chandrupatla.
    chandrupatla: |input| both(input, |side, lo, hi| {
        solver::chandrupatla(|k| residual(input, side, k).0, lo, hi, WIDTH * input.l2)
    });
    /// Newton inside the bracket.
    newton: |input| both(input, |side, lo, hi| {
        solver::newton(|k| residual(input, side, k), lo, hi, WIDTH * input.l2)
    });
}
