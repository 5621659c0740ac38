//! Where a record lies that was taken with another zero of the encoder.
//!
//! A restart finds a new zero at the opening stop, some milliradians beside the old one, and friction goes up and down with
//! the turn of the worm: the record must be shifted by what the zeros differ, or leaves what passes for a contact, or for
//! less than friction. The first free motion of a closing tells by how much: of some shifts tried side by side, the one at
//! which the difference from the record varies least, and between it and its neighbours by a parabola.

use super::Friction;
use crate::numeric::{clamp, sqrt};
use crate::sensing::block::Block;
use crate::sensing::{Drive, Drivetrain};

/// Two homings on the same stop differ by less, radian.
const REACH_RAD: f32 = 0.025;
/// Shifts tried.
const SHIFTS: usize = 21;
/// Free motion that is compared, radian: most of a turn of the worm (0.3 rad), and over before a finger that was opened
/// meets what stands in its way.
const WAY_RAD: f32 = 0.2;
/// A variance of so many times the noise's is no free motion, or no motion that the record knows.
const UNLIKE: f32 = 4.0;

/// What the motion so far tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aligned {
    /// Too little yet.
    Pending,
    /// A position on the new zero's scale and this many counts make one on the record's.
    By(i32),
    /// The record fits at no shift.
    Nowhere {
        /// Standard deviation of what is left at the best one, newton metre.
        misfit_nm: f32,
    },
}

/// Mean and sum of squared deviations of what a shift leaves.
#[derive(Clone, Copy, Debug)]
struct Left {
    mean_nm: f32,
    square_nm2: f32,
}

/// A comparison under way.
#[derive(Clone, Debug)]
pub struct Alignment {
    blocks: u16,
    left: [Left; SHIFTS],
}

impl Default for Alignment {
    fn default() -> Self {
        Self {
            blocks: 0,
            left: const {
                [Left {
                    mean_nm: 0.0,
                    square_nm2: 0.0,
                }; SHIFTS]
            },
        }
    }
}

/// Counts between two shifts.
fn step_counts(drivetrain: &Drivetrain) -> f32 {
    2.0 * REACH_RAD / (SHIFTS - 1) as f32 / drivetrain.rad_per_count
}

/// The shift of an index, counts.
fn shift_counts(index: f32, drivetrain: &Drivetrain) -> i32 {
    ((index - (SHIFTS / 2) as f32) * step_counts(drivetrain)) as i32
}

impl Alignment {
    /// Takes a block of a closing. One that the record does not reach at every shift is left out.
    #[inline(never)]
    pub fn push(&mut self, friction: &Friction, block: &Block, drivetrain: &Drivetrain) -> Aligned {
        let mut left = self.left;
        self.blocks = self.blocks.saturating_add(1);
        let share = 1.0 / f32::from(self.blocks);
        for (index, left) in left.iter_mut().enumerate() {
            let counts = block.counts + shift_counts(index as f32, drivetrain);
            let Some(torque_nm) = friction.at(Drive::Closing, counts) else {
                self.blocks -= 1;
                return Aligned::Pending;
            };
            let deviation = block.drive_torque_nm - torque_nm - left.mean_nm;
            left.mean_nm += share * deviation;
            left.square_nm2 += (1.0 - share) * deviation * deviation;
        }
        self.left = left;
        let way_counts = f32::from(self.blocks) * block.width_counts as f32;
        if way_counts * drivetrain.rad_per_count < WAY_RAD {
            return Aligned::Pending;
        }
        self.best(friction, block.width_counts, drivetrain)
    }

    fn best(&self, friction: &Friction, width_counts: u32, drivetrain: &Drivetrain) -> Aligned {
        let (mut best, mut least) = (0, f32::INFINITY);
        for (index, left) in self.left.iter().enumerate() {
            if left.square_nm2 < least {
                (best, least) = (index, left.square_nm2);
            }
        }
        let variance_nm2 = least / f32::from(self.blocks.max(2) - 1);
        let noise_nm2 =
            friction.noise_nm2_counts(Drive::Closing).unwrap_or(0.0) / width_counts.max(1) as f32;
        let square = |index: usize| self.left.get(index).map(|left| left.square_nm2);
        // At either end the least may lie beyond.
        let (Some(below), Some(above), true) = (
            best.checked_sub(1).and_then(square),
            square(best + 1),
            variance_nm2 <= UNLIKE * noise_nm2,
        ) else {
            return Aligned::Nowhere {
                misfit_nm: sqrt(variance_nm2),
            };
        };
        // Neither is below the least, and the first is above it.
        let beside = 0.5 * (below - above) / (below - 2.0 * least + above);
        Aligned::By(shift_counts(
            best as f32 + clamp(beside, -0.5, 0.5),
            drivetrain,
        ))
    }
}
