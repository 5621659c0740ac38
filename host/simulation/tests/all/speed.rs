//! The speed loop against the plant: the fastest load of the experiments must not slow the finger down. Simulated.

use palpate_plant::{Grasp, Parameters, Shape, World};
use palpate_scenes::P70;
use palpate_simulation::{Row, Simulation};

/// Samples over which a speed is averaged: a turn of the motor, whose encoder is uneven.
const TURN: usize = 16;
/// Closing speed, counts per second: 0.3 rad/s of 1,310,720 counts a turn.
const WANTED_COUNTS_PER_S: f64 = 62_582.0;

/// Largest deviation of the speed from the demanded one, as a share, from shortly before the contact to the end of probing.
fn deviation(trace: &[Row], contact_s: f64) -> f64 {
    let mut worst = 0.0f64;
    let mut judged = 0;
    for span in trace.windows(TURN + 1) {
        let (first, last) = (&span[0], &span[TURN]);
        let probing = last.true_torque_nm > 1e-3 && last.true_torque_nm < 0.34 && last.duty > 0.0;
        if first.time_s < contact_s - 0.1 || last.time_s > contact_s && !probing {
            continue;
        }
        let counts = f64::from(last.encoder_counts - first.encoder_counts);
        let share = counts / (last.time_s - first.time_s) / WANTED_COUNTS_PER_S - 1.0;
        worst = worst.max(share.abs());
        judged += 1;
    }
    assert!(judged > 200, "{judged}");
    worst
}

#[test]
fn speed_is_held_under_the_fastest_load() {
    let workshop = || -> Parameters {
        let world = World::named("workshop").expect("a named world");
        world.of("p70").expect("valid")
    };
    // The stiffest cable of the spreads, far out on the distal phalanx: the torque rises by 1.2 N m/s.
    let mut all = Vec::new();
    for cable_n_per_m in [3e3, 10e3] {
        let mut parameters = workshop();
        parameters.cable.stiffness_n_per_m = cable_n_per_m;
        let mut simulation = Simulation::<P70>::new(&parameters, 1).expect("valid");
        simulation.prepare().expect("accepted");
        simulation.traced = true;
        let pin = Shape::Cylinder { diameter_m: 0.01 };
        let outcome = simulation
            .close(&Grasp::touching(2, 0.06, 0.8, pin))
            .expect("accepted");
        let contact_s = outcome.first_contact.expect("touched").time_s;
        let worst = deviation(&outcome.trace, contact_s);
        println!("{cable_n_per_m} N/m: {:.2} %", 100.0 * worst);
        all.push(worst);
    }
    assert!(all.iter().all(|worst| *worst < 0.03), "{all:?}");
}
