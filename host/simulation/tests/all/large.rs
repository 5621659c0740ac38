//! Large objects: a cylinder of up to 0.2 m turns more of the curve into its own bend than the contact's place does. Simulated.

use crate::support::{Places, calibrated_on_pins};
use palpate_plant::{Engine, Grasp, Shape, World};
use palpate_scenes::P70;

const DIAMETERS_M: [f64; 4] = [0.06, 0.1, 0.15, 0.2];
const PLACES_M: [f64; 3] = [0.015, 0.03, 0.045];

/// The places told of three drawn fingers.
fn felt(world: &str, engine: Engine) -> Places {
    let mut world = World::named(world).expect("a world");
    world.engine = engine;
    let mut places = Places::default();
    for seed in [5, 6, 7] {
        let parameters = world.of("p70").expect("a scene").randomised(seed);
        let mut simulation = calibrated_on_pins::<P70>(&parameters, 0.07, 0.7);
        for diameter_m in DIAMETERS_M {
            for k_m in PLACES_M {
                let shape = Shape::Cylinder { diameter_m };
                let grasp = Grasp::touching(2, k_m, 0.7, shape);
                places.feel(&mut simulation, k_m, &grasp);
            }
        }
    }
    places
}

fn check(world: &str, engine: Engine) {
    let places = felt(world, engine);
    let (located, within, error_m) = (places.located, places.within, places.error_m());
    println!(
        "{located} located, {within} within two deviations, off by {:.2} mm",
        1e3 * error_m
    );
    assert!(located >= 34, "{located} of 36");
    assert!(
        f64::from(within) >= 0.85 * f64::from(located),
        "{within} of {located}"
    );
    assert!(error_m < 2e-3, "{error_m}");
}

#[test]
fn places_on_large_objects_are_within_what_is_claimed() {
    check("ideal", Engine::Plant);
    check("workshop", Engine::Plant);
}

#[cfg(feature = "mujoco")]
#[test]
fn places_on_large_objects_in_the_other_engine() {
    check("workshop", Engine::Mujoco);
}
