//! Where a record lies that was taken with another zero of the encoder.
//!
//! A restart finds a new zero at the opening stop, some milliradians beside the old one, and friction goes up and down with
//! the turn of the worm: the record must be shifted by what the zeros differ, or leaves what passes for a contact, or for
//! less than friction. The first free motion of a closing tells by how much. Of some shifts tried side by side that one is
//! taken which the squares of what it leaves (less their mean: a level that is off is no shift) and the homings' spread make
//! the likeliest, and between it and its neighbours the lowest point of a parabola. Where friction is even, nothing bends
//! the squares, and the spread keeps the shift small.
//!
//! A motion that no shift explains is no free one, or the record is of no use: that shows after some blocks, long before the
//! motor has pressed hard.

use super::Friction;
use crate::numeric::{Bounded, clamp, sqrt};
use crate::sensing::Drivetrain;
use crate::sensing::block::Block;

/// Farthest shift tried, radian: two homings on the same stop differ by less than 25 mrad.
const REACH_RAD: f32 = 0.03;
/// Shifts tried.
const SHIFTS: usize = 25;
/// Standard deviation of the difference of two homings, radian (R, chosen: a third of what they differ by at most).
const SPREAD_RAD: f32 = 0.008;
/// Free motion that is compared, radian: most of a turn of the worm (0.3 rad).
const WAY_RAD: f32 = 0.2;
/// Squares of so many variances a block, and as many blocks more, are no free motion, or none that the record knows. Free
/// motion has one a block.
const UNLIKE: f32 = 4.0;
const MORE_BLOCKS: f32 = 6.0;

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

/// Mean of what a shift leaves, and the sum of squared deviations from it.
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

/// The shift of an index, radian.
fn shift_rad(index: f32) -> f32 {
    REACH_RAD * (index / (SHIFTS / 2) as f32 - 1.0)
}

/// The same, counts.
fn shift_counts(index: f32, drivetrain: &Drivetrain) -> i32 {
    (shift_rad(index) / drivetrain.rad_per_count) as i32
}

impl Alignment {
    /// Takes a block of a closing. One that the record does not reach at every shift is left out.
    #[inline(never)]
    pub fn push(&mut self, friction: &Friction, block: &Block, drivetrain: &Drivetrain) -> Aligned {
        let at = |index: usize| {
            let shift = shift_counts(index as f32, drivetrain);
            let known = friction.at(block.counts.wrapping_add(shift));
            known.map(|known| known.torque_nm)
        };
        // Between the first shift and the last there is no gap in a record.
        let known = at(0).is_some() && at(SHIFTS - 1).is_some();
        if !(known && block.drive_torque_nm.is_finite()) {
            return Aligned::Pending;
        }
        self.blocks = self.blocks.saturating_add(1);
        let blocks = f32::from(self.blocks);
        for (index, left) in self.left.iter_mut().enumerate() {
            let Some(torque_nm) = at(index) else {
                continue;
            };
            let deviation_nm = block.drive_torque_nm - torque_nm - left.mean_nm;
            left.mean_nm += deviation_nm / blocks;
            left.square_nm2 += (1.0 - 1.0 / blocks) * deviation_nm * deviation_nm;
        }
        let width_counts = block.width_counts.max(1) as f32;
        // The record's own noise is in it: as noisy as the motion that it was taken from. So is what has wandered since.
        let speed_rad_per_s = width_counts * drivetrain.rad_per_count / block.duration_s;
        let wandered_nm = friction.wander(speed_rad_per_s).rms_nm;
        let noise_nm2 = 2.0 * friction.white_nm2(block.duration_s) + wandered_nm * wandered_nm;
        let over = blocks * width_counts * drivetrain.rad_per_count >= WAY_RAD;
        self.judge(noise_nm2, blocks, over, drivetrain)
    }

    fn judge(&self, noise_nm2: f32, blocks: f32, over: bool, drivetrain: &Drivetrain) -> Aligned {
        // Twice the negative logarithm of the likelihood, but for a constant.
        let cost = |index: usize| {
            let spreads = shift_rad(index as f32) / SPREAD_RAD;
            let left = self.left.get(index)?;
            Some(left.square_nm2 / noise_nm2 + spreads * spreads)
        };
        let (mut best, mut least) = (SHIFTS / 2, f32::INFINITY);
        for index in 0..SHIFTS {
            match cost(index) {
                Some(cost) if cost < least => (best, least) = (index, cost),
                _ => {}
            }
        }
        // Of a cost that is no number none is the least, which is infinite then.
        if least > UNLIKE * (blocks + MORE_BLOCKS) {
            return Aligned::Nowhere {
                misfit_nm: sqrt(least * noise_nm2 / blocks).at_most(f32::MAX),
            };
        }
        if !over {
            return Aligned::Pending;
        }
        let beside = match (best.checked_sub(1).and_then(cost), cost(best + 1)) {
            // Neither is below the least, and one of them at least is above it.
            (Some(below), Some(above)) => clamp(
                0.5 * (below - above) / (below - 2.0 * least + above),
                -0.5,
                0.5,
            ),
            _ => 0.0,
        };
        Aligned::By(shift_counts(best as f32 + beside, drivetrain))
    }
}
