// SPDX-License-Identifier: GPL-2.0-only
//! The firmware image on the emulated chip, with the simulated finger in its default state.

use crate::support::{self, firmware};
use palpate_emulator::sim::{Object, Script, Session, Settings, Summary, Told, end_of};
use palpate_emulator::{Firmware, Pause, ResetCause};

/// Five per cent of the distal phalanx.
const LOCATED_MM: f64 = 3.5;

fn settings(phalanx: u8, contact_mm: f64) -> Settings {
    let object = Object {
        phalanx,
        contact_mm,
        ..Object::default()
    };
    Settings {
        object: Some(object),
        ..Settings::default()
    }
}

/// Runs to the end; the run itself has to be sound.
fn run(firmware: &Firmware, settings: Settings) -> Summary {
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    let log = || {
        session
            .lines
            .iter()
            .map(|line| format!("{line}\n"))
            .collect::<String>()
    };
    assert!(session.completed(), "not completed:\n{}", log());
    assert_eq!(session.faults, [], "{}", log());
    assert_eq!(session.resets, [], "{}", log());
    assert_eq!(session.machine.malformed_frames(), 0);
    assert!(
        session.machine.chip().fpu_enabled(),
        "the image uses the floating-point unit it has not switched on"
    );
    Summary::of(&session)
}

fn locates(contact_mm: f64) {
    let Some(firmware) = firmware() else { return };
    let summary = run(&firmware, settings(2, contact_mm));
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    assert_eq!(summary.phalanx, Some(2), "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    assert!(error_mm.abs() < LOCATED_MM, "{summary:?}");
}

#[test]
fn locates_a_contact_at_15_mm() {
    locates(15.0);
}

#[test]
fn locates_a_contact_at_30_mm() {
    locates(30.0);
}

#[test]
fn locates_a_contact_at_45_mm() {
    locates(45.0);
}

#[test]
fn locates_a_contact_at_60_mm() {
    locates(60.0);
}

#[test]
fn tells_a_proximal_contact() {
    let Some(firmware) = firmware() else { return };
    let summary = run(&firmware, settings(1, 45.0));
    assert_eq!(summary.told, Told::Proximal, "{summary:?}");
    assert_eq!(summary.true_phalanx, Some(1));
}

#[test]
fn feels_nothing_where_there_is_nothing() {
    let Some(firmware) = firmware() else { return };
    let session = end_of(&firmware, Settings::default()).expect("a sound run");
    assert!(session.completed());
    assert!(
        support::last_closing(&session)
            .all(|event| !["touch", "located", "unusual"].contains(&event.name))
    );
    assert_eq!(Summary::of(&session).told, Told::None);
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_seed_does_not() {
    let Some(firmware) = firmware() else { return };
    let run = |seed| {
        let settings = Settings {
            seed,
            max_s: 3.0,
            ..Settings::default()
        };
        let session = end_of(&firmware, settings).expect("a sound run");
        let lines: Vec<_> = session.lines.iter().map(ToString::to_string).collect();
        (lines, session.machine.account().total())
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn control_keeps_its_rate_and_its_period() {
    let Some(firmware) = firmware() else { return };
    let settings = Settings {
        max_s: 5.0,
        ..Settings::default()
    };
    let session = end_of(&firmware, settings).expect("a sound run");
    let control = session.machine.account().exceptions()[&34];
    assert!(
        (control.count as f64 / session.machine.time_s() / 20_000.0 - 1.0).abs() < 0.01,
        "{control:?}"
    );
    crate::support::keeps_up(&session);
    // 8500 cycles at 170 MHz are one period; the upper bracket must leave room for everything else.
    assert!(control.max.cycles_high < 8500 / 2, "{control:?}");
    for stack in session.machine.stacks() {
        assert!(stack.used < stack.size, "{stack:?}");
    }
}

#[test]
fn a_reset_in_motion_takes_the_bridge_off_and_names_its_cause() {
    let Some(firmware) = firmware() else { return };
    let mut session = Session::start(&firmware, Settings::default(), None).expect("a sound start");
    while session.machine.time_s() < 2.0 {
        session.millisecond().expect("a sound run");
    }
    assert!(session.machine.world().bridge_on());
    session
        .machine
        .reset(ResetCause::Pin)
        .expect("the engine works");
    assert!(!session.machine.world().bridge_on());
    session.lines.clear();
    let end = session.machine.now() + palpate_emulator::time::TICKS_PER_S / 5;
    assert_eq!(
        session.machine.run_until(end).expect("a sound run"),
        Pause::Time
    );
    assert!(
        !session.machine.world().bridge_on(),
        "nothing moves without a command"
    );
    let lines = session.machine.take_lines();
    let reset = lines
        .iter()
        .find(|line| line.event().name == "reset")
        .expect("it says why it started");
    assert_eq!(reset.event().field("cause"), Some("pin"), "{reset}");
}

#[test]
fn a_run_that_waits_does_not_outlive_a_stop() {
    let Some(firmware) = firmware() else { return };
    let settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a sound start");
    let moves = |session: &mut Session, commands: &str| {
        let end_s = session.machine.time_s() + 1.0;
        session.machine.command(commands);
        let mut on = false;
        while session.machine.time_s() < end_s {
            session.millisecond().expect("a sound run");
            on |= session.machine.world().bridge_on();
        }
        on
    };
    assert!(!moves(&mut session, ""));
    // The list takes a tenth of a second on the serial port: what follows waits behind it.
    assert!(!moves(&mut session, "help\nrun\nrun\nrun\nrun\nstop\n"));
    let answers: Vec<_> = session.lines.iter().map(ToString::to_string).collect();
    let last = answers.iter().rfind(|line| line.contains("answer"));
    assert!(
        last.is_some_and(|line| line.contains("answer ok")),
        "{answers:?}"
    );
    assert!(
        answers
            .iter()
            .any(|line| line.contains("commands ignored=")),
        "{answers:?}"
    );
    assert!(moves(&mut session, "run\n"), "it listens as before");
}

/// Processor time of this thread in seconds, where the system tells it.
fn processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace()
        .next()?
        .parse::<f64>()
        .ok()
        .map(|ns| 1e-9 * ns)
}

#[test]
fn runs_faster_than_real_time() {
    let (Some(firmware), Some(before)) = (firmware(), processor_s()) else {
        return;
    };
    let settings = Settings {
        max_s: 5.0,
        ..Settings::default()
    };
    let session = end_of(&firmware, settings).expect("a sound run");
    let after = processor_s().expect("still there");
    assert!(
        after - before < session.machine.time_s(),
        "{} s for {} s",
        after - before,
        session.machine.time_s()
    );
}
