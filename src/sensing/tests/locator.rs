use super::{Noise as Random, drivetrain};
use crate::finger::{Contact, Mechanics};
use crate::scene::{P70, Scene, Tendon2, Tendon3};
use crate::sensing::curve::Point;
use crate::sensing::locator::{Data, Estimate, Locator, LocatorResult, Noise, Place, Prior};
use crate::sensing::{Cable, Calibration, NotLocated};
use core::marker::PhantomData;

pub(in crate::sensing) const CALIBRATION: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.01,
    cable_rad_per_nm: 0.5,
    cable_sigma_rad_per_nm: 0.005,
    correlation: 0.0,
    stiffening_per_nm: 0.2,
    stiffening_sigma_per_nm: 0.1,
    joint_nm: 0.0,
    joint_sigma_nm: 0.0,
    joint_correlation: 0.0,
    worm_rad: [0.0; 2],
    contacts: 2,
    presses: 1,
};
/// White noise of a block, newton metre.
const WHITE_NM: f32 = 2e-4;
const LEVEL_NM: f32 = 1e-3;
pub(super) const HALF_THICKNESS_M: f32 = 0.006;
const SPEED_RAD_PER_S: f32 = 0.3;

pub(in crate::sensing) fn prior(onset_rad: f32) -> Prior<Cable> {
    Prior {
        place: Place::Anywhere,
        half_thickness_m: HALF_THICKNESS_M,
        friction: [0.1, 0.1],
        joint_nm: [0.1e-3, 0.15e-3],
        onset_rad: [onset_rad, 0.03],
        weight: [0.0; 2],
        held_nm: 0.0,
        preload_nm: 0.0,
        give_m_per_n: 0.0,
        force_scale: None,
        calibration: CALIBRATION,
        leverage_sigma: 0.0,
        noise: Noise {
            wander_nm: 0.4e-3,
            wander_s: 2.0,
            level_nm: LEVEL_NM,
            trend_nm_per_s: 1e-4,
            speed_rad_per_s: SPEED_RAD_PER_S,
            worm_error_rad: 0.0,
        },
        series: PhantomData,
    }
}

/// What a contact shows at steps of the measured angle, with what the prior leaves open drawn from it. The angle of the
/// origin is some way before the onset.
pub(super) fn curve<F: Mechanics>(
    finger: &F,
    onset_rad: f32,
    contact: Contact,
    random: &mut Random,
) -> Vec<Point> {
    let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let path = finger
        .path(&free.configuration, free.torque_nm, contact)
        .unwrap();
    let factor = 1.0 + CALIBRATION.torque_factor_sigma * random.normal();
    let cable = CALIBRATION.cable_rad_per_nm + CALIBRATION.cable_sigma_rad_per_nm * random.normal();
    let friction = (0.1 + 0.1 * random.normal()).max(0.0);
    let stiffening =
        CALIBRATION.stiffening_per_nm + CALIBRATION.stiffening_sigma_per_nm * random.normal();
    // The integral of the cable's compliance over the nominal torque; it is given at 0.17 N m.
    let twist = |from_nm: f32, by_nm: f32| {
        let middle_nm = from_nm + 0.5 * by_nm;
        cable * by_nm * (1.0 - stiffening.max(0.0) * (middle_nm - 0.17))
    };
    let level = LEVEL_NM * random.normal();
    let before_rad = 0.05;
    // The whole path first: excess torque and measured angle since the onset, by rising torque.
    let mut follower = path;
    finger.lose(&mut follower);
    finger
        .rub(&mut follower, friction, HALF_THICKNESS_M)
        .unwrap();
    let mut way = vec![(0.0f32, 0.0f32)];
    for i in 1..400 {
        let torque_nm = 1e-3 * i as f32;
        let Some(point) = finger.follow(&mut follower, factor * torque_nm) else {
            break;
        };
        way.push((
            torque_nm,
            point.rotation_rad + twist(free.torque_nm / factor, torque_nm),
        ));
    }
    let held = |past_rad: f32| {
        let after = way.iter().position(|(_, angle)| *angle >= past_rad)?;
        let (t1, a1) = way[after];
        let (t0, a0) = way[after.checked_sub(1)?];
        Some(t0 + (t1 - t0) * (past_rad - a0) / (a1 - a0))
    };
    let mut points = Vec::new();
    for block in -40..400 {
        let angle = 5e-3 * block as f32 - before_rad + before_rad;
        let past_rad = angle - before_rad;
        let near = &free.configuration;
        let rests = |past: f32| {
            finger
                .free_at_angle(onset_rad + past, near)
                .map_or(0.0, |free| free.torque_nm)
        };
        let free_nm = rests(past_rad);
        let excess_nm = if past_rad <= 0.0 {
            0.0
        } else if let Some(held_nm) = held(past_rad) {
            held_nm + (free.torque_nm - free_nm) / factor
        } else {
            break;
        };
        points.push(Point {
            counts: angle / drivetrain().rad_per_count,
            time_s: angle / SPEED_RAD_PER_S,
            excess_nm: excess_nm + level + WHITE_NM * random.normal(),
            free_nm,
            variance_nm2: WHITE_NM * WHITE_NM,
            width_counts: 5e-3 / drivetrain().rad_per_count,
            blocks: 1,
            ..Point::EMPTY
        });
        if excess_nm > 0.33 {
            break;
        }
    }
    points
}

/// As the curve's bins would have it: some points before, some since.
fn thinned(points: &[Point]) -> Vec<Point> {
    let before = points.iter().filter(|p| p.time_s < 0.0).step_by(10);
    let since: Vec<&Point> = points.iter().filter(|p| p.time_s >= 0.0).collect();
    let step = since.len().div_ceil(36).max(1);
    before
        .chain(since.into_iter().step_by(step))
        .copied()
        .collect()
}

pub(super) fn locate<F: Mechanics>(
    finger: &F,
    onset_rad: f32,
    points: &[Point],
    prior: &Prior<Cable>,
) -> Locator<F, Cable> {
    let drivetrain = drivetrain();
    let points = thinned(points);
    let data = Data {
        points: &points,
        origin_rad: onset_rad - 0.05,
        drivetrain: &drivetrain,
    };
    let near = finger.rest();
    let mut locator = Locator::default();
    if locator.begin(finger, &data, prior, &near, true) {
        let mut steps = 0;
        while !locator.step(finger, &data, prior, &near, ()) {
            steps += 1;
            assert!(steps < 6000);
        }
    }
    locator
}

pub(super) fn judged<F: Mechanics>(finger: &F, onset_rad: f32, points: &[Point]) -> LocatorResult {
    let prior = prior(onset_rad);
    locate(finger, onset_rad, points, &prior).verdict(&prior)
}

#[test]
fn places_are_found_within_the_deviation_claimed() {
    let finger = P70::MECHANISM;
    let mut random = Random(17);
    let (mut total, mut within, mut squares) = (0, 0, 0.0);
    for i in 0..1000 {
        let k_m = 0.004 + 0.062 * random.uniform() as f32;
        let radius_m = HALF_THICKNESS_M + 0.002 + 0.018 * random.uniform() as f32;
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m,
        };
        let points = curve(&finger, 0.8, contact, &mut random);
        let verdict = judged(&finger, 0.8, &points);
        let LocatorResult::At(estimate @ Estimate { phalanx: 2, .. }) = verdict else {
            panic!("{i}: {contact:?} {verdict:?}");
        };
        assert!(estimate.p_phalanx > 0.95, "{estimate:?}");
        let z = (estimate.k_m - k_m) / estimate.k_sigma_m;
        total += 1;
        squares += z * z;
        within += usize::from(z.abs() < 2.0);
        assert!(z.abs() < 4.0, "{i}: {contact:?} {estimate:?}");
    }
    // 90 to 100 %: the noise drawn here is less than the efficiency's that the model allows for.
    assert!(within * 10 >= total * 9, "{within} of {total}");
    let mean = squares / total as f32;
    assert!((0.05..1.3).contains(&mean), "mean z^2 {mean}");
}

#[test]
fn a_proximal_contact_has_no_place() {
    let finger = P70::MECHANISM;
    let mut random = Random(23);
    for _ in 0..20 {
        let contact = Contact {
            phalanx: 1,
            k_m: 0.045,
            radius_m: 0.0,
        };
        let points = curve(&finger, 0.5, contact, &mut random);
        let prior = prior(0.5);
        let locator = locate(&finger, 0.5, &points, &prior);
        let verdict = locator.verdict(&prior);
        assert_eq!(verdict, LocatorResult::Nowhere(NotLocated::Proximal));
        assert!(locator.may_be_proximal());
    }
}

#[test]
fn a_contact_on_a_later_joint_has_no_place() {
    let finger = Tendon3::MECHANISM;
    let mut random = Random(29);
    let mut told = |phalanx: u8, k_m: f32| {
        let contact = Contact {
            phalanx,
            k_m,
            radius_m: HALF_THICKNESS_M + 0.005,
        };
        let points = curve(&finger, 0.8, contact, &mut random);
        let prior = prior(0.8);
        let locator = locate(&finger, 0.8, &points, &prior);
        let verdict = locator.verdict(&prior);
        // What is lost there says nothing of phalanx 1.
        let is_lost = verdict == LocatorResult::Nowhere(NotLocated::Unobservable);
        assert!(!is_lost || !locator.may_be_proximal());
        verdict
    };
    let unobservable = LocatorResult::Nowhere(NotLocated::Unobservable);
    let mut without = 0;
    for _ in 0..40 {
        match told(3, 1e-4) {
            LocatorResult::At(estimate) => assert!(estimate.k_m > 0.02 * 0.045, "{estimate:?}"),
            verdict => without += usize::from(verdict == unobservable),
        }
        let beyond = told(3, 0.006);
        let is_told = matches!(beyond, LocatorResult::At(Estimate { phalanx: 3, .. }));
        assert!(is_told, "{beyond:?}");
    }
    // Without any, this would not try what it is for.
    assert!(without > 0);
}

#[test]
fn a_known_place_teaches_the_torque_factor() {
    let finger = P70::MECHANISM;
    let mut random = Random(31);
    let contact = Contact {
        phalanx: 2,
        k_m: 0.02,
        radius_m: HALF_THICKNESS_M + 0.005,
    };
    // The motor is in truth 8 % weaker than thought.
    let mut points = curve(&finger, 0.8, contact, &mut random);
    for point in &mut points {
        point.excess_nm /= 0.92;
    }
    let prior = Prior {
        place: Place::Known {
            phalanx: 2,
            k_m: 0.02,
            sigma_m: 3e-4,
            radius_m: contact.radius_m,
        },
        calibration: Calibration {
            torque_factor_sigma: 0.115,
            cable_rad_per_nm: 0.5 * 0.92,
            ..CALIBRATION
        },
        ..prior(0.8)
    };
    let mut locator = locate(&finger, 0.8, &points, &prior);
    let learned = locator.learned(&prior).unwrap();
    let (learned, misfit) = (learned.calibration, learned.misfit);
    assert!(misfit < 2.0, "{misfit}");
    assert!(
        (learned.torque_factor - 0.92).abs() < 3.0 * learned.torque_factor_sigma,
        "{learned:?}"
    );
    assert!(learned.torque_factor_sigma < 0.04, "{learned:?}");
}

#[test]
fn a_curve_of_nonsense_ends_in_no_place() {
    let finger = P70::MECHANISM;
    let zigzag: Vec<Point> = (1..20)
        .map(|i| Point {
            counts: 1000.0 * i as f32,
            time_s: 0.03 * i as f32,
            excess_nm: if i % 2 == 0 { 0.3 } else { 0.1 },
            variance_nm2: 1e-8,
            width_counts: 1000.0,
            blocks: 1,
            ..Point::EMPTY
        })
        .collect();
    let verdict = judged(&finger, 0.8, &zigzag);
    assert!(matches!(verdict, LocatorResult::Nowhere(_)), "{verdict:?}");
    let verdict = judged(&finger, f32::NAN, &zigzag);
    assert!(
        matches!(
            verdict,
            LocatorResult::Nowhere(_) | LocatorResult::Undecided
        ),
        "{verdict:?}"
    );
    assert_eq!(judged(&finger, 0.8, &[]), LocatorResult::Undecided);
}

#[test]
fn the_force_is_that_of_the_present_angle() {
    fn check<F: Mechanics>(finger: &F, onset_rad: f32, k_m: f32, random: &mut Random) {
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: HALF_THICKNESS_M + 0.005,
        };
        let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
        let twist_rad = CALIBRATION.cable_rad_per_nm * free.torque_nm;
        let measured = onset_rad + twist_rad;
        let points = curve(finger, onset_rad, contact, random);
        let prior = prior(measured);
        let drivetrain = drivetrain();
        let points = thinned(&points);
        let data = Data {
            points: &points,
            origin_rad: measured - 0.05,
            drivetrain: &drivetrain,
        };
        let near = finger.rest();
        let mut locator = Locator::default();
        assert!(locator.begin(finger, &data, &prior, &near, true));
        while !locator.step(finger, &data, &prior, &near, ()) {}
        let LocatorResult::At(estimate) = locator.verdict(&prior) else {
            panic!("{k_m}");
        };
        // Half way up the curve, and at its end.
        for index in [points.len() / 2, points.len() - 1] {
            let point = &points[index];
            let angle_rad = data.origin_rad + point.counts * drivetrain.rad_per_count;
            let state = locator
                .state(&estimate, finger, &data, &prior, &near, angle_rad)
                .unwrap();
            let mut path = finger
                .path(&free.configuration, free.torque_nm, contact)
                .unwrap();
            finger.lose(&mut path);
            finger.rub(&mut path, 0.1, HALF_THICKNESS_M).unwrap();
            let rise_nm = point.excess_nm + point.free_nm - free.torque_nm;
            let force_n = finger.follow(&mut path, rise_nm).unwrap().force_n;
            // What was drawn of friction's level is in the torque compared with.
            let off_n = (state.force.force_n - force_n).abs();
            let most_n = 2.0 * state.force.sigma_n + 0.02 * force_n;
            assert!(off_n < most_n, "{k_m} {index}: {:?} {force_n}", state.force);
            assert!(state.force.sigma_n > 0.02 * force_n && state.force.sigma_n < 0.3 * force_n);
        }
    }
    let mut random = Random(41);
    for k_m in [0.015, 0.04, 0.06] {
        check(&P70::MECHANISM, 0.8, k_m, &mut random);
    }
    let finger = Tendon2::MECHANISM;
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.4;
    for k_m in [0.015, 0.03] {
        check(&finger, onset_rad, k_m, &mut random);
    }
}
