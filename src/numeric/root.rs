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
        let root: f32;
        // SAFETY: reads and writes one FPU register each; no memory, no stack. The result depends on the operand alone
        // (FPSCR is never changed from its reset value; the sticky exception flags are not read by anything).
        unsafe {
            core::arch::asm!("vsqrt.f32 {0}, {1}", out(sreg) root, in(sreg) x, options(pure, nomem, nostack))
        };
        root
    }
    #[cfg(not(target_os = "none"))]
    x.sqrt()
}
