//! Fingers of three phalanges that go on closing round an object after the first contact: until a second phalanx touches, the
//! curve is the first contact's, and its place must not bend to what comes after. Simulated.

use crate::support::calibrated_on_pins;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::Tendon3;

/// Length of the last phalanx, metre, and the angle of joint 1 at the pins, radian.
const LAST_M: f64 = 0.045;
const PINS_RAD: f64 = 0.6;
/// Phalanx and place of the first contact, metre.
const PLACES: [(u8, f64); 4] = [(2, 0.037), (2, 0.042), (3, 0.012), (3, 0.018)];
/// Cylinders so large that another phalanx comes to touch them too, metre.
const DIAMETERS_M: [f64; 3] = [0.012, 0.025, 0.040];
const THETA_1_RAD: [f64; 2] = [0.75, 0.85];

#[test]
fn a_second_phalanx_that_touches_later_does_not_move_the_first_place() {
    let world = World::named("ideal").expect("a world");
    let parameters = world.of("tendon3").expect("a scene");
    let mut simulation = calibrated_on_pins::<Tendon3>(&parameters, LAST_M, PINS_RAD);
    simulation.traced = true;
    let (mut both, mut within, mut located, mut forces) = (0, 0, 0, 0);
    for theta_1_rad in THETA_1_RAD {
        for (phalanx, k_m) in PLACES {
            for diameter_m in DIAMETERS_M {
                let shape = Shape::Cylinder { diameter_m };
                let grasp = Grasp::touching(phalanx, k_m, theta_1_rad, shape);
                let Ok(outcome) = simulation.close(&grasp) else {
                    continue;
                };
                simulation.open().expect("opens");
                let first = outcome.first_contact.expect("a contact").contact;
                let pressing = (outcome.trace.iter()).map(|row| row.true_pressing.count_ones());
                if first.phalanx != phalanx || pressing.max() < Some(2) {
                    continue;
                }
                both += 1;
                let told = (outcome.events.iter().rev()).find_map(|(_, event)| match *event {
                    Event::Located {
                        phalanx,
                        k_m,
                        sigma_m,
                        force_n,
                        settled: true,
                        ..
                    } => Some((phalanx, [k_m, sigma_m, force_n].map(f64::from))),
                    _ => None,
                });
                println!(
                    "{phalanx} at {:.1} mm, {diameter_m} m, {theta_1_rad} rad: {told:.4?}",
                    1e3 * first.k_m
                );
                if let Some((on, [told_m, sigma_m, force_n])) = told {
                    located += 1;
                    let near = (told_m - first.k_m).abs() < 2.0 * sigma_m;
                    within += u32::from(on == phalanx && near);
                    forces += u32::from(force_n.is_finite());
                }
            }
        }
    }
    println!("{both} with two contacts, {located} located, {within} within, {forces} forces");
    assert!(both >= 12 && located >= 10);
    assert!(within + 1 >= located, "{within} of {located}");
    // Two contacts share the force.
    assert!(4 * forces <= located, "{forces} of {located}");
}
