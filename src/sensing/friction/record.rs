//! The record of both directions, and what it says about a position.

use serde::{Deserialize, Serialize};

use super::track::{BINS, Track};
use crate::numeric::{Bounded, sqrt};
use crate::sensing::Drive;

/// Least share of the mean friction that the residual is taken to be: a record from one quiet pass is no proof.
const LEAST_RESIDUAL: f32 = 1e-3;

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
            closing: Track::EMPTY,
            opening: Track::EMPTY,
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
            .at_least(self.opening.noise_nm2_counts);
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
        let filled = |index| Some((index, track.bin(index)?));
        let (last, end) = (0..BINS).rev().find_map(filled)?;
        let end_counts = (last as f32 + 0.5) * self.bin_counts();
        let excess = counts as f32 - end_counts;
        if excess <= 0.0 {
            // Before the record's beginning, where the motion was not steady yet.
            let (_, first) = (0..BINS).find_map(filled)?;
            return Some((first, 0.0));
        }
        let period = period_counts as f32;
        // Whole periods that lead back into the record. A period of 0 never does.
        let mut periods = 1.0;
        while periods * period < excess && periods < 4.0 {
            periods += 1.0;
        }
        if periods < 4.0 {
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
    pub(super) fn index(&self, counts: i32) -> Option<usize> {
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
                .at_least(floor * floor * self.bin_counts()),
        )
    }
}
