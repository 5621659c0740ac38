//! Tasks `sqrt`, `sin`, `sin_cos`, `atan2`, `recip`: the functions that the methods stand on.

pub mod cordic;

use crate::candidate::Candidate;
use micromath::F32Ext;
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
    Candidate {
        name: "hardware_vsqrt",
        run: sqrt_hardware,
        chosen: Some("numeric::sqrt, everywhere: one instruction, correctly rounded"),
    },
    Candidate {
        name: "libm",
        run: sqrt_libm,
        chosen: None,
    },
    Candidate {
        name: "micromath",
        run: sqrt_micromath,
        chosen: None,
    },
];

/// Sine.
pub const SIN: &[Candidate<Angle, f32>] = &[
    Candidate {
        name: "minimax_f32",
        run: sin_minimax,
        chosen: None,
    },
    Candidate {
        name: cordic::NAME,
        run: cordic::sine,
        chosen: None,
    },
    Candidate {
        name: "libm",
        run: sin_libm,
        chosen: None,
    },
    Candidate {
        name: "micromath",
        run: sin_micromath,
        chosen: None,
    },
];

/// Sine and cosine.
pub const SIN_COS: &[Candidate<Angle, [f32; 2]>] = &[
    Candidate {
        name: "minimax_f32",
        run: sin_cos_minimax,
        chosen: Some(
            "numeric::sin_cos, for configurations and large steps: at the rounding of f32",
        ),
    },
    Candidate {
        name: cordic::NAME,
        run: cordic::both,
        chosen: None,
    },
    Candidate {
        name: "libm",
        run: sin_cos_libm,
        chosen: None,
    },
    Candidate {
        name: "libm_f64",
        run: sin_cos_libm_f64,
        chosen: None,
    },
    Candidate {
        name: "micromath",
        run: sin_cos_micromath,
        chosen: None,
    },
];

/// Sine and cosine where those of the last sample are at hand, a small step away.
pub const SIN_COS_STEP: &[Candidate<Angle, [f32; 2]>] = &[
    Candidate {
        name: "angle_addition",
        run: sin_cos_addition,
        chosen: None,
    },
    Candidate {
        name: "library_turn",
        run: sin_cos_turn,
        chosen: None,
    },
    Candidate {
        name: "minimax_f32_afresh",
        run: sin_cos_minimax,
        chosen: None,
    },
    Candidate {
        name: "micromath_afresh",
        run: sin_cos_micromath,
        chosen: None,
    },
];

/// Angle of the point (x, y), given as [y, x].
pub const ATAN2: &[Candidate<[f32; 2], f32>] = &[
    Candidate {
        name: "micromath_corrected",
        run: atan2_corrected,
        chosen: Some(
            "numeric::atan2, for the angle of a four-bar's lever: micromath alone would cost 0.3 % of k",
        ),
    },
    Candidate {
        name: "libm",
        run: atan2_libm,
        chosen: None,
    },
    Candidate {
        name: "micromath",
        run: atan2_micromath,
        chosen: None,
    },
];

/// Reciprocal.
pub const RECIP: &[Candidate<f32, f32>] = &[
    Candidate {
        name: "hardware_vdiv",
        run: recip_hardware,
        chosen: Some("the operator /, everywhere: one instruction, correctly rounded"),
    },
    Candidate {
        name: "micromath_recip",
        run: recip_micromath,
        chosen: None,
    },
    Candidate {
        name: "micromath_inv",
        run: inv_micromath,
        chosen: None,
    },
];

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
    let last = numeric::Turn {
        cos: angle.last_cos,
        sin: angle.last_sin,
    };
    let now = last.then(numeric::Turn::by(angle.step_rad));
    [now.sin, now.cos]
}

#[inline(never)]
fn atan2_corrected(point: &[f32; 2]) -> f32 {
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
