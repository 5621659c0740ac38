// SPDX-License-Identifier: GPL-2.0-only
//! Images of other scenes on the emulated chip: what they have in addition to the default scene works.

use crate::support;
use palpate_emulator::log::{Event, Line};
use palpate_emulator::sim::{
    CONTROL_INSTRUCTIONS, Object, Script, Session, Settings, Summary, Told, end_of,
};
use palpate_emulator::{Firmware, Setup};
use palpate_plant::{Grasp, ObjectMount, Parameters};

/// Most that an update may take: the limit of the default scene's (`host/report`).
const UPDATE_INSTRUCTIONS: u64 = 250_000;
/// Bytes of each stack that are never touched.
const STACK_MARGIN: usize = 1024;

/// A grasp; control stays within its bounds whatever a scene adds to it.
fn grasp<'f>(
    firmware: &'f Firmware,
    scene: &str,
    script: Script,
    (theta_1_deg, contact_mm): (f64, f64),
) -> Session<'f> {
    let settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
        script,
        object: Some(Object {
            phalanx: 2,
            contact_mm,
            diameter_mm: 10.0,
            theta_1_deg,
        }),
        ..Settings::default()
    };
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(session.completed(), "not completed");
    assert_eq!(session.faults, []);
    let control = session.machine.account().exceptions()[&34];
    assert!(
        control.max.instructions <= CONTROL_INSTRUCTIONS,
        "{control:?}"
    );
    assert_eq!(session.machine.chip().missed_triggers(), 0);
    session
}

/// With the joint so far closed, two places on phalanx 2 fit the curve, on either side of e_2; the Hall sensor's voltage,
/// from the pin through ADC2 to the verdict, says which.
#[test]
fn joint_2_is_read_and_decides_the_side() {
    let Some(firmware) = support::image(support::HALL) else {
        return;
    };
    let session = grasp(&firmware, "tendon2-hall", Script::button(), (95.0, 17.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    // Nothing was calibrated, and joint 2 is near 90 degrees: the claimed deviation says how little is known.
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 2.0 * sigma_mm, "{summary:?}");
    let branches: Vec<_> = session
        .lines
        .iter()
        .map(|line| line.event())
        .filter(|event| event.name == "branch")
        .collect();
    let last = branches.last().expect("a verdict of joint 2");
    assert_eq!(last.field("side"), Some("below"), "{last:?}");
    // Some 3 degrees in truth.
    let change_mrad = last.number("change_mrad").expect("a number");
    assert!((35.0..70.0).contains(&change_mrad), "{change_mrad}");
    assert!(
        session
            .lines
            .iter()
            .all(|line| line.event().name != "joint"),
        "the sensor was never without a reading"
    );
}

/// The same finger without a cable: a contact is placed, and the guided calibration sends nobody to the closing stop.
#[test]
fn without_a_cable_there_is_none_to_calibrate() {
    let Some(firmware) = support::image(support::RIGID) else {
        return;
    };
    let session = grasp(&firmware, "p70-rigid", Script::button(), (45.0, 30.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    assert!(error_mm.abs() < 3.5, "{summary:?}");
    let said = |text: &str| {
        session
            .lines
            .iter()
            .any(|line| line.to_string().contains(text))
    };
    assert!(
        !said("enter: calibrate cable"),
        "nobody is sent to the stop"
    );
    assert!(said("hint put a pin at"), "a pin comes first");
}

/// Joint 1's motor alone closes on an object, and joint 2, held by its own worm, gives way: a contact is placed.
#[test]
fn a_motor_at_every_joint_places_a_contact() {
    let Some(firmware) = support::image(support::DIRECT) else {
        return;
    };
    let session = grasp(&firmware, "direct2", Script::button(), (45.0, 35.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 3.0 * sigma_mm, "{summary:?}");
}

/// The amplifier's middle, sign and gain go from the scene into world and firmware alike: a contact is placed, and the self-test
/// takes an offset of either sign.
#[test]
fn a_signed_current_is_read_with_its_sign() {
    let Some(firmware) = support::image(support::SHUNT) else {
        return;
    };
    let session = grasp(&firmware, "p70-shunt", Script::button(), (45.0, 30.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 3.0 * sigma_mm, "{summary:?}");

    let mut parameters = Parameters::of("p70-shunt").expect("one of the scenes");
    parameters.sense.offset_a = -5e-3;
    let settings = Settings {
        parameters,
        script: Script::parse("selftest"),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a session");
    while !session.timed_out() && session.machine.time_s() < 10.0 {
        session.millisecond().expect("no misuse");
    }
    let steps: Vec<String> = session
        .lines
        .iter()
        .map(ToString::to_string)
        .filter(|line| line.contains("selftest step="))
        .collect();
    assert_eq!(steps.len(), 8, "{steps:#?}");
    assert!(
        steps.iter().all(|step| step.contains("result=ok")),
        "{steps:#?}"
    );
    assert!(
        steps.iter().any(|step| step.contains("value=-5")),
        "{steps:#?}"
    );
}

/// A closing whose firmware looks for a second contact: the grasp is the last word. `watch` names functions whose calls are
/// counted, and those that are counted apart.
fn held<'f>(
    firmware: &'f Firmware,
    scene: &str,
    object: Object,
    [watch, apart]: [&[&str]; 2],
) -> Session<'f> {
    let names = |of: &[&str]| of.iter().map(|&name| name.to_owned()).collect();
    let settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
        script: Script::parse("record-friction; close"),
        object: Some(object),
        setup: Setup {
            watch: names(watch),
            apart: names(apart),
            ..Setup::default()
        },
        ..Settings::default()
    };
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
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
    session
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
        let told = |session: &Session<'_>, name: &str| {
            let mut lines = session.lines.iter().map(|line| line.event());
            lines.any(|event| event.name == name)
        };
        // Some tenths of a second later, with a torque that can fall.
        let touched = told(&session, "touch");
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
        held(&firmware, "p70-grasp", object, [&[], &[]])
    };
    let power = closing(70.0, 70.0);
    let (grip, second) = told(&power);
    let phalanx = second.as_ref().and_then(|second| second.field("phalanx"));
    assert_eq!((grip, phalanx), ("enveloped", Some("2")));
    let single = closing(50.0, 10.0);
    let (grip, second) = told(&single);
    assert_eq!((grip, second.is_none()), ("single", true));
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
        // The sensor's own updates are those of `tendon3`, most of all the one that begins a contact.
        let watch: [&[&str]; 2] = [
            &["watch::Follow", "Sensor<F,H,X>::update", "begin_contact"],
            &["begin_contact"],
        ];
        let session = held(&firmware, "tendon3-grasp", object, watch);
        judge_costs(&session);
        session
    };

    // Met by phalanx 2 first: the second contact has a place.
    let placed = closing(2, 41.5, 61.5, 49.0);
    let (grip, second) = told(&placed);
    let second = second.expect("a second contact");
    assert_eq!((grip, second.field("phalanx")), ("two-contacts", Some("3")));
    let truth = placed.truth_at_estimate.as_ref().expect("contacts");
    let true_m = (truth.contacts.iter().find(|contact| contact.phalanx == 3)).map(|c| c.k_m);
    let [k_mm, sigma_mm] = ["k_mm", "sigma_mm"].map(|key| second.number(key).expect("a number"));
    let error_mm = k_mm - 1e3 * true_m.expect("phalanx 3 presses");
    assert!(
        error_mm.abs() < 2.0 * sigma_mm && sigma_mm < 8.0,
        "{error_mm}, {second:?}"
    );

    // By phalanx 1 first: the phalanx is known, and any place on it leaves the same motion.
    let proximal = closing(1, 60.0, 60.0, 40.0);
    let (grip, second) = told(&proximal);
    let second = second.expect("a second contact");
    assert_eq!((grip, second.field("phalanx")), ("two-contacts", Some("2")));
    assert_eq!(second.field("k_mm"), Some("NaN"));

    let single = closing(3, 20.0, 10.0, 45.0);
    let (grip, second) = told(&single);
    assert_eq!((grip, second.is_none()), ("single", true));
}

/// Bounds of the chip: the control interrupt, samples in time, an update of what follows the first contact, the sensor's but for that
/// which begins a contact, and the stacks.
fn judge_costs(session: &Session<'_>) {
    let account = session.machine.account();
    let control = account.exceptions()[&34];
    assert!(
        control.max.instructions <= CONTROL_INSTRUCTIONS,
        "{control:?}"
    );
    assert_eq!(session.machine.chip().missed_triggers(), 0);
    let of = |name: &str| {
        let mut functions = account.functions().iter();
        let found = functions.find(|(function, _)| function.contains(name));
        found.map_or_else(|| panic!("no {name}"), |(_, watched)| *watched)
    };
    let follow = of("AfterContact").all;
    assert!(
        follow.count > 1000 && follow.max.instructions <= UPDATE_INSTRUCTIONS,
        "{follow:?}"
    );
    let sensor = of("::update").without;
    assert!(
        sensor.max.instructions <= 2 * UPDATE_INSTRUCTIONS,
        "{sensor:?}"
    );
    for stack in session.machine.stacks() {
        assert!(stack.used + STACK_MARGIN <= stack.size, "{stack:?}");
    }
}

/// An object on springs of 0.5 N/mm behind pins that are fixed.
#[test]
fn the_stiffness_of_an_object_is_told() {
    let Some(firmware) = support::image(support::SOFT) else {
        return;
    };
    let mut parameters = Parameters::of("p70-soft").expect("a scene");
    parameters.object.mount = ObjectMount::Spring;
    parameters.object.stiffness_n_per_m = 500.0;
    let settings = Settings {
        parameters,
        object: Some(Object {
            contact_mm: 35.0,
            ..Object::default()
        }),
        script: Script::calibration(&[21.0, 52.0]),
        ..Settings::default()
    };
    let session = end_of(&firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(session.completed() && session.faults.is_empty());
    let events: Vec<_> = session.lines.iter().map(|line| line.event()).collect();
    let last = |name: &str| {
        let found = events.iter().rfind(|event| event.name == name);
        found.unwrap_or_else(|| panic!("no line {name}"))
    };
    let place = last("located");
    let [k_mm, sigma_mm] = ["k_mm", "sigma_mm"].map(|key| place.number(key).expect("a number"));
    assert!(
        (k_mm - 35.0).abs() < 2.0 * sigma_mm && sigma_mm < 2.0,
        "{k_mm} {sigma_mm}"
    );
    let object = last("object");
    let [given, sigma, least] = [
        "compliance_mm_per_n",
        "compliance_sigma_mm_per_n",
        "least_n_per_mm",
    ]
    .map(|key| object.number(key).expect("a number"));
    assert!(
        (given - 2.0).abs() < 2.0 * sigma && sigma < 0.6,
        "{given} {sigma}"
    );
    assert!(least < 0.5, "{least}");
    let told = events.iter().filter(|event| event.name == "object");
    assert_eq!(told.count(), 1, "with the last word, and not of a pin");
}
