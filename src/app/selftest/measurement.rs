//! What the motor is asked for in each step of the self-test, and what is made of the answers.

use super::{DRIVEN_A, ENCODER_COUNTS, SelfTestStep, TRAVEL_RAD, TRAVEL_RAD_PER_S};
use crate::drive::{OffsetState, Setpoint, Status, offset};
use crate::numeric::{Bounded, sqrt};

/// The bridge needs 1.5 ms, the motor some more to stand still.
pub const SETTLE_MS: u32 = 20;
/// Samples of the noise, one a millisecond.
const NOISE_MS: u32 = 200;
/// Longest drive for the encoder's direction, milliseconds: with a dead encoder it ends the motion.
const ENCODER_MS: u32 = 100;
/// The current's reference takes 5 ms to get there.
const RISEN_MS: u32 = 8;
/// Fewest samples of the driven current.
const LEAST_SAMPLES: u32 = 5;

/// One step after the other: asks of the motor, a status every millisecond, and a value at the end.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Counts of [`TRAVEL_RAD`], closing.
    travel_counts: i32,
    /// Speed of the travel, counts per second.
    slow_counts_per_s: f32,
    /// Where the motion under way began, how far it is to go, and how far it went.
    start_counts: i32,
    target_counts: i32,
    moved_counts: i32,
    /// How far the first motion of the travel went.
    there_counts: i32,
    offset_ma: f32,
    sum_ma: f32,
    squares_ma2: f32,
    samples: u32,
}

impl Measurement {
    /// For a drivetrain in which [`TRAVEL_RAD`] at the input link are so many counts.
    pub fn new(travel_counts: i32) -> Self {
        Self {
            travel_counts,
            slow_counts_per_s: travel_counts as f32 * (TRAVEL_RAD_PER_S / TRAVEL_RAD),
            start_counts: 0,
            target_counts: 0,
            moved_counts: 0,
            there_counts: 0,
            offset_ma: f32::NAN,
            sum_ma: 0.0,
            squares_ma2: 0.0,
            samples: 0,
        }
    }

    /// How often a step asks, one time after the other.
    pub fn asks(step: SelfTestStep) -> u8 {
        match step {
            // It is a value of the step before.
            SelfTestStep::Encoder => 0,
            // There and back.
            SelfTestStep::Travel => 2,
            _ => 1,
        }
    }

    /// Begins to ask: what for, and for how many milliseconds at most.
    pub fn ask(&mut self, step: SelfTestStep, status: &Status) -> (Setpoint, u32) {
        self.start_counts = status.position_counts;
        (self.sum_ma, self.squares_ma2, self.samples) = (0.0, 0.0, 0);
        match step {
            SelfTestStep::Supply | SelfTestStep::BreakInput | SelfTestStep::Encoder => {
                (Setpoint::Off, SETTLE_MS)
            }
            SelfTestStep::Wake => (Setpoint::Brake, SETTLE_MS),
            SelfTestStep::Offset => (Setpoint::MeasureOffset, offset::LONGEST_MS),
            SelfTestStep::Noise => (Setpoint::Brake, NOISE_MS),
            SelfTestStep::Current => (Setpoint::Current { a: DRIVEN_A }, ENCODER_MS),
            SelfTestStep::Travel => {
                let back = self.target_counts != 0;
                self.there_counts = self.moved_counts;
                self.target_counts = if back {
                    -self.there_counts
                } else {
                    self.travel_counts
                };
                let sign = if back { -1.0 } else { 1.0 };
                let slow = Setpoint::Speed {
                    counts_per_s: sign * self.slow_counts_per_s,
                    current_limit_a: 2.0 * DRIVEN_A,
                };
                // Twice the time that it takes.
                (slow, (2e3 * TRAVEL_RAD / TRAVEL_RAD_PER_S) as u32)
            }
        }
    }

    /// Takes the status a millisecond later, after `ms` others; whether there is no more to ask for.
    pub fn take(&mut self, step: SelfTestStep, ms: u32, status: &Status) -> bool {
        let current_ma = status.current_a * 1e3;
        match step {
            // The state of an earlier measurement stands until this one has begun.
            SelfTestStep::Offset if ms >= SETTLE_MS && status.offset == OffsetState::Known => {
                self.offset_ma = status.offset_a * 1e3;
                true
            }
            SelfTestStep::Noise => {
                self.add(current_ma);
                false
            }
            SelfTestStep::Current => {
                self.moved_counts = status.position_counts.wrapping_sub(self.start_counts);
                if ms >= RISEN_MS {
                    self.add(current_ma);
                }
                self.moved_counts.abs() >= ENCODER_COUNTS && self.samples >= LEAST_SAMPLES
            }
            SelfTestStep::Travel => {
                self.moved_counts = status.position_counts.wrapping_sub(self.start_counts);
                self.moved_counts.abs() >= self.target_counts.abs()
            }
            _ => false,
        }
    }

    /// Whether the motor is left to stand still after a step's motion.
    pub fn moves(step: SelfTestStep) -> bool {
        matches!(step, SelfTestStep::Current | SelfTestStep::Travel)
    }

    /// The step's value, in its unit; not a number where it was not measured. Those of the bridge's pins are not measured
    /// here.
    pub fn value(&self, step: SelfTestStep, status: &Status) -> f32 {
        let mean_ma = self.sum_ma / self.samples as f32;
        match step {
            SelfTestStep::Supply => status.supply_v,
            SelfTestStep::Offset => self.offset_ma,
            SelfTestStep::Noise => {
                let variance = self.squares_ma2 / self.samples as f32 - mean_ma * mean_ma;
                sqrt(variance.at_least(0.0))
            }
            SelfTestStep::Current => mean_ma,
            SelfTestStep::Encoder => self.moved_counts as f32,
            SelfTestStep::Travel => {
                1e3 * TRAVEL_RAD * (self.there_counts as f32 / self.travel_counts as f32)
            }
            SelfTestStep::Wake | SelfTestStep::BreakInput => f32::NAN,
        }
    }

    fn add(&mut self, current_ma: f32) {
        self.sum_ma += current_ma;
        self.squares_ma2 += current_ma * current_ma;
        self.samples += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of a step whose status is `status(ms)`, and how long each ask took.
    fn measured(
        measurement: &mut Measurement,
        step: SelfTestStep,
        status: impl Fn(u8, u32) -> Status,
    ) -> (f32, Vec<u32>) {
        let mut took = Vec::new();
        let mut last = status(0, 0);
        for ask in 0..Measurement::asks(step) {
            let (_, most_ms) = measurement.ask(step, &status(ask, 0));
            let mut ms = 0;
            while ms < most_ms {
                last = status(ask, ms + 1);
                ms += 1;
                if measurement.take(step, ms - 1, &last) {
                    break;
                }
            }
            took.push(ms);
        }
        (measurement.value(step, &last), took)
    }

    #[test]
    fn an_offset_of_before_the_measurement_does_not_count() {
        let status = |_, ms| Status {
            offset: if (10..200).contains(&ms) {
                OffsetState::Measuring
            } else {
                OffsetState::Known
            },
            offset_a: if ms < 200 { 9.0 } else { 3e-3 },
            ..Status::default()
        };
        let (value, took) = measured(&mut Measurement::new(1000), SelfTestStep::Offset, status);
        assert!((value - 3.0).abs() < 1e-5, "{value}");
        assert_eq!(took, [200]);
        let never = |_, _| Status::default();
        let (value, _) = measured(&mut Measurement::new(1000), SelfTestStep::Offset, never);
        assert!(value.is_nan());
    }

    #[test]
    fn noise_is_a_standard_deviation() {
        let status = |_, ms| Status {
            current_a: if ms % 2 == 0 { 1.5e-3 } else { 0.5e-3 },
            ..Status::default()
        };
        let (value, took) = measured(&mut Measurement::new(1000), SelfTestStep::Noise, status);
        assert!((value - 0.5).abs() < 1e-3, "{value}");
        assert_eq!(took, [NOISE_MS]);
    }

    #[test]
    fn the_current_is_read_once_it_has_risen_and_the_encoder_beside_it() {
        let status = |_, ms| Status {
            current_a: if ms <= RISEN_MS { 0.0 } else { 0.04 },
            position_counts: 70 + 50 * ms as i32,
            ..Status::default()
        };
        let mut measurement = Measurement::new(1000);
        let (value, took) = measured(&mut measurement, SelfTestStep::Current, status);
        assert!((value - 40.0).abs() < 1e-3, "{value}");
        assert_eq!(took, [20]);
        let (counts, took) = measured(&mut measurement, SelfTestStep::Encoder, status);
        assert_eq!((counts, took.len()), (1000.0, 0));
    }

    #[test]
    fn the_travel_goes_there_and_back() {
        // In either sense of the counts.
        for sense in [1, -1] {
            let status = |ask, ms: u32| Status {
                position_counts: sense
                    * if ask == 0 {
                        4 * ms as i32
                    } else {
                        1000 - 4 * ms as i32
                    },
                ..Status::default()
            };
            let mut measurement = Measurement::new(sense * 1000);
            let (value, took) = measured(&mut measurement, SelfTestStep::Travel, status);
            assert!((value - 1e3 * TRAVEL_RAD).abs() < 1e-3, "{value}");
            assert_eq!(took, [250, 250]);
        }
    }
}
