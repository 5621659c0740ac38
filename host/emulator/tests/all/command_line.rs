// SPDX-License-Identifier: GPL-2.0-only
//! The program as its user meets it: help with examples, colour on a terminal and nowhere else.
#![cfg(unix)]

use crate::support;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};

const PROGRAM: &str = env!("CARGO_BIN_EXE_palpate-emulator");
/// A run that takes longer never ends.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn every_command_has_examples_in_its_help() {
    for command in ["sim", "faults", "bench"] {
        let help = Command::new(PROGRAM)
            .args([command, "--help"])
            .output()
            .expect("the program starts");
        let text = String::from_utf8_lossy(&help.stdout);
        assert!(text.contains("\nExample"), "{command}: {text}");
    }
}

/// `cargo xtask` explains `faults` before it builds anything: with the options that the program has.
#[test]
fn the_help_of_faults_is_that_of_its_command() {
    let help = Command::new(PROGRAM).args(["faults", "-h"]).output();
    let text = String::from_utf8(help.expect("the program starts").stdout).expect("text");
    let told = include_str!("../../../xtask/src/help.rs");
    let options = text
        .split([' ', ',', '\n'])
        .filter(|word| word.starts_with("--") && !matches!(*word, "--help" | "--elf" | "--fault"));
    for option in options {
        assert!(told.contains(&format!("\"{option}")), "{option}");
    }
}

/// What cannot be is refused before anything runs, with what to do.
#[test]
fn wrong_calls_end_with_what_to_do() {
    let busy = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = busy.local_addr().expect("its address").port().to_string();
    let calls: [(&[&str], &str); 5] = [
        (&["--rtt-port", &port], "choose another"),
        (&["--gdb-port", &port], "choose another"),
        (&["--calibrate", "500"], "--calibrate takes places on it"),
        (&["--world", "nowhere"], "none of ideal"),
        (&["--html", "page.html"], "cargo xtask"),
    ];
    for (words, remedy) in calls {
        let Some(elf) = support::path(support::DEFAULT) else {
            return;
        };
        let mut call = Command::new(PROGRAM);
        call.args(["sim", "--elf"]).arg(elf).args(words);
        let refused = call.output().expect("the program starts");
        let told = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success(), "{words:?}");
        assert!(
            told.contains(remedy) && refused.stdout.is_empty(),
            "{words:?}: {told}"
        );
    }
}

/// A short run that says a few lines.
fn sim() -> Option<Command> {
    let elf = support::path(support::DEFAULT)?;
    let mut call = Command::new(PROGRAM);
    call.args(["sim", "--commands", "status", "--elf"])
        .arg(elf)
        .env("TERM", "xterm-256color")
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE");
    Some(call)
}

/// What a call prints to a terminal.
fn on_a_terminal(mut call: Command) -> String {
    let (mut screen, terminal) = TTYPort::pair().expect("a pair of terminals");
    screen
        .set_timeout(Duration::from_millis(100))
        .expect("a limit");
    let name = terminal.name().expect("its name");
    let open = || {
        let opened = std::fs::File::options().read(true).write(true).open(&name);
        Stdio::from(opened.expect("the terminal"))
    };
    let mut child = call
        .stdin(open())
        .stdout(open())
        .stderr(open())
        .spawn()
        .expect("the program starts");
    let (mut seen, mut bytes) = (Vec::new(), [0; 1024]);
    let start = Instant::now();
    loop {
        let ended = child.try_wait().expect("a child").is_some();
        let count = screen.read(&mut bytes).unwrap_or(0);
        seen.extend_from_slice(&bytes[..count]);
        if ended && count == 0 {
            return String::from_utf8_lossy(&seen).into_owned();
        }
        assert!(start.elapsed() < PATIENCE, "it does not end");
    }
}

#[test]
fn colour_is_for_a_terminal_and_nothing_else() {
    let Some(mut call) = sim() else { return };
    let piped = call.output().expect("the program starts");
    let text = String::from_utf8_lossy(&piped.stdout);
    assert!(text.contains("boot version="), "{text}");
    for bytes in [&piped.stdout, &piped.stderr] {
        assert!(!bytes.contains(&0x1b), "{}", String::from_utf8_lossy(bytes));
    }
    let seen = on_a_terminal(call);
    // The log's times are dim, and how far it is stands below.
    assert!(seen.contains("\x1b[2m"), "{seen:?}");
    assert!(seen.contains("s simulated"), "{seen:?}");
    let mut call = sim().expect("as before");
    call.env("NO_COLOR", "1");
    let seen = on_a_terminal(call);
    assert!(
        seen.contains("boot version=") && !seen.contains("\x1b[2m"),
        "{seen:?}"
    );
}
