//! Friction of the unloaded drivetrain over the angle of the input link, both ways, and how well it repeats.
//!
//! All torques here are motor torques seen from the input link as if nothing were lost: what the motor spends on a free
//! motion, the springs of the finger included where it has one at joint 1.

use crate::numeric::sqrt;
use crate::sensing::Drive;
use crate::sensing::block::Block;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Number of bins over the travel: at 1.6 rad a bin is 1/25 of a turn of the worm (0.3 rad with 20:1), and two or three
/// turns of the motor wide.
pub const BINS: usize = 128;

/// Blocks held back by the recorder.
const HELD: usize = 2;

/// Least share of the mean friction that the residual is taken to be: a record from one quiet pass is no proof.
const LEAST_RESIDUAL: f32 = 1e-3;

/// Friction in one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Mean torque in each bin, newton metre, positive when it closes.
    pub torque_nm: Vec<f32, BINS>,
    /// Passes that went into each bin; 0 marks one without a value.
    pub passes: Vec<u8, BINS>,
    /// Noise of the torque: variance of its mean over a way, times that way, newton metre squared counts.
    pub noise_nm2_counts: f32,
}

impl Track {
    fn empty() -> Self {
        Self {
            torque_nm: Vec::from_array([0.0; BINS]),
            passes: Vec::from_array([0; BINS]),
            noise_nm2_counts: 0.0,
        }
    }

    fn is_valid(&self) -> bool {
        self.torque_nm.len() == BINS
            && self.passes.len() == BINS
            && self.torque_nm.iter().all(|torque| torque.is_finite())
            && (0.0..f32::MAX).contains(&self.noise_nm2_counts)
    }

    fn bin(&self, index: usize) -> Option<f32> {
        match (self.torque_nm.get(index), self.passes.get(index)) {
            (Some(&torque), Some(&passes)) if passes > 0 => Some(torque),
            _ => None,
        }
    }

    /// Averages a value into a bin; the difference from what was there, if anything was.
    fn fill(&mut self, index: usize, torque_nm: f32) -> Option<f32> {
        let (torque, passes) = (self.torque_nm.get_mut(index)?, self.passes.get_mut(index)?);
        let difference = torque_nm - *torque;
        let filled = *passes > 0;
        *passes = passes.saturating_add(1);
        *torque += difference / f32::from(*passes);
        filled.then_some(difference)
    }

    /// Mean over the bins that have a value, newton metre; None without any.
    pub fn mean_nm(&self) -> Option<f32> {
        let (mut sum, mut count) = (0.0, 0u32);
        for index in 0..BINS {
            if let Some(torque) = self.bin(index) {
                sum += torque;
                count += 1;
            }
        }
        (count > 0).then(|| sum / count as f32)
    }

    /// Share of the bins that have a value, 0 to 1.
    pub fn coverage(&self) -> f32 {
        self.passes.iter().filter(|&&passes| passes > 0).count() as f32 / BINS as f32
    }
}

/// The record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Travel that the bins divide evenly, counts from the opening stop.
    pub travel_counts: i32,
    /// While closing.
    pub closing: Track,
    /// While opening.
    pub opening: Track,
}

impl Friction {
    /// Without any value, for a travel; at least one count a bin.
    pub fn empty(travel_counts: i32) -> Self {
        Self {
            travel_counts: travel_counts.max(BINS as i32),
            closing: Track::empty(),
            opening: Track::empty(),
        }
    }

    /// Whether every value is finite and in its range, as it must be after it was read from a memory.
    pub fn is_valid(&self) -> bool {
        self.travel_counts >= BINS as i32 && self.closing.is_valid() && self.opening.is_valid()
    }

    /// The track of a direction; None for [`Drive::Idle`].
    pub fn track(&self, drive: Drive) -> Option<&Track> {
        match drive {
            Drive::Closing => Some(&self.closing),
            Drive::Opening => Some(&self.opening),
            Drive::Idle => None,
        }
    }

    /// Standard deviation of what the record leaves unexplained in a bin, newton metre, the worse of both directions.
    pub fn residual_nm(&self) -> f32 {
        let noise = self
            .closing
            .noise_nm2_counts
            .max(self.opening.noise_nm2_counts);
        sqrt(noise / self.bin_counts())
    }

    /// Width of a bin, counts.
    pub fn bin_counts(&self) -> f32 {
        self.travel_counts as f32 / BINS as f32
    }

    /// Friction torque at a position, between the bins' centres linearly, newton metre. None outside the travel and where
    /// nothing was recorded.
    pub fn at(&self, drive: Drive, counts: i32) -> Option<f32> {
        let track = self.track(drive)?;
        let index = self.index(counts)?;
        let place = counts as f32 / self.bin_counts() - 0.5;
        let lower = if place < index as f32 {
            index.checked_sub(1)
        } else {
            Some(index)
        };
        let below = lower.and_then(|lower| track.bin(lower));
        let above = track.bin(lower.map_or(0, |lower| lower + 1));
        match (below, above) {
            (Some(below), Some(above)) => {
                let share = place - lower.unwrap_or(0) as f32;
                Some(below + share * (above - below))
            }
            // At either end of what was recorded.
            _ => track.bin(index),
        }
    }

    /// As [`Friction::at`]; beyond the end of the record it is continued with the period of the worm, `period_counts`,
    /// drifting on as it did over the last period (0: as at the end). With it how far that was, counts.
    pub fn beyond(&self, drive: Drive, counts: i32, period_counts: u32) -> Option<(f32, f32)> {
        if let Some(torque) = self.at(drive, counts) {
            return Some((torque, 0.0));
        }
        let track = self.track(drive)?;
        let last = (0..BINS).rev().find(|&index| track.bin(index).is_some())?;
        let end = track.bin(last)?;
        let end_counts = (last as f32 + 0.5) * self.bin_counts();
        let excess = counts as f32 - end_counts;
        if excess <= 0.0 {
            // Before the record's beginning, where the motion was not steady yet.
            let first = (0..BINS).find_map(|index| track.bin(index))?;
            return Some((first, 0.0));
        }
        let period = period_counts as f32;
        // Rounded up; `ceil` is not in core. A period of 0 gives more than is allowed below.
        let whole = (excess / period) as u32 as f32;
        let periods = if whole * period < excess {
            whole + 1.0
        } else {
            whole
        };
        if period_counts > 0 && periods < 4.0 {
            let back = counts as f32 - periods * period;
            let base = self.at(drive, back as i32);
            let before = self.at(drive, (end_counts - period) as i32);
            if let (Some(base), Some(before)) = (base, before) {
                return Some((base + periods * (end - before), excess));
            }
        }
        Some((end, excess))
    }

    /// Standard deviation of the friction over the travel, newton metre: how far it may be from the value at the end
    /// beyond what was recorded.
    pub fn unevenness_nm(&self, drive: Drive) -> Option<f32> {
        let track = self.track(drive)?;
        let mean = track.mean_nm()?;
        let (mut sum, mut count) = (0.0, 0u32);
        for torque in (0..BINS).filter_map(|index| track.bin(index)) {
            sum += (torque - mean) * (torque - mean);
            count += 1;
        }
        (count > 0).then(|| sqrt(sum / count as f32))
    }

    /// Bin of a position.
    fn index(&self, counts: i32) -> Option<usize> {
        if counts < 0 || counts >= self.travel_counts {
            return None;
        }
        Some(((counts as f32 / self.bin_counts()) as usize).min(BINS - 1))
    }

    /// Noise of a block's residual in a direction, as [`Track::noise_nm2_counts`]: divided by a way in counts it is the
    /// variance of the residual's mean over it. The table's own error is in it: it is as noisy as the motion that it was
    /// taken from.
    pub fn noise_nm2_counts(&self, drive: Drive) -> Option<f32> {
        let track = self.track(drive)?;
        let floor = LEAST_RESIDUAL * track.mean_nm()?;
        Some(
            2.0 * track
                .noise_nm2_counts
                .max(floor * floor * self.bin_counts()),
        )
    }
}

/// Mean over a stretch about as long as a bin.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    drive: Drive,
    index: usize,
    sum_counts: f32,
    sum_nm: f32,
    blocks: u16,
    way_counts: f32,
}

/// Where a stretch lies and what was measured over it.
#[derive(Clone, Copy, Debug)]
struct Node {
    counts: f32,
    torque_nm: f32,
    way_counts: f32,
}

impl Stretch {
    fn node(&self) -> Node {
        let blocks = f32::from(self.blocks.max(1));
        Node {
            counts: self.sum_counts / blocks,
            torque_nm: self.sum_nm / blocks,
            way_counts: self.way_counts,
        }
    }
}

/// Statistics of one direction.
#[derive(Clone, Copy, Debug, Default)]
struct Statistics {
    /// Squared deviations of a stretch from the line between its neighbours, as noise; what changes within a few bins
    /// counts as noise, rightly: interpolation does not follow it.
    rough_sum: f32,
    rough_count: u16,
    /// Differences between a pass and those before.
    count: u16,
    sum: f32,
    sum_of_squares: f32,
}

impl Statistics {
    fn rough(&mut self, first: &Node, middle: &Node, last: &Node) {
        let share = (middle.counts - first.counts) / (last.counts - first.counts);
        let deviation =
            middle.torque_nm - first.torque_nm - share * (last.torque_nm - first.torque_nm);
        let variances = 1.0 + share * share + (1.0 - share) * (1.0 - share);
        let noise = deviation * deviation / variances * middle.way_counts;
        if noise.is_finite() {
            self.rough_sum += noise;
            self.rough_count = self.rough_count.saturating_add(1);
        }
    }

    fn repeat(&mut self, difference: f32) {
        self.count = self.count.saturating_add(1);
        self.sum += difference;
        self.sum_of_squares += difference * difference;
    }

    /// The noise; None with too little to tell. A shift of a whole pass is not noise: the detector follows it.
    fn noise_nm2_counts(&self, bin_counts: f32) -> Option<f32> {
        if self.rough_count < 8 {
            return None;
        }
        let rough = self.rough_sum / f32::from(self.rough_count);
        if self.count < 16 {
            return Some(rough);
        }
        let count = f32::from(self.count);
        let mean = self.sum / count;
        // The difference of two passes has twice the variance of one.
        let repeat = 0.5 * (self.sum_of_squares / count - mean * mean) * bin_counts;
        Some(rough.max(repeat))
    }
}

/// Fills a record from free motion.
#[derive(Clone, Debug)]
pub struct Recorder {
    friction: Friction,
    stretch: Option<Stretch>,
    /// Blocks held back: those in which the motion came to its end are not free motion at a steady speed.
    held: [Option<Block>; HELD],
    /// The two stretches before, the last one first.
    nodes: [Option<Node>; 2],
    closing: Statistics,
    opening: Statistics,
}

impl Recorder {
    /// Starts a new record over a travel.
    pub fn new(travel_counts: i32) -> Self {
        Self {
            friction: Friction::empty(travel_counts),
            stretch: None,
            held: [None; HELD],
            nodes: [None; 2],
            closing: Statistics::default(),
            opening: Statistics::default(),
        }
    }

    /// Takes a block of free motion. One outside the travel is left out, and so are the last two of a run.
    pub fn push(&mut self, block: &Block) {
        let [first, second] = self.held;
        self.held = [second, Some(*block)];
        if let Some(block) = first {
            self.take(&block);
        }
    }

    fn take(&mut self, block: &Block) {
        let Some(index) = self.friction.index(block.counts) else {
            self.end_stretch();
            self.nodes = [None; 2];
            return;
        };
        if let Some(stretch) = &mut self.stretch {
            if stretch.index == index {
                stretch.sum_counts += block.counts as f32;
                stretch.sum_nm += block.drive_torque_nm;
                stretch.blocks = stretch.blocks.saturating_add(1);
                stretch.way_counts += block.width_counts as f32;
                return;
            } else {
                self.end_stretch();
            }
        }
        self.stretch = Some(Stretch {
            drive: block.drive,
            index,
            sum_counts: block.counts as f32,
            sum_nm: block.drive_torque_nm,
            blocks: 1,
            way_counts: block.width_counts as f32,
        });
    }

    /// The motion ended or turned round.
    pub fn end_run(&mut self) {
        self.held = [None; HELD];
        self.end_stretch();
        self.nodes = [None; 2];
    }

    /// Fills the bins whose centres lie between this stretch and the one before.
    fn end_stretch(&mut self) {
        let Some(stretch) = self.stretch.take() else {
            return;
        };
        let node = stretch.node();
        if !node.torque_nm.is_finite() {
            return;
        }
        let bin_counts = self.friction.bin_counts();
        let (track, statistics) = match stretch.drive {
            Drive::Closing => (&mut self.friction.closing, &mut self.closing),
            Drive::Opening => (&mut self.friction.opening, &mut self.opening),
            Drive::Idle => return,
        };
        let [before, first] = self.nodes;
        if let (Some(first), Some(middle)) = (&first, &before) {
            statistics.rough(first, middle, &node);
        }
        if let Some(before) = before {
            let (low, high) = if before.counts < node.counts {
                (before.counts, node.counts)
            } else {
                (node.counts, before.counts)
            };
            let from = (low / bin_counts - 0.5).max(0.0) as usize;
            // At most three: stretches are a bin apart, or two where one was left out.
            for index in from..BINS.min(from + 4) {
                let centre = (index as f32 + 0.5) * bin_counts;
                if centre > low && centre <= high {
                    let share = (centre - before.counts) / (node.counts - before.counts);
                    let torque_nm = before.torque_nm + share * (node.torque_nm - before.torque_nm);
                    if let Some(difference) = track.fill(index, torque_nm) {
                        statistics.repeat(difference);
                    }
                }
            }
        }
        self.nodes = [Some(node), before];
    }

    /// The record so far; None while either direction lacks the bins for its statistics.
    pub fn finish(&mut self) -> Option<Friction> {
        self.end_run();
        let mut friction = self.friction.clone();
        let bin_counts = friction.bin_counts();
        friction.closing.noise_nm2_counts = self.closing.noise_nm2_counts(bin_counts)?;
        friction.opening.noise_nm2_counts = self.opening.noise_nm2_counts(bin_counts)?;
        Some(friction)
    }

    /// Share of the travel that has been covered both ways, 0 to 1.
    pub fn coverage(&self) -> f32 {
        self.friction
            .closing
            .coverage()
            .min(self.friction.opening.coverage())
    }
}
