//! Has the finger touched? A sequential test of the torque that the friction record does not explain.
//!
//! Each block of a free closing leaves a residual r = b + noise: b is a slow misfit of the record (temperature, current
//! offset), followed by a scalar Kalman filter that runs [`LAG`] blocks late so that a contact does not enter it. A
//! contact adds a ramp. Page's test (CUSUM) sums what exceeds one standard deviation,
//!
//! g <- max(0, g + z - kappa), z = (r - b) / s, kappa = 1,
//!
//! and decides when g > h. Scaled by the long-run deviation s (the record's noise per way made, times the inverse of the
//! block's way), the sums behave as those of independent normal variables, for which Siegmund's approximation of the mean
//! number of blocks between false alarms is (exp(2 kappa w) - 1 - 2 kappa w) / (2 kappa^2), w = h + 1.166. With n blocks
//! a closing and a wanted rate p it must be n/p; [`threshold`] solves for h. At 1e-4 per closing of 600 blocks:
//! h = 7.2. A contact that adds s to the residual in each block is then felt after some five blocks.
//!
//! The same test on -z finds what is softer than a free finger.

use crate::numeric::{Bounded, ln, sqrt};

/// Blocks by which the misfit's filter lags: longer than a detection takes, so that a contact is decided before it can
/// pass for misfit.
pub const LAG: usize = 8;
/// What a deviation must exceed to count, in standard deviations.
const KAPPA: f32 = 1.0;
/// Siegmund's correction for the excess over the boundary.
const OVERSHOOT: f32 = 1.166;
/// How far the record's level may have moved since it was taken, as a share of the friction: a current offset of 1 mA
/// (docs/HARDWARE.md#bridge: what offset calibration leaves) beside a no-load current of some 14 mA.
const LEVEL_SHARE: f32 = 0.08;
/// Random walk of the misfit: its standard deviation over a thousand blocks, as a share of the friction.
const WALK_SHARE: f32 = 0.015;
/// A level further off than this share of the friction asks for a new record.
const STALE_SHARE: f32 = 0.25;
/// As does a mean square residual of this many variances.
const STALE_SQUARE: f32 = 6.0;
/// Blocks over which that mean square is taken.
const STALE_BLOCKS: u16 = 100;

/// Decision interval h for a false-alarm rate per closing of some number of blocks (module documentation).
pub fn threshold(false_alarms_per_closing: f32, blocks_per_closing: f32) -> f32 {
    let between = blocks_per_closing.at_least(1.0) / false_alarms_per_closing.clamp(1e-9, 0.1);
    // exp(2 kappa w) = 2 kappa^2 between + 1 + 2 kappa w: the fixed point is reached at once, w enters by a logarithm.
    let mut w = 0.0;
    for _ in 0..4 {
        w = ln(2.0 * KAPPA * KAPPA * between + 1.0 + 2.0 * KAPPA * w) / (2.0 * KAPPA);
    }
    (w - OVERSHOOT).at_least(1.0)
}

/// What a block tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// No more than friction.
    Free,
    /// A contact, since this many blocks (this one included).
    Contact {
        /// Blocks since the sum last was zero.
        since: usize,
    },
    /// Less than friction, since this many blocks.
    Softer {
        /// Blocks since the sum last was zero.
        since: usize,
    },
    /// The record no longer fits.
    Stale {
        /// How far off it is, newton metre.
        misfit_nm: f32,
    },
}

/// A one-sided sum of Page's test.
#[derive(Clone, Copy, Debug, Default)]
struct Page {
    sum: f32,
    since: usize,
}

impl Page {
    fn add(&mut self, z: f32) {
        self.sum += z - KAPPA;
        if self.sum > 0.0 {
            self.since = self.since.saturating_add(1);
        } else {
            *self = Self::default();
        }
    }
}

/// The test over one run in one direction.
#[derive(Clone, Debug)]
pub struct Detector {
    threshold: f32,
    /// Mean friction, newton metre, without sign.
    friction_nm: f32,
    /// Noise of the residual's mean over a way, times that way.
    noise_nm2_counts: f32,
    level_nm: f32,
    level_variance_nm2: f32,
    stiffer: Page,
    softer: Page,
    /// Residuals not yet taken by the level's filter, and their variances, oldest at `oldest`.
    late: [(f32, f32); LAG],
    oldest: usize,
    blocks: u32,
    square_sum: f32,
    square_count: u16,
}

impl Detector {
    /// A test with a decision interval, for a mean friction and the noise of [`super::friction::Friction`].
    pub fn new(threshold: f32, friction_nm: f32, noise_nm2_counts: f32) -> Self {
        let level = LEVEL_SHARE * friction_nm.abs();
        Self {
            threshold,
            friction_nm: friction_nm.abs(),
            noise_nm2_counts,
            level_nm: 0.0,
            level_variance_nm2: level * level,
            stiffer: Page::default(),
            softer: Page::default(),
            late: const { [(0.0, 0.0); LAG] },
            oldest: 0,
            blocks: 0,
            square_sum: 0.0,
            square_count: 0,
        }
    }

    /// Misfit b of the record's level here, newton metre, and its variance.
    pub fn level(&self) -> (f32, f32) {
        (self.level_nm, self.level_variance_nm2)
    }

    /// Noise of a residual, as in [`super::friction::Friction`].
    pub fn noise_nm2_counts(&self) -> f32 {
        self.noise_nm2_counts
    }

    /// Takes the residual of a block, motor torque less friction, newton metre, and the way that the block made.
    pub fn push(&mut self, residual_nm: f32, width_counts: u32) -> Finding {
        if !residual_nm.is_finite() {
            return Finding::Free;
        }
        let variance = self.noise_nm2_counts / (width_counts.max(1) as f32);
        let deviation = residual_nm - self.level_nm;
        // The level's error stays while the sum grows: over a run of LAG blocks it adds up LAG times as fast as noise.
        let lasting = variance + LAG as f32 * self.level_variance_nm2;
        let z = deviation / sqrt(lasting).at_least(f32::MIN_POSITIVE);
        self.stiffer.add(z);
        self.softer.add(-z);
        if self.stiffer.sum > self.threshold {
            return Finding::Contact {
                since: self.stiffer.since,
            };
        }
        if self.softer.sum > self.threshold {
            return Finding::Softer {
                since: self.softer.since,
            };
        }
        self.follow(residual_nm, variance);
        self.stale(deviation * deviation, variance + self.level_variance_nm2)
    }

    /// The level's filter takes the residual of [`LAG`] blocks ago, unless a decision may be on its way.
    fn follow(&mut self, residual_nm: f32, variance: f32) {
        let Some(slot) = self.late.get_mut(self.oldest) else {
            return;
        };
        let (late_nm, late_variance) = core::mem::replace(slot, (residual_nm, variance));
        self.oldest = (self.oldest + 1) % LAG;
        self.blocks = self.blocks.saturating_add(1);
        if self.blocks as usize <= LAG
            || self.stiffer.sum.at_least(self.softer.sum) > 0.5 * self.threshold
        {
            return;
        }
        let walk = WALK_SHARE * self.friction_nm;
        let predicted = self.level_variance_nm2 + walk * walk * 1e-3;
        let gain = predicted / (predicted + late_variance).at_least(f32::MIN_POSITIVE);
        self.level_nm += gain * (late_nm - self.level_nm);
        self.level_variance_nm2 = (1.0 - gain) * predicted;
    }

    fn stale(&mut self, square_nm2: f32, variance_nm2: f32) -> Finding {
        if self.level_nm.abs() > STALE_SHARE * self.friction_nm {
            return Finding::Stale {
                misfit_nm: self.level_nm,
            };
        }
        // A large value may be the beginning of a contact.
        let square = square_nm2 / variance_nm2.at_least(f32::MIN_POSITIVE);
        self.square_sum += square.at_most(4.0 * STALE_SQUARE);
        self.square_count += 1;
        if self.square_count < STALE_BLOCKS {
            return Finding::Free;
        }
        let mean = self.square_sum / f32::from(self.square_count);
        self.square_sum = 0.0;
        self.square_count = 0;
        if mean > STALE_SQUARE {
            return Finding::Stale {
                misfit_nm: sqrt(mean * variance_nm2),
            };
        }
        Finding::Free
    }
}
