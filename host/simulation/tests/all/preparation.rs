//! Fingers with tolerances against them get through homing, the friction record and the press on the closing stop.

use palpate_plant::World;
use palpate_scenes::{Linkage3, Tendon2, Tendon3};
use palpate_simulation::{Simulated, Simulation};

fn prepared<S: Simulated>(seed: u64) {
    let workshop = World::named("workshop").expect("a named world");
    let parameters = workshop.of(S::NAME).expect("valid").randomised(seed);
    let mut simulation = Simulation::<S>::new(&parameters, seed).expect("a plant");
    let recorded = simulation.prepare().expect("accepted");
    assert_eq!(recorded.fault, None, "{} {seed}: recording", S::NAME);
    let pressed = simulation.press().expect("accepted");
    assert_eq!(pressed.fault, None, "{} {seed}: pressing", S::NAME);
}

/// Springs, friction and weight together ask for more than the 60 mA that a finger without springs needs.
#[test]
fn springs_and_friction_do_not_stall_a_free_finger() {
    prepared::<Tendon2>(11);
    prepared::<Tendon3>(11);
    prepared::<Linkage3>(11);
}

/// Its cable winds up to the limit of the position before the current reaches its own.
#[test]
fn a_soft_cable_does_not_hold_up_a_press() {
    prepared::<Tendon3>(2102);
}
