//! The motions of an identification: pulses and coasting, closing over a turn of the worm and opening back.

use super::Identified;
use super::estimator::{Estimator, Phase};
use crate::drive::config::CheckedConfig;
use crate::drive::demand::{OffsetState, Setpoint, Status};
use crate::drive::offset;

/// Currents of the pulses, as shares of the drive's limit: two of them tell resistance from a lost voltage.
const PULSES: [f32; 2] = [0.6, 0.3];
/// Speed that ends a pulse, as a share of the drive's limit: the loops then do not bound the current.
const FAST: f32 = 0.7;
/// Longest pulse and longest coasting, milliseconds.
const PULSE_MS: u32 = 80;
const COAST_MS: u32 = 300;
/// From the demand to a settled current, milliseconds: two until it is carried out, 1.5 to wake, five for the current's slope.
const SETTLED_MS: u32 = 9;
/// From the demand until the bridge is off throughout a sample, milliseconds.
const OFF_MS: u32 = 4;
/// Way of the input link, radian: a turn of the worm and a little.
const WAY_RAD: f32 = 0.33;
/// Way that must be free to close into, radian: what the last pulse adds to that when friction is low.
pub const FREE_WAY_RAD: f32 = 0.6;
/// Way above the start at which opening brakes, radian. At the drive's largest speed, 0.8 rad/s at the input link, a motor goes on for
/// 2 ms until it is told, 1.5 ms until the bridge is awake, and as far as in the time constant `J R / k^2`, 4.4 ms, at full speed:
/// 6.3 mrad. The rest is for a motor of other values and a sample that comes late.
const BRAKING_RAD: f32 = 0.01;
/// A motor that makes fewer counts in a millisecond stands, or is about to.
const STANDING: i32 = 4;
/// Longest measurement of all, milliseconds.
const ALL_MS: u32 = 20_000;
const SAMPLE_US: u64 = 1000;

/// Why nothing was identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotIdentified {
    /// A pulse did not move the motor.
    Blocked,
    /// The motion took too long.
    TimedOut,
    /// What was measured makes no motor.
    Implausible,
}

impl NotIdentified {
    /// Reason in the answer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blocked => "blocked",
            Self::TimedOut => "timed-out",
            Self::Implausible => "implausible",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Offset,
    Pulse,
    Coast,
    /// Opening has come too near to where it began, or nothing halts the motor.
    Brake,
}

/// An identification under way.
#[derive(Clone, Debug)]
pub struct Identification {
    estimator: Estimator,
    limit_a: f32,
    fast_counts_per_s: f32,
    way_counts: i32,
    braking_counts: i32,
    motion: Motion,
    /// Samples since the motion began, and steps in all.
    ms: u32,
    all_ms: u32,
    /// Pulses so far.
    pulses: u8,
    opening: bool,
    /// Longest way of a pulse and its coasting.
    furthest_counts: i32,
    /// Where all began, where this motion began, where the last sample ended, and when.
    start_counts: i32,
    from_counts: i32,
    last_counts: i32,
    last_us: u64,
}

impl Identification {
    /// For a drive whose motor stands with room to close; friction is told at `closing_rad_per_s` of the input link.
    pub fn new(drive: &CheckedConfig, closing_rad_per_s: f32, status: &Status) -> Self {
        let (limits, scale) = (&drive.config().limits, drive.scale());
        Self {
            estimator: Estimator::new(drive, closing_rad_per_s),
            limit_a: limits.current_a,
            fast_counts_per_s: FAST * scale.counts_per_s(limits.speed_rad_per_s),
            way_counts: scale.counts(WAY_RAD),
            braking_counts: scale.counts(BRAKING_RAD),
            motion: Motion::Offset,
            ms: 0,
            all_ms: 0,
            pulses: 0,
            opening: false,
            furthest_counts: 0,
            start_counts: status.position_counts,
            from_counts: 0,
            last_counts: status.position_counts,
            last_us: status.time_us,
        }
    }

    /// One step, every millisecond: what the motor shall do, or what was found. A status that comes again, or leaves samples out,
    /// because whoever calls ran late, is no standing motor.
    ///
    /// # Errors
    /// Why nothing was.
    // Not inlined: the executor's future does not hold its variables.
    #[inline(never)]
    pub fn advance(&mut self, status: &Status) -> Result<Step, NotIdentified> {
        self.all_ms += 1;
        if self.all_ms > ALL_MS {
            return Err(NotIdentified::TimedOut);
        }
        let elapsed_us = status.time_us.wrapping_sub(self.last_us);
        if elapsed_us == 0 {
            return Ok(Step::Ask(self.setpoint()));
        }
        let moved = status.position_counts.wrapping_sub(self.last_counts);
        (self.last_us, self.last_counts) = (status.time_us, status.position_counts);
        // Of samples that were left out only the sum is known: the next one tells.
        let stands = elapsed_us == SAMPLE_US && moved.abs() < STANDING;
        let phase = match self.motion {
            Motion::Pulse if self.ms > SETTLED_MS && !stands => Some(Phase::Driven),
            Motion::Coast if self.ms > OFF_MS && !stands => Some(Phase::Coasting),
            _ => None,
        };
        self.estimator.take(phase, status);
        self.ms += 1;
        let way = status.position_counts.wrapping_sub(self.start_counts);
        let near = self.opening && way < self.braking_counts;
        let next = match self.motion {
            // The state of an earlier measurement stands until this one has begun.
            Motion::Offset if self.ms > 20 && status.offset == OffsetState::Known => Motion::Pulse,
            Motion::Pulse | Motion::Coast if near => Motion::Brake,
            Motion::Coast if self.ms > COAST_MS => Motion::Brake,
            Motion::Pulse
                if self.ms > PULSE_MS
                    || status.speed_counts_per_s.abs() > self.fast_counts_per_s =>
            {
                Motion::Coast
            }
            Motion::Coast if self.ms > OFF_MS && stands => {
                let made = status.position_counts.wrapping_sub(self.from_counts).abs();
                if made < 10 * STANDING {
                    return Err(NotIdentified::Blocked);
                }
                self.furthest_counts = self.furthest_counts.max(made);
                self.opening |= way >= self.way_counts;
                // Never further back than to where it began, which after homing is 0.03 rad from the stop. The next pulse may go half
                // as far again as the furthest so far: a friction of two thirds, four deviations from place to place.
                let needed = self.furthest_counts + self.furthest_counts / 2 + self.braking_counts;
                if self.opening && way < needed {
                    return self.identified();
                }
                Motion::Pulse
            }
            Motion::Brake if self.ms > OFF_MS && stands && near => return self.identified(),
            Motion::Brake if self.ms > OFF_MS && stands || self.ms > COAST_MS => {
                return Err(NotIdentified::TimedOut);
            }
            Motion::Offset if self.ms > offset::LONGEST_MS => return Err(NotIdentified::TimedOut),
            motion => motion,
        };
        if next != self.motion {
            self.motion = next;
            self.ms = 0;
            if next == Motion::Pulse {
                self.pulses = self.pulses.wrapping_add(1);
                self.from_counts = status.position_counts;
            }
        }
        Ok(Step::Ask(self.setpoint()))
    }

    /// The end of the motions.
    fn identified(&self) -> Result<Step, NotIdentified> {
        let identified = self.estimator.identified();
        if identified.is_valid() {
            Ok(Step::Done(identified))
        } else {
            Err(NotIdentified::Implausible)
        }
    }

    fn setpoint(&self) -> Setpoint {
        match self.motion {
            Motion::Offset => Setpoint::MeasureOffset,
            Motion::Coast => Setpoint::Off,
            Motion::Brake => Setpoint::Brake,
            Motion::Pulse => {
                let [strong, weak] = PULSES;
                let share = if self.pulses % 2 == 1 { strong } else { weak };
                let sign = if self.opening { -1.0 } else { 1.0 };
                Setpoint::Current {
                    a: sign * share * self.limit_a,
                }
            }
        }
    }
}

/// What a step of an identification decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// What the motor shall do until the next step.
    Ask(Setpoint),
    /// All is measured.
    Done(Identified),
}
