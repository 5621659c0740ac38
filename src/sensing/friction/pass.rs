//! Bins of one free motion in one direction.

use super::Friction;
use super::bins::{BINS, Bins};
use crate::sensing::Drive;
use crate::sensing::block::Block;

/// Blocks at the end that are not used, because the motion was ending.
const HELD: usize = 2;

/// A free motion, bin by bin: torque minus that of the record.
#[derive(Clone, Debug)]
pub struct Pass {
    pub(super) drive: Drive,
    /// Torque in the direction of motion minus the record's, newton metre; a bin counts its blocks.
    pub(super) bins: Bins,
    /// Sum and number of squared second differences of adjacent blocks: white noise without slow changes.
    square_sum_nm2: f32,
    squares: u16,
    duration_s: f32,
    blocks: u16,
    width_counts: u32,
    held: [Option<(i32, f32, f32)>; HELD],
    /// The last two blocks taken.
    last: [Option<(i32, f32)>; 2],
}

impl Pass {
    /// An empty pass in one direction.
    pub const fn new(drive: Drive) -> Self {
        Self {
            drive,
            bins: Bins::EMPTY,
            square_sum_nm2: 0.0,
            squares: 0,
            duration_s: 0.0,
            blocks: 0,
            width_counts: 0,
            held: [None; HELD],
            last: [None; 2],
        }
    }

    /// Takes a block at a position of the record; `known_nm` is the record's torque there while closing.
    pub fn push(&mut self, record: &Friction, counts: i32, block: &Block, known_nm: f32) {
        let sign = if self.drive == Drive::Opening {
            -1.0
        } else {
            1.0
        };
        let torque_nm = sign * block.drive_torque_nm - known_nm;
        let [first, second] = self.held;
        self.held = [second, Some((counts, torque_nm, block.duration_s))];
        if let Some((counts, torque_nm, duration_s)) = first {
            self.take(record, counts, torque_nm, duration_s, block.width_counts);
        }
    }

    fn take(
        &mut self,
        record: &Friction,
        counts: i32,
        torque_nm: f32,
        duration_s: f32,
        width: u32,
    ) {
        let Some(index) = record.index(counts) else {
            return;
        };
        if !torque_nm.is_finite() || self.bins.count.get(index) == Some(&u8::MAX) {
            return;
        }
        self.bins.add(index, torque_nm);
        self.duration_s += duration_s;
        self.width_counts = width;
        self.blocks = self.blocks.saturating_add(1);
        let near = |from: i32, to: i32| to.abs_diff(from) == width;
        if let [Some((middle, middle_nm)), Some((far, far_nm))] = self.last
            && near(far, middle)
            && near(middle, counts)
        {
            let difference = torque_nm - 2.0 * middle_nm + far_nm;
            self.square_sum_nm2 += difference * difference / 6.0;
            self.squares = self.squares.saturating_add(1);
        }
        self.last = [Some((counts, torque_nm)), self.last[0]];
    }

    /// Drops what was measured beyond a position, where a contact may have begun.
    pub fn cut(&mut self, record: &Friction, counts: i32) {
        self.held = [None; HELD];
        let from = record.index(counts.max(0)).unwrap_or(BINS);
        for count in self.bins.count.iter_mut().skip(from) {
            *count = 0;
        }
    }

    /// Bins with a value.
    pub fn filled(&self) -> usize {
        self.bins.filled()
    }

    /// Direction of the motion.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Mean duration of a block, second.
    pub(super) fn block_s(&self) -> f32 {
        self.duration_s / f32::from(self.blocks.max(1))
    }

    /// Mean speed, radian per second.
    pub(super) fn speed_rad_per_s(&self, rad_per_count: f32) -> f32 {
        self.width_counts as f32 * rad_per_count / self.block_s()
    }

    /// Variance of the white noise of a block by second differences, newton metre squared, and the degrees of freedom that
    /// of that estimate: adjacent differences share blocks, which leaves 18 of 35.
    pub(super) fn white_nm2(&self) -> (f32, f32) {
        let squares = f32::from(self.squares);
        let mean = self.square_sum_nm2 / f32::from(self.squares.max(1));
        (mean, squares * (18.0 / 35.0))
    }
}
