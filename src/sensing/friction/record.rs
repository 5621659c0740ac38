//! The friction record: torque of a free motion over the position.

use super::bins::{BINS, Bins};
use super::harmonics::{self, HARMONICS};
use super::wander::{Evidence, Wander};
use crate::numeric::{Bounded, dot, sin_cos, sqrt};
use crate::sensing::Drivetrain;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Half the width over which the curve is smoothed, radian. Faster changes are noise, or belong to the worm, which has terms of
/// its own.
const SMOOTHING_RAD: f32 = 0.12;
/// Largest extrapolation beyond the last bin, turns of the worm.
const BEYOND_TURNS: f32 = 4.0;
/// Smallest determinant of the normal equations of a quadratic, as a share of the cube of the weights' sum. Three neighbouring bins in the
/// narrowest window have 1e-5; with two it is zero but for rounding.
const SINGULAR: f32 = 1e-6;

/// Free motion as it was recorded: friction torque of the motor, the free torque of the finger included, over the angle of
/// the input link. Plain data: valid after a restart with another zero, once aligned.
#[derive(Clone, Debug, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Friction {
    /// Recorded travel, counts from the opening stop.
    pub travel_counts: i32,
    /// Width of a bin, counts: whole turns of the motor.
    pub bin_counts: u32,
    /// Counts per turn of the worm; 0 for no worm.
    pub worm_counts: u32,
    /// Rotation of the input link per count, radian.
    pub rad_per_count: f32,
    /// Speed of the recording, radian per second.
    pub speed_rad_per_s: f32,
    /// Torque while closing, newton metre, without the worm's harmonics; a bin counts its passes.
    pub closing_nm: Bins,
    /// The worm's harmonics: amplitudes of cosine and sine of its angle and of multiples of it, newton metre.
    pub worm_nm: [f32; 2 * HARMONICS],
    /// Mean torque while opening, newton metre, negative; 0 before it is known.
    pub opening_nm: f32,
    /// Torque of closing minus that of opening, each in its direction of motion: amplitudes of the cosine and the sine of the angle
    /// from the opening stop, newton metre; 0 before it is known. Friction is the same in both directions, weight and springs are
    /// not, and a weight's torque is such a wave.
    pub asymmetry_nm: [f32; 2],
    /// White noise of a block's torque: variance times the duration of the block, newton metre squared second.
    pub white_nm2_s: f32,
    /// Evidence from free passes on the wander.
    pub evidence: Evidence,
}

/// The record at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Torque while closing, newton metre.
    pub torque_nm: f32,
    /// The same without the worm's harmonics, newton metre.
    pub smooth_nm: f32,
    /// Variance of the torque from the noise of the record, newton metre squared.
    pub variance_nm2: f32,
    /// How far beyond the record the position is, counts.
    pub beyond_counts: f32,
}

impl Friction {
    /// An empty record for a travel.
    pub fn empty(travel_counts: i32, drivetrain: &Drivetrain) -> Self {
        let turn = drivetrain.counts_per_turn.max(1);
        let travel = travel_counts.max(1).unsigned_abs();
        let turns = travel.div_ceil(turn).div_ceil(BINS as u32).max(1);
        Self {
            travel_counts: travel_counts.max(1),
            bin_counts: turns.saturating_mul(turn),
            worm_counts: drivetrain.counts_per_worm_turn,
            rad_per_count: drivetrain.rad_per_count,
            speed_rad_per_s: 0.0,
            closing_nm: Bins::EMPTY,
            worm_nm: [0.0; 2 * HARMONICS],
            opening_nm: 0.0,
            asymmetry_nm: [0.0; 2],
            white_nm2_s: 0.0,
            evidence: Evidence::NONE,
        }
    }

    /// Whether every value is finite and in its range; to be checked after reading it from flash.
    pub fn is_valid(&self) -> bool {
        self.travel_counts > 0
            && self.bin_counts > 0
            && (f32::MIN_POSITIVE..1.0).contains(&self.rad_per_count)
            && (f32::MIN_POSITIVE..f32::MAX).contains(&self.speed_rad_per_s)
            && self.closing_nm.is_valid()
            && self.worm_nm.iter().all(|amplitude| amplitude.is_finite())
            && self.opening_nm.is_finite()
            && self.asymmetry_nm.iter().all(|nm| nm.is_finite())
            && (0.0..f32::MAX).contains(&self.white_nm2_s)
            && self.evidence.is_valid()
    }

    /// Bin of a position; None outside the travel.
    pub(super) fn index(&self, counts: i32) -> Option<usize> {
        let index = u32::try_from(counts).ok()? / self.bin_counts.max(1);
        (counts < self.travel_counts && index < BINS as u32).then_some(index as usize)
    }

    /// Middle of a bin, counts.
    pub(super) fn middle_counts(&self, index: usize) -> f32 {
        (index as f32 + 0.5) * self.bin_counts as f32
    }

    /// Share of the travel that is recorded, 0 to 1.
    pub fn coverage(&self) -> f32 {
        let bins = self.travel_counts as f32 / self.bin_counts as f32;
        (self.closing_nm.filled() as f32 / bins.at_least(1.0)).at_most(1.0)
    }

    /// Mean torque while closing, newton metre; None of an empty record.
    pub fn mean_nm(&self) -> Option<f32> {
        self.closing_nm.mean()
    }

    /// The first and the last third of the record: their middles, counts, and the mean torques while closing there, newton metre; `None` of
    /// an empty record.
    pub fn thirds(&self) -> Option<[(f32, f32); 2]> {
        let (first, last) = self.closing_nm.ends()?;
        let width = (last - first) / 3 + 1;
        let third = |from: usize| {
            let (mut counts, mut torque_nm, mut bins) = (0.0, 0.0, 0.0);
            for index in from..from + width {
                if let Some(nm) = self.closing_nm.get(index) {
                    counts += self.middle_counts(index);
                    torque_nm += nm;
                    bins += 1.0;
                }
            }
            // At least one end of it is filled.
            (counts / bins, torque_nm / bins)
        };
        Some([third(first), third(last + 1 - width)])
    }

    /// Number of passes in the record's mean.
    pub fn passes(&self) -> u8 {
        self.closing_nm.count.iter().fold(0, |most, &n| most.max(n))
    }

    /// [`Friction::asymmetry_nm`] at a position, newton metre, and its derivative by the angle, newton metre per radian.
    pub fn asymmetry(&self, counts: i32) -> [f32; 2] {
        let (sin, cos) = sin_cos(counts as f32 * self.rad_per_count);
        let [by_cos_nm, by_sin_nm] = self.asymmetry_nm;
        [
            by_cos_nm * cos + by_sin_nm * sin,
            by_sin_nm * cos - by_cos_nm * sin,
        ]
    }

    /// Variance of the white noise of a block of a duration, newton metre squared.
    pub fn white_nm2(&self, duration_s: f32) -> f32 {
        (self.white_nm2_s / duration_s.at_least(1e-6)).at_least(f32::MIN_POSITIVE)
    }

    /// Standard deviation of the white noise of a block as long as those of the record, newton metre.
    pub fn noise_nm(&self, drivetrain: &Drivetrain) -> f32 {
        let turn_rad = drivetrain.counts_per_turn as f32 * self.rad_per_count;
        sqrt(self.white_nm2(turn_rad / self.speed_rad_per_s))
    }

    /// The wander since the recording, for a motion at a speed (radian per second).
    pub fn wander(&self, speed_rad_per_s: f32) -> Wander {
        Wander::new(
            &self.evidence,
            self.white_nm2_s,
            self.mean_nm().unwrap_or(0.0),
            self.passes(),
            speed_rad_per_s / self.speed_rad_per_s,
        )
    }

    /// Standard deviation of the residual that a shift of the record would leave, newton metre per count. It is that of the
    /// worm's harmonics, the steepest part.
    pub fn steepness_nm_per_count(&self) -> f32 {
        let slopes = self.worm_nm.iter().enumerate().map(|(index, amplitude)| {
            // A pair for each order.
            let slope = (index / 2 + 1) as f32 * amplitude;
            slope * slope
        });
        let turn = self.worm_counts.max(1) as f32;
        sqrt(0.5 * slopes.sum::<f32>()) * core::f32::consts::TAU / turn
    }

    /// The record at a position. None outside the travel or where nothing was recorded.
    pub fn at(&self, counts: i32) -> Option<Estimate> {
        self.index(counts)?;
        let (first, last) = self.closing_nm.ends()?;
        let margin = 0.5 * self.bin_counts as f32;
        let (low, high) = (self.middle_counts(first), self.middle_counts(last));
        let position = counts as f32;
        if position < low - margin || position > high + margin {
            return None;
        }
        self.smooth(position)
    }

    /// As [`Friction::at`], but extrapolates beyond the end of the record: the worm's harmonics repeat, and the trend of the last
    /// turn of the worm continues, since springs of the finger go on adding torque.
    pub fn beyond(&self, counts: i32) -> Option<Estimate> {
        if let Some(found) = self.at(counts) {
            return Some(found);
        }
        let (first, last) = self.closing_nm.ends()?;
        let (low, high) = (self.middle_counts(first), self.middle_counts(last));
        let position = counts as f32;
        let mut found = self.smooth(position)?;
        let turn = self.worm_counts.max(self.bin_counts) as f32;
        let excess = (position - high).at_most(BEYOND_TURNS * turn);
        if excess <= 0.0 {
            // Before the beginning of the record the motion was not steady.
            return None;
        }
        let before = self.smooth((high - turn).at_least(low))?;
        let end = self.smooth(high)?;
        let turns = excess / (turn.at_most(high - low)).at_least(1.0);
        found.torque_nm += turns * (end.smooth_nm - before.smooth_nm);
        found.variance_nm2 += turns * turns * (end.variance_nm2 + before.variance_nm2);
        found.beyond_counts = excess;
        found.torque_nm.is_finite().then_some(found)
    }

    /// Quadratic through the bins around a position, by weighted least squares, plus the worm's harmonics.
    #[inline(never)]
    fn smooth(&self, position: f32) -> Option<Estimate> {
        let (first, last) = self.closing_nm.ends()?;
        let bin = self.bin_counts as f32;
        // In bins from the beginning of the first bin; beyond the ends the curve stays constant.
        let place = (position / bin).at_least(first as f32 + 0.5);
        let place = place.at_most(last as f32 + 0.5);
        let half = (SMOOTHING_RAD / (self.rad_per_count * bin)).at_least(2.5);
        let from = (place - half).at_least(0.0) as usize;
        let to = ((place + half) as usize).min(BINS - 1);
        // Moments of the weights about the place, and of the values.
        let (mut s, mut t) = ([0.0f32; 5], [0.0f32; 3]);
        for index in from..=to {
            let Some(value) = self.closing_nm.get(index) else {
                continue;
            };
            let x = (index as f32 + 0.5 - place) / half;
            let weight = 1.0 - x * x;
            if weight <= 0.0 {
                continue;
            }
            let mut power = weight;
            for (k, s) in s.iter_mut().enumerate() {
                *s += power;
                if let Some(t) = t.get_mut(k) {
                    *t += power * value;
                }
                power *= x;
            }
        }
        // The polynomial's value at the place and its variance follow from the first row of the adjugate. Distances are at most 1, so
        // cancellation costs at most 1e-5 of the level, where all bins lie on one side. Fewer than three bins only have a mean.
        let row = [
            s[2] * s[4] - s[3] * s[3],
            s[2] * s[3] - s[1] * s[4],
            s[1] * s[3] - s[2] * s[2],
        ];
        let determinant = dot(&row, &[s[0], s[1], s[2]]);
        let (smooth_nm, leverage) = if determinant > SINGULAR * s[0] * s[0] * s[0] {
            (dot(&row, &t) / determinant, row[0] / determinant)
        } else {
            (t[0] / s[0], 1.0 / s[0])
        };
        // Weights are at most 1, so the leverage bounds the sum.
        let bin_s = bin * self.rad_per_count / self.speed_rad_per_s;
        let passes = self.closing_nm.count.get(place as usize).copied();
        let passes = f32::from(passes.unwrap_or(0).max(1));
        let variance_nm2 = leverage.at_least(0.0) * self.white_nm2(bin_s) / passes;
        let waves = harmonics::waves(position, self.worm_counts);
        let torque_nm = smooth_nm + harmonics::sum(&self.worm_nm, &waves);
        (torque_nm + variance_nm2).is_finite().then_some(Estimate {
            torque_nm,
            smooth_nm,
            variance_nm2,
            beyond_counts: 0.0,
        })
    }

    /// Standard deviation of the curve over the travel, newton metre: how far it may be from the value at the end beyond what
    /// was recorded.
    pub fn unevenness_nm(&self) -> Option<f32> {
        let mean = self.mean_nm()?;
        let (mut sum, mut count) = (0.0, 0u32);
        for torque in (0..BINS).filter_map(|index| self.closing_nm.get(index)) {
            sum += (torque - mean) * (torque - mean);
            count += 1;
        }
        (count > 0).then(|| sqrt(sum / count as f32))
    }
}
