//! Torque over the last turn of the motor in any motion, steady or not, with every sample.
//!
//! A [`Block`] of steady motion is more exact, but ends where a turn ends, and there is none while the speed changes. Here the window
//! slides: what repeats with the turn (commutation, the encoder's periodic error) is averaged out all the same, a change of speed is
//! taken off as inertia, and a jump of the torque shows from its first samples on. The acceleration comes from two differences of
//! counts: some millinewton metres at the input link.

use crate::numeric::Bounded;
use crate::sensing::block::{Block, GAP_US};
use crate::sensing::{Drive, Drivetrain, Sample};
use heapless::Deque;

/// Marks at most.
const MARKS: usize = 32;
/// A turn that takes longer than this, in turns of the nominal speed, is cut short.
const LONGEST: f32 = 1.5;
/// Marks over which a speed is taken.
const TRAIL: usize = 3;

/// State of the motor at a sample.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    time_us: u32,
    counts: i32,
    /// Charge since some time, nanocoulomb, wrapping: differences count.
    charge_nc: i32,
    /// Counts a second; NaN where it begins.
    speed: f32,
    /// Torque over the turn that ends here, and the part of inertia that was taken off, newton metre; NaN before the first.
    drive_torque_nm: f32,
    inertia_nm: f32,
}

/// The last turn, and the one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    /// The last turn.
    pub(super) block: Block,
    /// Torque of the turn that ended where this one began, and the inertia's part that was taken off, newton metre; NaN if the motor
    /// stood then.
    pub(super) before_nm: f32,
    pub(super) before_inertia_nm: f32,
    /// Speed of the input link at its end, radian per second.
    pub(super) speed_rad_per_s: f32,
    /// The motor is so slow that this is less than a turn.
    pub(super) is_short: bool,
}

/// The samples of the last turn.
#[derive(Clone, Debug, Default)]
pub(super) struct TurnMeter {
    marks: Deque<Mark, MARKS>,
    now: Mark,
}

impl TurnMeter {
    /// The window begins anew with the next sample.
    pub(super) fn restart(&mut self) {
        self.marks.clear();
    }

    /// Takes a sample; the turn that ends there, if the motor has turned so far since the start. `speed_rad_per_s` is the speed that
    /// friction was recorded at.
    pub(super) fn push<J>(
        &mut self,
        sample: &Sample<J>,
        drivetrain: &Drivetrain,
        speed_rad_per_s: f32,
    ) -> Option<Turn> {
        let before = self.now;
        // Differences of the lower half are right for more than an hour.
        let time_us = sample.time_us as u32;
        let elapsed_us = time_us.wrapping_sub(before.time_us);
        if elapsed_us > GAP_US || !sample.current_a.is_finite() {
            self.restart();
        }
        let charge_nc = (sample.current_a * 1e3 * elapsed_us.min(GAP_US) as f32) as i32;
        self.now = Mark {
            time_us,
            counts: sample.position_counts,
            charge_nc: before.charge_nc.wrapping_add(charge_nc),
            drive_torque_nm: f32::NAN,
            ..before
        };
        let trail = self.marks.iter().rev().nth(TRAIL - 1);
        self.now.speed =
            (trail.or(self.marks.front())).map_or(f32::NAN, |from| speed(from, &self.now));
        let turn_us = 1e6 * drivetrain.counts_per_turn as f32 * drivetrain.rad_per_count
            / speed_rad_per_s.at_least(f32::MIN_POSITIVE);
        let longest_us = (LONGEST * turn_us) as u32;
        let mut turn = self.turn(drivetrain, speed_rad_per_s, longest_us);
        if let Some(turn) = &mut turn {
            turn.block.time_us = sample.time_us;
            self.now.drive_torque_nm = turn.block.drive_torque_nm;
            self.now.inertia_nm = turn.block.inertia_nm;
        }
        // One mark more than the longest turn has, and the trail before it.
        let apart_us = longest_us / (MARKS - TRAIL - 1) as u32;
        let last_us = self.marks.back().map(|last| last.time_us);
        if last_us.is_none_or(|last_us| time_us.wrapping_sub(last_us) >= apart_us) {
            if self.marks.is_full() {
                self.marks.pop_front();
            }
            // There is room now.
            let _ = self.marks.push_back(self.now);
        }
        turn
    }

    fn turn(&self, drivetrain: &Drivetrain, speed_rad_per_s: f32, longest_us: u32) -> Option<Turn> {
        let now = &self.now;
        let width = drivetrain.counts_per_turn.max(1) as i32;
        let mut after = *now;
        let mut found = None;
        for mark in self.marks.iter().rev() {
            let way = now.counts.wrapping_sub(mark.counts);
            if way >= width {
                // The turn begins between this mark and the one after it.
                let step = after.counts.wrapping_sub(mark.counts).max(1);
                let share = (way - width) as f32 / step as f32;
                found = Some((mark.towards(&after, share), false));
                break;
            }
            if now.time_us.wrapping_sub(mark.time_us) >= longest_us {
                found = Some((*mark, true));
                break;
            }
            after = *mark;
        }
        let (from, is_short) = found.filter(|(from, _)| from.speed.is_finite())?;
        let duration_s = now.time_us.wrapping_sub(from.time_us) as f32 * 1e-6;
        let counts = now.counts.wrapping_sub(from.counts);
        let rad_per_s = |counts: f32| counts * drivetrain.rad_per_count / duration_s;
        let inertia_nm = drivetrain.inertia_kg_m2 * rad_per_s(now.speed - from.speed);
        let deviation = rad_per_s(counts as f32) - speed_rad_per_s;
        let viscous_nm = drivetrain.viscous_nm_s_per_rad * deviation;
        let mean_a = now.charge_nc.wrapping_sub(from.charge_nc) as f32 * 1e-9 / duration_s;
        let motor_nm = drivetrain.torque_per_ampere_nm * mean_a;
        let block = Block {
            emf_v: f32::NAN,
            time_us: 0,
            drive: Drive::Closing,
            counts: from.counts.wrapping_add(counts / 2),
            width_counts: counts.unsigned_abs(),
            way_counts: i32::MAX,
            duration_s,
            drive_torque_nm: motor_nm - inertia_nm - viscous_nm,
            inertia_nm,
            overspeed: deviation / speed_rad_per_s,
        };
        Some(Turn {
            block,
            before_nm: from.drive_torque_nm,
            before_inertia_nm: from.inertia_nm,
            speed_rad_per_s: now.speed * drivetrain.rad_per_count,
            is_short,
        })
    }
}

impl Mark {
    /// A state between this one and a later one.
    fn towards(&self, later: &Self, share: f32) -> Self {
        let between = |from: f32, to: f32| from + share * (to - from);
        let step_us = later.time_us.wrapping_sub(self.time_us);
        let charge_nc = later.charge_nc.wrapping_sub(self.charge_nc);
        let way = later.counts.wrapping_sub(self.counts);
        Self {
            time_us: (self.time_us).wrapping_add((share * step_us as f32) as u32),
            counts: self.counts.wrapping_add((share * way as f32) as i32),
            charge_nc: (self.charge_nc).wrapping_add((share * charge_nc as f32) as i32),
            speed: between(self.speed, later.speed),
            drive_torque_nm: between(self.drive_torque_nm, later.drive_torque_nm),
            inertia_nm: between(self.inertia_nm, later.inertia_nm),
        }
    }
}

/// Counts a second from one state to another.
fn speed(from: &Mark, to: &Mark) -> f32 {
    let elapsed_us = to.time_us.wrapping_sub(from.time_us);
    if elapsed_us > 0 {
        to.counts.wrapping_sub(from.counts) as f32 * 1e6 / elapsed_us as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::tests::drivetrain;

    const SPEED_RAD_PER_S: f32 = 0.3;

    /// The turns seen of a motion: its angle and the torque of the motor at a time in second.
    fn turns(angle_rad: impl Fn(f32) -> f32, torque_nm: impl Fn(f32) -> f32) -> Vec<(u64, Turn)> {
        let (mut meter, drivetrain) = (TurnMeter::default(), drivetrain());
        let samples = (0..400u64).map(|ms| {
            // The mean of the millisecond before.
            let s = 1e-3 * (ms as f32 - 0.5);
            Sample {
                emf_v: f32::NAN,
                time_us: 1000 * ms,
                position_counts: (angle_rad(1e-3 * ms as f32) / drivetrain.rad_per_count) as i32,
                current_a: torque_nm(s) / drivetrain.torque_per_ampere_nm,
                drive: Drive::Closing,
                joint: (),
            }
        });
        samples
            .filter_map(|sample| {
                let turn = meter.push(&sample, &drivetrain, SPEED_RAD_PER_S)?;
                Some((sample.time_us / 1000, turn))
            })
            .collect()
    }

    fn turn_rad() -> f32 {
        drivetrain().rotation_rad(0, drivetrain().counts_per_turn as i32)
    }

    #[test]
    fn what_repeats_with_the_turn_averages_out() {
        let angle = |s: f32| SPEED_RAD_PER_S * s;
        let wave = |s: f32| (core::f32::consts::TAU * angle(s) / turn_rad()).sin();
        let seen = turns(angle, |s| 0.5 + 0.1 * wave(s));
        assert!(seen.len() > 300, "{}", seen.len());
        for (ms, turn) in &seen[40..] {
            let torque_nm = turn.block.drive_torque_nm;
            assert!((torque_nm - 0.5).abs() < 5e-3, "{ms} ms: {turn:?}");
            assert!((turn.before_nm - 0.5).abs() < 5e-3 && !turn.is_short);
        }
    }

    #[test]
    fn what_accelerates_the_motor_is_no_load() {
        let inertia = drivetrain().inertia_kg_m2;
        // From 0.3 to 0.36 rad/s within 60 ms.
        let change = |s: f32| (s - 0.2).clamp(0.0, 0.06);
        let angle = |s: f32| {
            let c = change(s);
            SPEED_RAD_PER_S * s + 0.5 * c * c + 0.06 * (s - 0.26).max(0.0)
        };
        let accelerates = |s: f32| (0.2..0.26).contains(&s);
        let torque = |s: f32| 0.4 + if accelerates(s) { inertia } else { 0.0 };
        for (ms, turn) in turns(angle, torque) {
            let torque_nm = turn.block.drive_torque_nm;
            assert!((torque_nm - 0.4).abs() < 0.4 * inertia, "{ms} ms: {turn:?}");
        }
    }

    #[test]
    fn a_jump_grows_over_a_turn_against_the_turn_before() {
        let seen = turns(|s| SPEED_RAD_PER_S * s, |s| if s < 0.2 { 0.5 } else { 0.3 });
        let turn_ms = 1e3 * turn_rad() / SPEED_RAD_PER_S;
        let change = |at_ms: f32| {
            let (_, turn) = seen.iter().find(|(ms, _)| *ms as f32 >= at_ms).unwrap();
            turn.block.drive_torque_nm - turn.before_nm
        };
        assert!(change(199.0).abs() < 5e-3);
        assert!((change(200.0 + 0.5 * turn_ms) + 0.1).abs() < 0.02);
        assert!((change(201.0 + turn_ms) + 0.2).abs() < 0.02);
        assert!(change(202.0 + 2.0 * turn_ms).abs() < 0.02);
    }

    #[test]
    fn a_motor_that_slows_down_gives_less_than_a_turn() {
        let seen = turns(|s| SPEED_RAD_PER_S * s.min(0.2), |_| 0.5);
        let last = seen.last().expect("turns").1;
        assert!(last.is_short && last.block.width_counts == 0, "{last:?}");
        assert!(!seen[100].1.is_short);
    }

    #[test]
    fn a_gap_or_a_bad_current_begins_anew() {
        let bad = turns(
            |s| SPEED_RAD_PER_S * s,
            |s| {
                if (0.2..0.201).contains(&s) {
                    f32::NAN
                } else {
                    0.5
                }
            },
        );
        assert!(
            bad.iter()
                .all(|(_, turn)| turn.block.drive_torque_nm.is_finite())
        );
        assert!(bad.iter().all(|(ms, _)| !(201..210).contains(ms)));
    }
}
