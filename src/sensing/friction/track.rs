//! Friction in one direction, bin by bin.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

/// Number of bins over the travel: at 1.6 rad a bin is 1/25 of a turn of the worm (0.3 rad with 20:1), and two or three
/// turns of the motor wide.
pub const BINS: usize = 128;

/// Friction in one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Mean torque in each bin, newton metre, positive when it closes.
    #[serde(with = "BigArray")]
    pub torque_nm: [f32; BINS],
    /// Passes that went into each bin; 0 marks one without a value.
    #[serde(with = "BigArray")]
    pub passes: [u8; BINS],
    /// Noise of the torque: variance of its mean over a way, times that way, newton metre squared counts.
    pub noise_nm2_counts: f32,
}

impl Track {
    /// Without any value.
    pub(super) const EMPTY: Self = Self {
        torque_nm: [0.0; BINS],
        passes: [0; BINS],
        noise_nm2_counts: 0.0,
    };

    pub(super) fn is_valid(&self) -> bool {
        self.torque_nm.iter().all(|torque| torque.is_finite())
            && (0.0..f32::MAX).contains(&self.noise_nm2_counts)
    }

    pub(super) fn bin(&self, index: usize) -> Option<f32> {
        match (self.torque_nm.get(index), self.passes.get(index)) {
            (Some(&torque), Some(&passes)) if passes > 0 => Some(torque),
            _ => None,
        }
    }

    /// Averages a value into a bin; the difference from what was there, if anything was.
    pub(super) fn fill(&mut self, index: usize, torque_nm: f32) -> Option<f32> {
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
