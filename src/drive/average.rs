//! Averages the control periods of one sample for the sensing: 20 periods, 1 ms.
//!
//! Part of the control interrupt: see [`controller`](super::controller) on what may not be called here.

use super::demand::LimitsReached;
use super::io::CONTROL_HZ;
use crate::sample::Drive;

/// Samples a second handed to sensing.
pub const SAMPLE_HZ: u32 = 1000;
/// Control periods a sample.
pub const PERIODS_PER_SAMPLE: u8 = (CONTROL_HZ / SAMPLE_HZ) as u8;
/// Every period of a sample in steady motion with the drive.
const ALL_CLOSING: i8 = PERIODS_PER_SAMPLE as i8;
const ALL_OPENING: i8 = -ALL_CLOSING;
/// Slowest speed, counts a period, that has a direction: 0.002 rad/s at the prototype's input link.
const MOVING: f32 = 0.02;

/// One control period as the average takes it.
#[derive(Clone, Copy, Debug)]
pub struct Period {
    /// Current that the sense shows, ampere, closing positive.
    pub signed_a: f32,
    /// The drive closes the finger; otherwise it opens it.
    pub closing: bool,
    /// Speed in the direction of the drive, counts a period; 0 where the sense cannot tell.
    pub speed_along: f32,
}

/// What one sample is averaged from.
#[derive(Clone, Debug, Default)]
pub struct Average {
    periods: u8,
    /// Periods of steady motion in the direction of the drive: closing counts up, opening down.
    driven: i8,
    sum_a: f32,
    sum_squares_a2: f32,
    /// Limits reached in any of its periods.
    pub limited: LimitsReached,
}

/// The average of a whole sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Averaged {
    /// Mean current, ampere, closing positive.
    pub current_a: f32,
    /// Mean square of the current, ampere squared.
    pub mean_square_a2: f32,
    /// What the bridge did: closing or opening only where every period did.
    pub drive: Drive,
}

impl Average {
    /// Periods averaged so far.
    #[inline(always)]
    pub fn periods(&self) -> u8 {
        self.periods
    }

    /// Adds a period; the number of periods so far.
    #[inline(always)]
    pub fn add(&mut self, period: Period) -> u8 {
        self.periods += 1;
        self.sum_a += period.signed_a;
        self.sum_squares_a2 += period.signed_a * period.signed_a;
        if period.speed_along > MOVING {
            self.driven += if period.closing { 1 } else { -1 };
        }
        self.periods
    }

    /// The average of [`PERIODS_PER_SAMPLE`] periods.
    #[inline(always)]
    pub fn averaged(&self) -> Averaged {
        const PER_SAMPLE: f32 = 1.0 / PERIODS_PER_SAMPLE as f32;
        Averaged {
            current_a: self.sum_a * PER_SAMPLE,
            mean_square_a2: self.sum_squares_a2 * PER_SAMPLE,
            drive: match self.driven {
                ALL_CLOSING => Drive::Closing,
                ALL_OPENING => Drive::Opening,
                _ => Drive::Idle,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn averaged(periods: impl Iterator<Item = Period>) -> Averaged {
        let mut average = Average::default();
        let count = periods.map(|period| average.add(period)).last();
        assert_eq!(count, Some(PERIODS_PER_SAMPLE));
        average.averaged()
    }

    fn moving(closing: bool, speed_along: f32) -> Period {
        Period {
            signed_a: 0.02,
            closing,
            speed_along,
        }
    }

    #[test]
    fn a_sample_is_driven_only_where_every_period_is() {
        let all = |closing| averaged((0..20).map(|_| moving(closing, 1.0)));
        assert_eq!(all(true).drive, Drive::Closing);
        assert_eq!(all(false).drive, Drive::Opening);
        let one_stands = averaged((0..20).map(|n| moving(true, if n == 7 { 0.0 } else { 1.0 })));
        assert_eq!(one_stands.drive, Drive::Idle);
        let reversed = averaged((0..20).map(|n| moving(n < 10, 1.0)));
        assert_eq!(reversed.drive, Drive::Idle);
    }

    #[test]
    fn means_are_those_of_the_periods() {
        let averaged = averaged((0..20).map(|n| Period {
            signed_a: 0.001 * n as f32,
            ..moving(true, 1.0)
        }));
        assert!((averaged.current_a - 0.0095).abs() < 1e-7);
        // 0 to 19 squared, on average.
        assert!((averaged.mean_square_a2 - 123.5e-6).abs() < 1e-9);
    }
}
