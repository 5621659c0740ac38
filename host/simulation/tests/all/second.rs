//! Second contacts of simulated closings: told where both phalanges press, not where one does.

use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate::finger::HoldsTwice;
use palpate::sensing::{Event, Followed, Grip};
use palpate_plant::{Contact, Grasp, Shape, World};
use palpate_scenes::{Linkage3, P70Grasp, Tendon3};
use palpate_simulation::{Outcome, Simulated, Simulation, second_contacts};

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

/// Forces told with the last word on a place.
fn settled_n(outcome: &Outcome) -> impl Iterator<Item = f32> {
    outcome.events.iter().filter_map(|(_, event)| match *event {
        Event::Located {
            settled: true,
            force_n,
            ..
        } => Some(force_n),
        _ => None,
    })
}

#[test]
fn a_second_contact_is_told_and_a_single_one_is_not() {
    let (mut power, mut told, mut single, mut false_ones) = (0, 0, 0, 0);
    for seed in 1..=SEEDS {
        let world = World::named("workshop").expect("a world");
        let parameters = world.of("p70-grasp").expect("a scene").randomised(seed);
        let mut simulation = Simulation::<P70Grasp>::new(&parameters, seed).expect("a simulation");
        simulation.prepare().expect("a record");
        for (phalanx, k_m, diameter_m) in GRASPS {
            let grasp = Grasp::touching(phalanx, k_m, 0.6, Shape::Cylinder { diameter_m });
            let outcome = simulation.close(&grasp).expect("a closing");
            // The phalanx that touched first may have let go since: the object pushed it open.
            let first = outcome.first_contact.expect("a contact").contact.phalanx;
            let other = |c: &palpate_plant::Contact| c.phalanx != first && c.force_n > 0.2;
            let is_second = outcome.truth.contacts.iter().any(other);
            let found = outcome.second_contact();
            let grip = outcome.grip().expect("a last word");
            println!(
                "seed {seed}: {phalanx} at {k_m} m, {diameter_m} m: second {is_second}, {grip:?}, {found:?}"
            );
            for force_n in settled_n(&outcome) {
                assert_eq!(force_n.is_nan(), found.is_some(), "{force_n} N: {found:?}");
            }
            if is_second {
                power += 1;
                let right = matches!(found, Some(Followed::SecondContact { phalanx, .. }) if phalanx != first);
                told += u32::from(right && grip == Grip::Enveloped);
            } else {
                single += 1;
                false_ones += u32::from(found.is_some() || grip != Grip::Single);
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

/// What a scale under a contact has told of the springs counts for the forces of two contacts as well.
#[test]
fn the_forces_of_two_contacts_go_with_the_force_scale() {
    let moments = |scale: Option<f32>| {
        let parameters = (World::named("ideal").expect("a world")).of("p70-grasp");
        let parameters = parameters.expect("a scene");
        let mut simulation = Simulation::<P70Grasp>::new(&parameters, 1).expect("a simulation");
        if let Some(scale) = scale {
            let command = Command::Set(Setting::ForceScale, scale);
            simulation
                .slow()
                .coordinator
                .command(command)
                .expect("taken");
        }
        simulation.prepare().expect("a record");
        let (phalanx, k_m, diameter_m) = GRASPS[0];
        let grasp = Grasp::touching(phalanx, k_m, 0.6, Shape::Cylinder { diameter_m });
        let outcome = simulation.close(&grasp).expect("a closing");
        let told = outcome.followed.iter().find_map(|(_, event)| match event {
            Followed::Grasp { grip, forces, .. } => Some((*grip, *forces)),
            _ => None,
        });
        let (grip, forces) = told.expect("a last word");
        assert_eq!(grip, Grip::Enveloped);
        forces.distal_moment_nm
    };
    let [plain, scaled] = [None, Some(1.25)].map(moments);
    assert!(
        plain > 0.0 && (scaled / plain - 1.25).abs() < 1e-5,
        "{plain} {scaled}"
    );
}

/// Three phalanges in `harsh`, where single contacts end with joint 3 at its stop, as rigid as two contacts, and where a curve that one
/// contact does not explain is fitted for long: every touch gets its last word, and no single contact is told as two.
#[test]
fn three_phalanges_get_a_last_word_and_a_stop_is_no_second_contact() {
    let world = World::named("harsh").expect("a world");
    let (mut touched, mut silent) = (0, Vec::new());
    let mut scores = second_contacts::Score::default();
    // Found among many: finger 7007 had no last word on its third closing, and finger 7006 told a stop twice.
    for (seed, grasps) in [(7006, 10), (7007, 4)] {
        let mut closing = 0;
        let score =
            second_contacts::finger::<Tendon3>(&world, seed, grasps, true, |outcome, _, _| {
                let is_last = |event: &Event| match *event {
                    Event::Located { settled, .. } | Event::Ambiguous { settled, .. } => settled,
                    Event::NotLocated { .. } => true,
                    _ => false,
                };
                let events = || outcome.events.iter().map(|(_, event)| event);
                if events().any(|event| matches!(event, Event::Touch { .. })) {
                    touched += 1;
                    if !events().any(is_last) {
                        silent.push((seed, closing));
                    }
                }
                closing += 1;
            });
        scores = scores.with(&score.expect("a finger"));
    }
    println!("{touched} touched, {silent:?} without a last word; {scores:?}");
    assert!(touched > 8 && scores.single > 3);
    assert_eq!(silent, []);
    assert_eq!(scores.false_ones, 0);
}

/// Of a tendon's straight line after a contact on phalanx 1 a corner stands out, though friction wanders by 3 %: one of this finger's
/// is seen in no curve that may bend.
#[test]
fn a_second_contact_after_phalanx_1_stands_out_of_friction_that_wanders() {
    /// Turns of the motor with two contacts from which on the search has the blocks that it wants of a straight line: three fours.
    const THREE_FOURS: f64 = 12.0;
    let world = World::named("harsh").expect("a world");
    let (mut after_inner, mut shared, mut missed) = (0, 0, 0);
    let mut judge = |outcome: &Outcome, _: Option<&Contact>, turns: f64| {
        let first = outcome.first_contact.expect("a contact").contact.phalanx;
        let found = outcome.second_contact();
        after_inner += u32::from(first == 1 && found.is_some());
        missed += u32::from(turns >= THREE_FOURS && found.is_none());
        // Two contacts share the torque in a way that the motor does not tell.
        for force_n in settled_n(outcome).filter(|_| found.is_some()) {
            assert!(force_n.is_nan(), "{force_n} N: {found:?}");
            shared += 1;
        }
    };
    let (mut told, mut single, mut false_ones) = (0, 0, 0);
    for seed in [5130, 5330] {
        let score = second_contacts::finger::<Tendon3>(&world, seed, 20, true, &mut judge);
        let score = score.expect("a finger");
        println!("{score:?}");
        told += score.told;
        single += score.single;
        false_ones += score.false_ones;
    }
    println!("{after_inner} after phalanx 1, {shared} without a force, {missed} missed");
    assert!(after_inner > 4 && shared > 0 && told > 10 && single >= 6);
    assert_eq!((missed, false_ones), (0, 0));
}

/// A finger that its weight closes shows no torque until an object has taken that over, and then all of the slope: no second contact.
#[test]
fn what_takes_a_weight_over_is_no_second_contact() {
    let world = World::named("harsh").expect("a world");
    // Found among many: it told one on phalanx 1 as two.
    let score = second_contacts::finger::<Tendon3>(&world, 6006, 20, true, |_, _, _| ());
    let score = score.expect("a finger");
    println!("{score:?}");
    assert!(score.single > 5);
    assert_eq!(score.false_ones, 0);
}

/// Medians of the logarithm, without sign, of moment and force of the contact on the last phalanx, told with the last word on a grasp with
/// two contacts, over the plant's.
fn off<S: Simulated<Finger: HoldsTwice>>(fingers: u64) -> [f64; 2] {
    let world = World::named("workshop").expect("a world");
    let mut ratios = [Vec::new(), Vec::new()];
    for seed in 1..=fingers {
        second_contacts::finger::<S>(&world, seed, 20, true, |outcome, _, turns| {
            let told = outcome.followed.iter().find_map(|(_, event)| match event {
                Followed::Grasp { forces, .. } => Some(*forces),
                _ => None,
            });
            let mut contacts = outcome.truth.contacts.iter();
            let truth = contacts.find(|contact| contact.phalanx == S::PHALANGES);
            let (Some(told), Some(truth)) = (told, truth) else {
                return;
            };
            let [moment, force] = [
                f64::from(told.distal_moment_nm) / (truth.force_n * truth.k_m),
                f64::from(told.distal_force_n) / truth.force_n,
            ];
            // A contact that has just begun has no moment to compare with.
            if turns > 4.0 && moment.is_finite() && truth.force_n > 0.1 {
                ratios[0].push(moment.max(1e-3).ln().abs());
                ratios[1].push(force.max(1e-3).ln().abs());
            }
        })
        .expect("a finger");
    }
    println!("{}: {} told", S::NAME, ratios[0].len());
    ratios.map(|mut ratios| {
        ratios.sort_by(f64::total_cmp);
        assert!(ratios.len() > 10);
        ratios[ratios.len() / 2]
    })
}

/// At the end of a closing, up to 0.3 N m after the second contact, when the finger gives way far less than at first and the contact has
/// rolled along the phalanx. With the motion of the first instant both were 20 to 45 % too small.
#[test]
fn what_the_last_phalanx_presses_with_is_right_where_the_closing_ends() {
    for [moment, force] in [off::<Tendon3>(3), off::<Linkage3>(4)] {
        println!("moment {moment:.2}, force {force:.2}");
        assert!(moment < 0.2 && force < 0.2, "{moment} {force}");
    }
}
