//! Averages samples over blocks of one motor turn of steady motion. Every estimate is made from blocks.
//!
//! The largest disturbances repeat with every turn of the motor: the commutator's ripple in the current, and the
//! encoder's periodic error, which the speed loop turns into current. Both average out over exactly one turn, so a block
//! ends at a count, if necessary within a sample, and not at a time (simulated: a tenth of the noise of blocks of 8 ms).
//! Blocks begin at the same positions in every motion, multiples of a turn, so that the remaining ripple repeats and is
//! recorded with the friction.
//!
//! The worm is self-locking and its friction depends on load and speed: the current shows the load only while the motor
//! turns steadily in the drive direction. Samples of a start, a reversal, the dead band after it or a change of speed are
//! dropped.

use crate::numeric::Bounded;
use crate::sensing::{Drive, Drivetrain, Sample, Settings};

/// Travel after a reversal that is not used, in nominal backlashes: more than one, because gears wear.
const DEAD_BAND: f32 = 1.5;
/// Number of blocks at the beginning of a run that determine its speed.
const REFERENCE_BLOCKS: u8 = 8;
/// After this many faster blocks in a row the run's speed is determined anew.
const FASTER_BLOCKS: u8 = 8;
/// Largest number of samples without drive between two blocks that does not end a run (chosen): gears may stick for a moment, and the speed
/// loop may brake for one.
const BRIDGED: u8 = 8;
/// A longer time without a sample discards the block, microseconds.
pub(super) const GAP_US: u32 = 5_000;

/// Means over one block of steady motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// End of the block, microseconds since boot.
    pub time_us: u64,
    /// Direction; never [`Drive::Idle`].
    pub drive: Drive,
    /// Encoder position in the middle of the block, counts.
    pub counts: i32,
    /// Distance travelled, counts, without sign.
    pub width_counts: u32,
    /// Distance of its end from where the motion began, counts; large where that is long ago.
    pub way_counts: i32,
    /// Duration, second.
    pub duration_s: f32,
    /// Torque of the motor at the input link without losses, newton metre; inertia and the viscous friction of a deviation from
    /// the nominal speed are already subtracted.
    pub drive_torque_nm: f32,
    /// Inertia torque that was subtracted, from the change of speed since the previous block, newton metre.
    pub inertia_nm: f32,
    /// Deviation from the nominal speed, as a share of it.
    pub overspeed: f32,
    /// Mean back-EMF, volt, closing positive; NaN where it is not known.
    pub emf_v: f32,
}

/// Result of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockUpdate {
    /// The block is not complete.
    Pending,
    /// A block of steady motion.
    Block(Block),
    /// The motion ended or turned round.
    Ended,
}

/// The last sample.
#[derive(Clone, Copy, Debug)]
struct Last {
    time_us: u64,
    counts: i32,
}

/// A run in one direction.
#[derive(Clone, Copy, Debug)]
struct Run {
    drive: Drive,
    start_counts: i32,
    /// Whether the run began with a reversal, so that the dead band must be crossed first.
    reversed: bool,
    /// Whether the backlash has been crossed.
    taken_up: bool,
    /// Speed over the previous block, if that one was adjacent.
    speed_rad_per_s: Option<f32>,
    /// Mean speed of the run's first blocks; `blocks` is their number.
    steady_rad_per_s: f32,
    blocks: u8,
    /// Faster blocks in a row.
    faster: u8,
    /// Samples without drive since the last block.
    idle: u8,
}

impl Run {
    /// Whether a block belongs to the run's steady motion. The first blocks determine the speed. A run that was slow at its
    /// beginning gets a new speed; one that slows down later is loaded, and the friction of a worm is different then.
    fn is_steady(&mut self, speed_rad_per_s: f32, tolerance: f32) -> bool {
        self.idle = 0;
        let ratio = speed_rad_per_s / self.steady_rad_per_s;
        if self.blocks == 0 || self.faster >= FASTER_BLOCKS {
            self.steady_rad_per_s = speed_rad_per_s;
            self.blocks = 1;
            self.faster = 0;
            return true;
        }
        self.faster = if ratio > 1.0 + tolerance {
            self.faster.saturating_add(1)
        } else {
            0
        };
        let steady = (ratio - 1.0).abs() <= tolerance;
        if steady && self.blocks < REFERENCE_BLOCKS {
            self.blocks += 1;
            self.steady_rad_per_s +=
                (speed_rad_per_s - self.steady_rad_per_s) / f32::from(self.blocks);
        }
        steady
    }
}

/// Sums over the block being filled.
#[derive(Clone, Copy, Debug)]
struct Sums {
    start_counts: i32,
    duration_us: f32,
    ampere_us: f32,
    emf_v_us: f32,
}

impl Sums {
    /// Adds a part of a sample.
    fn add<J>(&mut self, part_us: f32, sample: &Sample<J>) {
        self.duration_us += part_us;
        self.ampere_us += part_us * sample.current_a;
        self.emf_v_us += part_us * sample.emf_v;
    }
}

/// Averages samples into blocks.
#[derive(Clone, Debug, Default)]
pub struct BlockAverager {
    last: Option<Last>,
    run: Option<Run>,
    /// Direction in which the gears last had contact.
    in_touch: Option<Drive>,
    sums: Option<Sums>,
}

impl BlockAverager {
    /// Takes a sample. A sample with a repeated or earlier time is ignored, and so is one whose current is NaN.
    pub fn push<J>(
        &mut self,
        sample: &Sample<J>,
        drivetrain: &Drivetrain,
        settings: &Settings,
    ) -> BlockUpdate {
        let now = Last {
            time_us: sample.time_us,
            counts: sample.position_counts,
        };
        let Some(last) = self.last else {
            self.last = Some(now);
            return BlockUpdate::Pending;
        };
        if now.time_us <= last.time_us {
            return BlockUpdate::Pending;
        }
        self.last = Some(now);
        let before = self.run.as_ref().map(|run| run.drive);
        let driven = (sample.drive != Drive::Idle).then_some(sample.drive);
        let idle = driven.is_none() as u8;
        let is_bridged = self.run.as_mut().is_some_and(|run| {
            run.idle += idle;
            idle > 0 && run.idle <= BRIDGED
        });
        if before != driven && !is_bridged {
            self.sums = None;
            self.run = driven.map(|drive| Run {
                drive,
                start_counts: last.counts,
                reversed: self.in_touch != driven,
                taken_up: false,
                speed_rad_per_s: None,
                steady_rad_per_s: 0.0,
                blocks: 0,
                faster: 0,
                idle: 0,
            });
            if before.is_some() {
                return BlockUpdate::Ended;
            }
        }
        let elapsed_us = now.time_us.wrapping_sub(last.time_us);
        if is_bridged || elapsed_us > u64::from(GAP_US) || !sample.current_a.is_finite() {
            self.breach();
            return BlockUpdate::Pending;
        }
        // The difference is at most the gap, so f32 holds it exactly.
        let elapsed_us = elapsed_us as u32 as f32;
        self.collect(now, last, elapsed_us, sample, drivetrain, settings)
    }

    /// Whether the block being filled follows another of steady motion.
    pub fn is_adjacent(&self) -> bool {
        (self.run.as_ref()).is_some_and(|run| run.speed_rad_per_s.is_some())
    }

    /// Counts the way of a closing from the opening stop on: while the finger backs off from a press on it, the cable takes up its load.
    pub fn leave_stop(&mut self) {
        if let Some(run) = &mut self.run {
            run.start_counts = run.start_counts.max(0);
            run.taken_up = false;
        }
        self.sums = None;
    }

    /// Drops the block being filled.
    fn breach(&mut self) {
        self.sums = None;
        if let Some(run) = &mut self.run {
            run.speed_rad_per_s = None;
        }
    }

    fn collect<J>(
        &mut self,
        now: Last,
        last: Last,
        elapsed_us: f32,
        sample: &Sample<J>,
        drivetrain: &Drivetrain,
        settings: &Settings,
    ) -> BlockUpdate {
        let Some(run) = &mut self.run else {
            return BlockUpdate::Pending;
        };
        let sign = if run.drive == Drive::Opening { -1 } else { 1 };
        let forward = |from: i32, to: i32| to.wrapping_sub(from).wrapping_mul(sign);
        if !run.taken_up {
            let way_rad = forward(run.start_counts, now.counts) as f32 * drivetrain.rad_per_count;
            let dead_rad = if run.reversed {
                DEAD_BAND * drivetrain.backlash_rad
            } else {
                0.0
            };
            if way_rad >= dead_rad {
                self.in_touch = Some(run.drive);
            }
            run.taken_up = way_rad >= settings.settle_rad.at_least(dead_rad);
            return BlockUpdate::Pending;
        }
        let turn_counts = drivetrain.counts_per_turn.max(1) as i32;
        let Some(sums) = &mut self.sums else {
            // The first block begins where this sample passes a multiple of a turn.
            let start_counts = next_multiple(last.counts, turn_counts, sign);
            let way = forward(last.counts, now.counts);
            let before = forward(last.counts, start_counts);
            if before <= way && way < turn_counts {
                let mut sums = Sums {
                    start_counts,
                    duration_us: 0.0,
                    ampere_us: 0.0,
                    emf_v_us: 0.0,
                };
                let share = (way - before) as f32 / way.max(1) as f32;
                sums.add(share * elapsed_us, sample);
                self.sums = Some(sums);
            }
            return BlockUpdate::Pending;
        };
        let after = forward(sums.start_counts, now.counts);
        if after < turn_counts {
            sums.add(elapsed_us, sample);
            return BlockUpdate::Pending;
        }
        // The turn ends within this sample: `after` is at least a turn, `before` is less.
        let before = forward(sums.start_counts, last.counts);
        let share =
            (turn_counts.saturating_sub(before)) as f32 / (after.saturating_sub(before)) as f32;
        let mut done = *sums;
        done.add(share * elapsed_us, sample);
        let end_counts = done
            .start_counts
            .wrapping_add(turn_counts.wrapping_mul(sign));
        let mut next = Sums {
            start_counts: end_counts,
            duration_us: 0.0,
            ampere_us: 0.0,
            emf_v_us: 0.0,
        };
        next.add((1.0 - share) * elapsed_us, sample);
        // More than two turns in a sample is a jump of the counter, not motion.
        self.sums = (after < turn_counts.saturating_mul(2)).then_some(next);
        let duration_s = done.duration_us * 1e-6;
        let speed_rad_per_s = turn_counts as f32 * drivetrain.rad_per_count / duration_s;
        let deviation = speed_rad_per_s - settings.speed_rad_per_s;
        if !(self.sums.is_some() && run.is_steady(speed_rad_per_s, settings.speed_tolerance)) {
            run.speed_rad_per_s = None;
            return BlockUpdate::Pending;
        }
        let Some(before) = run.speed_rad_per_s.replace(speed_rad_per_s) else {
            return BlockUpdate::Pending;
        };
        let acceleration = (speed_rad_per_s - before) / duration_s;
        let direction = sign as f32;
        let inertia_nm = direction * drivetrain.inertia_kg_m2 * acceleration;
        let viscous_nm = direction * drivetrain.viscous_nm_s_per_rad * deviation;
        let motor_nm = drivetrain.torque_per_ampere_nm * done.ampere_us / done.duration_us;
        BlockUpdate::Block(Block {
            time_us: now.time_us,
            drive: run.drive,
            counts: done
                .start_counts
                .wrapping_add((turn_counts / 2).wrapping_mul(sign)),
            width_counts: turn_counts.unsigned_abs(),
            way_counts: forward(run.start_counts, now.counts),
            duration_s,
            drive_torque_nm: motor_nm - inertia_nm - viscous_nm,
            inertia_nm,
            overspeed: deviation / settings.speed_rad_per_s,
            emf_v: done.emf_v_us / done.duration_us,
        })
    }
}

/// The first multiple of a turn at or beyond a position in the direction of a motion.
// Not inlined: 40 bytes of flash less.
#[inline(never)]
fn next_multiple(counts: i32, turn_counts: i32, sign: i32) -> i32 {
    let along = counts.wrapping_mul(sign);
    let past = (along.unsigned_abs() % turn_counts.unsigned_abs().max(1)) as i32;
    // Before zero the remainder is itself what is missing.
    let missing = if along < 0 || past == 0 {
        past
    } else {
        turn_counts - past
    };
    counts.wrapping_add(missing.wrapping_mul(sign))
}
