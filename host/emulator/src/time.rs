// SPDX-License-Identifier: GPL-2.0-only
//! Virtual time, in a unit in which the period of every clock of the chip is a whole number.

/// Virtual time since power-on, in units of 1 / [`TICKS_PER_S`] s.
pub type Ticks = u64;

/// 4.08 GHz is a multiple of 170 MHz, 24 MHz, 16 MHz and 32 kHz: no clock of the firmware needs rounding.
pub const TICKS_PER_S: u64 = 4_080_000_000;
/// One microsecond.
pub const TICKS_PER_US: u64 = TICKS_PER_S / 1_000_000;
/// One millisecond.
pub const TICKS_PER_MS: u64 = TICKS_PER_S / 1_000;

/// Core cycles charged for one executed instruction, as a fraction: 1.5.
///
/// This is an assumption: the core's table gives one cycle for most instructions, two for a load,
/// two to four for a taken branch, plus flash wait states. Instruction counts do not depend on it.
pub const CYCLES_PER_INSTRUCTION: (u64, u64) = (3, 2);

/// Virtual time in seconds.
#[must_use]
pub fn seconds(ticks: Ticks) -> f64 {
    ticks as f64 / TICKS_PER_S as f64
}

/// The tick at or after `seconds`; 0 for negative values and NaN, saturates at the largest time.
#[must_use]
pub fn ticks(seconds: f64) -> Ticks {
    // Rounded up, where a processor may have no instruction for it.
    let exact = seconds * TICKS_PER_S as f64;
    let whole = exact as Ticks;
    whole.saturating_add(u64::from((whole as f64) < exact))
}

/// Period of a clock in ticks, or `None` if it is not a whole number.
#[must_use]
pub fn period(hertz: u64) -> Option<Ticks> {
    (hertz != 0 && TICKS_PER_S.is_multiple_of(hertz)).then(|| TICKS_PER_S / hertz)
}
