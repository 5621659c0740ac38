//! Friction of the unloaded drivetrain over the angle of the input link, both ways, and how well it repeats.
//!
//! All torques here are motor torques seen from the input link as if nothing were lost: what the motor spends on a free
//! motion, the springs of the finger included where it has one at joint 1.

use crate::numeric::sqrt;
use crate::sensing::Drive;
use crate::sensing::block::Block;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Number of bins over the travel: at 1.6 rad a bin is an eighth of a worm's tooth pitch or finer (0.3 rad with 20:1),
/// and half a dozen blocks wide, which average the motor's own turns.
pub const BINS: usize = 128;

/// Least share of the mean friction that the residual is taken to be: a record from one quiet pass is no proof.
const LEAST_RESIDUAL: f32 = 1e-3;

/// Friction in one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Mean torque in each bin, newton metre, positive when it closes.
    pub torque_nm: Vec<f32, BINS>,
    /// Passes that went into each bin; 0 marks one without a value.
    pub passes: Vec<u8, BINS>,
    /// Variance of a bin's mean about what its neighbours, or another pass, tell, newton metre squared.
    pub variance_nm2: f32,
}

impl Track {
    fn empty() -> Self {
        Self {
            torque_nm: Vec::from_array([0.0; BINS]),
            passes: Vec::from_array([0; BINS]),
            variance_nm2: 0.0,
        }
    }

    fn is_valid(&self) -> bool {
        self.torque_nm.len() == BINS
            && self.passes.len() == BINS
            && self.torque_nm.iter().all(|torque| torque.is_finite())
            && (0.0..f32::MAX).contains(&self.variance_nm2)
    }

    fn bin(&self, index: usize) -> Option<f32> {
        match (self.torque_nm.get(index), self.passes.get(index)) {
            (Some(&torque), Some(&passes)) if passes > 0 => Some(torque),
            _ => None,
        }
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

    /// Variance of a bin about the mean of its neighbours, as if of one bin alone: (1 + 2/4) times its own. What changes
    /// within a few bins counts as noise, rightly: interpolation does not follow it.
    fn roughness_nm2(&self) -> Option<f32> {
        let (mut sum, mut count) = (0.0, 0u32);
        for index in 1..BINS - 1 {
            if let (Some(before), Some(here), Some(after)) =
                (self.bin(index - 1), self.bin(index), self.bin(index + 1))
            {
                let deviation = here - 0.5 * (before + after);
                sum += deviation * deviation;
                count += 1;
            }
        }
        (count >= 8).then(|| sum / (1.5 * count as f32))
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
        sqrt(self.closing.variance_nm2.max(self.opening.variance_nm2))
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

    /// As [`Friction::at`], beyond the ends of the travel the value at the end.
    pub fn near(&self, drive: Drive, counts: i32) -> Option<f32> {
        let track = self.track(drive)?;
        let inside = counts.clamp(0, self.travel_counts - 1);
        self.at(drive, inside).or_else(|| {
            let index = self.index(inside)?;
            // The nearest bin with a value.
            (1..BINS).find_map(|away| {
                index
                    .checked_sub(away)
                    .and_then(|i| track.bin(i))
                    .or_else(|| track.bin(index + away))
            })
        })
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

    /// Noise of the torque in a direction, as a variance of its mean over a way, times that way: newton metre squared
    /// counts. Divided by a way in counts it is the variance of the mean over it, the table's own error included: the
    /// table is as noisy as the motion that it is taken from.
    pub fn noise_nm2_counts(&self, drive: Drive) -> Option<f32> {
        let track = self.track(drive)?;
        let floor = LEAST_RESIDUAL * track.mean_nm()?;
        Some(2.0 * track.variance_nm2.max(floor * floor) * self.bin_counts())
    }
}

/// Mean over the bin that the finger is passing.
#[derive(Clone, Copy, Debug)]
struct Passing {
    drive: Drive,
    index: usize,
    sum_nm: f32,
    blocks: u16,
}

/// How a later pass differs from those before.
#[derive(Clone, Copy, Debug, Default)]
struct Repeat {
    count: u16,
    sum: f32,
    sum_of_squares: f32,
}

impl Repeat {
    fn add(&mut self, difference: f32) {
        self.count = self.count.saturating_add(1);
        self.sum += difference;
        self.sum_of_squares += difference * difference;
    }

    /// Variance of a bin's mean in one pass: the difference of two has twice that. A shift of the whole pass is not
    /// noise: the detector follows it.
    fn variance(&self) -> Option<f32> {
        if self.count < 16 {
            return None;
        }
        let count = f32::from(self.count);
        let mean = self.sum / count;
        Some((0.5 * (self.sum_of_squares / count - mean * mean)).max(0.0))
    }
}

/// Fills a record from free motion.
#[derive(Clone, Debug)]
pub struct Recorder {
    friction: Friction,
    passing: Option<Passing>,
    closing: Repeat,
    opening: Repeat,
}

impl Recorder {
    /// Starts a new record over a travel.
    pub fn new(travel_counts: i32) -> Self {
        Self {
            friction: Friction::empty(travel_counts),
            passing: None,
            closing: Repeat::default(),
            opening: Repeat::default(),
        }
    }

    /// Takes a block of free motion. One outside the travel, or that fills no bin by half, is left out.
    pub fn push(&mut self, block: &Block) {
        let Some(index) = self.friction.index(block.counts) else {
            self.end_run();
            return;
        };
        if let Some(passing) = &mut self.passing
            && passing.drive == block.drive
            && passing.index == index
        {
            passing.sum_nm += block.drive_torque_nm;
            passing.blocks = passing.blocks.saturating_add(1);
            return;
        }
        self.end_run();
        self.passing = Some(Passing {
            drive: block.drive,
            index,
            sum_nm: block.drive_torque_nm,
            blocks: 1,
        });
    }

    /// The motion ended: what was collected of the bin at hand goes into the record.
    pub fn end_run(&mut self) {
        let Some(passing) = self.passing.take() else {
            return;
        };
        let mean = passing.sum_nm / f32::from(passing.blocks);
        let (track, repeat) = match passing.drive {
            Drive::Closing => (&mut self.friction.closing, &mut self.closing),
            Drive::Opening => (&mut self.friction.opening, &mut self.opening),
            Drive::Idle => return,
        };
        if let (Some(torque), Some(passes)) = (
            track.torque_nm.get_mut(passing.index),
            track.passes.get_mut(passing.index),
        ) && mean.is_finite()
        {
            if *passes > 0 {
                repeat.add(mean - *torque);
            }
            *passes = passes.saturating_add(1);
            *torque += (mean - *torque) / f32::from(*passes);
        }
    }

    /// The record so far; None while either direction lacks the bins for its statistics.
    pub fn finish(&mut self) -> Option<Friction> {
        self.end_run();
        let mut friction = self.friction.clone();
        for (track, repeat) in [
            (&mut friction.closing, &self.closing),
            (&mut friction.opening, &self.opening),
        ] {
            let roughness = track.roughness_nm2()?;
            track.variance_nm2 = repeat.variance().map_or(roughness, |v| v.max(roughness));
        }
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
