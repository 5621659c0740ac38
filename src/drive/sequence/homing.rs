//! Finding the encoder's zero at the opening stop.

use super::Sequence;
use super::motion::WINDUP_RAD;
use super::stall_detector::StallDetector;
use super::state::State;
use super::stop_detector::StopDetector;
use super::transitions::Observation;
use crate::drive::fault::Fault;

/// Steps of homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Homing {
    Seek,
    RunUp,
    Zero,
    BackOff,
}

/// Time from a start until the current is that of steady motion, microseconds: the reference takes 30 ms to its speed, the
/// speed loop as long again.
const STARTED_US: u32 = 100_000;
/// Free way before the opening stop that distinguishes free motion from windup, radian: 0.3 s and a backlash.
const RUN_UP_RAD: f32 = 0.12;
/// Two homings on the same stop differ by less, radian: twice what one may be off by.
const SAME_STOP_RAD: f32 = 0.025;

impl Sequence {
    /// Opens against the stop, makes the stop's beginning the zero, backs off to the rest position.
    pub(super) fn home(&mut self, seen: &Observation) -> Option<State> {
        let position_counts = seen.status.position_counts;
        match self.homing {
            Homing::Seek => {
                if seen.now_us.wrapping_sub(self.turned_us) > STARTED_US {
                    self.onset
                        .update(seen.status.current_a.abs(), position_counts);
                }
                if -seen.way_rad > self.motion.travel_rad + 2.0 * WINDUP_RAD {
                    return self.fail(Fault::TravelLimit);
                }
                if !seen.stalled {
                    return None;
                }
                self.stall = StallDetector::default();
                let stop_counts = self.onset.position_counts().unwrap_or(position_counts);
                let free_counts = self.start_counts.wrapping_sub(stop_counts);
                if self.scale.angle_rad(free_counts) < RUN_UP_RAD {
                    // Too short a way to distinguish free motion from windup: take a run-up.
                    self.start_counts = position_counts;
                    self.homing = Homing::RunUp;
                    self.run_ups = self.run_ups.saturating_add(1);
                } else {
                    self.demand.zero = self.demand.zero.wrapping_add(1);
                    self.demand.zero_at_counts = self.zero_counts(stop_counts);
                    self.zeroed = true;
                    self.homing = Homing::Zero;
                }
                None
            }
            Homing::RunUp => {
                if seen.way_rad <= RUN_UP_RAD + f32::from(self.run_ups) * WINDUP_RAD {
                    return self.fail_if_stalled(seen);
                }
                self.homing = Homing::Seek;
                self.onset = StopDetector::default();
                self.stall = StallDetector::default();
                self.start_counts = position_counts;
                self.turned_us = seen.now_us;
                None
            }
            Homing::Zero => {
                if seen.status.zero == self.demand.zero {
                    self.stall = StallDetector::default();
                    // The way begins here, at the stop.
                    self.start_counts = position_counts;
                    self.homing = Homing::BackOff;
                }
                None
            }
            Homing::BackOff => {
                if seen.angle_rad >= self.motion.rest_rad {
                    return self.first_motion();
                }
                self.fail_if_stalled(seen)
            }
        }
    }

    /// Where the zero is to be, for a stop found at a position.
    ///
    /// The friction record goes up and down with the turn of the worm: shifted by the few milliradians by which homings
    /// differ it leaves what the detector takes for a contact, or for less than friction. The zero it was taken with stays,
    /// unless the stop is so far off that counts were lost.
    fn zero_counts(&self, stop_counts: i32) -> i32 {
        let same = self.scale.angle_rad(stop_counts).abs() < SAME_STOP_RAD;
        if self.zeroed && self.friction_known && same {
            0
        } else {
            stop_counts
        }
    }
}
