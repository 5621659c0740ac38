//! The reset cause.

use embassy_stm32::pac::RCC;
use palpate::name_list::nth;

/// The reset that led here.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// Power came on, or dropped too low and recovered.
    Power,
    /// The reset pin or the debugger.
    Pin,
    /// The program asked for it, after a panic or a fault, or a debugger did, after flashing.
    Software,
    /// The independent watchdog.
    Watchdog,
    /// Anything else: option bytes, window watchdog, low-power entry.
    Other,
}

impl Reset {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        nth("power\npin\nsoftware\nwatchdog\nother\n", self as u8)
    }
}

/// Reads the cause and clears it for the next time. Several flags can stand: every reset also pulls the reset pin low,
/// and power-up also sets its own, so the most specific one counts.
pub fn take() -> Reset {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    if flags.iwdgrstf() {
        Reset::Watchdog
    } else if flags.sftrstf() {
        Reset::Software
    } else if flags.wwdgrstf() || flags.lpwrrstf() || flags.oblrstf() {
        Reset::Other
    } else if flags.borrstf() {
        Reset::Power
    } else {
        Reset::Pin
    }
}
