use super::Noise;
use crate::sensing::curve::{BINS, Curve, Point, slope};

fn point(torque_nm: f32) -> Point {
    Point {
        torque_nm,
        variance_nm2: 1e-6,
        blocks: 1,
        ..Point::EMPTY
    }
}

#[test]
fn a_full_curve_halves_its_resolution_and_keeps_its_means() {
    let mut curve = Curve::new(i32::MAX - 500, 1000);
    let mut torque_sum = 0.0;
    for i in 0..200 {
        let torque = 1e-3 * i as f32;
        torque_sum += torque;
        curve.push((i32::MAX - 500).wrapping_add(1000 * i), point(torque));
        assert!(curve.points().count() <= BINS);
    }
    let blocks: u32 = curve.points().map(|p| u32::from(p.blocks)).sum();
    assert_eq!(blocks, 200);
    let mean: f32 = curve
        .points()
        .map(|p| p.torque_nm * f32::from(p.blocks))
        .sum();
    assert!((mean - torque_sum).abs() < 1e-3);
    for p in curve.points() {
        // On the line, and as much surer as it has blocks.
        assert!((p.torque_nm - 1e-6 * p.counts).abs() < 1e-6);
        assert!((p.variance_nm2 * f32::from(p.blocks) - 1e-6).abs() < 1e-9);
    }
    assert!(curve.points().count() >= BINS / 2);
}

#[test]
fn what_lies_before_or_is_no_number_is_ignored() {
    let mut curve = Curve::new(1000, 0);
    curve.push(999, point(1.0));
    curve.push(2000, point(f32::NAN));
    curve.push(
        2000,
        Point {
            late_nm: f32::INFINITY,
            ..point(1.0)
        },
    );
    assert_eq!(curve.points().count(), 0);
    assert!(curve.last().is_none());
    curve.push(i32::MAX, point(1.0));
    assert_eq!(curve.points().count(), 1);
}

#[test]
fn the_slope_is_unbiased_and_its_deviation_honest() {
    // 0.5 rad/N m at 1e-5 rad a count: 50,000 counts/N m.
    let mut noise = Noise(11);
    let (mut sum, mut within) = (0.0, 0);
    for _ in 0..400 {
        let mut curve = Curve::new(0, 1000);
        for i in 0..20 {
            let counts = 1000 * i;
            curve.push(
                counts,
                point((counts as f32 - 3000.0) / 50_000.0 + 1e-3 * noise.normal()),
            );
        }
        let s = slope(curve.bins(), f32::NEG_INFINITY, 0.0).unwrap();
        sum += s.counts_per_nm;
        within += usize::from((s.counts_per_nm - 50_000.0).abs() < 2.0 * s.sigma_counts_per_nm);
        assert!((s.onset_counts - 3000.0).abs() < 200.0);
    }
    assert!((sum / 400.0 - 50_000.0).abs() < 30.0, "{}", sum / 400.0);
    assert!(
        (370..=392).contains(&within),
        "{within} of 400 within two deviations"
    );
}

#[test]
fn a_slope_that_is_not_one_is_refused() {
    let flat = [point(0.1); 5];
    assert!(slope(&flat, 0.0, 0.0).is_none());
    let rising: Vec<Point> = (0..5)
        .map(|i| Point {
            counts: 100.0 * i as f32,
            ..point(-0.1 * i as f32)
        })
        .collect();
    assert!(slope(&rising, f32::NEG_INFINITY, 0.0).is_none());
    assert!(slope(&rising[..2], f32::NEG_INFINITY, 0.0).is_none());
    assert!(slope(&[], 0.0, 0.0).is_none());
}
