//! A motor that stands while it holds, and starts again by itself (docs/MECHANICS.md#held-contacts).
//!
//! With a constant current it stands because the worm's load is more than the current can turn. It starts when that load has
//! gone: the object gave way.

use super::turn::{Place, TurnMeter};
use crate::sensing::block::Block;
use crate::sensing::{Drive, Drivetrain, Sample};

/// Without more motion than this for so long the motor stands, radian at the input link and microseconds.
const STILL_RAD: f32 = 0.5e-3;
const STILL_US: u64 = 30_000;
/// It has started when it moves by this within that time.
const STARTED_RAD: f32 = 1.0e-3;
/// So long after the start there is an answer at the latest, microseconds.
const ANSWER_US: u64 = 22_000;
/// Weight of a sample in the mean current of a motor that stands.
const GAIN: f32 = 0.05;

/// What a sample shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Standing {
    /// Nothing new.
    Nothing,
    /// A turn of a motor that moves.
    Turned(Block),
    /// It has started by itself, and nothing else was said of that so far.
    GaveWay,
}

/// Watches the motor sample by sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Stand {
    /// When and where it was last seen to move, or to stand.
    anchor: Option<Place>,
    is_still: bool,
    /// Mean current while it stood, ampere; none before it did.
    current_a: Option<f32>,
    turns: TurnMeter,
    /// When it started by itself, if nothing was said of that so far.
    started_us: Option<u64>,
}

impl Stand {
    /// The torque that the holding current makes where the motor stood, as a block of no width; none before it did.
    pub(super) fn held(&self, drivetrain: &Drivetrain) -> Option<Block> {
        let (time_us, counts) = self.anchor?;
        Some(Block {
            time_us,
            drive: Drive::Closing,
            counts,
            width_counts: 0,
            duration_s: STILL_US as f32 * 1e-6,
            drive_torque_nm: drivetrain.torque_per_ampere_nm * self.current_a?,
            inertia_nm: 0.0,
            overspeed: 0.0,
        })
    }

    /// Takes a sample of a finger in contact; `speed_rad_per_s` is the one that friction was recorded at.
    pub(super) fn push<J>(
        &mut self,
        sample: &Sample<J>,
        drivetrain: &Drivetrain,
        speed_rad_per_s: f32,
    ) -> Standing {
        let now = (sample.time_us, sample.position_counts);
        let turned = self.turns.push(sample, drivetrain, speed_rad_per_s);
        let (since_us, counts) = *self.anchor.get_or_insert(now);
        let way_rad = drivetrain.rotation_rad(counts, now.1);
        if self.is_still {
            if way_rad > STARTED_RAD {
                self.is_still = false;
                self.started_us = Some(now.0);
                self.anchor = Some(now);
            }
        } else if way_rad.abs() > STILL_RAD {
            self.anchor = Some(now);
        }
        if now.0.saturating_sub(since_us) > STILL_US && way_rad.abs() <= STILL_RAD {
            // It may creep: what counts is how far it moves within that time.
            self.anchor = Some(now);
            self.is_still = true;
        }
        if self.is_still {
            let mean_a = self.current_a.unwrap_or(sample.current_a);
            self.current_a = Some(mean_a + GAIN * (sample.current_a - mean_a));
            self.turns.begin(now);
        }
        if let Some(block) = turned {
            return Standing::Turned(block);
        }
        let is_due =
            |started_us: &mut u64| self.is_still || now.0.saturating_sub(*started_us) > ANSWER_US;
        match self.started_us.take_if(is_due) {
            Some(_) => Standing::GaveWay,
            None => Standing::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drivetrain() -> Drivetrain {
        Drivetrain {
            rad_per_count: 5e-6,
            counts_per_turn: 1000,
            counts_per_worm_turn: 0,
            creep: 0.0,
            creep_s: 1.0,
            opening_stop_rad: 0.0,
            torque_per_ampere_nm: 10.0,
            efficiency: 0.5,
            inertia_kg_m2: 0.015,
            inertia_share: 0.0,
            viscous_nm_s_per_rad: 0.0,
            efficiency_per_speed: 0.0,
            backlash_rad: 0.0,
        }
    }

    /// What is told of a motion at 0.06 A, given by its angle at every millisecond; the times are those of the samples.
    fn told(angle_rad: impl Fn(f32) -> f32) -> Vec<(u64, Standing)> {
        let (mut stand, drivetrain) = (Stand::default(), drivetrain());
        let samples = (0..400u64).map(|ms| Sample {
            time_us: 1000 * ms,
            position_counts: (angle_rad(1e-3 * ms as f32) / drivetrain.rad_per_count) as i32,
            current_a: 0.06,
            drive: Drive::Idle,
            joint: (),
        });
        samples
            .map(|sample| (sample.time_us / 1000, stand.push(&sample, &drivetrain, 0.3)))
            .filter(|(_, standing)| *standing != Standing::Nothing)
            .collect()
    }

    #[test]
    fn a_motor_that_stands_or_creeps_says_nothing() {
        assert_eq!(told(|_| 0.4), []);
        assert_eq!(told(|s| 0.4 + 0.015 * s), []);
    }

    #[test]
    fn a_start_of_its_own_is_told_within_50_ms() {
        // By 4 mrad within 20 ms, at 0.2 s.
        let told = told(|s| 0.4 + 0.2 * (s - 0.2).clamp(0.0, 0.02));
        assert!(
            matches!(told[..], [(200..250, Standing::GaveWay)]),
            "{told:?}"
        );
    }

    #[test]
    fn without_load_the_whole_torque_goes_into_the_acceleration() {
        let acceleration = 10.0 * 0.06 / 0.015;
        let told = told(|s| 0.4 + 0.5 * acceleration * (s - 0.2).max(0.0).powi(2));
        let (at_ms, Standing::Turned(block)) = told[0] else {
            panic!("{told:?}");
        };
        assert!((200..240).contains(&at_ms), "{at_ms}");
        assert!(block.drive_torque_nm.abs() < 0.06, "{block:?}");
    }
}
