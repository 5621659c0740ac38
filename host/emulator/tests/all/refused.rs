// SPDX-License-Identifier: GPL-2.0-only
//! A command that the firmware refuses moves nothing and says no `sequence done`: the user goes on with the next one.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::support::{self, firmware};
use palpate_emulator::sim::{Script, Session, Settings, Step, end_of};

/// Nothing moves in these runs.
const SOON_S: f64 = 5.0;

/// Answers of a run, in their order.
fn answers<'l>(lines: impl Iterator<Item = &'l str>) -> Vec<String> {
    lines
        .filter_map(|line| Some(line.split_once("answer ")?.1))
        .map(|answer| answer.chars().take(8).collect())
        .collect()
}

fn script(commands: &str) -> Settings {
    Settings {
        script: Script::parse(commands),
        ..Settings::default()
    }
}

#[test]
fn a_refused_motion_ends_no_script() {
    let Some(firmware) = firmware() else { return };
    let settings = script("calibrate 21; walk; calibrate cable; status");
    let session = end_of(&firmware, settings).expect("a sound run");
    assert!(session.completed() && session.machine.time_s() < SOON_S);
    let said = answers(session.lines.iter().map(|line| line.message.as_str()));
    assert_eq!(said, ["refused:", "error: n", "refused:", "state id"]);
    let steps: Vec<String> = (session.refused.iter())
        .map(|(step, _)| step.to_string())
        .collect();
    assert_eq!(steps, ["calibrate 21", "walk", "calibrate cable"]);
}

/// The firmware takes any place on its last phalanx, and refuses what lies beyond.
#[test]
fn a_pin_beyond_the_tip_ends_no_run() {
    let Some(firmware) = firmware() else { return };
    let settings = script("record-friction; calibrate 500; status");
    let session = end_of(&firmware, settings).expect("a sound run");
    assert!(session.completed(), "{:?}", session.state);
    assert!(session.notes.is_empty(), "{:?}", session.notes);
    let error = "answer error: the place must be 1 to 70 mm from the joint";
    let said = session.lines.iter().map(|line| line.message.as_str());
    assert_eq!(said.filter(|line| *line == error).count(), 1);
    let last = session.lines.last().map(|line| line.message.as_str());
    assert!(
        last.is_some_and(|line| line.starts_with("answer state")),
        "{last:?}"
    );
}

/// What the program says with these lines at its standard input; it ends after the last one.
fn typed(lines: &str) -> Option<String> {
    let elf = support::path(support::DEFAULT)?;
    let mut child = Command::new(env!("CARGO_BIN_EXE_palpate-emulator"))
        .args(["sim", "--keep-running", "--commands", "status"])
        .arg("--elf")
        .arg(elf)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut input = child.stdin.take().expect("a pipe");
    input.write_all(lines.as_bytes()).expect("it reads");
    drop(input);
    let output = child.wait_with_output().expect("it ends");
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn lines_typed_after_a_refusal_are_answered() {
    let Some(said) = typed("calibrate 21\nfoo\nstatus\n") else {
        return;
    };
    assert_eq!(
        answers(said.lines()),
        ["state id", "refused:", "error: n", "state id"],
        "{said}"
    );
}

/// The answer to a `stop` of a finger at rest is none to the line that is typed at the same time.
#[test]
fn a_stop_at_rest_does_not_hide_a_refusal() {
    let Some(firmware) = firmware() else { return };
    let mut session = Session::start(&firmware, script("status"), None).expect("a start");
    support::run_out(&mut session);
    session.stop();
    for line in ["calibrate 21", "status"] {
        session.enter(Step::Command(line.to_owned()));
    }
    while !session.over() && session.machine.time_s() < SOON_S {
        session.millisecond().expect("a sound run");
    }
    let said = answers(session.lines.iter().map(|line| line.message.as_str()));
    assert_eq!(said, ["state id", "ok", "refused:", "state id"]);
    assert!(session.completed());
}

/// `stop` ends what is asked for, whether it has begun or still waits, and what is typed after it is carried out.
#[test]
fn a_stop_lets_the_next_line_through() {
    let Some(firmware) = firmware() else { return };
    for wait_ms in [0, 1, 2, 5, 50, 1000] {
        let mut session = Session::start(&firmware, script("home"), None).expect("a start");
        // The first step is typed after 100 ms.
        while session.machine.time_s() < 0.1005 + 1e-3 * f64::from(wait_ms) {
            session.millisecond().expect("a sound run");
        }
        session.stop();
        session.enter(Step::Command("status".to_owned()));
        while !session.over() && session.machine.time_s() < SOON_S {
            session.millisecond().expect("a sound run");
        }
        let said = answers(session.lines.iter().map(|line| line.message.as_str()));
        assert!(session.completed(), "{wait_ms} ms: {said:?}");
        assert_eq!(said.last().map(String::as_str), Some("state id"));
    }
}
