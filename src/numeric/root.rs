//! Square root: the only unsafe code of the library, one instruction.
#![allow(unsafe_code)]

#[cfg(target_os = "none")]
unsafe extern "C" {
    /// The C function of that name, which the compiler knows: for a core with VSQRT.F32 it emits that instruction and no
    /// call. (Inline assembly cannot: stable Rust does not let it name the FPU's registers on this target.) Nothing
    /// defines the symbol, so a compiler that called it would fail to link; `cargo xtask size` looks for it as well.
    safe fn sqrtf(x: f32) -> f32;
}

/// Square root, correctly rounded; NaN for a negative or NaN argument, as IEEE 754 says. Callers guard the sign.
///
/// `core` has no square root and libm's is software on this target. VSQRT.F32 takes 14 cycles and rounds exactly as
/// `f32::sqrt` does on the host, so both run the same numbers.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_os = "none")]
    return sqrtf(x);
    #[cfg(not(target_os = "none"))]
    x.sqrt()
}
