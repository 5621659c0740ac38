//! Large objects: a cylinder of up to 0.2 m turns more of the curve into its own bend than the contact's place does. Simulated.

use crate::support::calibrated_on_pins;
use palpate::sensing::Event;
use palpate_plant::{Engine, Grasp, Shape, World};
use palpate_scenes::P70;

const DIAMETERS_M: [f64; 4] = [0.06, 0.1, 0.15, 0.2];
const PLACES_M: [f64; 3] = [0.015, 0.03, 0.045];

/// Places told, those within two deviations, and the mean error in metre.
fn felt(world: &str, engine: Engine) -> (u32, u32, f64) {
    let mut world = World::named(world).expect("a world");
    world.engine = engine;
    let (mut located, mut within, mut error_m) = (0, 0, 0.0);
    for seed in [5, 6, 7] {
        let parameters = world.of("p70").expect("a scene").randomised(seed);
        let mut simulation = calibrated_on_pins::<P70>(&parameters, 0.07, 0.7);
        for diameter_m in DIAMETERS_M {
            for k_m in PLACES_M {
                let shape = Shape::Cylinder { diameter_m };
                let outcome = simulation
                    .close(&Grasp::touching(2, k_m, 0.7, shape))
                    .expect("closes");
                simulation.open().expect("opens");
                for (_, event) in &outcome.events {
                    if let Event::Located {
                        phalanx: 2,
                        k_m: told_m,
                        sigma_m,
                        settled: true,
                        ..
                    } = event
                    {
                        let off_m = (f64::from(*told_m) - k_m).abs();
                        located += 1;
                        within += u32::from(off_m < 2.0 * f64::from(*sigma_m));
                        error_m += off_m;
                    }
                }
            }
        }
    }
    error_m /= f64::from(located);
    println!(
        "{located} located, {within} within two deviations, off by {:.2} mm",
        1e3 * error_m
    );
    (located, within, error_m)
}

fn check(world: &str, engine: Engine) {
    let (located, within, error_m) = felt(world, engine);
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
