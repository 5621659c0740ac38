//! Tasks `sqrt`, `sin`, `sin_cos`, `atan2`, `recip`: the functions that the methods stand on.

pub mod cordic;

use crate::candidate::Candidate;
use micromath::F32Ext;
use nalgebra::{Matrix3, Vector3};
use palpate::numeric;

/// An angle, and the last sample's angle as a control loop has it.
#[derive(Clone, Copy, Debug)]
pub struct Angle {
    /// The angle, radian, within a turn.
    pub rad: f32,
    /// Cosine of the last angle.
    pub last_cos: f32,
    /// Sine of the last angle.
    pub last_sin: f32,
    /// Change since the last angle, radian; a finger turns far less than 0.02 rad in a sample of 1 ms.
    pub step_rad: f32,
}

/// Square root.
pub const SQRT: &[Candidate<f32, f32>] = &[
    Candidate::used(
        "hardware_vsqrt",
        sqrt_hardware,
        "numeric::sqrt, everywhere: one instruction, correctly rounded",
    ),
    Candidate::rival("libm", sqrt_libm),
    Candidate::rival("micromath", sqrt_micromath),
];

/// Sine.
pub const SIN: &[Candidate<Angle, f32>] = &[
    Candidate::rival("minimax_f32", sin_minimax),
    Candidate::rival(cordic::NAME, cordic::sine),
    Candidate::rival("libm", sin_libm),
    Candidate::rival("micromath", sin_micromath),
];

/// Sine and cosine.
pub const SIN_COS: &[Candidate<Angle, [f32; 2]>] = &[
    Candidate::used(
        "minimax_f32",
        sin_cos_minimax,
        "numeric::sin_cos, for configurations and large steps: at the rounding of f32",
    ),
    Candidate::rival(cordic::NAME, cordic::both),
    Candidate::rival("libm", sin_cos_libm),
    Candidate::rival("libm_f64", sin_cos_libm_f64),
    Candidate::rival("micromath", sin_cos_micromath),
];

/// Sine and cosine where those of the last sample are at hand, a small step away.
pub const SIN_COS_STEP: &[Candidate<Angle, [f32; 2]>] = &[
    Candidate::rival("angle_addition", sin_cos_addition),
    Candidate::rival("library_turn", sin_cos_turn),
    Candidate::rival("minimax_f32_afresh", sin_cos_minimax),
    Candidate::rival("micromath_afresh", sin_cos_micromath),
];

/// Angle of the point (x, y), given as [y, x].
pub const ATAN2: &[Candidate<[f32; 2], f32>] = &[
    Candidate::used(
        "library_octants",
        atan2_library,
        "numeric::atan2, for the angle of a four-bar's lever: at the rounding of f32, where micromath would cost 0.3 % of k",
    ),
    Candidate::rival("libm", atan2_libm),
    Candidate::rival("micromath", atan2_micromath),
];

/// Reciprocal.
pub const RECIP: &[Candidate<f32, f32>] = &[
    Candidate::used(
        "hardware_vdiv",
        recip_hardware,
        "the operator /, everywhere: one instruction, correctly rounded",
    ),
    Candidate::rival("micromath_recip", recip_micromath),
    Candidate::rival("micromath_inv", inv_micromath),
];

/// Natural logarithm.
pub const LN: &[Candidate<f32, f32>] = &[
    Candidate::used(
        "library_micromath",
        ln_library,
        "numeric::ln, for the detector's threshold and the evidence of a fit: differences of one and more, so micromath's error is small enough",
    ),
    Candidate::rival("libm", ln_libm),
    Candidate::rival("micromath", ln_micromath),
];

/// Three linear equations with a symmetric, positive definite matrix, as the contact path solves them.
#[derive(Clone, Copy, Debug)]
pub struct Equations {
    /// Rows of the matrix.
    pub a: [[f32; 3]; 3],
    /// Right-hand side.
    pub b: [f32; 3],
}

/// Solves them; NaN where it cannot.
pub const SOLVE: &[Candidate<Equations, [f32; 3]>] = &[
    Candidate::used(
        "library_elimination",
        solve_library,
        "numeric::solve, for the contact path: pivots, because its matrix need not be positive definite far from the answer",
    ),
    Candidate::rival("nalgebra_lu", solve_lu),
    Candidate::rival("nalgebra_cholesky", solve_cholesky),
    Candidate::rival("cramer", solve_cramer),
];

#[inline(never)]
fn ln_library(x: &f32) -> f32 {
    numeric::ln(*x)
}

#[inline(never)]
fn ln_libm(x: &f32) -> f32 {
    libm::logf(*x)
}

#[inline(never)]
fn ln_micromath(x: &f32) -> f32 {
    F32Ext::ln(*x)
}

#[inline(never)]
fn solve_library(equations: &Equations) -> [f32; 3] {
    numeric::solve(equations.a, [equations.b]).map_or([f32::NAN; 3], |[x]| x)
}

#[inline(always)]
fn matrix(equations: &Equations) -> (Matrix3<f32>, Vector3<f32>) {
    // Columns of a symmetric matrix are its rows.
    (equations.a.into(), equations.b.into())
}

#[inline(never)]
fn solve_lu(equations: &Equations) -> [f32; 3] {
    let (a, b) = matrix(equations);
    a.lu().solve(&b).map_or([f32::NAN; 3], Into::into)
}

#[inline(never)]
fn solve_cholesky(equations: &Equations) -> [f32; 3] {
    let (a, b) = matrix(equations);
    a.cholesky()
        .map_or([f32::NAN; 3], |cholesky| cholesky.solve(&b).into())
}

#[inline(never)]
fn solve_cramer(equations: &Equations) -> [f32; 3] {
    let Equations { a, b } = *equations;
    let cross = |u: [f32; 3], v: [f32; 3]| {
        [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ]
    };
    let dot = |u: [f32; 3], v: [f32; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let normals = [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])];
    let inverse = 1.0 / dot(a[0], normals[0]);
    core::array::from_fn(|i| {
        inverse * (b[0] * normals[0][i] + b[1] * normals[1][i] + b[2] * normals[2][i])
    })
}

#[inline(never)]
fn sqrt_hardware(x: &f32) -> f32 {
    numeric::sqrt(*x)
}

#[inline(never)]
fn sqrt_libm(x: &f32) -> f32 {
    libm::sqrtf(*x)
}

// micromath by path: as a method it would be the standard library's on a PC.
#[inline(never)]
fn sqrt_micromath(x: &f32) -> f32 {
    F32Ext::sqrt(*x)
}

#[inline(never)]
fn sin_minimax(angle: &Angle) -> f32 {
    numeric::sin_cos(angle.rad).0
}

#[inline(never)]
fn sin_libm(angle: &Angle) -> f32 {
    libm::sinf(angle.rad)
}

#[inline(never)]
fn sin_micromath(angle: &Angle) -> f32 {
    F32Ext::sin(angle.rad)
}

#[inline(never)]
fn sin_cos_minimax(angle: &Angle) -> [f32; 2] {
    numeric::sin_cos(angle.rad).into()
}

#[inline(never)]
fn sin_cos_libm(angle: &Angle) -> [f32; 2] {
    libm::sincosf(angle.rad).into()
}

#[inline(never)]
fn sin_cos_libm_f64(angle: &Angle) -> [f32; 2] {
    let (sin, cos) = libm::sincos(f64::from(angle.rad));
    [sin as f32, cos as f32]
}

#[inline(never)]
fn sin_cos_micromath(angle: &Angle) -> [f32; 2] {
    F32Ext::sin_cos(angle.rad).into()
}

/// One step from the last sample; over many samples the rounding of each adds up, and the length drifts from 1.
#[inline(never)]
fn sin_cos_addition(angle: &Angle) -> [f32; 2] {
    let square = angle.step_rad * angle.step_rad;
    let sin = angle.step_rad * (1.0 - square * (1.0 / 6.0));
    // 1 - cos, small: added to the last value, it is not rounded away.
    let versine = square * (0.5 - square * (1.0 / 24.0));
    [
        angle.last_sin + (angle.last_cos * sin - angle.last_sin * versine),
        angle.last_cos - (angle.last_sin * sin + angle.last_cos * versine),
    ]
}

/// The library's rotations, put together.
#[inline(never)]
fn sin_cos_turn(angle: &Angle) -> [f32; 2] {
    let last = numeric::Rotation {
        cos: angle.last_cos,
        sin: angle.last_sin,
    };
    let now = last.then(numeric::Rotation::by(angle.step_rad));
    [now.sin, now.cos]
}

#[inline(never)]
fn atan2_library(point: &[f32; 2]) -> f32 {
    numeric::atan2(point[0], point[1])
}

#[inline(never)]
fn atan2_libm(point: &[f32; 2]) -> f32 {
    libm::atan2f(point[0], point[1])
}

#[inline(never)]
fn atan2_micromath(point: &[f32; 2]) -> f32 {
    F32Ext::atan2(point[0], point[1])
}

#[inline(never)]
fn recip_hardware(x: &f32) -> f32 {
    1.0 / *x
}

#[inline(never)]
fn recip_micromath(x: &f32) -> f32 {
    F32Ext::recip(*x)
}

#[inline(never)]
fn inv_micromath(x: &f32) -> f32 {
    F32Ext::inv(*x)
}
