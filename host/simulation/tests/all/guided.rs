//! The guided calibration as the commands run it: every pin with a homing before it, the pin left in place until the
//! finger has opened. Simulated.

use palpate::app::console::command::Command;
use palpate::drive::fault::Fault;
use palpate::drive::sequence::Request;
use palpate::sensing::{Directive, Event};
use palpate_plant::{Grasp, Parameters, Shape, World};
use palpate_scenes::{P70, Tendon3};
use palpate_simulation::{Outcome, Simulation};
use rayon::prelude::*;

/// theta_1 when the pin is touched, radian.
const THETA_1_RAD: f64 = 0.785;

fn prepared(parameters: &Parameters, seed: u64) -> Simulation<P70> {
    let mut simulation = Simulation::<P70>::new(parameters, seed).unwrap();
    assert_eq!(simulation.prepare().unwrap().fault, None);
    simulation
}

/// What `calibrate` does.
fn calibrate(simulation: &mut Simulation<P70>, k_m: f32) -> Outcome {
    let pin = Shape::Cylinder { diameter_m: 0.01 };
    simulation
        .plant()
        .place(&Grasp::touching(2, k_m.into(), THETA_1_RAD, pin))
        .unwrap();
    let outcome = simulation
        .motion(Request::Run, Directive::Calibrate { phalanx: 2, k_m })
        .unwrap();
    simulation.plant().place(&Grasp::Free).unwrap();
    outcome
}

/// Homings differ by some milliradians, the friction record by a multiple of its noise over as much: a zero that moves
/// makes the detector blind in one closing of some thirty, and the finger then presses until the motor stands.
#[test]
fn every_pin_is_felt_at_any_place_after_any_homing() {
    let places_mm = [20.0f32, 50.0, 35.0, 58.0, 25.0, 45.0, 54.0, 30.0];
    let plants = (1..=7).flat_map(|seed| {
        let nominal = Parameters::default();
        [nominal.randomised(seed), nominal].map(|parameters| (seed, parameters))
    });
    let calibrated: Vec<bool> = plants
        .par_bridge()
        .flat_map_iter(|(seed, parameters)| {
            let mut simulation = prepared(&parameters, seed);
            places_mm.map(|k_mm| {
                let outcome = calibrate(&mut simulation, 1e-3 * k_mm);
                let told = format!("seed {seed}, {k_mm} mm: {:?}", outcome.events);
                assert_eq!(outcome.fault, None, "{told}");
                assert!(
                    matches!(outcome.events.first(), Some((_, Event::Touch { .. }))),
                    "{told}"
                );
                let delay_s = outcome.delay_s().expect("touched");
                assert!((0.0..0.3).contains(&delay_s), "{delay_s} s, {told}");
                matches!(outcome.events.last(), Some((_, Event::Calibrated { .. })))
            })
        })
        .collect();
    let closings = calibrated.len();
    let refused = calibrated.iter().filter(|&&calibrated| !calibrated).count();
    assert_eq!(closings, 14 * places_mm.len());
    println!("{closings} closings, {refused} refused");
    assert!(20 * refused <= closings, "{refused} of {closings}");
}

/// The finger slides off a pin this near the tip and closes before it: opening, it is jammed from behind until the pin is
/// taken away. That stall is a true one.
#[test]
fn a_pin_behind_the_finger_stalls_the_opening() {
    let mut simulation = prepared(&Parameters::default(), 2);
    let outcome = calibrate(&mut simulation, 0.065);
    assert_eq!(outcome.fault, Some(Fault::Stall));
    assert!(
        outcome.truth.contacts.iter().any(|contact| contact.back),
        "{:?}",
        outcome.truth.contacts
    );
    // The pin is gone, the fault cleared: the zero and the record still fit.
    simulation
        .slow()
        .coordinator
        .command(Command::Clear)
        .unwrap();
    simulation.idle(0.1);
    let outcome = calibrate(&mut simulation, 0.045);
    assert_eq!(outcome.fault, None);
    assert!(
        matches!(outcome.events.last(), Some((_, Event::Calibrated { .. }))),
        "{:?}",
        outcome.events
    );
}

/// A drawn finger whose weight closes it to 0.6 rad at the opening stop: a pin there is met before the motion is steady, and the
/// record seems not to fit. Taken at its word, that pin taught a torque factor of 0.56 (1.00 +- 0.12 before).
#[test]
fn a_pin_that_is_met_where_the_record_does_not_fit_teaches_nothing() {
    const SEED: u64 = 7011;
    let world = World::named("workshop").expect("a world");
    let parameters = world.of("tendon3").expect("a scene").randomised(SEED);
    let mut simulation = Simulation::<Tendon3>::new(&parameters, SEED).expect("a simulation");
    simulation.prepare().expect("a record");
    let before = *simulation.calibration();
    let outcome = simulation.calibrate(3, 0.0135, 0.6).expect("a closing");
    let told = |wanted: fn(&Event) -> bool| outcome.events.iter().any(|(_, event)| wanted(event));
    let stale = told(|event| matches!(event, Event::FrictionStale { .. }));
    let refused = told(|event| matches!(event, Event::CalibrationRefused { .. }));
    assert!(stale && refused, "{:?}", outcome.events);
    assert_eq!(*simulation.calibration(), before);
}
