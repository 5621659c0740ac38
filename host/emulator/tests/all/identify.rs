// SPDX-License-Identifier: GPL-2.0-only
//! `identify` on the emulated chip: what it reports is the motor's, it is kept, and it can be stopped.

use crate::support;
use crate::support::firmware;
use palpate::drive::identify::Quantity;
use palpate::scene::Scene;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Script, Session, Settings};
use palpate_plant::Parameters;
use palpate_scenes::P70Shunt;
use palpate_scenes::kept as kept_record;

fn session<'f>(firmware: &'f Firmware, scene: &str) -> Session<'f> {
    let settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
        script: Script(Vec::new()),
        ..Settings::default()
    };
    let mut session = Session::start(firmware, settings, None).expect("a sound start");
    run(&mut session, 200, |_| false);
    session
}

fn run(session: &mut Session<'_>, most_ms: u32, done: impl Fn(&str) -> bool) {
    for _ in 0..most_ms {
        let seen = session.lines.len();
        session
            .millisecond()
            .expect("the firmware keeps to the rules of the chip");
        if session.lines[seen..].iter().any(|line| done(&line.message)) {
            return;
        }
    }
}

/// Types a command; its answer.
fn ask(session: &mut Session<'_>, command: &str, most_ms: u32) -> String {
    session.machine.command(&format!("{command}\n"));
    run(session, most_ms, |line| line.starts_with("answer "));
    let last = session.lines.last().expect("a line");
    last.message.clone()
}

fn homed<'f>(firmware: &'f Firmware) -> Session<'f> {
    let mut session = session(firmware, "p70-shunt");
    ask(&mut session, "home", 100);
    run(&mut session, 10_000, |line| {
        line.starts_with("sequence done")
    });
    session
}

#[test]
fn every_quantity_is_the_motor_s_and_is_kept() {
    let Some(firmware) = support::image(support::SHUNT) else {
        return;
    };
    let mut session = homed(&firmware);
    let answer = ask(&mut session, "identify", 20_000);
    assert!(answer.contains("identified"), "{answer}");
    let p = Parameters::of("p70-shunt").expect("one of the scenes");
    let friction = p.motor.coulomb_nm + p.gearhead.drag_nm + 384.0 * p.motor.viscous_nm_s_per_rad;
    let truth = [
        p.motor.resistance_ohm + p.choke.resistance_ohm,
        p.motor.torque_constant_nm_per_a * 1e3,
        p.motor.rotor_inertia_kg_m2 * 1e7,
        friction * 1e3,
        p.bridge.dead_time_s * 1e6,
    ];
    let events = session.lines.iter().map(|line| line.event());
    let told: Vec<_> = events.filter(|event| event.name == "identify").collect();
    assert_eq!(told.len(), Quantity::ALL.len());
    for (event, truth) in told.iter().zip(truth) {
        let number = |key: &str| -> f64 {
            let text = event.field(key).expect("a key of the line");
            text.parse().expect("a number")
        };
        let (value, sigma) = (number("value"), number("sigma"));
        assert!((value - truth).abs() < 3.0 * sigma, "{event:?} {truth}");
        assert_eq!(event.field("result"), Some("ok"));
    }
    assert!(ask(&mut session, "save", 500).contains("saved"));

    // The record is read again; not homed, nothing moves.
    session.machine.power_cycle().expect("the engine works");
    let seen = session.lines.len();
    run(&mut session, 300, |_| false);
    let lines = &session.lines[seen..];
    assert!(
        lines
            .iter()
            .any(|line| line.message.contains("state=loaded"))
    );
    assert!(
        !lines
            .iter()
            .any(|line| line.message.contains("bad-configuration"))
    );
    let answer = ask(&mut session, "identify", 100);
    assert!(answer.contains("identify failed: home first"), "{answer}");
}

/// What `save` would keep: the torque factor that the sensing has, and whether there is a motor that was identified.
fn kept(session: &mut Session<'_>) -> (f32, bool) {
    let seen = session.lines.len();
    session.machine.command("trace on 1000\n");
    run(session, 300, |_| false);
    session.machine.command("trace off\n");
    run(session, 50, |_| false);
    let pieces = session.lines[seen..]
        .iter()
        .filter_map(|line| line.message.strip_prefix("answer kept "));
    let bytes: Vec<u8> = pieces
        // The piece's number comes first.
        .flat_map(|piece| piece.split_whitespace().skip(1))
        .map(|byte| byte.parse().expect("a byte"))
        .collect();
    kept_record::<P70Shunt, _>(&bytes, |record| {
        let factor = record.calibration.torque_factor;
        (factor, record.identified.is_some())
    })
    .expect("a whole record")
}

#[test]
fn factory_forgets_the_motor_in_sensing_drive_and_flash() {
    let Some(firmware) = support::image(support::SHUNT) else {
        return;
    };
    let nominal = P70Shunt::UNCALIBRATED.torque_factor;
    let mut session = homed(&firmware);
    assert_eq!(kept(&mut session), (nominal, false));
    let answer = ask(&mut session, "identify", 20_000);
    assert!(answer.contains("identified"), "{answer}");
    assert!(ask(&mut session, "save", 500).contains("saved"));
    session.machine.power_cycle().expect("the engine works");
    run(&mut session, 300, |_| false);
    // The sensing has taken the measured torque constant over.
    let (factor, identified) = kept(&mut session);
    assert!(identified && factor != nominal, "{factor}");

    assert!(ask(&mut session, "factory", 3000).contains("forgotten"));
    run(&mut session, 10, |_| false);
    assert_eq!(kept(&mut session), (nominal, false), "before a restart");
    assert!(ask(&mut session, "save", 500).contains("saved"));
    session.machine.power_cycle().expect("the engine works");
    let seen = session.lines.len();
    run(&mut session, 300, |_| false);
    let said = |text: &str| {
        let mut lines = session.lines[seen..].iter();
        lines.any(|line| line.message.contains(text))
    };
    assert!(said("state=loaded") && !said("bad-configuration"));
    assert_eq!(kept(&mut session), (nominal, false), "after a restart");
}

#[test]
fn stop_ends_it_with_the_bridge_off() {
    let Some(firmware) = support::image(support::SHUNT) else {
        return;
    };
    let mut session = homed(&firmware);
    session.machine.command("identify\n");
    run(&mut session, 1000, |_| false);
    let counts = |session: &Session<'_>| {
        session
            .machine
            .plant()
            .expect("there is one")
            .encoder_count()
    };
    session.machine.command("stop\n");
    run(&mut session, 200, |_| false);
    let stopped = counts(&session);
    run(&mut session, 500, |_| false);
    assert_eq!(counts(&session), stopped);
    let said = |text: &str| session.lines.iter().any(|line| line.message.contains(text));
    assert!(said("identify failed: stopped"));
    assert!(!said("identify quantity="));
}

#[test]
fn a_scene_without_it_says_so() {
    let Some(firmware) = firmware() else { return };
    let mut session = session(&firmware, "p70");
    let answer = ask(&mut session, "identify", 100);
    assert!(answer.contains("set identify.fitted"), "{answer}");
}
