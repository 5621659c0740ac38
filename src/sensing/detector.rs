//! Decides whether a contact has begun: generalised likelihood ratio test for a ramp in the residual torque.
//!
//! In a free closing the residual wanders: an Ornstein-Uhlenbeck process, a level, a drift ([`Wander`]) and white noise. A Kalman
//! filter with these three states turns it into white innovations e of variance S. A contact adds a ramp over the angle, from an
//! onset that is not known and with a slope that is not known either but is at least half that of the softest contact of the
//! finger. What a ramp of slope 1 from a certain onset would add to an innovation, g, follows from the filter's gains alone
//! (Willsky and Jones, IEEE Trans. Automatic Control 21, 1976). With c = sum g e / S and d = sum g^2 / S since the onset, the
//! logarithm of the likelihood ratio is b c - b^2 d / 2, largest for the slope b = max(c / d, b_least). Every block is a possible
//! onset. At most [`ONSETS`] are followed, back to the start of the closing: the newest are consecutive blocks, older ones are
//! spaced ever wider. A contact whose torque rises slowly is therefore found too. A contact is decided when the largest of these
//! logarithms exceeds the threshold.
//!
//! An innovation far outside the model gets a larger variance, so that a decision takes at least two blocks.
//!
//! The same test with -b finds a finger that is softer than free; its threshold is the same.

use crate::numeric::{Bounded, exp, ln, sqrt};
use crate::sensing::friction::Wander;
use core::f32::consts::PI;
use heapless::Vec;

/// Largest number of onsets followed at once. The newer half are consecutive blocks.
pub const ONSETS: usize = 60;
/// Number of independent tests that a block stands for, measured with closings drawn from the model (docs/MANUAL.md).
const CHANCES_PER_BLOCK: f32 = 4.0;
/// Larger than any motor torque, newton metre.
const LARGE_NM: f32 = 1e6;
/// The evidence of a single block stays this far below the threshold, so that one outlier decides nothing.
const SHORT_OF_DECISION: f32 = 3.0;
/// If the level is off by more than this share of the friction, a new record is needed.
const STALE_SHARE: f32 = 0.25;
/// The same for a mean square innovation of this many variances.
const STALE_SQUARE: f32 = 3.0;
/// Blocks over which that mean square is taken.
const STALE_BLOCKS: u16 = 100;

/// Logarithm of the likelihood ratio at which a contact is decided, for a number of false contacts per thousand free
/// closings of some number of blocks.
///
/// The ratio of one slope exceeds a threshold t by chance as often as a normal variable exceeds sqrt(2 t).
pub fn threshold(false_contacts_per_thousand: f32, blocks_per_closing: f32) -> f32 {
    let per_closing = 1e-3 * false_contacts_per_thousand.at_least(1e-6).at_most(100.0);
    let blocks = blocks_per_closing.at_least(1.0).at_most(1e6);
    let most = ln(CHANCES_PER_BLOCK * blocks / per_closing);
    let mut t = most;
    for _ in 0..4 {
        // The tail of the normal distribution, exp(-t) / sqrt(4 pi t).
        t = (most - 0.5 * ln(4.0 * PI * t)).at_least(2.0);
    }
    t
}

/// Torque of a block that the friction record does not explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// End of the block, microseconds since boot.
    pub time_us: u64,
    /// Middle of the block, counts from the opening stop.
    pub counts: i32,
    /// Distance travelled, counts, without sign.
    pub width_counts: u32,
    /// Torque of the motor less friction and what the rotor's inertia took, newton metre.
    pub torque_nm: f32,
    /// Variance of its white share: noise of the block and of the record, newton metre squared.
    pub variance_nm2: f32,
}

/// A change of the residual that the detector follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Blocks since it began, the last one included.
    pub since: usize,
    /// Where it began, mean and standard deviation, counts.
    pub counts: f32,
    /// See `counts`.
    pub sigma_counts: f32,
    /// Slope of the residual since, newton metre of motor torque per count.
    pub slope_nm_per_count: f32,
    /// Logarithm of its likelihood ratio.
    pub ln_ratio: f32,
    /// Residual that friction alone would have left by now, newton metre.
    pub level_nm: f32,
}

/// Result of the test after a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// Friction explains the residual.
    Free,
    /// A contact.
    Contact(Onset),
    /// The residual falls: the finger is softer than free.
    Softer(Onset),
    /// The record no longer fits.
    Stale {
        /// By how much, newton metre.
        misfit_nm: f32,
    },
}

/// A ramp of slope 1 that begins at one onset.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    onset_counts: i32,
    /// Blocks since it began.
    since: u32,
    /// Its contribution to the filter's states.
    states: [f32; STATES],
    /// Sums of g e / S and g^2 / S.
    correlation: f32,
    energy: f32,
}

/// Wander, level, drift.
const STATES: usize = 3;
type Covariance = [[f32; STATES]; STATES];

/// Settings of the test, for one closing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// Logarithm of the likelihood ratio that decides; see [`threshold`].
    pub threshold: f32,
    /// Half the slope of the softest contact, newton metre of motor torque per count.
    pub least_slope_nm_per_count: f32,
    /// The same for a fall, without sign.
    pub least_fall_nm_per_count: f32,
    /// Mean friction, newton metre.
    pub friction_nm: f32,
}

/// The test over one closing.
#[derive(Clone, Debug)]
pub struct Detector {
    test: Test,
    wander: Wander,
    states: [f32; STATES],
    covariance: Covariance,
    last_us: Option<u64>,
    /// In the order of their onsets, the oldest first.
    ramps: Vec<Ramp, ONSETS>,
    /// Variance of the last innovation, newton metre squared.
    variance_nm2: f32,
    square_sum: f32,
    square_count: u16,
    /// Logarithm of the likelihood ratio of the likeliest contact at the last block.
    ln_ratio: f32,
}

impl Detector {
    /// Begins a closing with a noise model.
    pub fn new(test: Test, wander: Wander) -> Self {
        let square = |x: f32| x * x;
        Self {
            test,
            states: [0.0; STATES],
            covariance: [
                [square(wander.rms_nm), 0.0, 0.0],
                [0.0, square(wander.level_sigma_nm), 0.0],
                [0.0, 0.0, square(wander.trend_sigma_nm_per_s)],
            ],
            wander,
            last_us: None,
            ramps: Vec::new(),
            variance_nm2: 0.0,
            square_sum: 0.0,
            square_count: 0,
            ln_ratio: 0.0,
        }
    }

    /// The noise model.
    pub fn wander(&self) -> &Wander {
        &self.wander
    }

    /// The filter's estimate of the friction in the residual, newton metre, with its variance.
    pub fn level(&self) -> (f32, f32) {
        let p = &self.covariance;
        let variance = p[0][0] + 2.0 * p[0][1] + p[1][1];
        (self.states[0] + self.states[1], variance)
    }

    /// The likeliest ramp so far.
    pub fn suspect(&self) -> Option<Onset> {
        self.largest(1.0).map(|(ramp, _)| self.onset(&ramp, 1.0))
    }

    /// Logarithm of the likelihood ratio of the likeliest contact at the last block, and the one that decides.
    pub fn evidence(&self) -> (f32, f32) {
        (self.ln_ratio, self.test.threshold)
    }

    /// Takes the residual of the next block; NaN is ignored.
    pub fn push(&mut self, block: &Residual) -> Finding {
        if !(block.torque_nm.is_finite() && block.variance_nm2 > 0.0 && block.variance_nm2 < 1e6) {
            return Finding::Free;
        }
        let elapsed_us = self
            .last_us
            .replace(block.time_us)
            .map_or(0, |last| block.time_us.saturating_sub(last));
        // Wraps after an hour, and a closing takes seconds.
        self.predict(elapsed_us.min(3_600_000_000) as u32 as f32 * 1e-6);
        let half = (block.width_counts / 2) as i32;
        if self.ramps.is_full() {
            // Make room: drop every second ramp of the older half.
            let mut rank = 0;
            self.ramps.retain(|_| {
                rank += 1;
                rank % 2 == 1 || rank > ONSETS / 2
            });
        }
        let _ = self.ramps.push(Ramp {
            onset_counts: block.counts.wrapping_sub(half),
            since: 0,
            states: [0.0; STATES],
            correlation: 0.0,
            energy: 0.0,
        });
        let p = &self.covariance;
        let gains: [f32; STATES] = core::array::from_fn(|i| p[i][0] + p[i][1]);
        let innovation = block.torque_nm - self.states[0] - self.states[1];
        let innovation = innovation.at_least(-LARGE_NM).at_most(LARGE_NM);
        // An outlier gets a larger variance: a decision takes at least two blocks.
        let evidence = (self.test.threshold - SHORT_OF_DECISION).at_least(1.0);
        let least = innovation * innovation / (2.0 * evidence);
        let expected = gains[0] + gains[1] + block.variance_nm2;
        let weight = 1.0 / expected.at_least(least);
        self.variance_nm2 = expected;
        for ramp in &mut self.ramps {
            let signal = block.counts.wrapping_sub(ramp.onset_counts) as f32;
            let seen = signal - ramp.states[0] - ramp.states[1];
            ramp.since += 1;
            ramp.correlation += seen * innovation * weight;
            ramp.energy += seen * seen * weight;
            for (state, gain) in ramp.states.iter_mut().zip(&gains) {
                *state += gain * weight * seen;
            }
        }
        self.correct(&gains, innovation, weight);
        self.find(innovation * innovation / expected)
    }

    /// Predicts the filter's states.
    fn predict(&mut self, elapsed_s: f32) {
        let phi = self.wander.correlation(elapsed_s);
        for ramp in &mut self.ramps {
            ramp.states[0] *= phi;
            ramp.states[1] += elapsed_s * ramp.states[2];
        }
        self.states[0] *= phi;
        self.states[1] += elapsed_s * self.states[2];
        let stationary = self.wander.rms_nm * self.wander.rms_nm;
        let [[a, b, c], [_, d, e], [_, _, f]] = self.covariance;
        let (b, e) = (b + elapsed_s * c, e + elapsed_s * f);
        let d = d + elapsed_s * (self.covariance[1][2] + e);
        let a = stationary + phi * phi * (a - stationary);
        let (b, c) = (phi * b, phi * c);
        self.covariance = [[a, b, c], [b, d, e], [c, e, f]];
    }

    fn correct(&mut self, gains: &[f32; STATES], innovation: f32, weight: f32) {
        for i in 0..STATES {
            self.states[i] += gains[i] * weight * innovation;
            for k in 0..STATES {
                self.covariance[i][k] -= gains[i] * gains[k] * weight;
            }
            // Rounding must not make a variance negative.
            self.covariance[i][i] = self.covariance[i][i].at_least(0.0);
        }
    }

    fn find(&mut self, square: f32) -> Finding {
        if let Some((ramp, ratio)) = self.largest(1.0) {
            self.ln_ratio = ratio;
            if ratio > self.test.threshold {
                return Finding::Contact(self.onset(&ramp, 1.0));
            }
        }
        if let Some((ramp, ratio)) = self.largest(-1.0)
            && ratio > self.test.threshold
        {
            return Finding::Softer(self.onset(&ramp, -1.0));
        }
        self.stale(square)
    }

    fn slope(&self, ramp: &Ramp, sign: f32) -> f32 {
        let least = if sign > 0.0 {
            self.test.least_slope_nm_per_count
        } else {
            self.test.least_fall_nm_per_count
        };
        (sign * ramp.correlation / ramp.energy.at_least(f32::MIN_POSITIVE)).at_least(least)
    }

    fn ln_ratio(&self, ramp: &Ramp, sign: f32) -> f32 {
        let slope = self.slope(ramp, sign);
        slope * (sign * ramp.correlation - 0.5 * slope * ramp.energy)
    }

    /// The ramp with the largest likelihood ratio.
    fn largest(&self, sign: f32) -> Option<(Ramp, f32)> {
        let mut found = None;
        let mut most = f32::NEG_INFINITY;
        for ramp in &self.ramps {
            let ratio = self.ln_ratio(ramp, sign);
            if ratio > most {
                most = ratio;
                found = Some((*ramp, ratio));
            }
        }
        found
    }

    /// Details of the ramp that has the largest likelihood ratio.
    #[inline(never)]
    fn onset(&self, best: &Ramp, sign: f32) -> Onset {
        let most = self.ln_ratio(best, sign);
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for ramp in &self.ramps {
            let weight = exp(self.ln_ratio(ramp, sign) - most);
            let beside = ramp.onset_counts.wrapping_sub(best.onset_counts) as f32;
            sum += weight;
            mean += weight * beside;
            square += weight * beside * beside;
        }
        // The best one has a weight of 1.
        mean /= sum;
        let slope = sign * self.slope(best, sign);
        let (level_nm, _) = self.level();
        Onset {
            since: best.since as usize,
            counts: best.onset_counts as f32 + mean,
            sigma_counts: sqrt((square / sum - mean * mean).at_least(0.0)),
            slope_nm_per_count: slope,
            ln_ratio: most,
            level_nm: level_nm - slope * (best.states[0] + best.states[1]),
        }
    }

    fn stale(&mut self, square: f32) -> Finding {
        let (level_nm, variance) = self.level();
        let beyond = level_nm.abs() - STALE_SHARE * self.test.friction_nm;
        if beyond > 0.0 && beyond * beyond > 2.0 * self.test.threshold * variance {
            return Finding::Stale {
                misfit_nm: level_nm,
            };
        }
        // A large innovation may be the beginning of a contact, so it does not count here.
        self.square_sum += square.at_most(4.0 * STALE_SQUARE);
        self.square_count += 1;
        if self.square_count < STALE_BLOCKS {
            return Finding::Free;
        }
        let count = f32::from(self.square_count);
        let mean = self.square_sum / count;
        self.square_sum = 0.0;
        self.square_count = 0;
        // Logarithm of the likelihood ratio of that variance to the one expected.
        let ln_ratio = 0.5 * count * (mean - 1.0 - ln(mean));
        if mean > STALE_SQUARE && ln_ratio > self.test.threshold {
            return Finding::Stale {
                misfit_nm: sqrt(mean * self.variance_nm2),
            };
        }
        Finding::Free
    }
}
