// SPDX-License-Identifier: GPL-2.0-only
//! Virtual time: one unit in which every clock of the chip has a whole period.

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
/// An assumption, the only one of the kind: the core's table says one cycle for most instructions, two for a load,
/// two to four for a taken branch, and flash wait states come on top. Instruction counts do not depend on it.
pub const CYCLES_PER_INSTRUCTION: (u64, u64) = (3, 2);

/// Virtual time in seconds.
#[must_use]
pub fn seconds(ticks: Ticks) -> f64 {
    ticks as f64 / TICKS_PER_S as f64
}

/// The tick at or after `seconds`; negative and not-a-number give 0, beyond the end of time gives the end.
#[must_use]
pub fn ticks(seconds: f64) -> Ticks {
    (seconds * TICKS_PER_S as f64).ceil() as Ticks
}

/// Period of a clock in ticks, or `None` where it has no whole number of them.
#[must_use]
pub fn period(hertz: u64) -> Option<Ticks> {
    (hertz != 0 && TICKS_PER_S.is_multiple_of(hertz)).then(|| TICKS_PER_S / hertz)
}
