//! A motor that stands while it holds, and starts again by itself (docs/SECOND_CONTACTS.md#while-the-motor-holds).
//!
//! With a constant current it stands because the worm's load is more than the current can turn. It starts when that load has
//! gone: the object gave way.

use crate::sensing::block::Block;
use crate::sensing::{Drive, Drivetrain, Sample};

/// Without more motion than this for so long the motor stands, radian at the input link and microseconds.
const STILL_RAD: f32 = 0.5e-3;
const STILL_US: u64 = 30_000;
/// It has started when it moves by this within that time.
const STARTED_RAD: f32 = 1.0e-3;
/// So long after the start there is an answer at the latest, microseconds.
const ANSWER_US: u64 = 22_000;
/// A sample above this many mean currents shows that the current was raised: the controller keeps it far closer (chosen).
const RAISED: f32 = 1.1;
/// Weight of a sample in the mean current of a motor that stands.
const GAIN: f32 = 0.05;

/// Time, microseconds, and position, counts.
type Place = (u64, i32);

/// Watches the motor sample by sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Stand {
    /// When and where it was last seen to move, or to stand.
    anchor: Option<Place>,
    is_still: bool,
    /// Mean current while it stood, ampere; none before it did.
    current_a: Option<f32>,
    /// When it started by itself, if nothing was said of that so far.
    started_us: Option<u64>,
}

impl Stand {
    /// The motor stands.
    pub(super) fn is_still(&self) -> bool {
        self.is_still
    }

    /// The torque that the holding current makes where the motor stood, as a block of no width; none before it did.
    pub(super) fn held(&self, drivetrain: &Drivetrain) -> Option<Block> {
        let (time_us, counts) = self.anchor?;
        Some(Block {
            emf_v: f32::NAN,
            time_us,
            drive: Drive::Closing,
            counts,
            width_counts: 0,
            way_counts: i32::MAX,
            duration_s: STILL_US as f32 * 1e-6,
            drive_torque_nm: drivetrain.torque_per_ampere_nm * self.current_a?,
            inertia_nm: 0.0,
            overspeed: 0.0,
        })
    }

    /// Takes a sample of a finger in contact; whether the motor has started by itself.
    pub(super) fn push<J>(&mut self, sample: &Sample<J>, drivetrain: &Drivetrain) -> bool {
        if self
            .current_a
            .is_some_and(|mean_a| sample.current_a > RAISED * mean_a)
        {
            // The current was raised: a start that follows is not by itself.
            *self = Self::default();
        }
        let now = (sample.time_us, sample.position_counts);
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
            // Another stand had another current.
            self.current_a = self.current_a.filter(|_| self.is_still);
            self.is_still = true;
        }
        if self.is_still {
            let mean_a = self.current_a.unwrap_or(sample.current_a);
            self.current_a = Some(mean_a + GAIN * (sample.current_a - mean_a));
        }
        let is_due =
            |started_us: &mut u64| self.is_still || now.0.saturating_sub(*started_us) > ANSWER_US;
        self.started_us.take_if(is_due).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::tests::drivetrain;

    /// When a motion at 0.06 A, given by its angle at every millisecond, is told as a start, millisecond.
    fn told(angle_rad: impl Fn(f32) -> f32) -> Vec<u64> {
        told_at(angle_rad, |_| 0.06)
    }

    /// The same with a current of every millisecond, ampere.
    fn told_at(angle_rad: impl Fn(f32) -> f32, current_a: impl Fn(u64) -> f32) -> Vec<u64> {
        let (mut stand, drivetrain) = (Stand::default(), drivetrain());
        let samples = (0..400u64).map(|ms| Sample {
            emf_v: f32::NAN,
            time_us: 1000 * ms,
            position_counts: (angle_rad(1e-3 * ms as f32) / drivetrain.rad_per_count) as i32,
            current_a: current_a(ms),
            drive: Drive::Idle,
            joint: (),
        });
        samples
            .filter(|sample| stand.push(sample, &drivetrain))
            .map(|sample| sample.time_us / 1000)
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
        assert!(matches!(told[..], [200..250]), "{told:?}");
    }

    /// What held before, at another current, is not in the mean of the stand now.
    #[test]
    fn the_current_that_holds_is_that_of_this_stand() {
        let (mut stand, drivetrain) = (Stand::default(), drivetrain());
        // At 0.2 A it stands, turns on by 0.1 rad, and stands at 0.05 A.
        let samples = (0..300u64).map(|ms| Sample {
            emf_v: f32::NAN,
            time_us: 1000 * ms,
            position_counts: ((1e-3 * ms.clamp(100, 200) as f32) / drivetrain.rad_per_count) as i32,
            current_a: if ms < 200 { 0.2 } else { 0.05 },
            drive: Drive::Idle,
            joint: (),
        });
        for sample in samples {
            stand.push(&sample, &drivetrain);
            if stand.is_still() {
                let held = stand.held(&drivetrain).expect("a stand");
                let held_a = held.drive_torque_nm / drivetrain.torque_per_ampere_nm;
                assert!(
                    (held_a - sample.current_a).abs() < 1e-6,
                    "{sample:?} {held_a}"
                );
            }
        }
    }

    /// A holding current that is raised, as the last word does for a wanted force, makes it start because it was told to.
    #[test]
    fn a_start_by_more_current_is_not_of_its_own() {
        let start = |raised_a: f32| {
            let angle_rad = |s: f32| 0.4 + 0.2 * (s - 0.2).clamp(0.0, 0.02);
            told_at(angle_rad, |ms| if ms < 200 { 0.06 } else { raised_a }).len()
        };
        assert_eq!(start(0.098), 0);
        assert_eq!(start(0.062), 1, "the controller's own ripple");
    }

    /// A motor that is turned back did not start by itself: it is the load that grew.
    #[test]
    fn a_motion_backwards_is_no_start() {
        assert_eq!(told(|s| 0.4 - 0.2 * (s - 0.2).clamp(0.0, 0.02)), []);
    }
}
