//! The filter against the covariance by its definition.

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
    let turn = |point: &Point| f64::from(point.counts) / f64::from(drivetrain.counts_per_worm_turn);
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
    let mut whitening = Whitening::new(noise, drivetrain, 0.0, [0.0; 2]);
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
        Whitening::new(&noise, &drivetrain, 0.0, [0.0; 2]).whiten(&point, 1.0, 0, &mut row);
        row.variance
    };
    let none = variance(0.0, 1.0);
    for nm_per_rad in [0.2f32, 1.0] {
        let more = variance(2e-3, nm_per_rad) - none;
        let expected = 0.5 * (2e-3 * nm_per_rad) * (2e-3 * nm_per_rad);
        assert!((more / expected - 1.0).abs() < 1e-2, "{more} {expected}");
    }
}

/// Of a wave of the angle a curve tells a part, whatever its phase, and none of it is left once it is known.
#[test]
fn an_error_of_the_angle_is_told_in_part_and_taken_off() {
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let noise = Noise {
        worm_error_rad: 1.5e-3,
        ..NOISE
    };
    let origin_rad = 0.83;
    for phase in 0..8u8 {
        let (sin, cos) = (f32::from(phase) * core::f32::consts::FRAC_PI_4).sin_cos();
        let [cosine_rad, sine_rad] = [2e-3 * cos, 2e-3 * sin];
        let judged = |known_rad: [f32; 2]| {
            let mut whitening = Whitening::new(&noise, &drivetrain, origin_rad, known_rad);
            let mut squares = 0.0;
            for (point, row) in rows(&drivetrain) {
                let counts = origin_rad / drivetrain.rad_per_count + point.counts;
                let (sin, cos) = (TAU * counts / drivetrain.counts_per_worm_turn as f32).sin_cos();
                let mut row = Row {
                    residual: row.nm_per_rad * (cosine_rad * cos + sine_rad * sin),
                    ..row
                };
                let past_rad = point.counts * drivetrain.rad_per_count;
                whitening.whiten(&point, past_rad, 0, &mut row);
                squares += row.residual * row.residual / row.variance;
            }
            (whitening.worm_rad(), squares)
        };
        let ([told_cosine, told_sine], unknown) = judged([0.0; 2]);
        let along = (told_cosine * cos + told_sine * sin) / 2e-3;
        let across = (told_sine * cos - told_cosine * sin) / 2e-3;
        assert!((0.1..1.0).contains(&along), "{phase}: {along} {across}");
        assert!(across.abs() < 0.5 * along, "{phase}: {along} {across}");
        let (kept, known) = judged([cosine_rad, sine_rad]);
        assert!(known < 1e-3 * unknown, "{phase}: {known} {unknown}");
        assert!((kept[0] - cosine_rad).abs() + (kept[1] - sine_rad).abs() < 1e-5);
    }
}
