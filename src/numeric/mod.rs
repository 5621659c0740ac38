//! Numerical functions for f32 without an operating system, each with its measured error and the reason for its choice.
//!
//! micromath is used wherever its error is below what the place needs; the table says where it is not. Errors are measured
//! against f64 by the tests of each module and by `cargo xtask report`.
//!
//! | function | uses | error | why |
//! |---|---|---|---|
//! | [`constant_sqrt`] | the integer root of the mantissa | correctly rounded | while the compiler works out a constant there is no VSQRT.F32 |
//! | [`sqrt`] | VSQRT.F32 on target, `f32::sqrt` on the host | correctly rounded, identical on both | 14 cycles; micromath's is 6 % off, libm's is software |
//! | [`sin_cos`] | own minimax polynomials after exact reduction | 4.7e-8 | micromath's 1.1e-3 rad would be 0.1 % of l in k; libm's computes in f64 inside |
//! | [`atan2`] | own minimax polynomial from the nearest axis or diagonal, one division | 1.2e-7 rad | micromath's 2.8e-3 rad would cost 0.3 % of k |
//! | [`Rotation`] | products | 1e-7 a composition | postures change by rotation, no trigonometric function at all |
//! | division | VDIV.F32 | correctly rounded | 14 cycles; micromath's reciprocal is 9e-6 off at best, which the stiffness near e_2 multiplies |
//! | [`bisect`], [`bisect_quadratic`] | halving | 2^-25 of the bracket, and the residual's rounding | 24 halvings, whatever the residual |
//! | [`clamp`], [`Bounded`] | two compares | none | `f32::clamp` can panic; `min` and `max` cost three times as much to treat a NaN on either side alike |
//! | [`ln`] | micromath's polynomial, arguments below one lifted by a power of two | 7.2e-5 | thresholds and evidences are compared with differences of one and more |
//! | [`exp`] | exponent and the series of the rest | 5e-7 relative | micromath's is 7.6e-4 off (2.4e-3 below zero): weights would bear it, but the covariance of wandering friction that is built from it must stay positive definite |
//! | [`not_negative`] | a logistic curve for the normal distribution | 2 % of the deviation | deviations of cables and joints are known to no more than that |
//! | [`dot`] | a sum in the order of the elements | a rounding for each product and each sum | `core` has none |
//! | [`solve`], [`solve_in_place`] | Gaussian elimination, row pivoting | grows with the matrix's condition number | one unknown a joint, or the seven of a curve with a corner |
//! | [`LeastSquares`] | covariance form | 1e-4 of unknowns of size one after 1,000 equations | samples need not be kept |
//!
//! Host and target run the same operations in the same order (nothing is fused), so they give the same numbers.

mod angle;
mod bisect;
mod clamp;
mod exp;
mod linear;
mod log;
mod positive;
mod recursive;
mod root;

pub use angle::{Rotation, SIN_COS_MAX_RAD, atan2, sin_cos};
pub use bisect::{BISECTION_STEPS, bisect, bisect_quadratic};
pub use clamp::{Bounded, clamp};
pub use exp::exp;
pub use linear::{dot, solve, solve_in_place};
pub use log::ln;
pub use positive::not_negative;
pub use recursive::LeastSquares;
pub use root::{constant_sqrt, sqrt};
