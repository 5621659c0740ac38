//! Fingers whose joint 2 stands at its stop until a break-away torque, which tells the place of a contact beside the stiffness from then
//! on: a preloaded spring, and a return cable in place of springs. Simulated.

use crate::support::{calibrated_on_pins, close_and_open, settled};
use palpate_plant::{Grasp, Parameters, Shape, World};
use palpate_scenes::{P70Preloaded, Return2};
use palpate_simulation::Simulated;

const PINS_RAD: f64 = 0.7;
const PLACES_M: [f64; 7] = [0.008, 0.016, 0.024, 0.032, 0.040, 0.048, 0.056];

/// Places told of contacts all along the last phalanx, with their deviations, metre; `None` where there was none.
fn told<S: Simulated>(parameters: &Parameters, last_m: f64) -> Vec<Option<[f64; 2]>> {
    let mut simulation = calibrated_on_pins::<S>(parameters, last_m, PINS_RAD);
    PLACES_M
        .map(|k_m| {
            let shape = Shape::Cylinder { diameter_m: 0.010 };
            let grasp = Grasp::touching(2, k_m, 0.8, shape);
            let outcome = close_and_open(&mut simulation, &grasp);
            let on_phalanx_2 = settled(&outcome).filter(|(phalanx, _)| *phalanx == 2);
            let told = on_phalanx_2.map(|(_, place)| place);
            println!(
                "{:.1} mm: {told:.4?} {:?} {:?}",
                1e3 * k_m,
                outcome.verdict,
                outcome.events
            );
            told
        })
        .into()
}

/// Most that a place may be off, metre; one on the wrong side of the kink that the break-away torque puts into the curve may be further.
const OFF_M: f64 = 0.004;

/// Compares all places with the truth in both engines; `beyond` of them may be farther off than [`OFF_M`].
fn every_place_is_told<S: Simulated>(scene: &str, last_m: f64, beyond: usize) {
    let world = World::named("ideal").expect("a world");
    let mut far = 0;
    for engine in ["plant", "mujoco"] {
        let mut parameters = world.of(scene).expect("a scene");
        parameters.engine = engine.parse().expect("an engine");
        println!("{scene}, {engine}");
        let mut sum_m = 0.0;
        for (k_m, told) in PLACES_M.iter().zip(told::<S>(&parameters, last_m)) {
            let [told_m, sigma_m] = told.unwrap_or_else(|| panic!("{k_m}"));
            let off_m = (told_m - k_m).abs();
            assert!(off_m < 2.0 * sigma_m && off_m < 0.006, "{off_m} {sigma_m}");
            far += usize::from(off_m >= OFF_M);
            sum_m += off_m;
        }
        let mean_m = sum_m / PLACES_M.len() as f64;
        assert!(mean_m < 0.002, "off by {mean_m} on average");
    }
    assert!(far <= beyond, "{far} are far off");
}

#[test]
fn a_return_cable_lets_every_place_be_told() {
    // At 56 mm, where the break-away torque is the largest, MuJoCo's is told 5.7 +- 4.6 mm off.
    every_place_is_told::<Return2>("return2", 0.0675, 1);
}

#[test]
fn a_preloaded_spring_lets_every_place_be_told() {
    every_place_is_told::<P70Preloaded>("p70-preloaded", 0.070, 0);
}
