//! A finger of three phalanges that touches with its last one: joint 2, which the free finger closed, turns back, and its pulley first
//! holds it. The path that sensing follows, next to the plant, which shares no code with it. Simulated.

use palpate::finger::{Contact, Mechanics as LibraryMechanics, Mounting};
use palpate::scene::Scene;
use palpate_plant::{CableEnd, Grasp, Mechanics, Parameters, Quasistatic, Shape};
use palpate_scenes::Tendon3;

const CLOSING_RAD_PER_S: f64 = 0.3;
const STEP_S: f64 = 1e-4;
/// Radius of the pin, metre, and the angle of joint 1 at contact, radian.
const RADIUS_M: f64 = 0.005;
const THETA_1_RAD: f64 = 0.8;
/// Rises of the torque at which both are compared, newton metre.
const RISES_NM: [f64; 8] = [0.003, 0.006, 0.009, 0.012, 0.02, 0.03, 0.04, 0.05];
/// A joint that has turned by less still stands, radian: the plant's friction creeps.
const STANDS_RAD: f64 = 3e-4;
/// Largest difference while joint 2 stands and once it turns, radian, and the share of the rotation that comes to the second.
const OFF_RAD: [f64; 2] = [1e-3, 2e-4];
const OFF_SHARE: f64 = 0.01;

/// Closes on a pin at a place of phalanx 3. Returns rotations since contact for each rise of the torque, radian: of the plant's input link,
/// of its joint 2, and of the path's input link, with losses and without.
fn turned(k_m: f64) -> Vec<[f64; 4]> {
    let mut parameters = Parameters::of("tendon3").expect("a scene of this project");
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let [loss, _] = <<Tendon3 as Scene>::Finger as LibraryMechanics>::JOINT_LOSS;
    parameters.mechanism.capstan_share = loss.into();
    let mut plant = Quasistatic::new(&parameters).expect("the defaults are valid");
    let shape = Shape::Cylinder {
        diameter_m: 2.0 * RADIUS_M,
    };
    plant
        .place(&Grasp::touching(3, k_m, THETA_1_RAD, shape))
        .expect("clear of the open finger");
    let stiffness_nm_per_rad = parameters.cable_stiffness_nm_per_rad();
    let mut at_rad = plant.state().stops_rad[0];
    let mut began = None;
    let mut turned = Vec::new();
    while turned.len() < RISES_NM.len() {
        at_rad += CLOSING_RAD_PER_S * STEP_S;
        let end = CableEnd {
            low_rad: at_rad,
            high_rad: at_rad,
            stiffness_nm_per_rad,
        };
        plant.step(&end, STEP_S);
        let state = plant.state();
        let Some(contact) = state.contacts.first() else {
            continue;
        };
        assert_eq!((state.contacts.len(), contact.phalanx), (1, 3), "{k_m}");
        let (theta_a_rad, joint_rad, torque_nm, paths) = began.get_or_insert_with(|| {
            let near = finger.rest();
            let free = finger.free_at_angle(state.theta_a_rad as f32, &near);
            let free = free.expect("a posture");
            let half_m = parameters.mechanism.phalanx_half_thickness_m;
            let contact = Contact {
                phalanx: 3,
                k_m: contact.k_m as f32,
                radius_m: (RADIUS_M + half_m) as f32,
            };
            let path = finger.path(&free.configuration, free.torque_nm, contact);
            let mut paths = [path.expect("a contact"); 2];
            finger.lose(&mut paths[0]);
            (
                state.theta_a_rad,
                state.joint_rad[1],
                state.torque_nm,
                paths,
            )
        });
        let rise_nm = state.torque_nm - *torque_nm;
        if rise_nm >= RISES_NM[turned.len()] {
            let [lossy, lossless] = paths.each_mut().map(|path| {
                let point = finger.follow(path, rise_nm as f32);
                f64::from(point.expect("on the path").rotation_rad)
            });
            turned.push([
                state.theta_a_rad - *theta_a_rad,
                state.joint_rad[1] - *joint_rad,
                lossy,
                lossless,
            ]);
        }
    }
    turned
}

#[test]
fn a_joint_that_turns_back_is_held_as_in_the_plant() {
    let mut stood = 0;
    for k_m in [0.010, 0.020, 0.030, 0.040] {
        for [link_rad, joint_rad, lossy_rad, lossless_rad] in turned(k_m) {
            let told = [link_rad, joint_rad, lossy_rad, lossless_rad].map(|rad| 1e3 * rad);
            println!("{:.0} mm: {told:.2?} mrad", 1e3 * k_m);
            let off_rad = (lossy_rad - link_rad).abs();
            let stands = joint_rad.abs() < STANDS_RAD;
            let most_rad = if stands {
                OFF_RAD[0]
            } else {
                OFF_RAD[1] + OFF_SHARE * link_rad
            };
            assert!(off_rad < most_rad, "{k_m}: {told:?}");
            // Without losses joint 2 would turn back at once, and the input link would turn farther.
            assert!(
                stands || lossless_rad - link_rad > 5.0 * off_rad,
                "{k_m}: {told:?}"
            );
            stood += u32::from(stands);
        }
    }
    assert!((8..24).contains(&stood), "{stood}");
}
