//! An error of the worm's angle at pins and contacts.

use super::*;

/// A curve whose measured angles are off by a wave over the worm's turn: amplitudes of its cosine and sine, radian.
fn off(points: &[Point], drivetrain: &Drivetrain, [cosine_rad, sine_rad]: [f32; 2]) -> Vec<Point> {
    let slope = |index: usize| {
        let after = &points[(index + 1).min(points.len() - 1)];
        let before = &points[index.max(1) - 1];
        let rad = (after.counts - before.counts) * drivetrain.rad_per_count;
        (after.excess_nm - before.excess_nm) / rad
    };
    let origin_rad = data(points, drivetrain).origin_rad;
    let moved = points.iter().enumerate().map(|(index, point)| {
        let rad = origin_rad + point.counts * drivetrain.rad_per_count;
        let counts = rad / drivetrain.rad_per_count;
        let turns = counts / drivetrain.counts_per_worm_turn as f32;
        let (sin, cos) = (core::f32::consts::TAU * turns).sin_cos();
        Point {
            excess_nm: point.excess_nm + slope(index) * (cosine_rad * cos + sine_rad * sin),
            ..*point
        }
    });
    moved.collect()
}

/// What two pins have told of the worm's error makes places better: by a fifth of the mean error over phases and places.
#[test]
fn a_contact_uses_what_pins_have_told_of_the_worm() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let radius_m = 0.011;
    let (mut with_m, mut without_m) = (0.0, 0.0);
    for phase in 0..6u8 {
        let (sin, cos) = (f32::from(phase) * core::f32::consts::FRAC_PI_3).sin_cos();
        let error = [2e-3 * cos, 2e-3 * sin];
        let found = |prior: &Prior<Cable>, k_m: f32| {
            let points = curve(k_m, radius_m, prior.joint_nm[0], &drivetrain);
            let points = off(&points, &drivetrain, error);
            judged(&finger, &data(&points, &drivetrain), prior)
        };
        let noise = Noise {
            worm_error_rad: 1.5e-3,
            ..prior().noise
        };
        let calibration = pinned(radius_m, noise, |_| prior().joint_nm, found);
        for k_m in [0.012, 0.03, 0.04] {
            let off_m = |calibration: Calibration| {
                let prior = Prior {
                    calibration,
                    ..prior()
                };
                match found(&prior, k_m).verdict(&prior) {
                    LocatorResult::At(estimate) => (estimate.k_m - k_m).abs(),
                    other => panic!("{k_m}: {other:?}"),
                }
            };
            with_m += off_m(calibration);
            without_m += off_m(Calibration {
                worm_rad: [0.0; 2],
                ..calibration
            });
        }
    }
    println!("{with_m} {without_m}");
    assert!(with_m < 0.8 * without_m, "{with_m} {without_m}");
}
