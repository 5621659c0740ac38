// SPDX-License-Identifier: GPL-2.0-only
//! A grasp recorded from the firmware is replayed to exactly what the firmware said live.
//!
//! Nothing is lost on the way: a sample a millisecond, each with all its digits, and between them the lines that tell what the
//! sensing was asked to do. So every event comes again with the same sample and the same digits.
//!
//! The image comes from `PALPATE_ELF` (`cargo xtask test` sets it); without it this test says so and passes.

use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings, end_of};
use palpate_evaluation::replay::{Comparison, again};
use palpate_evaluation::trace::stream;
use palpate_monitor::recording::Recording;
use palpate_monitor::stream::{Message, parse};
use palpate_scenes::P70;

/// Runs a script on the chip, from flash contents of before; none without an image.
fn session<'f>(firmware: &'f Firmware, commands: &str, flash: Option<Vec<u8>>) -> Session<'f> {
    let mut settings = Settings {
        object: Some(Object {
            phalanx: 2,
            contact_mm: 30.0,
            diameter_mm: 10.0,
            theta_1_deg: 45.0,
        }),
        script: Script::parse(commands),
        ..Settings::default()
    };
    settings.setup.flash = flash;
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(
        session.completed() && session.faults.is_empty(),
        "{:?}",
        session.faults
    );
    session
}

/// Records what a session logged as `cargo xtask record` does, and replays the file.
fn round_trip(name: &str, session: &Session<'_>) -> (usize, Vec<&'static str>, Comparison) {
    let file = format!("palpate-round-{name}-{}.csv", std::process::id());
    let file = std::env::temp_dir().join(file);
    let mut recording = Recording::create(&file).expect("a temporary file");
    for line in &session.lines {
        // As a printer of the log writes it.
        let message: Option<Message> = parse(&line.to_string());
        recording
            .take(&message.expect("a line"))
            .expect("room on the disk");
        assert_ne!(line.event().name, "log", "dropped: {line}");
    }
    recording.finish().expect("the file is written");
    let opened = std::fs::File::open(&file).expect("the file");
    let rows = stream(opened).expect("replay reads it");
    let rows = rows.expect("every millisecond has its sample");
    std::fs::remove_file(&file).expect("the file is there");
    let (found, compared) = again::<P70>(&rows);
    let names = found
        .told
        .iter()
        .map(|told| palpate_evaluation::replay::fields(&told.event).0);
    (rows.len(), names.collect(), compared)
}

/// What the log of a normal first grasp may hold, each with what its reader learns or does.
const NORMAL: [(&str, &str); 13] = [
    ("boot", "which firmware, for which finger"),
    ("reset", "why it started"),
    (
        "record",
        "whether friction and calibration are known from before",
    ),
    ("state", "what the finger is doing"),
    ("offset", "whether the current sense is sound"),
    ("friction-recorded", "how much friction, how well known"),
    ("hint", "what to do next to calibrate"),
    ("touch", "when and where contact began"),
    ("located", "the result"),
    ("stiffness", "how stiff the grasp is"),
    ("sequence done", "how the motion ended"),
    ("answer", "what became of a command"),
    ("sample", "asked for by trace"),
];

/// No line that a reader can neither learn from nor act on, and no warning where nothing is wrong.
fn has_no_useless_line(session: &Session<'_>) {
    for line in &session.lines {
        let name = line.event().name;
        let known = NORMAL.iter().any(|(normal, _)| {
            name.strip_prefix(normal)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
        });
        assert!(known && line.level == "info", "{line}");
    }
    // A place is told while it is refined, not at every sample.
    let located = session
        .lines
        .iter()
        .filter(|line| line.event().name == "located");
    assert!(located.count() <= 6);
}

fn image() -> Option<Firmware> {
    let path = std::env::var_os("PALPATE_ELF");
    if path.is_none() {
        eprintln!("PALPATE_ELF is not set: nothing tested");
    }
    path.map(|path| Firmware::load(path.as_ref()).expect("the image loads"))
}

#[test]
fn a_recorded_grasp_is_replayed_to_what_was_said_live() {
    let Some(firmware) = image() else { return };
    let session = session(&firmware, "trace on; run", None);
    has_no_useless_line(&session);
    let (rows, said, compared) = round_trip("run", &session);
    println!("{rows} rows, {said:?}, {compared:?}");
    assert!(rows > 15_000, "{rows}");
    for name in ["friction-recorded", "touch", "located", "stiffness"] {
        assert!(said.contains(&name), "{name}: {said:?}");
    }
    assert_eq!(compared.live, said.len());
    assert_eq!(compared.differences, [""; 0]);
}

#[test]
fn what_was_kept_and_what_a_closing_is_for_are_in_the_recording() {
    let Some(firmware) = image() else { return };
    let before = session(&firmware, "record-friction; calibrate cable; save", None);
    let flash = before.machine.flash().to_vec();
    let session = session(&firmware, "trace on; calibrate 21; run", Some(flash));
    let (_, said, compared) = round_trip("kept", &session);
    println!("{said:?}, {compared:?}");
    assert!(!said.contains(&"friction-recorded"), "{said:?}");
    for name in ["touch", "located", "calibrated"] {
        assert!(said.contains(&name), "{name}: {said:?}");
    }
    assert_eq!(compared.live, said.len());
    assert_eq!(compared.differences, [""; 0]);
}
