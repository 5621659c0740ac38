//! Wander of friction: what changes between two motions and no record can contain.
//!
//! Friction is modelled as the record plus an Ornstein-Uhlenbeck process in time plus white noise of the
//! measurement. Size and time constant come from free motion alone, by marginal likelihood over a grid
//! ([`Assessment`](super::Assessment)); each free pass adds its logarithms to the grid. A short record determines the rate at
//! which the wander grows well and its time constant hardly at all; the detection of a contact needs only the rate.

use crate::numeric::{Bounded, exp, sqrt};
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Rates of growth in the grid.
pub const RATES: usize = 8;
/// Time constants in the grid.
pub const TIMES: usize = 3;
/// Smallest rate of the grid, per second squared.
const LEAST_RATE: f32 = 0.5;
/// Ratio of neighbouring rates.
const STEP: f32 = 4.0;
/// Time constants of the grid, second.
const TIME_S: [f32; TIMES] = [0.5, 2.0, 8.0];
/// Logarithm of the ratio of neighbouring ones.
const LN_TIME_STEP: f32 = 2.0 * core::f32::consts::LN_2;
/// Ratio of neighbouring rates between the grid's, a quarter of a step.
const BETWEEN: f32 = core::f32::consts::SQRT_2;
/// Ratio of the first rate of the grid and the first place about it, three eighths of a step.
const FIRST: f32 = 1.681_793;
/// Bound of what a place between the grid's points is likelier than all of them, as a logarithm.
const MOST_BESIDE: f32 = 31.0;
/// Weight of earlier evidence after another pass: friction changes with wear and temperature.
const MEMORY: f32 = 0.9;
/// Deviation of the level since the recording, as a share of the friction (chosen: a warm-up of 5 % and a sense
/// offset of 1 mA in a no-load current of some 14 mA).
const LEVEL_SHARE: f32 = 0.1;
/// Drift within a closing, as a share of the friction per second (chosen: 5 % of warm-up within some ten seconds).
const TREND_SHARE_PER_S: f32 = 0.006;

/// A point of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// Growth of the wander's variance per second, as a multiple of the white noise's variance in a block of one second,
    /// per second squared: what two blocks differ by, whatever their length.
    pub rate_per_s2: f32,
    /// Time constant, second.
    pub time_s: f32,
}

impl Hypothesis {
    /// The point of an index below [`RATES`] times [`TIMES`].
    pub fn of(index: usize) -> Self {
        let mut rate_per_s2 = LEAST_RATE;
        for _ in 0..index % RATES {
            rate_per_s2 *= STEP;
        }
        Self {
            rate_per_s2,
            time_s: TIME_S.get(index / RATES).copied().unwrap_or(TIME_S[0]),
        }
    }
}

/// Evidence from free motion on the wander: logarithms of the likelihood over the grid.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Evidence {
    /// Logarithm of the likelihood of each point but for a constant, the time constants one after the other.
    pub ln_likelihood: [f32; RATES * TIMES],
}

impl Evidence {
    /// No evidence: every point is equally likely.
    pub const NONE: Self = Self {
        ln_likelihood: [0.0; RATES * TIMES],
    };

    /// Whether every value is finite.
    pub fn is_valid(&self) -> bool {
        self.ln_likelihood.iter().all(|value| value.is_finite())
    }

    /// Adds the evidence of another pass; it is ignored if any value is not finite.
    pub fn add(&mut self, pass: &Self) {
        if !pass.is_valid() {
            return;
        }
        let most = pass.most();
        for (value, new) in self.ln_likelihood.iter_mut().zip(&pass.ln_likelihood) {
            // Only differences matter: the largest is kept at zero, so that rounding loses none.
            *value = MEMORY * *value + (new - most).at_least(-1e3);
        }
    }

    // Not inlined: called in three places.
    #[inline(never)]
    fn most(&self) -> f32 {
        self.ln_likelihood
            .iter()
            .fold(f32::MIN, |most, &value| most.at_least(value))
    }

    /// The likeliest point.
    pub fn likeliest(&self) -> usize {
        let most = self.most();
        (self.ln_likelihood.iter())
            .position(|&value| value >= most)
            .unwrap_or(0)
    }

    /// Posterior mean of the rate (a rate taken too low makes false alarms, one taken too high costs milliseconds), and
    /// geometric mean of the time constant; the prior is even over the logarithm of the rate and over the time constants.
    ///
    /// Two passes tell the rate to a fifth, while the grid's points are a factor of four apart: between them the logarithm of
    /// the likelihood is a parabola through the nearest point and its neighbours.
    pub fn mean(&self) -> Hypothesis {
        let most = self.most();
        let (mut sum, mut rate, mut times) = (0.0, 0.0, 0.0);
        for (index, line) in self.ln_likelihood.chunks_exact(RATES).enumerate() {
            let mut rate_per_s2 = LEAST_RATE / FIRST;
            let mut before = None;
            for (rank, &here) in line.iter().enumerate() {
                // At the ends of the grid take the point's own value for its whole cell: a parabola could peak outside the grid.
                let (below, above) = match (before.replace(here), line.get(rank + 1)) {
                    (Some(below), Some(&above)) => (below, above),
                    _ => (here, here),
                };
                // Four places about the point, from three eighths of a step before it to as much behind it.
                let mut x = -0.375;
                while x < 0.5 {
                    let beside = 0.5 * x * (above - below + x * (above - here + below - here));
                    // Between the points it may well be likelier than at any of them, but not without bounds.
                    let weight = exp((here + beside - most).at_most(MOST_BESIDE));
                    sum += weight;
                    rate += weight * rate_per_s2;
                    times += weight * index as f32;
                    rate_per_s2 *= BETWEEN;
                    x += 0.25;
                }
            }
        }
        // The likeliest has a weight of about 1.
        Hypothesis {
            rate_per_s2: rate / sum,
            time_s: TIME_S[0] * exp(LN_TIME_STEP * times / sum),
        }
    }
}

/// Wander of friction since it was recorded: the noise model of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wander {
    /// Standard deviation of the Ornstein-Uhlenbeck part of a residual (of this closing and of the record's passes
    /// together), newton metre of motor torque.
    pub rms_nm: f32,
    /// Its time constant, second, > 0.
    pub time_s: f32,
    /// Standard deviation of the level since it was recorded, newton metre.
    pub level_sigma_nm: f32,
    /// Standard deviation of a steady drift, newton metre per second.
    pub trend_sigma_nm_per_s: f32,
}

impl Wander {
    /// Builds the noise model from evidence: `white_nm2_s` is the variance of the white noise times the duration of its block,
    /// `friction_nm` the mean friction, `passes` the number in the record, `speed_ratio` the present speed over the record's.
    pub fn new(
        evidence: &Evidence,
        white_nm2_s: f32,
        friction_nm: f32,
        passes: u8,
        speed_ratio: f32,
    ) -> Self {
        let Hypothesis {
            rate_per_s2,
            time_s,
        } = evidence.mean();
        // The record's own wander adds one over the number of its passes.
        let both = 1.0 + 1.0 / f32::from(passes.max(1));
        let variance = 0.5 * rate_per_s2 * white_nm2_s * time_s * both;
        // Stribeck's curve: friction may change by half the change of speed, as shares of themselves (chosen).
        let other_speed = 0.5 * (speed_ratio - 1.0).abs();
        Self {
            rms_nm: sqrt(variance),
            time_s,
            level_sigma_nm: (LEVEL_SHARE + other_speed) * friction_nm.abs(),
            trend_sigma_nm_per_s: TREND_SHARE_PER_S * friction_nm.abs(),
        }
    }

    /// Correlation of the wander with itself after a time, 0 to 1.
    pub fn correlation(&self, elapsed_s: f32) -> f32 {
        correlation(elapsed_s / self.time_s)
    }
}

/// exp(-x) for x >= 0 by a rational function, within 1 % up to x = 0.5 and never negative; cheaper than the function, for steps
/// that are a small part of the time constant.
pub(super) fn correlation(x: f32) -> f32 {
    ((1.0 - 0.5 * x) / (1.0 + 0.5 * x)).at_least(0.0)
}

/// Share of an Ornstein-Uhlenbeck process's variance that its mean over a time lacks, for that time x >= 0 in units of its time constant:
/// within 0.055 of 1 - 2 (x - 1 + exp(-x)) / x^2 for any x.
///
/// Neighbouring means share nearly what instants do. Means are therefore modelled as instants whose white noise has this variance less; of a
/// walk, the limit for small x, they lack a sixth of its growth. Taken for instants, they made rates of large wanders 0.8 times what they are.
pub(super) fn averaged_out(x: f32) -> f32 {
    x / (3.0 + x)
}

#[cfg(test)]
mod tests {
    use super::{Evidence, Hypothesis, RATES, TIMES, averaged_out};

    /// As sharp as ten passes make it, rates beyond the largest of the grid: nothing outside is found.
    #[test]
    fn evidence_at_an_end_of_the_grid_tells_the_rate_at_that_end() {
        for (end, ratio) in [(0, 1.0 / 1.3), (RATES - 1, 1.3f32)] {
            let there = Hypothesis::of(end).rate_per_s2 * ratio;
            let ln_likelihood = core::array::from_fn(|index| {
                let off = (Hypothesis::of(index % RATES).rate_per_s2 / there).ln();
                -150.0 * off * off
            });
            let evidence = Evidence { ln_likelihood };
            assert_eq!(evidence.ln_likelihood.len(), RATES * TIMES);
            let found = evidence.mean().rate_per_s2;
            assert!((0.65..1.55).contains(&(found / there)), "{found} {there}");
        }
    }

    #[test]
    fn means_of_a_wandering_process_are_instants_with_less_white_noise() {
        // Exact covariance of means over a time x, the process's variance 1 and its time constant 1, `lag` means apart.
        let exact = |x: f64, lag: i32| match lag {
            0 => 2.0 * (x + (-x).exp_m1()) / (x * x),
            _ => (2.0 * x.cosh() - 2.0) / (x * x) * (-x * f64::from(lag)).exp(),
        };
        for x in [1e-3f64, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0] {
            let own = 1.0 - f64::from(averaged_out(x as f32));
            assert!((own - exact(x, 0)).abs() < 0.055, "{x}: {own}");
            // The variance of the difference of neighbouring means is what the rate is found from: two thirds of a walk's growth 2 x.
            // A block or a bin is at most a fifth of the shortest time constant of the grid.
            if x <= 0.2 {
                let told = 2.0 * (own - (-x).exp());
                let true_one = 2.0 * (exact(x, 0) - exact(x, 1));
                assert!(
                    (told / true_one - 1.0).abs() < 0.15,
                    "{x}: {told} {true_one}"
                );
            }
        }
    }
}
