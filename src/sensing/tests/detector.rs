use super::Noise;
use crate::sensing::detector::{Detector, Finding, LAG, threshold};

const FRICTION: f32 = 0.17;
/// Blocks of 1 mN m deviation.
const NOISE: f32 = 1e-6 * 1000.0;
const WIDTH: u32 = 1000;

fn run(
    detector: &mut Detector,
    blocks: usize,
    mut signal: impl FnMut(usize) -> f32,
) -> Option<(usize, Finding)> {
    (0..blocks).find_map(|i| match detector.push(signal(i), WIDTH) {
        Finding::Free => None,
        finding => Some((i, finding)),
    })
}

#[test]
fn false_alarms_are_as_rare_as_stated() {
    // A rate that can be counted: 5 % of 2,000 closings of 300 blocks. The bound is an approximation and the detector
    // keeps a margin (the level's own uncertainty): fewer is fine, more is not.
    let h = threshold(0.05, 300.0);
    let mut noise = Noise(7);
    let mut alarms = 0;
    for _ in 0..2000 {
        let mut detector = Detector::new(h, FRICTION, NOISE);
        let offset = 0.02 * FRICTION * noise.normal();
        let found = run(&mut detector, 300, |_| offset + 1e-3 * noise.normal());
        alarms += usize::from(matches!(found, Some((_, Finding::Contact { .. }))));
    }
    assert!(alarms <= 2000 / 20, "{alarms} alarms");
    // Not by being deaf: the threshold is no higher than it must be.
    assert!(alarms >= 1, "{alarms} alarms");
}

#[test]
fn the_threshold_grows_with_what_is_asked() {
    let h = threshold(1e-4, 300.0);
    assert!((6.5..7.5).contains(&h), "{h}");
    assert!(
        threshold(1e-6, 300.0) > h && threshold(1e-2, 300.0) < h && threshold(1e-4, 3000.0) > h
    );
    for (rate, blocks) in [
        (0.0, 1.0),
        (f32::NAN, 300.0),
        (1.0, f32::NAN),
        (1e-4, f32::INFINITY),
    ] {
        assert!(threshold(rate, blocks) >= 1.0);
    }
}

#[test]
fn a_ramp_is_felt_soon_and_its_beginning_known() {
    let mut noise = Noise(3);
    let mut worst = 0;
    for _ in 0..200 {
        let mut detector = Detector::new(threshold(1e-4, 300.0), FRICTION, NOISE);
        let found = run(&mut detector, 300, |i| {
            1e-3 * (i.saturating_sub(100) as f32) + 1e-3 * noise.normal()
        });
        let Some((at, Finding::Contact { since })) = found else {
            panic!("{found:?}");
        };
        worst = worst.max(at - 100);
        assert!((96..=105).contains(&(at + 1 - since)), "{at} {since}");
    }
    assert!(worst <= 8, "{worst} blocks");
}

#[test]
fn a_shifted_level_is_followed_a_fall_is_told_and_a_large_shift_asks_for_a_new_record() {
    let h = threshold(1e-4, 300.0);
    let mut noise = Noise(5);
    let mut detector = Detector::new(h, FRICTION, NOISE);
    let drift = |i: usize| 0.05 * FRICTION * (i as f32 / 300.0);
    assert_eq!(
        run(&mut detector, 300, |i| drift(i) + 1e-3 * noise.normal()),
        None
    );
    let (level, variance) = detector.level();
    assert!((level - drift(300)).abs() < 2e-3, "{level}");
    assert!(variance > 0.0 && variance < 1e-6);

    let mut detector = Detector::new(h, FRICTION, NOISE);
    let found = run(&mut detector, 200, |i| {
        -2e-3 * (i.saturating_sub(100) as f32) + 1e-3 * noise.normal()
    });
    assert!(
        matches!(found, Some((100..=110, Finding::Softer { .. }))),
        "{found:?}"
    );

    // A record that is rougher than it says: an alternating misfit of five deviations moves neither sum for long.
    let mut detector = Detector::new(h, FRICTION, NOISE);
    let found = run(
        &mut detector,
        300,
        |i| if i % 2 == 0 { 5e-3 } else { -5e-3 },
    );
    assert!(
        matches!(found, Some((_, Finding::Stale { misfit_nm })) if misfit_nm > 3e-3),
        "{found:?}"
    );
}

#[test]
fn nonsense_is_ignored() {
    let mut detector = Detector::new(threshold(1e-4, 300.0), FRICTION, NOISE);
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(detector.push(value, WIDTH), Finding::Free);
    }
    let mut silent = Detector::new(7.0, 0.0, 0.0);
    for _ in 0..3 * LAG {
        assert_eq!(silent.push(0.0, 0), Finding::Free);
    }
    assert!(silent.level().0.is_finite());
}
