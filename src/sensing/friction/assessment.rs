//! Learns from a pass of free motion: the likelihood of each kind of wander, and a better record.
//!
//! The bins of a pass are modelled as a smooth curve over the position, harmonics of the worm, an Ornstein-Uhlenbeck process
//! in time and white noise. Curve and harmonics are marginalised with a flat prior, the variance of the white noise gets its
//! likeliest value (restricted maximum likelihood): a scalar Kalman filter whitens the bins and each regressor, and a
//! Cholesky factor of their products gives the likelihood. The white noise of single blocks, from their second differences,
//! enters as additional data. While a closing finger swings after its start nothing is learned of the wander. A step evaluates one
//! point of the grid, to keep steps short.

use super::Friction;
use super::bins::BINS;
use super::harmonics::{HARMONICS, waves};
use super::pass::Pass;
use super::regression::{Regression, dot};
use super::wander::{Evidence, Hypothesis, RATES, TIMES, averaged_out, correlation};
use crate::numeric::{Bounded, ln, sin_cos, sqrt};
use crate::sensing::Drive;

/// Terms of the smooth curve: Legendre polynomials.
const CURVE: usize = 5;
/// Regressors.
const COLUMNS: usize = CURVE + 2 * HARMONICS;
/// Columns: the regressors, and the values as the last one.
const ALL: usize = COLUMNS + 1;
/// Smallest number of bins that a pass must fill.
pub const LEAST_BINS: usize = 40;
/// Turns of the worm that a pass must cover so that harmonics can be distinguished from the curve.
const LEAST_TURNS: f32 = 1.5;
/// Largest number of passes in the record's mean: a new pass has at least a weight of one over this.
const PASSES_MAX: u8 = 8;
/// Share of a pass's mean deviation by which the record's level is corrected.
const LEVEL_GAIN: f32 = 0.5;
/// One over the share of a closing that is left out at its start, some 0.1 rad: the finger swings in its cable there, which is not wander.
const SWINGS: usize = 16;
/// Smallest noise of a block, as a share of the mean friction: one quiet pass proves little.
const LEAST_NOISE: f32 = 1e-3;

/// A pass being assessed, step by step.
#[derive(Clone, Debug)]
pub struct Assessment {
    pass: Pass,
    /// First and last bin.
    ends: (usize, usize),
    /// Curve and harmonics that were subtracted from the pass.
    coefficients: [f32; COLUMNS],
    has_worm: bool,
    next: usize,
    evidence: Evidence,
    /// White noise of a block under each hypothesis, newton metre squared.
    white_nm2: [f32; RATES * TIMES],
}

impl Assessment {
    /// Begins the assessment of a pass; None if it is too short.
    pub fn new(pass: Pass, record: &Friction) -> Option<Self> {
        let ends = pass.bins.ends()?;
        let (first, last) = ends;
        let width = (last - first + 1) as f32 * record.bin_counts as f32;
        let turn = record.worm_counts as f32;
        let mut assessment = Self {
            pass,
            ends,
            coefficients: [0.0; COLUMNS],
            has_worm: turn > 0.0 && width >= LEAST_TURNS * turn,
            next: 0,
            evidence: Evidence::NONE,
            white_nm2: [0.0; RATES * TIMES],
        };
        (assessment.pass.filled() >= LEAST_BINS && assessment.take_off(record))
            .then_some(assessment)
    }

    /// Whether it is a closing.
    pub fn is_closing(&self) -> bool {
        self.pass.drive == Drive::Closing
    }

    /// One step; true when the last is done.
    #[inline(never)]
    pub fn step(&mut self, record: &Friction) -> bool {
        let index = self.next;
        if index < RATES * TIMES {
            let (ln_likelihood, white_nm2) = self
                .likelihood(record, Hypothesis::of(index))
                .unwrap_or((f32::NAN, f32::NAN));
            // A NaN here makes `Evidence::add` ignore the pass.
            if let Some(slot) = self.evidence.ln_likelihood.get_mut(index) {
                *slot = ln_likelihood;
            }
            if let Some(slot) = self.white_nm2.get_mut(index) {
                *slot = white_nm2;
            }
            self.next += 1;
        }
        self.next >= RATES * TIMES
    }

    /// Gives a new record what is known before the first step of [`Self::update`].
    pub fn prepare(&self, record: &mut Friction) {
        if !self.is_closing() {
            record.opening_nm = -self.coefficients[0];
            record.asymmetry_nm = self.asymmetry_nm(record);
        }
    }

    /// The wave through the difference of record and opening, by least squares over their common bins.
    fn asymmetry_nm(&self, record: &Friction) -> [f32; 2] {
        let (mut cc, mut cs, mut ss, mut cy, mut sy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (first, last) = self.ends;
        for index in first..=last {
            let Some(closing_nm) = record.closing_nm.get(index) else {
                continue;
            };
            let columns = self.columns(record, index);
            let y = closing_nm - dot(&self.coefficients[..CURVE], &columns[..CURVE]);
            let (sin, cos) = sin_cos(record.middle_counts(index) * record.rad_per_count);
            cc += cos * cos;
            cs += cos * sin;
            ss += sin * sin;
            cy += cos * y;
            sy += sin * y;
        }
        let determinant = cc * ss - cs * cs;
        if determinant > 0.0 {
            [ss * cy - cs * sy, cc * sy - cs * cy].map(|wave| wave / determinant)
        } else {
            [0.0; 2]
        }
    }

    /// Evidence of the pass.
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// Regressors at a bin.
    fn columns(&self, record: &Friction, index: usize) -> [f32; COLUMNS] {
        let (first, last) = self.ends;
        let half = (last - first) as f32 * 0.5;
        let x = (index as f32 - first as f32 - half) / half.at_least(0.5);
        let mut columns = [0.0; COLUMNS];
        let (curve, worm) = columns.split_at_mut(CURVE);
        let (mut before, mut now) = (0.0, 1.0);
        for (degree, column) in curve.iter_mut().enumerate() {
            *column = now;
            // Bonnet's recursion.
            let n = degree as f32;
            (before, now) = (now, ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0));
        }
        if self.has_worm {
            worm.copy_from_slice(&waves(record.middle_counts(index), record.worm_counts));
        }
        columns
    }

    /// Subtracts curve and harmonics from the bins by ordinary least squares. The likelihoods do not change by that, and the
    /// small remainders make single precision sufficient.
    fn take_off(&mut self, record: &Friction) -> bool {
        let mean = self.pass.bins.mean().unwrap_or(0.0);
        let mut regression = Regression::<ALL>::new();
        for index in 0..BINS {
            if let Some(value) = self.pass.bins.get(index) {
                let mut row = [0.0; ALL];
                row[..COLUMNS].copy_from_slice(&self.columns(record, index));
                row[COLUMNS] = value - mean;
                regression.add(&row);
            }
        }
        if !regression.factor() {
            return false;
        }
        let coefficients = regression.coefficients();
        self.coefficients.copy_from_slice(&coefficients[..COLUMNS]);
        self.coefficients[0] += mean;
        for index in 0..BINS {
            let columns = self.columns(record, index);
            let fitted = dot(&self.coefficients, &columns);
            if let Some(value) = self.pass.bins.mean.get_mut(index) {
                *value -= fitted;
            }
        }
        self.coefficients.iter().all(|value| value.is_finite())
    }

    /// Logarithm of the restricted likelihood, up to a constant, and the likeliest white noise of a block.
    fn likelihood(&self, record: &Friction, point: Hypothesis) -> Option<(f32, f32)> {
        let block_s = self.pass.block_s();
        // All variances in units of a block's white noise.
        let growth = point.rate_per_s2 * block_s * block_s;
        let stationary = 0.5 * growth * point.time_s / block_s;
        let blocks_per_bin = self.blocks_per_bin();
        let bin_s = block_s * blocks_per_bin;
        let mut state = [0.0f32; ALL];
        let mut variance = stationary;
        let mut regression = Regression::<ALL>::new();
        let mut ln_determinant = 0.0;
        let mut filled = 0.0f32;
        let mut before: Option<usize> = None;
        let faded = block_s / point.time_s;
        let (first, last) = self.ends;
        let swings = if self.is_closing() {
            (last - first) / SWINGS
        } else {
            0
        };
        for step in swings..=last - first {
            // In order of time.
            let index = if self.is_closing() {
                first + step
            } else {
                last - step
            };
            let (Some(value), Some(&count)) =
                (self.pass.bins.get(index), self.pass.bins.count.get(index))
            else {
                continue;
            };
            if let Some(before) = before.replace(index) {
                let elapsed_s = index.abs_diff(before) as f32 * bin_s;
                let phi = correlation(elapsed_s / point.time_s);
                for x in &mut state {
                    *x *= phi;
                }
                variance = stationary + phi * phi * (variance - stationary);
            }
            let mut row = [0.0; ALL];
            row[..COLUMNS].copy_from_slice(&self.columns(record, index));
            row[COLUMNS] = value;
            let blocks = f32::from(count);
            let total = variance + 1.0 / blocks - stationary * averaged_out(blocks * faded);
            let gain = variance / total;
            let scale = 1.0 / sqrt(total);
            for (x, y) in state.iter_mut().zip(&mut row) {
                let innovation = *y - *x;
                *x += gain * innovation;
                *y = innovation * scale;
            }
            variance *= 1.0 - gain;
            ln_determinant += ln(total);
            regression.add(&row);
            filled += 1.0;
        }
        if !regression.factor() {
            return None;
        }
        let mut rank = 0.0;
        for pivot in regression.pivots() {
            if pivot > 0.0 {
                ln_determinant += 2.0 * ln(pivot);
                rank += 1.0;
            }
        }
        let left = regression.left();
        // Second differences of means contain a sixth of the wander's growth over a block.
        let (white_nm2, freedoms) = self.pass.white_nm2();
        let seen = 1.0 + growth / 6.0;
        let sum = left * left + freedoms * white_nm2 / seen;
        let all = filled - rank + freedoms;
        let white_nm2 = (sum / all).at_least(f32::MIN_POSITIVE);
        let ln_likelihood = -0.5 * (all * ln(white_nm2) + ln_determinant + freedoms * ln(seen));
        ln_likelihood
            .is_finite()
            .then_some((ln_likelihood, white_nm2))
    }

    /// Mean number of blocks in a bin.
    fn blocks_per_bin(&self) -> f32 {
        let sum: u32 = self
            .pass
            .bins
            .count
            .iter()
            .map(|&count| u32::from(count))
            .sum();
        sum as f32 / self.pass.filled().max(1) as f32
    }

    /// Updates the record after the last step.
    // Not inlined: its stack frame is rarely needed.
    #[inline(never)]
    pub fn update(&self, record: &mut Friction) {
        record.evidence.add(&self.evidence);
        let passes = record.passes().min(PASSES_MAX - 1);
        let share = 1.0 / (f32::from(passes) + 1.0);
        let white = self.white_nm2.get(self.evidence.likeliest());
        if let Some(white_nm2) = white.filter(|white| white.is_finite()) {
            // A later pass has the record subtracted, so its own mean is near 0.
            let floor = LEAST_NOISE * record.mean_nm().unwrap_or(self.coefficients[0]);
            let white_nm2_s = white_nm2.at_least(floor * floor) * self.pass.block_s();
            let share = if record.white_nm2_s > 0.0 {
                0.5 * share
            } else {
                1.0
            };
            record.white_nm2_s += share * (white_nm2_s - record.white_nm2_s);
        }
        if !self.is_closing() {
            self.prepare(record);
            return;
        }
        self.improve(record, passes, share);
    }

    fn improve(&self, record: &mut Friction, passes: u8, share: f32) {
        let is_first = passes == 0;
        if is_first {
            record.speed_rad_per_s = self.pass.speed_rad_per_s(record.rad_per_count);
        }
        let worm: [f32; 2 * HARMONICS] = core::array::from_fn(|i| self.coefficients[CURVE + i]);
        for (known, new) in record.worm_nm.iter_mut().zip(&worm) {
            *known += share * new;
        }
        // The level of all bins is corrected together, so that a pass that ended early leaves no step in the curve.
        let level = if is_first { 0.0 } else { self.coefficients[0] };
        let shift = LEVEL_GAIN * level;
        for index in 0..BINS {
            let columns = self.columns(record, index);
            let smooth = dot(&self.coefficients[..CURVE], &columns[..CURVE]);
            let new = self.pass.bins.get(index).map(|left| left + smooth - level);
            let slots = (
                record.closing_nm.mean.get_mut(index),
                record.closing_nm.count.get_mut(index),
            );
            let (Some(mean), Some(count)) = slots else {
                continue;
            };
            // Leave a bin empty that the recording missed: there is no record that a later pass could differ from.
            if let Some(new) = new
                && (is_first || *count > 0)
            {
                let was = (*count).min(PASSES_MAX - 1);
                *mean += new / (f32::from(was) + 1.0);
                *count = was + 1;
            }
            if *count > 0 {
                *mean += shift;
            }
        }
    }
}
