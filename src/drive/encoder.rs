//! Encoder: the 16-bit counter extended to 32 bits, a speed observer, and a plausibility check.

use super::convert::PERIOD_S;
use super::io::EncoderCount;

/// Natural frequency of the speed observer, radian per second: 150 Hz, three times the speed loop's bandwidth: it costs
/// the loop 30 degrees of phase and leaves 45. At the creeping speed of 3 counts a period the rounding to whole counts is
/// then some 0.1 % of the speed.
const OBSERVER_RAD_PER_S: f32 = 942.0;
/// Observer gains for a damping of 0.7: on the position error, and on the speed.
const POSITION_GAIN: f32 = 1.4 * OBSERVER_RAD_PER_S * PERIOD_S;
const SPEED_GAIN: f32 = OBSERVER_RAD_PER_S * PERIOD_S * OBSERVER_RAD_PER_S * PERIOD_S;

/// More counts than this in one period cannot be motion: [`CheckedConfig`](super::config::CheckedConfig) keeps the configured speed at
/// or below it.
pub const JUMP_COUNTS: u32 = 16;
/// Change of speed, in counts a period, from one period to the next that no motor reaches: a rotor of 0.1 g cm2 changes by
/// 0.14 at stall current, rounding adds 1 and the encoder's own unevenness 1. A blow through the gears can be worse, once.
const KICK_COUNTS: u32 = 5;
/// A kick adds this, a quiet period takes one away.
const KICK_WEIGHT: u32 = 8;
/// This many points of kicks are noise on the wires: seven kicks in quick succession.
const KICK_LIMIT: u32 = 50;

/// Position and speed of the motor.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    last: EncoderCount,
    /// There was a reading before.
    started: bool,
    last_delta: i32,
    position: i32,
    lag_counts: f32,
    speed: f32,
    kicks: u32,
}

impl Encoder {
    /// Takes a reading. `true` if the step from the last one is one that a motor can make.
    pub fn update(&mut self, count: EncoderCount) -> bool {
        if !self.started {
            self.started = true;
            self.last = count;
        }
        // The shorter way round: right as long as fewer than 32768 counts pass between readings.
        let delta = i32::from(count.0.wrapping_sub(self.last.0) as i16);
        self.last = count;
        self.position = self.position.wrapping_add(delta);

        // Tracking loop in differences: nothing in it grows with the position.
        let lag = self.lag_counts + delta as f32 - self.speed;
        self.speed += SPEED_GAIN * lag;
        self.lag_counts = lag - POSITION_GAIN * lag;

        let kick = delta.wrapping_sub(self.last_delta);
        self.last_delta = delta;
        self.kicks = if kick.unsigned_abs() <= KICK_COUNTS {
            self.kicks.saturating_sub(1)
        } else {
            self.kicks.saturating_add(KICK_WEIGHT)
        };
        delta.unsigned_abs() <= JUMP_COUNTS && self.kicks <= KICK_LIMIT
    }

    /// Position, counts; wraps.
    pub fn position_counts(&self) -> i32 {
        self.position
    }

    /// Makes this position the zero.
    pub fn rezero(&mut self, at_counts: i32) {
        self.position = self.position.wrapping_sub(at_counts);
    }

    /// Speed, counts a control period.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Resets the plausibility check and the speed, which may be made of noise: after a fault.
    pub fn settle(&mut self) {
        self.kicks = 0;
        self.lag_counts = 0.0;
        self.speed = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn extends_the_counter_through_every_wrap(start: u16, steps in prop::collection::vec(-200i16..=200, 1..2000)) {
            let mut encoder = Encoder::default();
            let mut raw = start;
            let mut truth = 0i32;
            encoder.update(EncoderCount(raw));
            for step in steps {
                raw = raw.wrapping_add_signed(step);
                truth += i32::from(step);
                encoder.update(EncoderCount(raw));
                prop_assert_eq!(encoder.position_counts(), truth);
            }
        }
    }

    /// Readings of a motor at a constant speed, with a periodic error of 2 counts a turn.
    fn readings(counts_per_period: f64) -> impl Iterator<Item = EncoderCount> {
        (0i64..).map(move |period| {
            let position = counts_per_period * period as f64;
            let uneven = 2.0 * (position * core::f64::consts::TAU / 1024.0).sin();
            EncoderCount((position + uneven).floor() as i64 as u16)
        })
    }

    #[test]
    fn speed_converges_and_stays_smooth_at_every_speed() {
        for speed in [-10.7, -3.13, -0.31, 0.01, 0.031, 0.31, 1.0, 3.13, 10.7] {
            let mut encoder = Encoder::default();
            let mut mean = 0.0;
            let mut worst = 0.0f64;
            for (period, reading) in readings(speed).take(60_000).enumerate() {
                assert!(
                    encoder.update(reading),
                    "healthy motion taken for noise at {speed}"
                );
                if period >= 20_000 {
                    mean += f64::from(encoder.speed()) / 40_000.0;
                    worst = worst.max((f64::from(encoder.speed()) - speed).abs());
                }
            }
            assert!(
                (mean - speed).abs() < 1e-3 + 1e-3 * speed.abs(),
                "{speed}: {mean}"
            );
            // 2 counts uneven is 1.2 % of the speed; rounding comes on top.
            assert!(worst < 0.02 + 0.02 * speed.abs(), "{speed}: off by {worst}");
        }
    }

    #[test]
    fn a_jump_is_found_at_once() {
        for jump in [17i16, -17, 100, -3000, i16::MAX, i16::MIN] {
            let mut encoder = Encoder::default();
            assert!(encoder.update(EncoderCount(7)));
            assert!(
                !encoder.update(EncoderCount(7u16.wrapping_add_signed(jump))),
                "{jump}"
            );
        }
    }

    #[test]
    fn noise_on_the_wires_is_found_though_no_step_is_a_jump() {
        let mut encoder = Encoder::default();
        let mut raw = 0u16;
        let tripped = (0..200).position(|period| {
            raw = raw.wrapping_add_signed(if period % 2 == 0 { 8 } else { -6 });
            !encoder.update(EncoderCount(raw))
        });
        assert!(tripped.is_some_and(|period| period < 10), "{tripped:?}");
    }

    #[test]
    fn single_blows_are_not_noise() {
        let mut encoder = Encoder::default();
        let mut raw = 0u16;
        for period in 0..200_000u32 {
            // Stopped dead from 8 counts a period, every 5 ms.
            raw = raw.wrapping_add_signed(if period % 100 < 50 { 8 } else { 0 });
            assert!(encoder.update(EncoderCount(raw)), "period {period}");
        }
    }
}
