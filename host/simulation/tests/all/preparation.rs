//! Fingers with tolerances against them get through homing, the friction record and the press on the closing stop.

use palpate::scene::Scene;
use palpate::sensing::Directive;
use palpate_plant::{Parameters, World};
use palpate_scenes::{Linkage3, P70, Tendon2, Tendon3};
use palpate_simulation::{Simulated, Simulation};

fn prepared<S: Simulated>(seed: u64) {
    let workshop = World::named("workshop").expect("a named world");
    let parameters = workshop.of(S::NAME).expect("valid").randomised(seed);
    prepare::<S>(&parameters, seed);
}

fn prepare<S: Simulated>(parameters: &Parameters, seed: u64) {
    let mut simulation = Simulation::<S>::new(parameters, seed).expect("a plant");
    let recorded = simulation.prepare().expect("accepted");
    assert_eq!(
        recorded.fault,
        None,
        "{} {seed}: recording and pressing",
        S::NAME
    );
    let pressed = |(directive, _): &_| *directive == Directive::CalibrateCable;
    assert!(recorded.samples.iter().any(pressed), "{} {seed}", S::NAME);
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

/// Winding and choke have more resistance than the scene says, and the sense shows less current: while the motor presses, it takes more
/// voltage than its current seems to need, as one does that turns and whose encoder stands still.
#[test]
fn a_stalled_motor_of_much_resistance_has_no_stuck_encoder() {
    prepared::<Linkage3>(2214);
    let workshop = World::named("workshop").expect("a named world");
    let mut worst = workshop.of(P70::NAME).expect("valid");
    worst.motor.resistance_ohm *= 1.2;
    worst.choke.resistance_ohm *= 1.2;
    worst.sense.gain_error = -0.05;
    prepare::<P70>(&worst, 1);
}
