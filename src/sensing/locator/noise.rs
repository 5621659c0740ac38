//! Noise of residuals that is correlated along the curve: a Kalman filter of friction and efficiency predicts it, point by point.
//!
//! The excess torque of a point is the finger's plus
//!
//! - a level and a trend: the record of friction is some seconds old;
//! - the wander of friction, an Ornstein-Uhlenbeck process of time;
//! - a share of the load, because the gears' efficiency changes with the turn of the worm: a wave of that period whose size
//!   and phase are not known, and what is left of it, correlated over a third of a turn;
//! - an error of the angle over that turn, where a scene states one (docs/SENSING.md#transmission-error), as part of the wave;
//! - white noise: that of the blocks, of the impact of the contact, and of the load.
//!
//! The filter predicts this sum from the previous points; the innovations are independent. The derivatives of the model go
//! through the same filter, so that least squares of the innovations are generalised least squares.

use super::prior::UNKNOWNS;
use crate::numeric::{Bounded, exp, sin_cos, sqrt};
use crate::sensing::Drivetrain;
use crate::sensing::curve::Point;
use core::f32::consts::TAU;

/// States: level, trend, wander, two of the wave, remainder.
const STATES: usize = 6;
const LEVEL: usize = 0;
const TREND: usize = 1;
const WANDER: usize = 2;
const COSINE: usize = 3;
const SINE: usize = 4;
const REST: usize = 5;

/// Amplitude of the efficiency's wave over a turn of the worm, standard deviation, as a share of the load
/// (docs/BOUNDS.md#estimation-from-recordings: 1 %; a little more, because it is taken from recordings).
pub(in crate::sensing) const WAVE_SHARE: f32 = 0.012;
/// Standard deviation of the remainder, as a share of the load (R, chosen).
const REST_SHARE: f32 = 0.004;
/// Distance over which it is correlated, as a share of a turn of the worm.
const REST_TURNS: f32 = 0.3;
/// White noise of the efficiency, as a share of the load (docs/BOUNDS.md#estimation-from-recordings).
const WHITE_SHARE: f32 = 0.003;
/// A contact bounces: torque per speed at contact, newton metre second per radian, and its decay time,
/// second (docs/BOUNDS.md#estimation-from-recordings: 5 mN m at 0.3 rad/s, gone after 0.1 s).
const IMPACT_NM_S_PER_RAD: f32 = 5e-3 / 0.3;
const IMPACT_S: f32 = 0.04;

/// Torque that the efficiency's wave takes a share of, newton metre: the load, and what an error of the angle over a turn of the worm,
/// radian, adds where the excess changes by so much with the angle (docs/SENSING.md#transmission-error).
#[inline(always)]
pub(in crate::sensing) fn waves_nm(load_nm: f32, worm_error_rad: f32, nm_per_rad: f32) -> f32 {
    let error_nm = worm_error_rad / WAVE_SHARE * nm_per_rad;
    sqrt(load_nm * load_nm + error_nm * error_nm)
}

/// Prior of the noise at the beginning of the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Wander of the friction, newton metre at the input link, standard deviation.
    pub wander_nm: f32,
    /// Its time constant, second.
    pub wander_s: f32,
    /// Deviation of the level, newton metre.
    pub level_nm: f32,
    /// Deviation of the trend, newton metre per second.
    pub trend_nm_per_s: f32,
    /// Speed of the input link, radian per second.
    pub speed_rad_per_s: f32,
    /// Amplitude of the transmission error over a turn of the worm, radian, >= 0.
    pub worm_error_rad: f32,
}

/// A residual and the model's derivatives at it, by the unknowns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) residual: f32,
    pub(super) slopes: [f32; UNKNOWNS],
    /// Variance of the residual without the filter's states; afterwards that of the innovation.
    pub(super) variance: f32,
    /// Derivative of the excess by the angle of the onset, newton metre per radian, <= 0: the free finger's stiffness less that in contact.
    /// An error of the angle moves the excess by as much, because the friction record already has the free finger's share of it.
    pub(super) nm_per_rad: f32,
}

/// State of the filter along one curve.
#[derive(Clone, Debug)]
pub(super) struct Whitening {
    noise: Noise,
    worm_per_count: f32,
    variance: [[f32; STATES]; STATES],
    residual: [f32; STATES],
    slopes: [[f32; STATES]; UNKNOWNS],
    /// Time and angle of the previous point.
    before: Option<(f32, f32)>,
}

impl Whitening {
    pub(super) fn new(noise: &Noise, drivetrain: &Drivetrain) -> Self {
        let mut variance = [[0.0; STATES]; STATES];
        let wave = 0.5 * WAVE_SHARE * WAVE_SHARE;
        variance[LEVEL][LEVEL] = noise.level_nm * noise.level_nm;
        variance[TREND][TREND] = noise.trend_nm_per_s * noise.trend_nm_per_s;
        variance[WANDER][WANDER] = noise.wander_nm * noise.wander_nm;
        variance[COSINE][COSINE] = wave;
        variance[SINE][SINE] = wave;
        variance[REST][REST] = REST_SHARE * REST_SHARE;
        let worm_counts = drivetrain.counts_per_worm_turn;
        Self {
            noise: *noise,
            worm_per_count: if worm_counts == 0 {
                0.0
            } else {
                1.0 / worm_counts as f32
            },
            variance,
            residual: [0.0; STATES],
            slopes: [[0.0; STATES]; UNKNOWNS],
            before: None,
        }
    }

    /// Subtracts the prediction of earlier points from a row, whose first `unknowns` slopes are used, and updates the states with the
    /// innovation; `past_rad` is the angle from the onset to the end of the point.
    pub(super) fn whiten(&mut self, point: &Point, past_rad: f32, unknowns: usize, row: &mut Row) {
        let turns = point.counts * self.worm_per_count;
        if let Some((time_s, before)) = self.before.replace((point.time_s, turns)) {
            let fading = exp((time_s - point.time_s) / self.noise.wander_s);
            self.fade(WANDER, fading, self.noise.wander_nm * self.noise.wander_nm);
            let fading = exp((before - turns) / REST_TURNS);
            self.fade(REST, fading, REST_SHARE * REST_SHARE);
        }
        let load = point.excess_nm.at_least(0.0);
        // An error of the angle is a wave of the same period, independent of the efficiency's, so their variances add up. Keep both in one
        // wave: two more states would cost a third more in each point.
        let wave = waves_nm(load, self.noise.worm_error_rad, row.nm_per_rad);
        let (sin, cos) = sin_cos(TAU * (turns - (turns as i32) as f32));
        let seen = [1.0, point.time_s, 1.0, wave * cos, wave * sin, load];
        let impact = IMPACT_NM_S_PER_RAD * self.noise.speed_rad_per_s * self.bounce(past_rad);
        let white = WHITE_SHARE * load;
        row.variance +=
            point.variance_nm2 + white * white / f32::from(point.blocks.max(1)) + impact * impact;
        // Covariance of each state with the measurement.
        let mut with = [0.0; STATES];
        for (with, variance) in with.iter_mut().zip(&self.variance) {
            *with = dot(variance, &seen);
        }
        row.variance += dot(&with, &seen);
        let gain = with.map(|with| with / row.variance);
        for (variance, with) in self.variance.iter_mut().zip(&with) {
            for (variance, gain) in variance.iter_mut().zip(&gain) {
                *variance -= with * gain;
            }
        }
        row.residual = update(&mut self.residual, row.residual, &seen, &gain);
        for (state, slope) in self.slopes.iter_mut().zip(&mut row.slopes).take(unknowns) {
            *slope = update(state, *slope, &seen, &gain);
        }
    }

    /// Share of the impact that remains at an angle beyond the onset, 0 to 1.
    fn bounce(&self, past_rad: f32) -> f32 {
        if past_rad < 0.0 {
            return 0.0;
        }
        exp(-past_rad / (self.noise.speed_rad_per_s * IMPACT_S).at_least(f32::MIN_POSITIVE))
    }

    /// Lets a state decay towards its stationary variance.
    fn fade(&mut self, state: usize, fading: f32, variance: f32) {
        let fade = |value: Option<&mut f32>| {
            if let Some(value) = value {
                *value *= fading;
            }
        };
        for row in &mut self.variance {
            fade(row.get_mut(state));
        }
        if let Some(row) = self.variance.get_mut(state) {
            for value in &mut *row {
                *value *= fading;
            }
            if let Some(own) = row.get_mut(state) {
                *own += (1.0 - fading * fading) * variance;
            }
        }
        fade(self.residual.get_mut(state));
        for slopes in &mut self.slopes {
            fade(slopes.get_mut(state));
        }
    }
}

// Here and below one state after the other instead of a loop, which would cost as much again: a fit comes by some ten times
// a point.
#[inline(always)]
fn dot(a: &[f32; STATES], b: &[f32; STATES]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}

/// Innovation of a value; updates the states.
#[inline(never)]
fn update(
    state: &mut [f32; STATES],
    value: f32,
    seen: &[f32; STATES],
    gain: &[f32; STATES],
) -> f32 {
    let left = value - dot(state, seen);
    let [level, trend, wander, cosine, sine, rest] = state;
    *level += gain[LEVEL] * left;
    *trend += gain[TREND] * left;
    *wander += gain[WANDER] * left;
    *cosine += gain[COSINE] * left;
    *sine += gain[SINE] * left;
    *rest += gain[REST] * left;
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::ln;
    use crate::scene::{P70, Scene};
    use nalgebra::{DMatrix, DVector};

    const NOISE: Noise = Noise {
        wander_nm: 0.6e-3,
        wander_s: 2.0,
        level_nm: 1.5e-3,
        trend_nm_per_s: 4e-4,
        speed_rad_per_s: 0.3,
        worm_error_rad: 0.0,
    };
    /// Angle between points, radian.
    const STEP_RAD: f32 = 0.011;

    /// Points of a contact that stiffens, with their residuals.
    fn rows(drivetrain: &Drivetrain) -> Vec<(Point, Row)> {
        (0..40u8)
            .map(|i| {
                let along = f32::from(i);
                let point = Point {
                    counts: along * STEP_RAD / drivetrain.rad_per_count,
                    time_s: along * STEP_RAD / NOISE.speed_rad_per_s,
                    excess_nm: 4e-3 * along + 1e-4 * along * along,
                    variance_nm2: 1e-8,
                    blocks: 3,
                    ..Point::EMPTY
                };
                let row = Row {
                    residual: 2e-3 * (0.7 * along).sin() + 1e-3 * (0.1 * along * along).cos(),
                    slopes: [0.0; UNKNOWNS],
                    variance: 2e-8,
                    nm_per_rad: -(0.2 + 0.02 * along),
                };
                (point, row)
            })
            .collect()
    }

    /// Covariance of the residuals of these points, by the definition of the noise, f64.
    fn covariance(noise: &Noise, drivetrain: &Drivetrain) -> DMatrix<f64> {
        let rows = rows(drivetrain);
        let square = |x: f32| f64::from(x) * f64::from(x);
        let turn =
            |point: &Point| f64::from(point.counts) / f64::from(drivetrain.counts_per_worm_turn);
        DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            let ((a, left), (b, right)) = (&rows[i], &rows[j]);
            let [load_a, load_b] = [a, b].map(|point| f64::from(point.excess_nm));
            let apart_s = f64::from((a.time_s - b.time_s).abs());
            let turns = turn(a) - turn(b);
            let in_phase = (core::f64::consts::TAU * turns).cos();
            // One wave of efficiency and angle error.
            let size = |of: &Row, load: f64| {
                let error = square(noise.worm_error_rad) * square(of.nm_per_rad);
                (square(WAVE_SHARE) * load * load + error).sqrt()
            };
            let wave = 0.5 * size(left, load_a) * size(right, load_b);
            let rest =
                square(REST_SHARE) * load_a * load_b * (-turns.abs() / f64::from(REST_TURNS)).exp();
            let white = if i == j {
                let past_rad = a.counts * drivetrain.rad_per_count;
                let bounce = f64::from(-past_rad / (noise.speed_rad_per_s * IMPACT_S)).exp();
                f64::from(left.variance + a.variance_nm2)
                    + square(WHITE_SHARE) * load_a * load_a / f64::from(a.blocks)
                    + square(IMPACT_NM_S_PER_RAD * noise.speed_rad_per_s) * bounce * bounce
            } else {
                0.0
            };
            square(noise.level_nm)
                + square(noise.trend_nm_per_s) * f64::from(a.time_s * b.time_s)
                + square(noise.wander_nm) * (-apart_s / f64::from(noise.wander_s)).exp()
                + wave * in_phase
                + rest
                + white
        })
    }

    /// Sum of the squared innovations over their variances, and of the logarithms of these.
    fn whitened(noise: &Noise, drivetrain: &Drivetrain) -> [f64; 2] {
        let mut whitening = Whitening::new(noise, drivetrain);
        let mut sums = [0.0; 2];
        for (point, mut row) in rows(drivetrain) {
            let past_rad = point.counts * drivetrain.rad_per_count;
            whitening.whiten(&point, past_rad, 0, &mut row);
            sums[0] += f64::from(row.residual * row.residual / row.variance);
            sums[1] += f64::from(ln(row.variance));
        }
        sums
    }

    #[test]
    fn innovations_are_as_likely_as_the_residuals_by_their_whole_covariance() {
        let drivetrain = P70::drivetrain(&P70::MECHANISM);
        let residuals = rows(&drivetrain).into_iter();
        let residuals = DVector::from_iterator(40, residuals.map(|(_, row)| row.residual.into()));
        let mut logarithms = Vec::new();
        for worm_error_rad in [0.0, 1e-3, 4e-3] {
            let noise = Noise {
                worm_error_rad,
                ..NOISE
            };
            let [squares, logarithm] = whitened(&noise, &drivetrain);
            let factor = covariance(&noise, &drivetrain)
                .cholesky()
                .expect("a covariance");
            let expected = residuals.dot(&factor.solve(&residuals));
            assert!(
                (squares / expected - 1.0).abs() < 2e-3,
                "{worm_error_rad}: {squares} {expected}"
            );
            let expected = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
            assert!(
                (logarithm - expected).abs() < 0.02,
                "{worm_error_rad}: {logarithm} {expected}"
            );
            logarithms.push(logarithm);
        }
        // An error that is stated is more noise.
        assert!(logarithms.is_sorted() && logarithms[2] > logarithms[0] + 1.0);
    }

    /// Where the load is small a stiff finger shows the error of the angle all the same, a soft one does not.
    #[test]
    fn an_error_of_the_angle_counts_with_the_stiffness() {
        let drivetrain = P70::drivetrain(&P70::MECHANISM);
        let variance = |worm_error_rad: f32, nm_per_rad: f32| {
            let noise = Noise {
                worm_error_rad,
                ..NOISE
            };
            let point = Point {
                blocks: 1,
                ..Point::EMPTY
            };
            let mut row = Row {
                residual: 0.0,
                slopes: [0.0; UNKNOWNS],
                variance: 0.0,
                nm_per_rad,
            };
            Whitening::new(&noise, &drivetrain).whiten(&point, 1.0, 0, &mut row);
            row.variance
        };
        let none = variance(0.0, 1.0);
        for nm_per_rad in [0.2f32, 1.0] {
            let more = variance(2e-3, nm_per_rad) - none;
            let expected = 0.5 * (2e-3 * nm_per_rad) * (2e-3 * nm_per_rad);
            assert!((more / expected - 1.0).abs() < 1e-2, "{more} {expected}");
        }
    }
}
