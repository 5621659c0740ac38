//! What the length of the engine's step does: a closing in every named world, in contact, with steps of 50 us (the control period)
//! and with the usual ones. What the drivetrain feels is the same within 0.1 %; in the harsh world, whose contacts and pulleys rub
//! most, within 0.5 %.

use palpate_mujoco::{MujocoFinger, Surroundings};
use palpate_plant::{CableEnd, Grasp, Mechanics, Parameters, Shape, World, world_names};

/// A control period, second.
const PERIOD_S: f64 = 50e-6;
/// Speed of the cable's end, radian per second: that of a closing.
const SPEED_RAD_PER_S: f64 = 0.3;

/// Torque in newton metre, force in newton and place in metre along the way, once in contact.
fn closing(parameters: &Parameters, step_s: Option<f64>) -> Vec<[f64; 3]> {
    let surroundings = Surroundings::default();
    let mut finger = match step_s {
        Some(step_s) => MujocoFinger::with_step(parameters, &surroundings, step_s),
        None => MujocoFinger::new(parameters, &surroundings),
    }
    .expect("a valid model");
    let start = finger.state().stops_rad[0] + 0.2;
    let end = |rad: f64| CableEnd {
        low_rad: rad,
        high_rad: rad,
        stiffness_nm_per_rad: parameters.cable_stiffness_nm_per_rad(),
    };
    finger.settle(&end(start));
    let object = Shape::Cylinder { diameter_m: 0.02 };
    // Past the rest angle of the springs.
    let theta_1_rad = if parameters.finger.spring_nm_per_rad[0] > 0.0 {
        0.8
    } else {
        0.3
    };
    finger
        .place(&Grasp::touching(2, 0.035, theta_1_rad, object))
        .expect("clear of the open finger");
    let mut felt = Vec::new();
    let mut at = start;
    for period in 0.. {
        at += SPEED_RAD_PER_S * PERIOD_S;
        finger.step(&end(at), PERIOD_S);
        let state = finger.state();
        if state.torque_nm > 0.3 {
            break;
        }
        assert!(at < start + 2.0, "no contact");
        // Every 20 ms, past the impact.
        if period % 400 == 0
            && let [contact] = state.contacts[..]
            && contact.force_n > 0.5
        {
            felt.push([state.torque_nm, contact.force_n, contact.k_m]);
        }
    }
    felt
}

#[test]
fn a_longer_step_feels_the_same() {
    for name in world_names() {
        let allowed = if name == "harsh" { 5e-3 } else { 1e-3 };
        for scene in ["p70", "tendon2", "linkage3"] {
            let world = World::named(name).expect("known");
            let parameters = world.of(scene).expect("a scene of this project");
            let (short, usual) = (
                closing(&parameters, Some(PERIOD_S)),
                closing(&parameters, None),
            );
            assert!(!short.is_empty() && short.len().abs_diff(usual.len()) <= 1);
            let mut worst = [0.0f64; 3];
            for (short, usual) in short.iter().zip(&usual) {
                for ((worst, short), usual) in worst.iter_mut().zip(short).zip(usual) {
                    *worst = worst.max((short - usual).abs() / short);
                }
            }
            println!("{name} {scene}: {} states, {worst:.6?}", short.len());
            assert!(
                worst.iter().all(|worst| *worst < allowed),
                "{name} {scene}: {worst:?}"
            );
        }
    }
}
