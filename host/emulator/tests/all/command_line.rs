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
    let calls: [(&[&str], &str); 20] = [
        (&["--rtt-port", &port], "choose another"),
        (&["--gdb-port", &port], "choose another"),
        (
            &["--calibrate", "500"],
            "--calibrate 500: 1 to 70 mm on phalanx 2",
        ),
        (
            &["--calibrate", "20,0.5"],
            "--calibrate 0.5: 1 to 70 mm on phalanx 2",
        ),
        (
            &["--calibrate", "-5"],
            "--calibrate -5: 1 to 70 mm on phalanx 2",
        ),
        (
            &["--scene", "tendon2", "--calibrate", "67.2"],
            "--calibrate 67.2: 1 to 67 mm on phalanx 2",
        ),
        (&["--world", "nowhere"], "none of ideal"),
        (&["--html", "page.html"], "cargo xtask"),
        // Options, values and ranges in the options' own units; negative numbers are values.
        (
            &["--contact-mm", "500"],
            "--contact-mm 500: 0 to 70 mm on phalanx 2",
        ),
        (
            &["--contact-mm", "-5"],
            "--contact-mm -5: 0 to 70 mm on phalanx 2",
        ),
        (
            &["--proximal", "--contact-mm", "95"],
            "0 to 90 mm on phalanx 1",
        ),
        (&["--phalanx", "3"], "--phalanx 3: 1 to 2"),
        (&["--object-mm", "100000"], "0.001 to 1000 mm"),
        (
            &["--theta1-deg", "200"],
            "--theta1-deg 200: 4 to 91 degrees",
        ),
        (
            &["--theta1-deg", "-10"],
            "--theta1-deg -10: 4 to 91 degrees",
        ),
        (&["--theta1-deg", "0"], "--theta1-deg 0: 4 to 91 degrees"),
        (&["--object-n-per-mm", "0"], "0.001 to 10000 N/mm"),
        (
            &["--mount", "fixed", "--object-n-per-mm", "2"],
            "--mount fixed: --object-n-per-mm 2 implies --mount spring",
        ),
        (
            &["--object-n-per-mm", "2", "--mount", "free"],
            "--mount free: --object-n-per-mm 2 implies --mount spring",
        ),
        (&["--flash", "/no/such/folder/f"], "does the folder exist"),
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

/// A matrix of no cell, or a step through none, is no campaign.
#[test]
fn every_nth_cell_is_one_of_the_matrix() {
    for (words, remedy) in [
        (&["--matrix", "--every", "0"][..], "from 1 on"),
        (&["--matrix", "--every", "-1"], "from 1 on"),
        (&["--every", "2"], "--matrix"),
    ] {
        let mut call = Command::new(PROGRAM);
        let refused = call.arg("faults").args(words).output();
        let refused = refused.expect("the program starts");
        let told = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{words:?}: {told}");
        assert!(told.contains(remedy), "{words:?}: {told}");
    }
}

#[test]
fn the_help_of_sim_is_for_callers_of_xtask() {
    let help = Command::new(PROGRAM).args(["sim", "--help"]).output();
    let text = String::from_utf8(help.expect("the program starts").stdout).expect("text");
    assert!(text.contains("Usage: cargo xtask sim [OPTIONS]"), "{text}");
    assert!(text.contains("[default: ideal]"), "{text}");
    assert!(!text.contains("--elf"), "{text}");
}

/// What is left of a file that is tried before the run is what was there.
#[test]
fn flash_is_kept_where_nothing_was() {
    let Some(mut call) = sim() else { return };
    let file = std::env::temp_dir().join(format!("palpate-flash-{}", std::process::id()));
    for _ in 0..2 {
        let kept = call.arg("--flash").arg(&file).output().expect("it starts");
        assert!(kept.status.success(), "{kept:?}");
        assert!(std::fs::metadata(&file).is_ok_and(|file| file.len() > 100_000));
        call = sim().expect("as before");
    }
    std::fs::remove_file(&file).expect("the file is there");
}

/// The file holds the program too; what runs is the program that was named, and of the file the record stays.
#[test]
fn another_firmware_runs_over_the_flash_that_was_kept() {
    let Some(rigid) = support::path(support::RIGID) else {
        return;
    };
    let Some(p70) = support::path(support::DEFAULT) else {
        return;
    };
    let file = std::env::temp_dir().join(format!("palpate-other-{}", std::process::id()));
    let run = |elf: &std::path::Path, scene: &str, commands: &str| {
        let mut call = Command::new(PROGRAM);
        call.args(["sim", "--scene", scene, "--commands", commands, "--elf"]);
        let output = call.arg(elf).arg("--flash").arg(&file).output();
        let output = output.expect("the program starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let saved = run(&p70, "p70", "set hold-force 7;save");
    assert!(saved.contains("answer saved"), "{saved}");
    let other = run(&rigid, "p70-rigid", "status");
    for told in [
        "scene=p70-rigid",
        "record state=other-scene",
        "name=bad-record",
    ] {
        assert!(other.contains(told), "{told}: {other}");
    }
    let back = run(&p70, "p70", "show");
    for told in ["scene=p70\n", "record state=loaded", "hold-force 7"] {
        assert!(back.contains(told), "{told}: {back}");
    }
    std::fs::remove_file(&file).expect("the file is there");
}

#[test]
fn a_stiffness_of_springs_stands_beside_their_mount() {
    let Some(mut call) = sim() else { return };
    call.args(["--mount", "spring", "--object-n-per-mm", "2"]);
    let output = call.output().expect("the program starts");
    assert!(output.status.success(), "{output:?}");
}

/// Beside a page a reader sees what the own commands are answered, refusals above all, and not what the page asks for.
#[test]
fn beside_a_page_own_commands_are_answered() {
    let Some(elf) = support::path(support::DEFAULT) else {
        return;
    };
    let file = std::env::temp_dir().join(format!("palpate-events-{}", std::process::id()));
    let mut call = Command::new(PROGRAM);
    call.args(["sim", "--commands", "walk; calibrate 21; show", "--events"])
        .arg(&file)
        .arg("--elf")
        .arg(elf);
    let output = call.output().expect("the program starts");
    let events = std::fs::read_to_string(&file).expect("the events");
    std::fs::remove_file(&file).expect("the file is there");
    let said = String::from_utf8_lossy(&output.stdout);
    for told in ["answer error: n", "answer refused: no friction"] {
        assert!(said.contains(told), "{told}: {said}");
    }
    let times = |text: &str, what: &str| text.matches(what).count();
    assert_eq!(times(&said, "hold-force"), 1, "of its own: {said}");
    assert_eq!(times(&events, "hold-force"), 2, "{events}");
    for hidden in ["answer ok", "answer kept", "sample time_us"] {
        assert!(!said.contains(hidden), "{hidden}: {said}");
    }
}

/// What was asked for and refused is told at the end, whatever else is printed, and the run has not ended well.
#[test]
fn what_the_firmware_refuses_is_told_at_the_end() {
    let Some(elf) = support::path(support::DEFAULT) else {
        return;
    };
    let run = |commands: &str, form: &[&str]| {
        let mut call = Command::new(PROGRAM);
        call.args(["sim", "--commands", commands, "--elf"])
            .arg(&elf)
            .args(form);
        let output = call.output().expect("the program starts");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), told)
    };
    for (commands, form, refused) in [
        ("foo", &[][..], "'foo': error: n"),
        (
            "set sensitivity 1000;status",
            &["--json"],
            "'set sensitivity 1000': error: sensitivity must be",
        ),
        (
            "calibrate cable;save",
            &["--quiet"],
            "'calibrate cable': refused: no friction",
        ),
    ] {
        let (code, told) = run(commands, form);
        assert_eq!(code, Some(1), "{commands}: {told}");
        let line = format!("error: the firmware did not carry out {refused}");
        assert_eq!(told.matches(&line).count(), 1, "{commands}: {told}");
        assert_eq!(told.matches("did not carry out").count(), 1, "{told}");
    }
    assert_eq!(
        run("set sensitivity 1;status", &["--quiet"]),
        (Some(0), String::new())
    );
}

/// A fault ends a run, and what was not entered is told; a script that clears it goes on, and so does who asks for it.
#[test]
fn commands_behind_a_fault_are_entered_or_told() {
    let Some(elf) = support::path(support::DEFAULT) else {
        return;
    };
    let run = |commands: &str, further: &[&str]| {
        let mut call = Command::new(PROGRAM);
        call.args(["sim", "--fault", "encoder-cut@0.6", "--commands", commands])
            .args(further)
            .arg("--elf")
            .arg(&elf)
            .stdin(Stdio::null());
        let output = call.output().expect("the program starts");
        assert!(!output.status.success(), "there was a fault");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (text(&output.stdout), text(&output.stderr))
    };
    let (said, told) = run("home;status;open", &[]);
    assert!(
        told.contains(
            "ended the run, so these commands were not entered: status; open; with --keep-running"
        ),
        "{told}"
    );
    assert!(!said.contains("answer state"), "{said}");
    for (commands, further) in [
        ("home;status;clear;status", &[][..]),
        ("home;status", &["--keep-running"]),
    ] {
        let (said, told) = run(commands, further);
        assert!(said.contains("answer state fault"), "{said}");
        assert!(!told.contains("not entered"), "{told}");
        assert_eq!(
            commands.contains("clear"),
            said.contains("answer state idle")
        );
        // The verdict is that of what came after the fault, where it was cleared.
        assert_eq!(
            commands.contains("clear"),
            said.contains("verdict   none\n"),
            "{said}"
        );
    }
}

#[test]
fn a_fault_whose_time_never_comes_is_told() {
    let Some(mut call) = sim() else { return };
    let late = call.args(["--fault", "encoder-cut@9999"]).output();
    let late = late.expect("the program starts");
    let told = String::from_utf8_lossy(&late.stderr);
    assert!(!late.status.success());
    assert!(
        told.contains("encoder-cut@9999 not injected: the run ended at 0.1"),
        "{told}"
    );
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
