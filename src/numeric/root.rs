//! Square root: the only unsafe code of the library, one instruction.
#![allow(unsafe_code)]

/// Square root, correctly rounded; NaN for a negative or NaN argument, as IEEE 754 says. Callers guard the sign.
///
/// `core` has no square root and libm's is software on this target. VSQRT.F32 takes 14 cycles and rounds exactly as
/// `f32::sqrt` does on the host, so both run the same numbers.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_os = "none")]
    {
        vsqrt(x)
    }
    #[cfg(not(target_os = "none"))]
    x.sqrt()
}

#[cfg(all(target_os = "none", not(target_abi = "eabihf")))]
compile_error!(
    "the square root takes its argument in an FPU register: build for thumbv7em-none-eabihf"
);

/// The instruction as a function: argument and result lie where the calling convention of a target with FPU has them. As
/// inline assembly it would take four moves, through the core registers, because the compiler offers FPU registers for
/// assembly only where the FPU also knows double precision. It lies in flash: nothing in the control interrupt calls it.
#[cfg(target_os = "none")]
#[unsafe(naked)]
extern "C" fn vsqrt(x: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}

/// Square root for constants, where VSQRT.F32 is not available: correctly rounded too, by the integer root of the mantissa. 0 where the
/// argument is not a positive, normal and finite number.
pub const fn constant_sqrt(x: f32) -> f32 {
    if !(x >= f32::MIN_POSITIVE && x < f32::INFINITY) {
        return 0.0;
    }
    let (exponent, mantissa) = (x.to_bits() >> 23, x.to_bits() & 0x7F_FFFF | 0x80_0000);
    // x = mantissa 2^(exponent - 150): what is left of the exponent must be even, and the root of 25 bits, one to round.
    let odd = exponent & 1;
    let root = ((mantissa as u64) << (26 - odd)).isqrt() as u32;
    // Never halfway between two numbers: the square of an odd root would be odd.
    let rounded = root.div_ceil(2);
    // The root's leading bit, wherever rounding left it, is the lowest one of the exponent.
    f32::from_bits((((exponent + odd) / 2 + 62) << 23) + rounded)
}
