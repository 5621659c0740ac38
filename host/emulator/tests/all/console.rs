// SPDX-License-Identifier: GPL-2.0-only
//! Answers that tell what really follows, in whole sessions.

use crate::support::firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings, Step};
use palpate_plant::Grasp;

/// A session whose script is over soon.
fn session<'f>(firmware: &'f palpate_emulator::Firmware, commands: &str) -> Session<'f> {
    let settings = Settings {
        script: Script::parse(commands),
        object: Some(Object::default()),
        ..Settings::default()
    };
    Session::start(firmware, settings, None).expect("a start")
}

/// Runs until a line contains a text, at most for so many seconds more.
#[track_caller]
fn until(session: &mut Session<'_>, text: &str, seconds: f64) {
    let (from, end_s) = (session.lines.len(), session.machine.time_s() + seconds);
    let said = |session: &Session<'_>| {
        let mut lines = session.lines[from..].iter();
        lines.any(|line| line.message.contains(text))
    };
    while !said(session) {
        assert!(session.machine.time_s() < end_s, "never said: {text}");
        session.millisecond().expect("a sound run");
    }
}

fn count(session: &Session<'_>, text: &str) -> usize {
    let lines = session.lines.iter();
    lines.filter(|line| line.message.contains(text)).count()
}

/// A supply that is too high shows at rest, one that is too low too, where that is the fault.
#[test]
fn a_fault_is_cleared_once_its_cause_is_gone() {
    let Some(firmware) = firmware() else { return };
    for (supply_v, fault) in [(20.0, "supply-high"), (5.0, "supply-low")] {
        let mut session = session(&firmware, "home");
        until(&mut session, "state name=home", 2.0);
        let supply = |session: &mut Session<'_>, supply_v| {
            session
                .machine
                .plant_mut()
                .expect("there is one")
                .faults
                .supply_v = supply_v;
        };
        supply(&mut session, Some(supply_v));
        until(&mut session, &format!("name={fault}"), 0.1);
        let refused = format!("answer refused: {fault} is still there");
        session.machine.command("clear\n");
        until(&mut session, &refused, 0.5);
        assert_eq!(count(&session, "state name=idle from=fault"), 0);
        supply(&mut session, None);
        session.machine.command("status\n");
        until(&mut session, "answer state fault", 0.5);
        session.machine.command("clear\n");
        until(&mut session, "state name=idle from=fault", 0.5);
        assert_eq!(count(&session, "answer ok"), 2, "of home and of this");
    }
}

/// A pin has no place in the press on the closing stop; and where the finger is closed that press begins with its opening.
#[test]
fn a_stopped_press_asks_for_no_pin_and_a_press_begins_open() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, "record-friction");
    until(&mut session, "calibrating pin_m=NaN", 30.0);
    until(&mut session, "state name=close", 1.0);
    while session.machine.time_s() < 16.0 {
        session.millisecond().expect("a sound run");
    }
    session.stop();
    until(&mut session, "calibration-refused why=no-contact", 2.0);
    assert!(
        session.refused.is_empty(),
        "stopping a press is no refusal: {:?}",
        session.refused
    );
    session.enter(Step::Command("status".to_owned()));
    until(&mut session, "answer state idle", 2.0);
    assert_eq!(count(&session, "hint"), 0);
    session.enter(Step::Command("calibrate cable".to_owned()));
    until(&mut session, "state name=open from=calibrate-offset", 2.0);
    until(&mut session, "state name=close from=open", 10.0);
    until(&mut session, "hint put a pin at 21 mm", 20.0);
}

/// A limit of the current that acts with the next motion, and one that needs a restart; a force beyond it is told once a hold.
#[test]
fn a_force_beyond_the_current_s_limit_is_told_once() {
    let Some(firmware) = firmware() else { return };
    let commands = "set current-limit 100; set current-limit 183; set current-limit 120; set hold-force 20; run";
    let mut session = session(&firmware, commands);
    until(&mut session, "sequence done verdict=contact", 60.0);
    assert_eq!(count(&session, "answer ok; save keeps it"), 3);
    assert_eq!(
        count(&session, "answer ok; takes effect after save and a restart"),
        1
    );
    assert_eq!(count(&session, "limit current=true"), 1);
}

/// What was learnt is not kept by a `save` after it.
#[test]
fn factory_forgets_what_was_learnt() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, "record-friction; factory; save");
    until(&mut session, "answer saved", 60.0);
    assert_eq!(count(&session, "calibrated "), 1);
    session.enter(Step::Command("calibrate cable".to_owned()));
    until(&mut session, "answer refused: no friction", 2.0);
    session.enter(Step::Command("run".to_owned()));
    until(&mut session, "state name=record-closing", 10.0);
    until(&mut session, "calibrated ", 30.0);
}

/// What a client of a port asks for meets what the script's own motions would: the object, or the pin that it names.
#[test]
fn a_closing_that_a_client_asks_for_meets_its_object() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, "status");
    until(&mut session, "answer state idle", 2.0);
    session.machine.command("run\n");
    until(&mut session, "located phalanx=2", 60.0);
    until(&mut session, "sequence done verdict=contact", 10.0);
    session.machine.command("calibrate 50\n");
    until(&mut session, "sequence done verdict=contact", 30.0);
    let truth = session.truth_at_estimate.clone();
    let met = truth.and_then(|truth| truth.first_contact);
    assert!(
        met.is_some_and(|met| (1e3 * met.contact.k_m - 30.0).abs() < 1.0),
        "{met:?}"
    );
    assert_eq!(count(&session, "contacts=1 presses=1"), 1);
}

/// A calibration from which the firmware learns nothing counts as refused, so `sim` ends with an error.
#[test]
fn a_pin_that_is_not_there_is_told_at_the_end() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, "record-friction; calibrate 21");
    until(&mut session, "calibrating pin_m=0.021", 60.0);
    // It closes by now.
    assert_eq!(session.state, "close");
    let plant = session.machine.plant_mut().expect("a world");
    plant.place(&Grasp::Free).expect("room");
    until(&mut session, "calibration-refused why=", 20.0);
    assert!(
        matches!(&session.refused[..], [(_, why)] if why.contains("calibration-refused")),
        "{:?}",
        session.refused
    );
}
