//! Second contacts on the blocks of simulated closings: told where both phalanges press, not where one does.

use palpate::sample::Drive;
use palpate::scene::Scene;
use palpate::sensing::Event;
use palpate::sensing::block::{BlockAverager, BlockUpdate};
use palpate::sensing::second::{Elbow, SecondContact};
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::P70;
use palpate_simulation::{Outcome, Simulation};

/// Fingers of the world `workshop`.
const SEEDS: u64 = 3;
/// Phalanx that touches first, place from its joint and diameter of the cylinder, metre: large ones meet the other phalanx
/// too, small ones do not.
const GRASPS: [(u8, f64, f64); 8] = [
    (1, 0.07, 0.07),
    (1, 0.06, 0.09),
    (1, 0.07, 0.05),
    (1, 0.06, 0.01),
    (1, 0.04, 0.02),
    (2, 0.02, 0.01),
    (2, 0.05, 0.03),
    (2, 0.03, 0.06),
];

/// What a program beside the sensor does: blocks, the record's friction taken off, from the touch on.
fn elbow(simulation: &mut Simulation<P70>, outcome: &Outcome) -> Option<Elbow> {
    let finger = P70::MECHANISM;
    let (drivetrain, settings) = (P70::drivetrain(&finger), P70::settings());
    let friction = simulation.slow().sensing.sensor().friction()?.clone();
    let touched_us = outcome.events.iter().find_map(|(_, event)| match event {
        Event::Touch { time_us, .. } => Some(*time_us),
        _ => None,
    })?;
    let stop_rad = drivetrain.opening_stop_rad + settings.closing_stop_rad - 0.01;
    let (mut averager, mut search) = (BlockAverager::default(), SecondContact::new(stop_rad));
    for (_, sample) in &outcome.samples {
        let BlockUpdate::Block(block) = averager.push(sample, &drivetrain, &settings) else {
            continue;
        };
        let Some(known) = friction.beyond(block.counts) else {
            continue;
        };
        if block.drive != Drive::Closing || block.time_us < touched_us {
            continue;
        }
        let efficiency = drivetrain.efficiency;
        let torque_nm = efficiency * (block.drive_torque_nm - known.torque_nm);
        let variance = efficiency * efficiency * friction.white_nm2(block.duration_s);
        let found = search.push(drivetrain.closing_rad(block.counts), torque_nm, variance);
        if found.is_some() {
            return found;
        }
    }
    None
}

#[test]
fn a_second_contact_is_told_and_a_single_one_is_not() {
    // Nothing is calibrated: the cable is known to a quarter.
    let cable = P70::UNCALIBRATED.cable_rad_per_nm;
    let (mut power, mut told, mut single, mut false_ones) = (0, 0, 0, 0);
    for seed in 1..=SEEDS {
        let world = World::named("workshop").expect("a world");
        let parameters = world.of("p70").expect("a scene").randomised(seed);
        let mut simulation = Simulation::<P70>::new(&parameters, seed).expect("a simulation");
        simulation.prepare().expect("a record");
        for (phalanx, k_m, diameter_m) in GRASPS {
            let grasp = Grasp::touching(phalanx, k_m, 0.6, Shape::Cylinder { diameter_m });
            let outcome = simulation.close(&grasp).expect("a closing");
            // The phalanx that touched first may have let go since: the object pushed it open.
            let first = outcome.first_contact.expect("a contact").contact.phalanx;
            let other = |c: &palpate_plant::Contact| c.phalanx != first && c.force_n > 0.2;
            let is_second = outcome.truth.contacts.iter().any(other);
            let found = elbow(&mut simulation, &outcome);
            let is_rigid = found.is_some_and(|elbow| elbow.is_rigid(cable, 0.25 * cable));
            println!(
                "seed {seed}: {phalanx} at {k_m} m, {diameter_m} m: second {is_second}, rigid {is_rigid}, {found:?}"
            );
            if is_second {
                power += 1;
                told += u32::from(is_rigid);
            } else {
                single += 1;
                false_ones += u32::from(found.is_some());
            }
            simulation.open().expect("opens");
        }
    }
    println!(
        "{told} of {power} second contacts told; {false_ones} told in {single} single contacts"
    );
    assert!(power >= 3 && single >= 3);
    assert_eq!((told, false_ones), (power, 0));
}
