//! A stretch of a torque-angle curve with its noise made independent: friction wanders, and the efficiency waves over a turn of the
//! worm. Least squares of what is left are generalised least squares of the curve.

use super::BlockNoise;
use super::corner::WINDOW;
use crate::numeric::{Bounded, dot, sin_cos, sqrt};
use crate::sensing::locator::{WAVE_SHARE, waves_nm};
use core::f32::consts::TAU;
use heapless::Vec;

/// Terms of the curve: constant, slope, curvature, change of curvature, the wave in phase and out of phase with the middle of the
/// stretch, hinge. About the middle and in units of half the stretch, the first four and the last have one size.
pub(super) const TERMS: usize = 7;
/// The curvature.
pub(super) const BEND: usize = 2;
/// The change of curvature.
pub(super) const TURN: usize = 3;
/// The two of the wave.
const WAVE: [usize; WAVES] = [4, 5];
/// Terms of the wave, and one over the variance of their amplitudes: each has all of [`WAVE_SHARE`], which makes a wave of twice the
/// variance that a first contact's has, because thresholds of corners were chosen with that.
pub(super) const WAVES: usize = 2;
const WAVE_PRIOR: f32 = 1.0 / (WAVE_SHARE * WAVE_SHARE);
/// The hinge.
pub(super) const HINGE: usize = 6;

/// A point: its noise has the variance 1, and it is independent of the others'.
struct Point {
    /// Angle of the input link from the middle, in units of half the stretch.
    u: f32,
    /// Whitens a column.
    filter: Filter,
    /// The terms there.
    row: [f32; TERMS],
    /// The torque there.
    torque: f32,
}

/// One step of the Kalman filter of friction that wanders.
#[derive(Clone, Copy)]
struct Filter {
    /// By how much the prediction follows what it did not predict.
    gain: f32,
    /// One over the standard deviation of what is not predicted, per newton metre.
    weight: f32,
}

impl Filter {
    /// What was not predicted of a value, in its deviations; updates the prediction.
    fn apply(self, value: f32, predicted: &mut f32) -> f32 {
        let innovation = value - *predicted;
        *predicted += self.gain * innovation;
        self.weight * innovation
    }
}

/// A stretch of a curve whose noise is independent, with its normal equations.
pub(super) struct Whitened {
    /// Angle of the input link in the middle, and half the stretch, radian.
    middle_rad: f32,
    pub(super) scale_rad: f32,
    /// Torque that the constant counts from, newton metre.
    pub(super) level_nm: f32,
    points: Vec<Point, WINDOW>,
    /// Of the terms, and of the terms with the torque; the wave's prior is in them.
    pub(super) normal: [[f32; TERMS]; TERMS],
    pub(super) right: [f32; TERMS],
}

impl Whitened {
    /// A stretch of angles and torques; `None` unless it closes. There is no hinge yet.
    pub(super) fn of(stretch: &[[f32; 2]], noise: &BlockNoise) -> Option<Self> {
        let [from, level_nm] = *stretch.first()?;
        let [to, last_nm] = *stretch.last()?;
        let scale_rad = 0.5 * (to - from);
        let closes = scale_rad > 0.0;
        if !closes {
            return None;
        }
        let mut white = Self {
            middle_rad: from + scale_rad,
            scale_rad,
            level_nm,
            points: Vec::new(),
            normal: [[0.0; TERMS]; TERMS],
            right: [0.0; TERMS],
        };
        let slope = (last_nm - level_nm) / (to - from);
        let (mut predicted, mut predicted_nm, mut wandered_nm2) = ([0.0; TERMS], 0.0, 0.0);
        for &[theta, torque] in stretch {
            let variance = noise.white_nm2 + wandered_nm2;
            let gain = wandered_nm2 / variance;
            wandered_nm2 = gain * noise.white_nm2 + noise.walk_nm2;
            let filter = Filter {
                gain,
                weight: 1.0 / sqrt(variance),
            };
            let from_rad = theta - white.middle_rad;
            let u = from_rad / scale_rad;
            let (sin, cos) = sin_cos(TAU / noise.worm_turn_rad * from_rad);
            let wave_nm = waves_nm(torque, noise.worm_error_rad, slope);
            let mut row = [1.0, u, u * u, u * u * u, wave_nm * cos, wave_nm * sin, 0.0];
            for (value, predicted) in row.iter_mut().zip(&mut predicted) {
                *value = filter.apply(*value, predicted);
            }
            let torque = filter.apply(torque - level_nm, &mut predicted_nm);
            for (line, a) in white.normal.iter_mut().zip(row) {
                for (entry, b) in line.iter_mut().zip(row) {
                    *entry += a * b;
                }
            }
            for (sum, a) in white.right.iter_mut().zip(row) {
                *sum += a * torque;
            }
            // As many as the stretch has at most.
            let _ = white.points.push(Point {
                u,
                filter,
                row,
                torque,
            });
        }
        for term in WAVE {
            if let Some(entry) = (white.normal.get_mut(term)).and_then(|line| line.get_mut(term)) {
                *entry += WAVE_PRIOR;
            }
        }
        Some(white)
    }

    /// Puts the hinge at an angle of the input link; returns it as the terms have it.
    pub(super) fn set_hinge(&mut self, theta_a_rad: f32) -> f32 {
        let at = (theta_a_rad - self.middle_rad) / self.scale_rad;
        let (mut line, mut right, mut predicted) = ([0.0; TERMS], 0.0, 0.0);
        for point in &mut self.points {
            let beyond = (point.u - at).at_least(0.0);
            let hinge = point.filter.apply(beyond, &mut predicted);
            point.row[HINGE] = hinge;
            for (entry, term) in line.iter_mut().zip(point.row) {
                *entry += hinge * term;
            }
            right += hinge * point.torque;
        }
        for (row, entry) in self.normal.iter_mut().zip(line) {
            row[HINGE] = entry;
        }
        self.normal[HINGE] = line;
        self.right[HINGE] = right;
        at
    }

    /// Squared residuals of a fit, in their deviations, and what the wave's prior gave way.
    pub(super) fn squares(&self, fit: &[f32; TERMS]) -> f32 {
        let prior: f32 = WAVE.iter().map(|&term| fit[term] * fit[term]).sum();
        let off = |point: &Point| point.torque - dot(&point.row, fit);
        let residuals: f32 = self.points.iter().map(off).map(|off| off * off).sum();
        residuals + WAVE_PRIOR * prior
    }
}

#[cfg(test)]
mod tests {
    use super::super::corner::unit;
    use super::*;
    use crate::numeric::solve;
    use nalgebra::{DMatrix, DVector};

    /// Generalised least squares with the whole covariance, in f64: coefficients, their covariance, squared residuals.
    fn oracle(
        points: &[[f32; 2]],
        noise: &BlockNoise,
        white: &Whitened,
        hinge: f32,
    ) -> (DVector<f64>, DMatrix<f64>, f64) {
        let number = points.len();
        let u = |i: usize| f64::from((points[i][0] - white.middle_rad) / white.scale_rad);
        let curve = DMatrix::from_fn(number, 5, |i, term| match term {
            4 => (u(i) - f64::from(hinge)).max(0.0),
            power => u(i).powi(i32::try_from(power).expect("small")),
        });
        let turn = |i: usize| {
            let from_rad = f64::from(points[i][0] - white.middle_rad);
            from_rad * std::f64::consts::TAU / f64::from(noise.worm_turn_rad)
        };
        let rise = |of: usize| f64::from(points[number - 1][of] - points[0][of]);
        let error_nm = f64::from(noise.worm_error_rad) * rise(1) / rise(0);
        let waves_nm = |i: usize| error_nm.hypot(f64::from(WAVE_SHARE * points[i][1]));
        let covariance = DMatrix::from_fn(number, number, |i, j| {
            let white_nm2 = if i == j { noise.white_nm2 } else { 0.0 };
            let walked = f64::from(noise.walk_nm2) * i.min(j) as f64;
            let wave = waves_nm(i) * waves_nm(j) * (turn(i) - turn(j)).cos();
            f64::from(white_nm2) + walked + wave
        });
        let torques = DVector::from_fn(number, |i, _| f64::from(points[i][1] - white.level_nm));
        let weight = covariance.try_inverse().expect("positive definite");
        let information = curve.transpose() * &weight * &curve;
        let inverse = information.try_inverse().expect("a unique fit");
        let fit = &inverse * curve.transpose() * &weight * &torques;
        let off = torques - curve * &fit;
        let squares = (off.transpose() * weight * off)[0];
        (fit, inverse, squares)
    }

    /// The hinge, its deviation and the squared residuals agree with the oracle, whatever makes the noise.
    #[test]
    fn whitening_is_generalised_least_squares() {
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut worst = [0.0f64; 3];
        for case in 0..300 {
            let number = 12 + case % (WINDOW - 11);
            let noise = BlockNoise {
                white_nm2: 10f32.powf(-8.0 + 2.0 * draw()),
                walk_nm2: if case % 3 == 0 {
                    0.0
                } else {
                    10f32.powf(-10.0 + 3.0 * draw())
                },
                worm_turn_rad: 0.1 + 0.4 * draw(),
                worm_error_rad: if case % 2 == 0 { 0.0 } else { 1e-3 * draw() },
            };
            let (slope, bend, corner) = (0.05 + draw(), draw(), draw());
            let points: std::vec::Vec<_> = (0..number)
                .map(|i| {
                    let theta = 0.005 * i as f32;
                    let torque = 0.02
                        + slope * theta
                        + bend * theta * theta
                        + corner * (theta - 0.03).at_least(0.0);
                    [1.3 + theta, torque + 3e-4 * (draw() - 0.5)]
                })
                .collect();
            let mut white = Whitened::of(&points, &noise).expect("it closes");
            let hinge = white.set_hinge(points[number - 4][0]);
            // A hinge that was put elsewhere before leaves nothing behind.
            let _ = white.set_hinge(points[number - 7][0]);
            let again = white.set_hinge(points[number - 4][0]);
            assert_eq!(hinge, again);
            let sides = [white.right, unit(HINGE)];
            let [fit, by_hinge] = solve(white.normal, sides).expect("a unique fit");
            let (wanted, covariance, squares) = oracle(&points, &noise, &white, hinge);
            let deviation = covariance[(4, 4)].sqrt();
            let off = (f64::from(fit[HINGE]) - wanted[4]) / deviation;
            let ratio = f64::from(by_hinge[HINGE]).sqrt() / deviation - 1.0;
            let more = f64::from(white.squares(&fit)) / squares - 1.0;
            for (worst, value) in worst.iter_mut().zip([off, ratio, more]) {
                *worst = worst.max(value.abs());
            }
        }
        println!(
            "worst: hinge off by {:.1e} deviations, deviation by {:.1e}, squares by {:.1e}",
            worst[0], worst[1], worst[2]
        );
        assert!(
            worst[0] < 0.02 && worst[1] < 2e-4 && worst[2] < 5e-4,
            "{worst:?}"
        );
    }
}
