//! What a sensor of joint 2 adds to the fit, on curves computed from the finger's path.

use super::locator::{HALF_THICKNESS_M, prior};
use super::{Noise as Random, drivetrain};
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointChange;
use crate::scene::{Scene, Tendon2};
use crate::sensing::Cable;
use crate::sensing::curve::Point;
use crate::sensing::locator::{Data, Locator, LocatorResult};

/// A contact on phalanx 2 without friction: its curve, and what joint 2 has turned at the last point.
struct Grasp {
    measured_rad: f32,
    points: Vec<Point>,
    change: JointChange,
}

fn grasp(onset_rad: f32, k_m: f32) -> Grasp {
    let finger = Tendon2::MECHANISM;
    let cable = prior(0.0).calibration.cable_rad_per_nm;
    let free = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let contact = Contact {
        phalanx: 2,
        k_m,
        radius_m: HALF_THICKNESS_M + 0.005,
    };
    let mut path = (finger.path(&free.configuration, free.torque_nm, contact)).unwrap();
    finger.lose(&mut path);
    let mut random = Random(5);
    let mut points = Vec::new();
    let (mut before_rad, mut turned_rad) = (0.0, 0.0);
    for i in -6..40 {
        let torque_nm = 5e-3 * (i as f32).max(0.0);
        let past_rad = if i <= 0 {
            5e-3 * i as f32
        } else {
            let end = finger.follow(&mut path, torque_nm).unwrap();
            // Until a joint that is to turn back does, the finger is rigid.
            if end.rotation_rad > 0.0 {
                turned_rad = end.joints_rad[1];
            }
            end.rotation_rad.max(0.0) + cable * torque_nm
        };
        let at = finger.free_at_angle(onset_rad + past_rad, &free.configuration);
        let free_nm = at.unwrap().torque_nm;
        points.push(Point {
            counts: past_rad / drivetrain().rad_per_count,
            time_s: past_rad / 0.3,
            excess_nm: torque_nm + free.torque_nm.min(free_nm) - free_nm + 2e-4 * random.normal(),
            free_nm,
            variance_nm2: 4e-8,
            width_counts: (past_rad - before_rad).abs().max(1e-3) / drivetrain().rad_per_count,
            blocks: 1,
            ..Point::EMPTY
        });
        before_rad = past_rad;
    }
    let last = points.last().unwrap();
    Grasp {
        measured_rad: onset_rad + cable * free.torque_nm,
        change: JointChange {
            rad: turned_rad,
            sigma_rad: 3.5e-3,
            excess_nm: last.excess_nm,
            free_nm: last.free_nm,
        },
        points,
    }
}

fn located(grasp: &Grasp, change: Option<JointChange>) -> LocatorResult {
    let finger = Tendon2::MECHANISM;
    let mut prior = prior(grasp.measured_rad);
    (prior.calibration.stiffening_per_nm, prior.noise.level_nm) = (0.0, 1e-4);
    let (drivetrain, near) = (drivetrain(), finger.rest());
    let data = Data {
        points: &grasp.points,
        origin_rad: grasp.measured_rad,
        drivetrain: &drivetrain,
    };
    let mut locator = Locator::<_, Cable>::default();
    assert!(locator.begin(&finger, &data, &prior, &near, true));
    while !locator.step(&finger, &data, &prior, &near, change) {}
    locator.verdict(&prior)
}

/// The input link's angle where joint 1 is at an angle in degree.
fn onset_rad(theta_1_deg: f32) -> f32 {
    let finger = Tendon2::MECHANISM;
    let at = |torque_nm: f32| finger.free_at_torque(torque_nm, &finger.rest()).unwrap();
    let torque_nm = (0..400)
        .map(|i| 1e-3 * i as f32)
        .find(|&torque_nm| finger.joint_rad(&at(torque_nm), 1).unwrap() >= theta_1_deg.to_radians())
        .unwrap();
    finger.input_angle_rad(&at(torque_nm))
}

/// Place and deviation of the likeliest estimate.
fn place(result: &LocatorResult) -> [f32; 2] {
    match result {
        LocatorResult::At(estimate) | LocatorResult::Either([estimate, _]) => {
            [estimate.k_m, estimate.k_sigma_m]
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn where_the_stiffness_does_not_tell_the_place_the_joint_does() {
    for (theta_1_deg, k_m) in [(92.0, 0.04), (94.0, 0.03), (95.0, 0.02)] {
        let grasp = grasp(onset_rad(theta_1_deg), k_m);
        let [_, blind_m] = place(&located(&grasp, None));
        let seeing = located(&grasp, Some(grasp.change));
        let case = format!("{theta_1_deg} {k_m}: {blind_m}, {seeing:?}");
        assert!(matches!(seeing, LocatorResult::At(_)), "{case}");
        let [told_m, sigma_m] = place(&seeing);
        assert!((told_m - k_m).abs() < sigma_m, "{case}");
        assert!(sigma_m < 0.5 * blind_m, "{case}");
    }
}

#[test]
fn a_sensor_that_is_wrong_does_not_decide() {
    for k_m in [0.02, 0.04] {
        let grasp = grasp(onset_rad(60.0), k_m);
        let [blind_m, blind_sigma_m] = place(&located(&grasp, None));
        let [told_m, sigma_m] = place(&located(&grasp, Some(grasp.change)));
        assert!((told_m - k_m).abs() < 2.0 * sigma_m, "{told_m} {sigma_m}");
        assert!(sigma_m < 0.6 * blind_sigma_m, "{sigma_m} {blind_sigma_m}");
        for off_rad in [-0.3, -0.1, 0.1, 0.3, 1e3, f32::MAX] {
            let wrong = JointChange {
                rad: grasp.change.rad + off_rad,
                ..grasp.change
            };
            let [told_m, sigma_m] = place(&located(&grasp, Some(wrong)));
            let case = format!("{off_rad}: {told_m} {sigma_m}, {blind_m} {blind_sigma_m}");
            assert!((told_m - blind_m).abs() < 0.1 * blind_sigma_m, "{case}");
            assert!((sigma_m / blind_sigma_m - 1.0).abs() < 0.05, "{case}");
        }
    }
}
