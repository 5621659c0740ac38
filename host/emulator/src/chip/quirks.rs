// SPDX-License-Identifier: GPL-2.0-only
//! Behaviour of real parts beyond their registers.

/// Behaviour of the parts on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quirks {
    /// nFAULT is low for this long after the bridge was woken. The DRV8876 wakes within 1 ms (t_WAKE, SLVSDS7B); that its
    /// charge pump holds the pin low meanwhile is an assumption, taken from sibling parts that say so (DRV81545, SLVSHI4A).
    pub wake_fault_s: f64,
    /// nFAULT is shorted to the logic supply, so nothing can pull it low.
    pub fault_pin_held_high: bool,
    /// The crystal does not start.
    pub crystal_dead: bool,
    /// The backup domain holds random bits after power-on, and drives the oscillator of 32 kHz out on PA2 (errata ES0431).
    pub stale_backup_domain: bool,
    /// FLASH_SR holds a sequence error after every reset, as seen on this family (RIOT issue 22151).
    pub stale_flash_flags: bool,
    /// ECCR reports a wrong address for a bad double word.
    pub wrong_ecc_address: bool,
}

impl Default for Quirks {
    fn default() -> Self {
        Self {
            wake_fault_s: 1e-3,
            fault_pin_held_high: false,
            crystal_dead: false,
            stale_backup_domain: false,
            stale_flash_flags: false,
            wrong_ecc_address: false,
        }
    }
}
