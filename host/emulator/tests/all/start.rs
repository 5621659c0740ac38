// SPDX-License-Identifier: GPL-2.0-only
//! Start and arming on parts that behave as real ones do: a bridge that wakes slowly, stale flags, torn words of flash, a crystal
//! that does not start, noise on the fault pin.

use palpate_emulator::chip::PowerCut;
use palpate_emulator::sim::{Script, Session, Settings};

use crate::support::firmware;
use palpate_emulator::{Firmware, Quirks, ResetCause};

/// A session with nothing to do, and these parts.
fn session(firmware: &Firmware, quirks: Quirks) -> Session<'_> {
    let mut settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    settings.setup.quirks = quirks;
    let mut session = Session::start(firmware, settings, None).expect("a sound start");
    run(&mut session, "", 0.15);
    session
}

/// Types a command and lets time pass.
fn run(session: &mut Session<'_>, command: &str, seconds: f64) {
    session.machine.command(command);
    let end_s = session.machine.time_s() + seconds;
    while session.machine.time_s() < end_s {
        session
            .millisecond()
            .expect("the firmware keeps to the rules of the chip");
    }
}

/// Names of the faults in the log so far.
fn faults(session: &Session<'_>) -> Vec<String> {
    let events = session.lines.iter().map(|line| line.event());
    let faults = events.filter(|event| event.name == "fault");
    faults
        .filter_map(|event| event.field("name").map(str::to_owned))
        .collect()
}

fn says(session: &Session<'_>, text: &str) -> bool {
    session.lines.iter().any(|line| line.message.contains(text))
}

/// The motor moves: homing has begun and nothing is wrong.
fn moves(session: &mut Session<'_>) -> bool {
    run(session, "home\n", 0.8);
    session.machine.world().bridge_on() && faults(session).is_empty()
}

#[test]
fn a_bridge_that_holds_its_fault_pin_while_it_wakes_is_waited_for() {
    let Some(firmware) = firmware() else { return };
    for wake_fault_s in [0.0, 0.5e-3, 1.0e-3, 1.4e-3] {
        let mut session = session(
            &firmware,
            Quirks {
                wake_fault_s,
                ..Quirks::default()
            },
        );
        assert!(
            moves(&mut session),
            "{wake_fault_s}: {:?}",
            faults(&session)
        );
    }
}

#[test]
fn a_bridge_that_does_not_wake_is_a_fault_and_nothing_is_driven() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(
        &firmware,
        Quirks {
            wake_fault_s: 5e-3,
            ..Quirks::default()
        },
    );
    session.machine.command("home\n");
    for _ in 0..300 {
        session.millisecond().expect("a sound run");
        assert!(!session.machine.chip().bridge_enabled());
    }
    assert_eq!(faults(&session), ["bridge"]);
}

#[test]
fn flags_that_stand_in_the_flash_controller_after_a_reset_do_not_spoil_the_first_save() {
    let Some(firmware) = firmware() else { return };
    let quirks = Quirks {
        stale_flash_flags: true,
        ..Quirks::default()
    };
    let mut session = session(&firmware, quirks);
    run(&mut session, "save\n", 0.5);
    assert!(says(&session, "answer saved"));
}

#[test]
fn random_bits_in_the_backup_domain_do_not_take_the_serial_port() {
    let Some(firmware) = firmware() else { return };
    let quirks = Quirks {
        stale_backup_domain: true,
        ..Quirks::default()
    };
    let mut session = session(&firmware, quirks);
    assert!(!session.machine.chip().serial_port_is_taken());
    assert!(moves(&mut session), "{:?}", faults(&session));
}

#[test]
fn a_crystal_that_does_not_start_leaves_the_internal_oscillator_and_a_line_in_the_log() {
    let Some(firmware) = firmware() else { return };
    let quirks = Quirks {
        crystal_dead: true,
        ..Quirks::default()
    };
    let mut session = session(&firmware, quirks);
    assert!(says(&session, "clock source=internal"));
    assert!(moves(&mut session), "{:?}", faults(&session));
}

#[test]
fn a_torn_word_of_flash_ends_neither_in_a_bridge_fault_nor_in_a_reset() {
    let Some(firmware) = firmware() else { return };
    for wrong_ecc_address in [false, true] {
        let quirks = Quirks {
            wrong_ecc_address,
            ..Quirks::default()
        };
        let mut session = session(&firmware, quirks);
        // The first word of the record: the page is erased before it.
        let done = session.machine.flash_operations().len();
        session.machine.cut_power_at(done + 1, PowerCut::During);
        session.machine.command("save\n");
        let mut waited = 0;
        while session.millisecond().is_ok() && !session.machine.power_lost() && waited < 1000 {
            waited += 1;
        }
        assert!(session.machine.power_lost(), "the power went in the save");
        session.lines.clear();
        session.machine.power_cycle().expect("the engine works");
        run(&mut session, "", 0.2);
        let record = session
            .lines
            .iter()
            .find(|line| line.event().name == "record")
            .expect("it says what it found");
        assert!(
            record
                .event()
                .number("bad_words")
                .is_some_and(|bad| bad > 0.0),
            "{record}: nothing tested"
        );
        assert!(moves(&mut session), "{:?}", faults(&session));
        assert_eq!(session.resets.len(), 0, "{:?}", session.resets);
    }
}

#[test]
fn a_spike_on_the_fault_pin_is_filtered_and_a_pulse_is_not() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, Quirks::default());
    assert!(moves(&mut session));
    session.machine.pulse_fault_pin(0.4e-6);
    run(&mut session, "", 0.05);
    assert_eq!(faults(&session), [""; 0]);
    session.machine.pulse_fault_pin(1.5e-6);
    assert!(!session.machine.world().bridge_on(), "by hardware, at once");
    run(&mut session, "", 0.05);
    assert_eq!(faults(&session), ["bridge"]);
}

/// Winding temperature that `status` reports, degree Celsius.
fn winding_c(session: &mut Session<'_>) -> f64 {
    run(session, "status\n", 0.1);
    let mut lines = session.lines.iter().rev().map(|line| line.event());
    lines
        .find(|event| event.name == "status")
        .and_then(|event| event.number("winding_c"))
        .expect("status is answered")
}

#[test]
fn the_winding_s_temperature_survives_a_reset_and_is_assumed_warm_after_a_power_cut() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, Quirks::default());
    let assumed = winding_c(&mut session);
    assert!(assumed > 40.0, "warm after power-on: {assumed}");
    run(&mut session, "", 20.0);
    let cooled = winding_c(&mut session);
    assert!(cooled < assumed - 3.0, "{assumed} to {cooled}");
    for cause in [ResetCause::Pin, ResetCause::Watchdog, ResetCause::Software] {
        session.machine.reset(cause).expect("the engine works");
        run(&mut session, "", 0.15);
        let kept = winding_c(&mut session);
        assert!((kept - cooled).abs() < 0.5, "{cause:?}: {cooled} to {kept}");
    }
    session.machine.power_cycle().expect("the engine works");
    run(&mut session, "", 0.15);
    let again = winding_c(&mut session);
    assert!((again - assumed).abs() < 0.5, "{assumed} and {again}");
}

/// A button that is held through the reset is no press; let go and pressed it is one.
#[test]
fn a_button_held_through_a_reset_starts_nothing() {
    let Some(firmware) = firmware() else { return };
    let settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a sound start");
    session.machine.button(true);
    run(&mut session, "", 0.3);
    assert!(!session.machine.world().bridge_on(), "moved by itself");
    assert!(says(&session, "boot "), "it has started");
    session.machine.button(false);
    run(&mut session, "", 0.1);
    session.machine.button(true);
    run(&mut session, "", 0.3);
    assert!(session.machine.world().bridge_on(), "a press");
    assert_eq!(faults(&session), [""; 0]);
}

/// The supply dips again soon after the start that a dip led to, at any time: nothing moves before `clear`. A record in flash makes the
/// fault the second thing that the sequence hears of.
#[test]
fn a_second_dip_of_the_supply_right_after_a_start_is_a_brown_out_too() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, Quirks::default());
    run(&mut session, "save\n", 0.5);
    assert!(says(&session, "answer saved"));
    run(&mut session, "home\n", 0.4);
    assert!(session.machine.world().bridge_on(), "homing");
    // Faults told since the last start, after a dip and so much time.
    let dip = |session: &mut Session<'_>, seconds: f64| {
        let reset = session.machine.reset(ResetCause::BrownOut);
        reset.expect("the engine works");
        run(session, "", seconds);
        let boot = (session.lines.iter()).rposition(|line| line.event().name == "boot");
        session.lines.drain(..boot.unwrap_or_default());
        faults(session)
    };
    assert_eq!(dip(&mut session, 0.1), ["brown-out"]);
    for millisecond in 1..20 {
        dip(&mut session, 1e-3 * f64::from(millisecond));
        let told = dip(&mut session, 0.1);
        assert_eq!(told, ["brown-out"], "after {millisecond} ms");
    }
}
