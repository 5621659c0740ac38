use super::{Noise, drivetrain};
use crate::finger::{Contact, Mechanics};
use crate::scene::{P70, Scene, Tendon2};
use crate::sensing::curve::Point;
use crate::sensing::fit::{Data, Estimate, Hypothesis, Place, Prior};
use crate::sensing::locator::{Locator, Verdict};
use crate::sensing::{Calibration, NotLocated};

const CALIBRATION: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.01,
    cable_rad_per_nm: 0.5,
    cable_sigma_rad_per_nm: 0.005,
    correlation: 0.0,
    contacts: 2,
    presses: 1,
};

fn prior(onset_rad: f32) -> Prior {
    Prior {
        place: Place::Anywhere,
        radius_m: (0.014, 0.007),
        offset_sigma_nm: 2e-4,
        onset_rad: (onset_rad, 0.03),
        calibration: CALIBRATION,
        creep: [0.0, 0.0],
        inertia_share: 0.0,
        series: core::marker::PhantomData,
    }
}

/// What a contact shows, with what the prior leaves open drawn from it.
fn curve<F: Mechanics>(
    finger: &F,
    onset_rad: f32,
    contact: Contact,
    noise: &mut Noise,
) -> Vec<Point> {
    let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let mut path = finger
        .path(&free.configuration, free.torque_nm, contact)
        .unwrap();
    let factor = 1.0 + CALIBRATION.torque_factor_sigma * noise.normal();
    let cable = CALIBRATION.cable_rad_per_nm + CALIBRATION.cable_sigma_rad_per_nm * noise.normal();
    let offset = 2e-4 * noise.normal();
    let sigma = 2e-4;
    (1..20)
        .map_while(|i| {
            let excess = 0.012 * i as f32;
            // Where the phalanx slips off, the curve ends.
            let rotation = finger.follow(&mut path, factor * excess)?.rotation_rad;
            Some(Point {
                counts: (rotation + cable * excess) / drivetrain().rad_per_count,
                torque_nm: excess + free.torque_nm / factor + offset + sigma * noise.normal(),
                variance_nm2: sigma * sigma,
                blocks: 1,
                ..Point::EMPTY
            })
        })
        .collect()
}

fn locate<F: Mechanics>(finger: &F, onset_rad: f32, points: &[Point]) -> Locator {
    let drivetrain = drivetrain();
    let frame = (onset_rad, &drivetrain);
    let near = finger.rest();
    let mut locator = Locator::default();
    for _ in 0..80 {
        locator.refine(finger, points.iter(), frame, &prior(onset_rad), &near);
    }
    locator
}

fn judged(locator: &Locator) -> Verdict {
    locator.verdict(locator.misfit(), |_| 0.0)
}

#[test]
fn places_and_radii_are_found_within_the_deviation_claimed() {
    let finger = P70::MECHANISM;
    let mut noise = Noise(17);
    let (mut total, mut within, mut radius_within) = (0, 0, 0);
    for i in 0..120 {
        let k_m = 0.004 + 0.064 * noise.uniform() as f32;
        let radius_m = 0.008 + 0.016 * noise.uniform() as f32;
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m,
        };
        let points = curve(&finger, 0.8, contact, &mut noise);
        let verdict = judged(&locate(&finger, 0.8, &points));
        let Verdict::At(estimate @ Estimate { phalanx: 2, .. }) = verdict else {
            panic!("{i}: {contact:?} {verdict:?}");
        };
        total += 1;
        within += usize::from((estimate.k_m - k_m).abs() < 2.0 * estimate.k_sigma_m);
        radius_within +=
            usize::from((estimate.radius_m - radius_m).abs() < 2.0 * estimate.radius_sigma_m);
        assert!(
            (estimate.k_m - k_m).abs() < 4e-3,
            "{i}: {contact:?} {estimate:?}"
        );
    }
    // 90 to 99 %, with the scatter of 120 draws.
    assert!((106..=120).contains(&within), "{within} of {total}");
    assert!(
        (106..=120).contains(&radius_within),
        "{radius_within} of {total}"
    );
}

#[test]
fn a_proximal_contact_has_no_place() {
    let finger = P70::MECHANISM;
    let mut noise = Noise(23);
    for _ in 0..20 {
        let contact = Contact {
            phalanx: 1,
            k_m: 0.045,
            radius_m: 0.0,
        };
        let points = curve(&finger, 0.5, contact, &mut noise);
        let verdict = judged(&locate(&finger, 0.5, &points));
        assert_eq!(verdict, Verdict::Nowhere(NotLocated::Proximal));
    }
}

#[test]
fn a_sprung_finger_works_the_same() {
    let finger = Tendon2::MECHANISM;
    let mut noise = Noise(29);
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.4;
    for k_m in [0.012, 0.025, 0.035] {
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: 0.012,
        };
        let points = curve(&finger, onset_rad, contact, &mut noise);
        // The cable is twisted before the contact, too: the angle that was measured is larger.
        let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
        let measured = onset_rad + CALIBRATION.cable_rad_per_nm * free.torque_nm;
        let verdict = judged(&locate(&finger, measured, &points));
        let Verdict::At(estimate @ Estimate { phalanx: 2, .. }) = verdict else {
            panic!("{k_m}: {verdict:?}");
        };
        assert!(
            (estimate.k_m - k_m).abs() < 3.0 * estimate.k_sigma_m,
            "{k_m}: {estimate:?}"
        );
    }
}

#[test]
fn a_known_place_teaches_the_torque_factor() {
    let finger = P70::MECHANISM;
    let mut noise = Noise(31);
    let contact = Contact {
        phalanx: 2,
        k_m: 0.02,
        radius_m: 0.009,
    };
    let points = curve(&finger, 0.8, contact, &mut noise);
    // The motor is in truth 8 % weaker than thought.
    let points: Vec<Point> = points
        .into_iter()
        .map(|p| Point {
            torque_nm: p.torque_nm / 0.92,
            ..p
        })
        .collect();
    let drivetrain = drivetrain();
    let data = Data {
        points: &points,
        origin_rad: 0.8,
        drivetrain: &drivetrain,
    };
    let prior = Prior {
        place: Place::Known {
            phalanx: 2,
            k_m: 0.02,
            sigma_m: 3e-4,
        },
        calibration: Calibration {
            torque_factor_sigma: 0.115,
            cable_rad_per_nm: 0.5 * 0.92,
            ..CALIBRATION
        },
        ..prior(0.8)
    };
    let mut hypothesis = Hypothesis::new(2, 0.02, 0.07, &prior);
    for _ in 0..20 {
        hypothesis.refine(&finger, &data, &prior, &finger.rest());
    }
    let learned = hypothesis.learned(&prior).unwrap();
    assert!(
        (learned.torque_factor - 0.92).abs() < 3.0 * learned.torque_factor_sigma,
        "{learned:?}"
    );
    assert!(learned.torque_factor_sigma < 0.03, "{learned:?}");
}

#[test]
fn a_curve_of_nonsense_ends_in_no_place() {
    let finger = P70::MECHANISM;
    let zigzag: Vec<Point> = (1..20)
        .map(|i| Point {
            counts: 1000.0 * i as f32,
            torque_nm: if i % 2 == 0 { 0.3 } else { 0.1 },
            variance_nm2: 1e-8,
            blocks: 1,
            ..Point::EMPTY
        })
        .collect();
    let verdict = judged(&locate(&finger, 0.8, &zigzag));
    assert!(
        matches!(verdict, Verdict::Nowhere(_) | Verdict::Undecided),
        "{verdict:?}"
    );
    assert_eq!(
        judged(&locate(&finger, f32::NAN, &zigzag)),
        Verdict::Undecided
    );
    assert_eq!(judged(&locate(&finger, 0.8, &[])), Verdict::Undecided);
}
