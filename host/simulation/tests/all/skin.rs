//! A skin of rubber: contact friction holds a phalanx back on the object, or in its place. Whoever builds such a finger sets
//! `contact-friction`. Simulated: the ideal world with that friction alone.

use crate::support::{Places, calibrated_on_pins};
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::Tendon2;

/// Length of the last phalanx, metre, and the angle of joint 1 at the pins, radian.
const LAST_M: f64 = 0.0675;
const PINS_RAD: f64 = 0.7;
const PLACES_M: [f64; 6] = [0.010, 0.018, 0.026, 0.034, 0.042, 0.050];
const THETA_1_RAD: [f64; 2] = [0.7, 0.9];

/// The places that a finger tells whose builder says this of its friction of 0.5.
fn felt(stated: f64) -> Places {
    let world = World::named("ideal").expect("a world");
    let mut parameters = world.of("tendon2").expect("a scene");
    parameters.contact.friction = 0.5;
    parameters.contact.stated_friction = stated;
    let mut simulation = calibrated_on_pins::<Tendon2>(&parameters, LAST_M, PINS_RAD);
    let mut places = Places::default();
    for theta_1_rad in THETA_1_RAD {
        for k_m in PLACES_M {
            let shape = Shape::Cylinder { diameter_m: 0.012 };
            let grasp = Grasp::touching(2, k_m, theta_1_rad, shape);
            places.feel(&mut simulation, k_m, &grasp);
        }
    }
    places
}

#[test]
fn a_skin_that_the_user_states_has_honest_places() {
    let stated = felt(0.6);
    assert!(2 * stated.located > stated.closings, "{stated:?}");
    assert!(stated.within + 1 >= stated.located, "{stated:?}");
    // Nobody else can know: what the scene says of polished plastics is not true of this finger.
    let unknown = felt(0.0);
    assert!(
        stated.error_m() < 0.4 * unknown.error_m(),
        "{stated:?} {unknown:?}"
    );
}
