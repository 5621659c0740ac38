// SPDX-License-Identifier: GPL-2.0-only
//! Second contacts on the emulated chip: what is told of them, and what it costs.

use crate::support;
use palpate_emulator::log::{Event, Line};
use palpate_emulator::sim::{Object, Script, Session, Settings};
use palpate_emulator::{Firmware, Setup};
use palpate_plant::{Grasp, Parameters};

/// Most that an update may take: the limit of the default scene's (`host/report`).
const UPDATE_INSTRUCTIONS: u64 = 250_000;
/// Bytes of each stack that are never touched.
const STACK_MARGIN: usize = 1024;

/// Closes a finger whose firmware looks for a second contact: the grasp is the last word. `watch` names functions whose calls are
/// counted. Returns the places where each phalanx touched first, metre, too.
fn held<'f>(
    firmware: &'f Firmware,
    scene: &str,
    object: Object,
    watch: &[&str],
) -> (Session<'f>, [Option<f64>; 3]) {
    let settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
        script: Script::parse("record-friction; close"),
        object: Some(object),
        setup: Setup {
            watch: watch.iter().map(|&name| name.to_owned()).collect(),
            ..Setup::default()
        },
        ..Settings::default()
    };
    let mut session = Session::start(firmware, settings, None).expect("a session");
    let mut first_m = [None; 3];
    while !session.over() {
        session.millisecond().expect("no misuse");
        let truth = session.machine.plant().map(palpate_plant::Plant::truth);
        for contact in truth.iter().flat_map(|truth| &truth.contacts) {
            first_m[usize::from(contact.phalanx) - 1].get_or_insert(contact.k_m);
        }
    }
    session.finish().expect("the log");
    assert!(session.completed(), "not completed");
    assert_eq!(session.faults, []);
    let at = |name: &str| {
        let named = |line: &Line| line.event().name == name;
        session.lines.iter().rposition(named)
    };
    let first = at("located").max(at("not-located"));
    assert!(
        first.is_some() && first < at("grasp"),
        "the grasp comes last"
    );
    assert!(at("second-contact") < at("grasp"), "of all that is told");
    assert!(
        at("grasp") < at("sequence done"),
        "but for the motion's end"
    );
    (session, first_m)
}

/// How a closing said that the object is held, and the line of its second contact.
fn told<'s>(session: &'s Session<'_>) -> (&'s str, Option<Event<'s>>) {
    let event = |name: &str| {
        let mut lines = session.lines.iter().map(Line::event);
        lines.find(|event| event.name == name)
    };
    let grip = event("grasp").and_then(|event| event.field("grip"));
    (grip.expect("a last word"), event("second-contact"))
}

/// What is taken away while the finger closes on is lost, and the closing ends at once.
#[test]
fn a_contact_that_lets_go_is_told_as_lost() {
    let Some(firmware) = support::image(support::GRASP) else {
        return;
    };
    let settings = Settings {
        parameters: Parameters::of("p70-grasp").expect("one of the scenes"),
        script: Script::parse("record-friction; close"),
        object: Some(Object {
            phalanx: 1,
            contact_mm: 50.0,
            diameter_mm: 10.0,
            theta_1_deg: 30.0,
        }),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a session");
    let mut taken_s = None;
    while !session.over() {
        session.millisecond().expect("no misuse");
        // Some tenths of a second later, with a torque that can fall.
        let touched = support::last_closing(&session).any(|event| event.name == "touch");
        let now_s = session.machine.time_s();
        let since_s = *taken_s.get_or_insert(if touched { now_s } else { f64::INFINITY });
        if !touched {
            taken_s = None;
        } else if (0.3..0.302).contains(&(now_s - since_s))
            && let Some(plant) = session.machine.plant_mut()
        {
            plant.place(&Grasp::Free).expect("nothing fits anywhere");
        }
    }
    session.finish().expect("the log");
    let grasps: Vec<_> = session
        .lines
        .iter()
        .map(|line| line.event())
        .filter(|event| event.name == "grasp")
        .collect();
    assert_eq!(grasps.len(), 1, "{grasps:?}");
    assert_eq!(grasps[0].field("grip"), Some("lost"), "{grasps:?}");
}

/// A large cylinder is met by both phalanges, a small one by the first alone.
#[test]
fn a_second_contact_is_told_of_a_power_grasp_only() {
    let Some(firmware) = support::image(support::GRASP) else {
        return;
    };
    let closing = |contact_mm, diameter_mm| {
        let object = Object {
            phalanx: 1,
            contact_mm,
            diameter_mm,
            theta_1_deg: 40.0,
        };
        held(&firmware, "p70-grasp", object, &[]).0
    };
    let power = closing(70.0, 70.0);
    let (grip, second) = told(&power);
    let phalanx = second.as_ref().and_then(|second| second.field("phalanx"));
    assert_eq!((grip, phalanx), ("enveloped", Some("2")));
    let single = closing(50.0, 10.0);
    let (grip, second) = told(&single);
    assert_eq!((grip, second.is_none()), ("single", true));
}

/// Checks the place of a second contact on phalanx 3, which is truly at `true_m`, against the deviation that is told.
#[track_caller]
fn judge_place(second: &Event<'_>, true_m: Option<f64>) {
    let [k_mm, sigma_mm] = ["k_mm", "sigma_mm"].map(|key| second.number(key).expect("a number"));
    let error_mm = k_mm - 1e3 * true_m.expect("phalanx 3 presses");
    assert!(
        error_mm.abs() < 2.0 * sigma_mm && sigma_mm < 8.0,
        "{error_mm}, {second:?}"
    );
}

/// Cylinders that two phalanges of three meet and one that only the last does: what is told of them, and what that costs the chip.
#[test]
fn three_phalanges_tell_a_second_contact_in_time() {
    let Some(firmware) = support::image(support::GRASP_TENDON3) else {
        return;
    };
    let closing = |phalanx, contact_mm, diameter_mm, theta_1_deg| {
        let object = Object {
            phalanx,
            contact_mm,
            diameter_mm,
            theta_1_deg,
        };
        let watch = ["watch::Follow", "Sensor<F,H,X>::update"];
        let held = held(&firmware, "tendon3-grasp", object, &watch);
        judge_costs(&held.0);
        held
    };

    // Met by phalanx 2 first: the second contact has a place.
    let (placed, [.., true_m]) = closing(2, 41.5, 61.5, 49.0);
    let (grip, second) = told(&placed);
    let second = second.expect("a second contact");
    assert_eq!((grip, second.field("phalanx")), ("two-contacts", Some("3")));
    judge_place(&second, true_m);

    // By phalanx 1 first: the phalanx is known, and any place on it leaves the same motion.
    let (proximal, _) = closing(1, 60.0, 60.0, 40.0);
    let (grip, second) = told(&proximal);
    let second = second.expect("a second contact");
    assert_eq!((grip, second.field("phalanx")), ("two-contacts", Some("2")));
    assert_eq!(second.field("k_mm"), Some("NaN"));

    let (single, _) = closing(3, 20.0, 10.0, 45.0);
    let (grip, second) = told(&single);
    assert_eq!((grip, second.is_none()), ("single", true));
}

/// A linkage of two stages takes longest to find the postures: the samples that come meanwhile wait, and none is lost.
#[test]
fn a_linkage_of_two_stages_tells_a_second_contact_in_time() {
    let Some(firmware) = support::image(support::GRASP_LINKAGE3) else {
        return;
    };
    let object = Object {
        phalanx: 2,
        contact_mm: 45.0,
        diameter_mm: 70.0,
        theta_1_deg: 40.0,
    };
    let watch = ["watch::Follow", "Sensor<F,H,X>::update"];
    let (session, [.., true_m]) = held(&firmware, "linkage3-grasp", object, &watch);
    judge_costs(&session);
    let (grip, second) = told(&session);
    let second = second.expect("a second contact");
    assert_eq!((grip, second.field("phalanx")), ("enveloped", Some("3")));
    judge_place(&second, true_m);
}

/// Checks the bounds of the chip: control, an update of what follows the first contact, one of the sensor, and the stacks.
fn judge_costs(session: &Session<'_>) {
    support::keeps_up(session);
    let account = session.machine.account();
    let of = |name: &str| {
        let mut functions = account.functions().iter();
        let found = functions.find(|(function, _)| function.contains(name));
        found.map_or_else(|| panic!("no {name}"), |(_, watched)| watched.all)
    };
    let follow = of("AfterContact");
    assert!(
        follow.count > 1000 && follow.max.instructions <= UPDATE_INSTRUCTIONS,
        "{follow:?}"
    );
    let sensor = of("::update");
    assert!(sensor.max.instructions <= UPDATE_INSTRUCTIONS, "{sensor:?}");
    for stack in session.machine.stacks() {
        assert!(stack.used + STACK_MARGIN <= stack.size, "{stack:?}");
    }
}
