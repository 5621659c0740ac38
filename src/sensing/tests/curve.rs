use super::Noise;
use crate::sensing::curve::{Curve, POINTS, Point, slope};

fn point(excess_nm: f32) -> Point {
    Point {
        excess_nm,
        variance_nm2: 1e-6,
        width_counts: 1000.0,
        blocks: 1,
        ..Point::EMPTY
    }
}

#[test]
fn bins_grow_and_keep_their_means() {
    let mut curve = Curve::new(i32::MAX - 500);
    let mut sum = 0.0;
    for i in 0..200 {
        let excess = 1e-3 * i as f32;
        sum += excess;
        curve.push((i32::MAX - 500).wrapping_add(1000 * i), point(excess));
        assert!(curve.points().len() <= POINTS);
    }
    let filled = || curve.points().iter().filter(|p| p.blocks > 0);
    let blocks: u32 = filled().map(|p| u32::from(p.blocks)).sum();
    assert_eq!(blocks, 200);
    assert!(curve.complete().len() + 1 >= curve.points().len());
    let mean: f32 = filled().map(|p| p.excess_nm * f32::from(p.blocks)).sum();
    assert!((mean - sum).abs() < 1e-3);
    let mut last = 0;
    for p in filled() {
        // On the line, and as much surer as it has blocks.
        assert!((p.excess_nm - 1e-6 * p.counts).abs() < 1e-6);
        assert!((p.variance_nm2 * f32::from(p.blocks) - 1e-6).abs() < 1e-9);
        assert_eq!(p.width_counts, 1000.0 * f32::from(p.blocks));
        assert!(p.blocks >= last || p.counts > 190_000.0);
        last = p.blocks;
    }
    assert_eq!(filled().next().map(|p| p.blocks), Some(1));
}

#[test]
fn what_lies_before_or_is_no_number_is_ignored() {
    let mut curve = Curve::new(1000);
    curve.push(999, point(1.0));
    curve.push(2000, point(f32::NAN));
    curve.push(
        2000,
        Point {
            late_nm: f32::INFINITY,
            ..point(1.0)
        },
    );
    curve.push_before(0, 0, 0, point(f32::NAN));
    curve.push_before(7, 2, 0, point(1.0));
    let filled = |curve: &Curve| curve.points().iter().filter(|p| p.blocks > 0).count();
    assert_eq!(filled(&curve), 0);
    curve.push(i32::MAX, point(1.0));
    assert_eq!(filled(&curve), 1);
}

#[test]
fn what_was_before_is_kept_apart() {
    let mut curve = Curve::new(60_000);
    for i in 0..60 {
        curve.push_before(i, 60, 1000 * i as i32, point(0.0));
    }
    curve.push(60_000, point(0.01));
    let points = curve.points();
    assert_eq!(points.len(), 5);
    assert!(
        points
            .windows(2)
            .all(|pair| pair[0].counts < pair[1].counts)
    );
    assert_eq!(points[0].blocks, 15);
    assert_eq!(points[4].blocks, 1);
}

/// A point without blocks would count where residuals are compared with the number of points.
#[test]
fn a_short_history_leaves_no_empty_points() {
    for before in 0..10 {
        let mut curve = Curve::new(1000 * before);
        for i in 0..before {
            curve.push_before(i as usize, before as usize, 1000 * i, point(0.0));
        }
        for i in before..before + 3 {
            curve.push(1000 * i, point(0.01));
        }
        let points = curve.points();
        assert!(points.iter().all(|point| point.blocks > 0), "{before}");
        assert!(
            points
                .windows(2)
                .all(|pair| pair[0].counts < pair[1].counts)
        );
        let blocks: i32 = points.iter().map(|point| i32::from(point.blocks)).sum();
        assert_eq!(blocks, before + 3);
        assert_eq!(points.len(), before.min(4) as usize + 3);
        assert_eq!(curve.complete().len() + 1, points.len());
    }
}

#[test]
fn the_slope_is_unbiased_and_its_deviation_honest() {
    // 0.5 rad/N m at 1e-5 rad a count: 50,000 counts/N m.
    let mut noise = Noise(11);
    let (mut sum, mut within) = (0.0, 0);
    for _ in 0..400 {
        let points: Vec<Point> = (0..20)
            .map(|i| Point {
                counts: 1000.0 * i as f32,
                ..point(0.02 * i as f32 + 1e-3 * noise.normal())
            })
            .collect();
        let s = slope(&points, 1.0, 0.0).unwrap();
        sum += s.counts_per_nm;
        within += usize::from((s.counts_per_nm - 50_000.0).abs() < 2.0 * s.sigma_counts_per_nm);
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
    assert!(slope(&flat, 1.0, 0.0).is_none());
    let falling: Vec<Point> = (0..5)
        .map(|i| Point {
            counts: 100.0 * i as f32,
            ..point(-0.1 * i as f32)
        })
        .collect();
    assert!(slope(&falling, 1.0, 0.0).is_none());
    assert!(slope(&falling[..2], 1.0, 0.0).is_none());
    assert!(slope(&[], 1.0, 0.0).is_none());
}

#[test]
fn a_curve_is_cut_before_a_position_and_stays_whole_where_little_would_be_left() {
    let mut curve = Curve::new(0);
    for i in 0..20 {
        curve.push(1000 * i + 500, point(1e-3 * i as f32));
    }
    let whole = curve.clone();
    curve.cut(4_900, 6);
    assert_eq!(curve.points(), whole.points());
    // The bins of one block end at 6000; the first of two blocks reaches from there to 8000.
    curve.cut(7_900, 6);
    let kept: Vec<f32> = curve.points().iter().map(|p| p.counts).collect();
    assert_eq!(kept, [500.0, 1500.0, 2500.0, 3500.0, 4500.0, 5500.0]);
}
