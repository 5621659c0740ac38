//! A finger whose first phalanx lies within the palm: every place of the two others has a stiffness of its own. Simulated.

use crate::support::{calibrated_on_pins, close_and_open, settled};
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::Hidden3;
use palpate_simulation::{Simulation, Verdict};

const LAST_M: f64 = 0.0675;
const PINS_RAD: f64 = 0.7;
/// Phalanx and place, metre.
const PLACES: [(u8, f64); 6] = [
    (2, 0.012),
    (2, 0.040),
    (2, 0.075),
    (3, 0.012),
    (3, 0.034),
    (3, 0.055),
];

#[test]
fn every_place_on_both_phalanges_is_told() {
    let world = World::named("ideal").expect("a world");
    let parameters = world.of("hidden3").expect("a scene");
    let mut simulation = calibrated_on_pins::<Hidden3>(&parameters, LAST_M, PINS_RAD);
    for (phalanx, k_m) in PLACES {
        let shape = Shape::Cylinder { diameter_m: 0.010 };
        let grasp = Grasp::touching(phalanx, k_m, 0.8, shape);
        let outcome = close_and_open(&mut simulation, &grasp);
        let told = settled(&outcome);
        println!("{phalanx} at {:.1} mm: {told:.4?}", 1e3 * k_m);
        let (on, [told_m, sigma_m]) = told.unwrap_or_else(|| panic!("{:?}", outcome.verdict));
        assert_eq!(on, phalanx);
        let off_m = (told_m - k_m).abs();
        assert!(off_m < 2.0 * sigma_m && off_m < 0.005, "{off_m} {sigma_m}");
    }
}

#[test]
fn what_only_the_hidden_phalanx_meets_is_not_touched() {
    let world = World::named("ideal").expect("a world");
    for engine in ["plant", "mujoco"] {
        let mut parameters = world.of("hidden3").expect("a scene");
        parameters.engine = engine.parse().expect("an engine");
        let mut simulation = Simulation::<Hidden3>::new(&parameters, 1).expect("a simulation");
        simulation.prepare().expect("a record");
        simulation.traced = true;
        // In the way of phalanx 1, which closes by more than 1 rad, and nearer to joint 1 than the others come.
        let behind = Grasp::At {
            origin_m: [0.015, 0.012],
            angle_rad: 0.0,
            shape: Shape::Cylinder { diameter_m: 0.004 },
        };
        let outcome = simulation.close(&behind).expect("closes");
        assert_eq!(outcome.first_contact, None, "{engine}");
        assert!(
            outcome.trace.iter().all(|row| row.true_pressing == 0),
            "{engine}"
        );
    }
}

/// Stiffness of a cable at the stiff end of its range, newton per metre, and places near the end of phalanx 2, metre.
const STIFF_N_PER_M: f64 = 8300.0;
const BEFORE_JOINT_3_M: [f64; 4] = [0.056, 0.060, 0.066, 0.072];

/// Without a calibration the end of phalanx 2 behind a stiff cable looks like the beginning of phalanx 3 behind a soft one; a prior that
/// takes a stiff cable for next to impossible names phalanx 3.
#[test]
fn a_stiff_cable_is_not_taken_for_the_next_phalanx() {
    let world = World::named("workshop").expect("a world");
    let mut parameters = world.of("hidden3").expect("a scene");
    parameters.cable.stiffness_n_per_m = STIFF_N_PER_M;
    let mut simulation = Simulation::<Hidden3>::new(&parameters, 1).expect("a simulation");
    simulation.prepare().expect("a record");
    let mut right = 0;
    for k_m in BEFORE_JOINT_3_M {
        let grasp = Grasp::touching(2, k_m, 0.8, Shape::Cylinder { diameter_m: 0.010 });
        let outcome = close_and_open(&mut simulation, &grasp);
        println!("{:.0} mm: {:?}", 1e3 * k_m, outcome.verdict);
        right += match outcome.verdict {
            Verdict::Located { phalanx: 2, .. } => 1,
            // Both are named.
            Verdict::Ambiguous { phalanx, .. } => usize::from(phalanx[0] == 2),
            _ => 0,
        };
    }
    assert!(right + 1 >= BEFORE_JOINT_3_M.len(), "{right}");
}
