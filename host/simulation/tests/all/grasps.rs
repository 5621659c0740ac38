//! The library against the plant.

use palpate::sensing::{Event, NotLocated};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Outcome, Scenario, Simulation, Verdict, run};

/// Events as text: what they do not know is NaN, which equals nothing.
fn told(outcome: &Outcome) -> String {
    format!("{:?}", outcome.events)
}

fn cylinder() -> Shape {
    Shape::Cylinder { diameter_m: 0.01 }
}

/// On the default plant without pins: 5 % of l_2.
#[test]
fn contacts_are_felt_and_placed() {
    let mut simulation = Simulation::<P70>::new(&Parameters::default(), 1).unwrap();
    let prepared = simulation.prepare().unwrap();
    let events = &prepared.events;
    // Then a press on the closing stop tells the cable.
    assert!(
        matches!(events.first(), Some((_, Event::FrictionRecorded { .. })))
            && matches!(events.last(), Some((_, Event::Calibrated { .. }))),
        "{events:?}"
    );
    for k_m in [0.015, 0.03, 0.045, 0.06] {
        let outcome = simulation
            .close(&Grasp::touching(2, k_m, 0.8, cylinder()))
            .unwrap();
        let error_m = outcome
            .error_m()
            .unwrap_or_else(|| panic!("{k_m} m: {:?}", outcome.verdict));
        println!(
            "{k_m} m: error {:.2} mm, delay {:.0?} ms",
            1e3 * error_m,
            outcome.delay_s().map(|d| 1e3 * d)
        );
        assert!(error_m.abs() < 0.05 * 0.07, "{k_m} m: {error_m} m");
        simulation.open().unwrap();
    }
    let proximal = simulation
        .close(&Grasp::touching(1, 0.06, 0.8, cylinder()))
        .unwrap();
    assert_eq!(proximal.verdict, Verdict::NotLocated(NotLocated::Proximal));
    simulation.open().unwrap();
    assert_eq!(
        simulation.close(&Grasp::Free).unwrap().verdict,
        Verdict::Free
    );
}

#[test]
fn same_scenario_same_outcome() {
    let scenario = |seed| Scenario {
        parameters: Parameters::default(),
        grasp: Grasp::touching(2, 0.03, 0.5, cylinder()),
        seed,
        calibrate: Vec::new(),
        traced: true,
    };
    let once = run::<P70>(&scenario(4)).unwrap();
    assert!(once.trace.len() > 2000);
    let again = run::<P70>(&scenario(4)).unwrap();
    assert!(told(&once) == told(&again) && once.trace == again.trace && once.truth == again.truth);
    assert_ne!(told(&once), told(&run::<P70>(&scenario(5)).unwrap()));
}

/// A clone continues like its original; another seed makes it differ.
#[test]
fn clones_go_their_own_way() {
    let mut simulation = Simulation::<P70>::new(&Parameters::default(), 2).unwrap();
    simulation.prepare().unwrap();
    let grasp = Grasp::touching(2, 0.045, 0.4, cylinder());
    let (mut twin, mut other) = (simulation.clone(), simulation.clone());
    other.reseed(77);
    let outcome = simulation.close(&grasp).unwrap();
    assert_eq!(told(&outcome), told(&twin.close(&grasp).unwrap()));
    assert_ne!(told(&outcome), told(&other.close(&grasp).unwrap()));
}

#[test]
fn a_fault_ends_the_motion_and_is_told() {
    let mut simulation = Simulation::<P70>::new(&Parameters::default(), 2).unwrap();
    simulation.plant().faults.rotor_locked = true;
    let outcome = simulation.prepare().unwrap();
    assert!(
        matches!(outcome.verdict, Verdict::Fault(_)),
        "{:?}",
        outcome.verdict
    );
    assert_eq!(outcome.truth.motor_current_a, 0.0);
}
