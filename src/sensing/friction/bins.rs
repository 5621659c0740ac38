//! Means over the bins that divide the travel, with the number of measurements in each.

use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Number of bins over the travel. Each is a whole number of motor turns wide: at 1.5 rad three turns, 1/21 of a turn of the
/// worm.
pub const BINS: usize = 128;

/// Means, bin by bin.
#[derive(Clone, Debug, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Bins {
    /// Mean in each bin.
    pub mean: [f32; BINS],
    /// Number of measurements in each; 0 marks a bin without a value.
    pub count: [u8; BINS],
}

impl Bins {
    /// Bins without a value.
    pub const EMPTY: Self = Self {
        mean: [0.0; BINS],
        count: [0; BINS],
    };

    /// Mean of a bin; None if it has no value.
    pub fn get(&self, index: usize) -> Option<f32> {
        match (self.mean.get(index), self.count.get(index)) {
            (Some(&mean), Some(&count)) if count > 0 => Some(mean),
            _ => None,
        }
    }

    /// Adds a measurement to a bin's mean.
    pub(super) fn add(&mut self, index: usize, value: f32) {
        let slots = (self.mean.get_mut(index), self.count.get_mut(index));
        if let (Some(mean), Some(count)) = slots {
            *count = count.saturating_add(1);
            *mean += (value - *mean) / f32::from(*count);
        }
    }

    /// First and last bin with a value.
    pub fn ends(&self) -> Option<(usize, usize)> {
        let filled = |count: &u8| *count > 0;
        let first = self.count.iter().position(filled)?;
        let last = self.count.iter().rposition(filled)?;
        Some((first, last))
    }

    /// Number of bins with a value.
    pub fn filled(&self) -> usize {
        self.count.iter().filter(|&&count| count > 0).count()
    }

    /// Mean over the bins that have a value; None without any.
    pub fn mean(&self) -> Option<f32> {
        let values = (0..BINS).filter_map(|index| self.get(index));
        let filled = self.filled();
        (filled > 0).then(|| values.sum::<f32>() / filled as f32)
    }

    pub(super) fn is_valid(&self) -> bool {
        self.mean.iter().all(|mean| mean.is_finite())
    }
}
