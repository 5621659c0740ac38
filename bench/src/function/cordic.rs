//! The chip's CORDIC co-processor: cosine and sine of an angle in units of pi, fixed point, one write and two reads.
//!
//! The reference manual (RM0440) promises a residual error of at most 2^-19 for 6 cycles, which a read waits for. On a board
//! this is the co-processor; the emulated one rounds the exact value down to a multiple of 2^-19, and so does the copy for a
//! PC: its error is the promise, its low bits are a model. It never counts as a measurement of precision.

use super::Angle;
use core::f32::consts::PI;

/// Name of the candidates: a model wherever there is no chip.
pub const NAME: &str = "cordic_modelled";

/// Residual error that the reference manual promises for 6 cycles, 2^-19.
pub const LARGEST_ERROR: f64 = 1.0 / 524_288.0;

/// 2^31: one in q1.31.
const ONE: f32 = 2_147_483_648.0;

/// Switches the co-processor on. Call before the candidates.
#[cfg(target_os = "none")]
pub fn start() {
    use embassy_stm32::pac::cordic::vals::{Func, Num, Precision, Scale};
    use embassy_stm32::pac::{CORDIC, RCC};

    RCC.ahb1enr().modify(|w| w.set_cordicen(true));
    // A write takes effect two bus cycles after the clock is on.
    let _ = RCC.ahb1enr().read();
    CORDIC.csr().write(|w| {
        w.set_func(Func::COSINE);
        w.set_precision(Precision::ITERS24);
        w.set_scale(Scale::A1_R1);
        w.set_nres(Num::NUM2);
        w.set_nargs(Num::NUM1);
    });
}

#[cfg(target_os = "none")]
#[inline(always)]
fn rotate(angle: i32) -> [i32; 2] {
    use embassy_stm32::pac::CORDIC;

    CORDIC.wdata().write_value(angle as u32);
    let cos = CORDIC.rdata().read() as i32;
    [CORDIC.rdata().read() as i32, cos]
}

#[cfg(not(target_os = "none"))]
fn rotate(angle: i32) -> [i32; 2] {
    let rad = f64::from(angle) / f64::from(ONE) * core::f64::consts::PI;
    let (sin, cos) = libm::sincos(rad);
    [sin, cos].map(|exact: f64| {
        let kept = libm::floor(exact * f64::from(1u32 << 19)) * f64::from(1u32 << 12);
        // A cast to an integer stops at the largest.
        kept as i32
    })
}

/// Sine and cosine.
#[inline(always)]
pub(super) fn sin_cos(angle: &Angle) -> [f32; 2] {
    rotate((angle.rad * (ONE / PI)) as i32).map(|value| value as f32 * (1.0 / ONE))
}

/// Sine and cosine by the co-processor.
#[inline(never)]
pub(super) fn both(angle: &Angle) -> [f32; 2] {
    sin_cos(angle)
}

/// Sine by the co-processor: the cosine comes first and must be read too.
#[inline(never)]
pub(super) fn sine(angle: &Angle) -> f32 {
    sin_cos(angle)[0]
}
