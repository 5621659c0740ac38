//! A skin of rubber: contact friction holds a phalanx back on the object, or in its place. Whoever builds such a finger sets
//! `contact-friction`. Simulated: the ideal world with that friction alone.

use crate::support::calibrated_on_pins;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::Tendon2;

/// Length of the last phalanx, metre, and the angle of joint 1 at the pins, radian.
const LAST_M: f64 = 0.0675;
const PINS_RAD: f64 = 0.7;
const PLACES_M: [f64; 6] = [0.010, 0.018, 0.026, 0.034, 0.042, 0.050];
const THETA_1_RAD: [f64; 2] = [0.7, 0.9];

/// Closings, located ones, places within two deviations, and the mean error in metre, of a finger whose builder says this of its
/// friction of 0.5.
fn within(stated: f64) -> ([u32; 3], f64) {
    let world = World::named("ideal").expect("a world");
    let mut parameters = world.of("tendon2").expect("a scene");
    parameters.contact.friction = 0.5;
    parameters.contact.stated_friction = stated;
    let mut simulation = calibrated_on_pins::<Tendon2>(&parameters, LAST_M, PINS_RAD);
    let [mut closings, mut located, mut within] = [0; 3];
    let mut error_m = 0.0;
    for theta_1_rad in THETA_1_RAD {
        for k_m in PLACES_M {
            let shape = Shape::Cylinder { diameter_m: 0.012 };
            let outcome = simulation
                .close(&Grasp::touching(2, k_m, theta_1_rad, shape))
                .expect("closes");
            simulation.open().expect("opens");
            closings += 1;
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
                    println!(
                        "{:.1} mm: off by {:.2} mm +- {:.2}",
                        1e3 * k_m,
                        1e3 * off_m,
                        1e3 * sigma_m
                    );
                    located += 1;
                    error_m += off_m;
                    within += u32::from(off_m < 2.0 * f64::from(*sigma_m));
                }
            }
        }
    }
    ([closings, located, within], error_m / f64::from(located))
}

#[test]
fn a_skin_that_the_user_states_has_honest_places() {
    let ([closings, located, honest], stated_m) = within(0.6);
    assert!(2 * located > closings, "{located} of {closings}");
    assert!(honest + 1 >= located, "{honest} of {located}");
    // Nobody else can know: what the scene says of polished plastics is not true of this finger.
    let (_, unknown_m) = within(0.0);
    assert!(stated_m < 0.4 * unknown_m, "{stated_m} {unknown_m}");
}
