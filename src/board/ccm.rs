//! Copies the control interrupt's code from flash to the CCM SRAM, where it is linked to run (`memory.x`).

use core::ptr;

use cortex_m::asm;

/// Copies the code. Call once, before the interrupt is enabled and before anything else of [`super::control`] is called.
pub fn load() {
    // `memory.x` defines them; only their addresses mean something.
    unsafe extern "C" {
        static mut _control_start: u32;
        static _control_end: u32;
        static _control_load: u32;
    }
    // SAFETY: the linker aligns the three to words and reserves the region from start to end for this code, none of which has
    // run yet.
    unsafe {
        let start = &raw mut _control_start;
        let words = (&raw const _control_end).offset_from(start);
        ptr::copy_nonoverlapping(&raw const _control_load, start, words as usize);
    }
    // The copy must be complete before it is fetched.
    asm::dsb();
    asm::isb();
}
