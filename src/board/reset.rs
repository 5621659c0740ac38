//! The reset cause.

use embassy_stm32::pac::RCC;

/// The reset that led here.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// Power came on, or dropped too low and recovered.
    Power,
    /// The reset pin or the debugger.
    Pin,
    /// The program asked for it: after a panic or a fault.
    Software,
    /// The independent watchdog.
    Watchdog,
    /// Anything else: option bytes, window watchdog, low-power entry.
    Other,
}

impl Reset {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Power => "power",
            Self::Pin => "pin",
            Self::Software => "software",
            Self::Watchdog => "watchdog",
            Self::Other => "other",
        }
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
