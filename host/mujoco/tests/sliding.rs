//! Compares both worlds while a phalanx slides on a fixed pin with friction: torque, place and force agree within 0.5 % up to the end of
//! a probing. MuJoCo softens friction. If it is too soft, a contact that slides fast under a large force loses part of it, and so does a
//! joint that turns. What pulleys and joints take may add as much to what the worlds differ by without it.

use palpate_mujoco::{MujocoFinger, Surroundings};
use palpate_plant::{CableEnd, Grasp, Mechanics, Parameters, Quasistatic, Shape};

/// Largest deviation, as a share.
const SHARE: f64 = 0.005;
const CLOSING_RAD_PER_S: f64 = 0.3;
const STEP_S: f64 = 1e-4;
/// Torques between which the worlds are compared, newton metre: below, the engine's finger still bounces.
const TORQUES_NM: [f64; 2] = [0.1, 0.4];

/// Compares both worlds while a phalanx closes on a pin; the largest deviation of torque, force and place, as a share, and the number of
/// states compared.
fn compared(parameters: &Parameters, pin: &Grasp) -> (f64, u32) {
    let mut own = Quasistatic::new(parameters).expect("the defaults are valid");
    let mut mujoco = MujocoFinger::new(parameters, &Surroundings::default()).expect("a model");
    own.place(pin).expect("clear of the open finger");
    mujoco.place(pin).expect("clear of the open finger");
    let stiffness_nm_per_rad = parameters.cable_stiffness_nm_per_rad();
    let (mut at_rad, mut worst, mut compared) = (own.state().stops_rad[0], 0.0f64, 0);
    while own.state().torque_nm < TORQUES_NM[1] {
        at_rad += CLOSING_RAD_PER_S * STEP_S;
        let end = CableEnd {
            low_rad: at_rad,
            high_rad: at_rad,
            stiffness_nm_per_rad,
        };
        own.step(&end, STEP_S);
        mujoco.step(&end, STEP_S);
        let (own, mujoco) = (own.state(), mujoco.state());
        if own.torque_nm < TORQUES_NM[0] {
            continue;
        }
        let ([told], [other]) = (&own.contacts[..], &mujoco.contacts[..]) else {
            // Only a finger of three phalanges may end otherwise: a second one touches.
            let touching = own.contacts.len().max(mujoco.contacts.len());
            assert!(own.phalanges > 2 && touching > 1, "{own:?} {mujoco:?}");
            break;
        };
        for (own, other) in [
            (own.torque_nm, mujoco.torque_nm),
            (told.force_n, other.force_n),
            (told.k_m, other.k_m),
        ] {
            worst = worst.max((other / own - 1.0).abs());
        }
        compared += 1;
    }
    (worst, compared)
}

const PIN: Shape = Shape::Cylinder { diameter_m: 0.01 };

#[test]
fn friction_is_the_same_while_a_contact_slides() {
    for friction in [0.0, 0.2, 0.5] {
        for k_m in [0.021, 0.052] {
            let mut parameters = Parameters::of("p70").expect("a scene of this project");
            parameters.contact.friction = friction;
            let (worst, compared) = compared(&parameters, &Grasp::touching(2, k_m, 0.8, PIN));
            println!(
                "friction {friction}, {:.0} mm: {:.2} % in {compared} states",
                1e3 * k_m,
                1e2 * worst
            );
            assert!(
                compared > 1000 && worst < SHARE,
                "{friction} {k_m}: {worst}"
            );
        }
    }
}

/// Compares what pulleys take of the tension and the friction of joints with the same closing without either.
#[test]
fn losses_are_the_same_while_joints_turn() {
    for (scene, phalanx, k_m) in [
        ("tendon2", 2, 0.035),
        ("return2", 2, 0.035),
        ("tendon3", 2, 0.030),
        ("tendon3", 3, 0.020),
    ] {
        let mut lossless = None;
        for (capstan_share, joint_friction_nm) in
            [(0.0, 0.0), (0.0, 1e-3), (0.03, 0.0), (0.08, 1e-3)]
        {
            let mut parameters = Parameters::of(scene).expect("a scene of this project");
            parameters.mechanism.capstan_share = capstan_share;
            parameters.mechanism.joint_friction_nm = joint_friction_nm;
            let pin = Grasp::touching(phalanx, k_m, 0.8, PIN);
            let (worst, compared) = compared(&parameters, &pin);
            println!(
                "{scene}, {capstan_share} lost and {joint_friction_nm} N m, {:.0} mm of phalanx {phalanx}: {:.2} % in {compared} states",
                1e3 * k_m,
                1e2 * worst
            );
            let lossless = *lossless.get_or_insert(worst);
            assert!(
                compared > 300 && worst < lossless + SHARE,
                "{scene}: {worst}"
            );
        }
    }
}
