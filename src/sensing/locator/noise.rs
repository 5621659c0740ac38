//! Noise of residuals that is correlated along the curve: a Kalman filter of friction and efficiency predicts it, point by point.
//!
//! The excess torque of a point is the finger's plus
//!
//! - a level and a trend: the record of friction is some seconds old;
//! - the wander of friction, an Ornstein-Uhlenbeck process of time;
//! - a share of the load, because the gears' efficiency changes with the turn of the worm: a wave of that period whose size
//!   and phase are not known, and what is left of it, correlated over a third of a turn;
//! - an error of the angle over that turn (docs/SENSING.md#transmission-error): what pins have told of it is taken off, what a scene states,
//!   or what is doubted at a pin, is part of the wave;
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
    /// Turns of the worm at the curve's origin, from where the angle is 0.
    origin_turns: f32,
    /// See [`Calibration::worm_rad`](crate::sensing::Calibration::worm_rad).
    known_rad: [f32; 2],
    /// Error of the angle that the wave's states stand for at the last point, radian.
    error_by_wave_rad: f32,
    variance: [[f32; STATES]; STATES],
    residual: [f32; STATES],
    slopes: [[f32; STATES]; UNKNOWNS],
    /// Time and angle of the previous point.
    before: Option<(f32, f32)>,
}

impl Whitening {
    /// For a curve from an origin, with what is known of the worm's error.
    pub(super) fn new(
        noise: &Noise,
        drivetrain: &Drivetrain,
        origin_rad: f32,
        known_rad: [f32; 2],
    ) -> Self {
        let mut variance = [[0.0; STATES]; STATES];
        let wave = 0.5 * WAVE_SHARE * WAVE_SHARE;
        variance[LEVEL][LEVEL] = noise.level_nm * noise.level_nm;
        variance[TREND][TREND] = noise.trend_nm_per_s * noise.trend_nm_per_s;
        variance[WANDER][WANDER] = noise.wander_nm * noise.wander_nm;
        variance[COSINE][COSINE] = wave;
        variance[SINE][SINE] = wave;
        variance[REST][REST] = REST_SHARE * REST_SHARE;
        let worm_counts = drivetrain.counts_per_worm_turn;
        let worm_per_count = if worm_counts == 0 {
            0.0
        } else {
            1.0 / worm_counts as f32
        };
        Self {
            noise: *noise,
            worm_per_count,
            origin_turns: origin_rad / drivetrain.rad_per_count * worm_per_count,
            known_rad,
            error_by_wave_rad: 0.0,
            variance,
            residual: [0.0; STATES],
            slopes: [[0.0; STATES]; UNKNOWNS],
            before: None,
        }
    }

    /// Subtracts the prediction of earlier points from a row, whose first `unknowns` slopes are used, and updates the states with the
    /// innovation; `past_rad` is the angle from the onset to the end of the point.
    pub(super) fn whiten(&mut self, point: &Point, past_rad: f32, unknowns: usize, row: &mut Row) {
        let turns = self.origin_turns + point.counts * self.worm_per_count;
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
        let [cosine_rad, sine_rad] = self.known_rad;
        row.residual -= row.nm_per_rad * (cosine_rad * cos + sine_rad * sin);
        // The error's part of the wave, by its part of the variance.
        let scale_rad = self.noise.worm_error_rad / WAVE_SHARE;
        self.error_by_wave_rad =
            scale_rad * scale_rad * row.nm_per_rad / wave.at_least(f32::MIN_POSITIVE);
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

    /// Error of the angle over a turn of the worm, radian, by the points so far ([`Calibration::worm_rad`](crate::sensing::Calibration)).
    // By the load and stiffness of the last point: the states that would keep error and efficiency apart cost a third more in each point.
    pub(super) fn worm_rad(&self) -> [f32; 2] {
        let [cosine_rad, sine_rad] = self.known_rad;
        [
            cosine_rad + self.error_by_wave_rad * self.residual[COSINE],
            sine_rad + self.error_by_wave_rad * self.residual[SINE],
        ]
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
mod tests;
