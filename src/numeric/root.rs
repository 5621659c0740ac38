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
        let mut bits = x.to_bits();
        // SAFETY: one FPU register, declared as overwritten; no memory, no stack. The result depends on the operand alone
        // (FPSCR is never changed from its reset value; the sticky exception flags are not read by anything). The operand
        // goes through a core register because the compiler offers FPU registers for assembly only where the FPU also
        // knows double precision.
        unsafe {
            core::arch::asm!(
                "vmov s0, {bits}",
                "vsqrt.f32 s0, s0",
                "vmov {bits}, s0",
                bits = inout(reg) bits,
                out("s0") _,
                options(pure, nomem, nostack, preserves_flags)
            )
        };
        f32::from_bits(bits)
    }
    #[cfg(not(target_os = "none"))]
    x.sqrt()
}
