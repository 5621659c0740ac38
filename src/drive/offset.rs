//! Offset of the current sense: averaged at standstill, with its spread checked.

use super::protect::OFFSET_LIMIT_A;

/// Longest measurement, milliseconds, before it is given up: about twice the 225 ms that one takes.
pub const LONGEST_MS: u32 = 420;
/// Periods (20 ms) to wait after the motor stands still.
const SETTLE_PERIODS: u32 = 400;
/// Periods (205 ms) that are averaged: 0.5 mA of noise leaves 8 uA.
const AVERAGED: u32 = 4096;
/// Largest standard deviation of the reading, ampere: five times the noise expected.
const SPREAD_LIMIT_A: f32 = 2.5e-3;
/// Speed, counts a period, that still counts as standstill.
const STANDSTILL: f32 = 0.02;

/// A measurement in progress, or its result.
#[derive(Clone, Debug, Default)]
pub struct OffsetMeter {
    settled: u32,
    taken: u32,
    sum_a: f32,
    sum_squares_a2: f32,
}

/// Result of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OffsetReading {
    /// Not yet.
    Pending,
    /// The offset, ampere.
    Offset(f32),
    /// Mean or spread are out of range.
    OutOfRange,
}

impl OffsetMeter {
    /// Takes a raw reading, at a speed in counts a period.
    pub fn update(&mut self, reading_a: f32, speed: f32) -> OffsetReading {
        if speed.abs() > STANDSTILL {
            *self = Self::default();
            return OffsetReading::Pending;
        }
        if self.settled < SETTLE_PERIODS {
            self.settled += 1;
            return OffsetReading::Pending;
        }
        if self.taken < AVERAGED {
            self.taken += 1;
            self.sum_a += reading_a;
            self.sum_squares_a2 += reading_a * reading_a;
            return OffsetReading::Pending;
        }
        const PER_AVERAGED: f32 = 1.0 / AVERAGED as f32;
        let mean_a = self.sum_a * PER_AVERAGED;
        let variance_a2 = self.sum_squares_a2 * PER_AVERAGED - mean_a * mean_a;
        if mean_a.abs() > OFFSET_LIMIT_A || variance_a2 > SPREAD_LIMIT_A * SPREAD_LIMIT_A {
            OffsetReading::OutOfRange
        } else {
            OffsetReading::Offset(mean_a)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(reading_a: impl Fn(u32) -> f32, speed: impl Fn(u32) -> f32) -> (OffsetReading, u32) {
        let mut meter = OffsetMeter::default();
        for period in 0..20_000 {
            let measured = meter.update(reading_a(period), speed(period));
            if measured != OffsetReading::Pending {
                return (measured, period);
            }
        }
        (OffsetReading::Pending, 20_000)
    }

    fn noise_a(period: u32) -> f32 {
        // Uniform, standard deviation 0.5 mA, from a multiplicative hash.
        let hashed = period.wrapping_mul(2_654_435_761) ^ (period >> 7).wrapping_mul(40_503);
        (hashed as f32 / u32::MAX as f32 - 0.5) * 0.5e-3 * 12f32.sqrt()
    }

    #[test]
    fn averages_the_noise_away() {
        let (measured, _) = measure(|period| 3e-3 + noise_a(period), |_| 0.0);
        let OffsetReading::Offset(offset_a) = measured else {
            panic!("{measured:?}")
        };
        assert!((offset_a - 3e-3).abs() < 5e-5, "{offset_a}");
    }

    #[test]
    fn refuses_what_is_no_offset() {
        assert_eq!(
            measure(|period| 20e-3 + noise_a(period), |_| 0.0).0,
            OffsetReading::OutOfRange
        );
        assert_eq!(
            measure(|period| 5e-3 + 8.0 * noise_a(period), |_| 0.0).0,
            OffsetReading::OutOfRange
        );
        assert_eq!(
            measure(|period| if period % 2 == 0 { 0.0 } else { 10e-3 }, |_| 0.0).0,
            OffsetReading::OutOfRange
        );
    }

    #[test]
    fn waits_for_standstill() {
        let (measured, period) = measure(|_| 1e-3, |period| if period < 3000 { 1.0 } else { 0.0 });
        assert!(matches!(measured, OffsetReading::Offset(_)) && period > 3000 + 4096);
        assert_eq!(measure(|_| 1e-3, |_| 0.5).0, OffsetReading::Pending);
    }
}
