//! Compares both worlds while a phalanx slides on a fixed pin with friction: torque, place and force agree within 0.5 % up to the end of
//! a probing. MuJoCo softens friction. If it is too soft, a contact that slides fast under a large force loses part of it.

use palpate_mujoco::{MujocoFinger, Surroundings};
use palpate_plant::{CableEnd, Contact, Grasp, Mechanics, Parameters, Quasistatic, Shape};

/// Largest deviation, as a share.
const SHARE: f64 = 0.005;
const CLOSING_RAD_PER_S: f64 = 0.3;
const STEP_S: f64 = 1e-4;
/// Torques between which the worlds are compared, newton metre: below, the engine's finger still bounces.
const TORQUES_NM: [f64; 2] = [0.1, 0.4];

#[test]
fn friction_is_the_same_while_a_contact_slides() {
    for friction in [0.0, 0.2, 0.5] {
        for k_m in [0.021, 0.052] {
            let mut parameters = Parameters::of("p70").expect("a scene of this project");
            parameters.contact.friction = friction;
            let mut own = Quasistatic::new(&parameters).expect("the defaults are valid");
            let mut mujoco =
                MujocoFinger::new(&parameters, &Surroundings::default()).expect("a model");
            let pin = Grasp::touching(2, k_m, 0.8, Shape::Cylinder { diameter_m: 0.01 });
            own.place(&pin).expect("clear of the open finger");
            mujoco.place(&pin).expect("clear of the open finger");
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
                let [
                    Contact {
                        k_m: own_k_m,
                        force_n: own_n,
                        ..
                    },
                ] = own.contacts[..]
                else {
                    panic!("{:?}", own.contacts);
                };
                let [
                    Contact {
                        k_m: k_now_m,
                        force_n,
                        ..
                    },
                ] = mujoco.contacts[..]
                else {
                    panic!("{:?}", mujoco.contacts);
                };
                for (own, other) in [
                    (own.torque_nm, mujoco.torque_nm),
                    (own_n, force_n),
                    (own_k_m, k_now_m),
                ] {
                    worst = worst.max((other / own - 1.0).abs());
                }
                compared += 1;
            }
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
