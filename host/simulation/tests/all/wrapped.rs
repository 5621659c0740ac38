//! Fingers of three phalanges that go on closing round an object after the first contact: until a second phalanx touches, the
//! curve is the first contact's, and its place must not bend to what comes after. Simulated.

use crate::support::calibrated_on_pins;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::Tendon3;
use palpate_simulation::Simulation;

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

/// Weight of a printed finger that carries as much again, kilogram per metre, and gravity.
const HEAVY_KG_PER_M: f64 = 0.2;
const GRAVITY_M_PER_S2: f64 = 9.81;

/// A heavy finger that its weight opens folds round a pin near the last joint. What it learns there must not differ from what a pin near
/// the tip teaches, which one phalanx touches: from the whole curve it learnt 0.65 for 0.91.
#[test]
fn a_pin_that_two_phalanges_touch_teaches_what_one_that_one_touches_does() {
    let world = World::named("ideal").expect("a world");
    let mut parameters = world.of("tendon3").expect("a scene");
    parameters.mechanism.linear_density_kg_per_m = HEAVY_KG_PER_M;
    parameters.mechanism.gravity_m_per_s2 = GRAVITY_M_PER_S2;
    let mut pressed = Simulation::<Tendon3>::new(&parameters, 1).expect("a simulation");
    pressed.prepare().expect("a record");
    pressed.traced = true;
    let [near, far] = [(0.3, 2), (0.75, 1)].map(|(share, touching)| {
        let mut simulation = pressed.clone();
        let outcome = simulation
            .calibrate(3, (share * LAST_M) as f32, PINS_RAD)
            .expect("a pin");
        let most = (outcome.trace.iter()).map(|row| row.true_pressing.count_ones());
        assert_eq!(most.max(), Some(touching), "{share}");
        let learned = *simulation.calibration();
        println!("{share}: {learned:?}");
        assert_eq!(learned.contacts, 1, "{share}: {:?}", outcome.events);
        learned
    });
    let apart = (near.torque_factor / far.torque_factor).ln().abs();
    let sigma = near.torque_factor_sigma.hypot(far.torque_factor_sigma);
    assert!(apart < 1.5 * sigma, "{apart} {sigma}");
    // It is the surer of the two, being nearer to the joint, unless a curve that does not fit spoils it.
    assert!(near.torque_factor_sigma < far.torque_factor_sigma);
}
