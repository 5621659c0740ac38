//! How well the friction of one direction repeats.

use crate::numeric::Bounded;

/// Where a stretch lies and what was measured over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) counts: f32,
    pub(super) torque_nm: f32,
    pub(super) way_counts: f32,
}

/// Statistics of one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Statistics {
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
    pub(super) fn rough(&mut self, first: &Node, middle: &Node, last: &Node) {
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

    pub(super) fn repeat(&mut self, difference: f32) {
        self.count = self.count.saturating_add(1);
        self.sum += difference;
        self.sum_of_squares += difference * difference;
    }

    /// The noise; None with too little to tell. A shift of a whole pass is not noise: the detector follows it.
    pub(super) fn noise_nm2_counts(&self, bin_counts: f32) -> Option<f32> {
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
        Some(rough.at_least(repeat))
    }
}
