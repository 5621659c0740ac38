// SPDX-License-Identifier: GPL-2.0-only
//! A grasp recorded from the firmware is replayed to exactly what the firmware said live.
//!
//! Nothing is lost on the way: a sample a millisecond, each with all its digits, and between them the lines that tell what the
//! sensing was asked to do. So every event comes again with the same sample and the same digits.

use crate::support;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::support::firmware;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings, end_of};
use palpate_evaluation::replay::{Comparison, Replayer};
use palpate_evaluation::trace::stream;
use palpate_monitor::recording::Recording;
use palpate_monitor::stream::{Message, parse};
use palpate_plant::Parameters;

/// Runs a script on the chip of a scene, from flash contents of before.
fn session<'f>(
    firmware: &'f Firmware,
    scene: &str,
    object: Object,
    commands: &str,
    flash: Option<Vec<u8>>,
) -> Session<'f> {
    let mut settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
        object: Some(object),
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
    has_no_useless_line(&session);
    session
}

/// What came of a recording.
#[derive(Debug)]
struct Trip {
    rows: usize,
    /// Names of the events, in the order of time.
    said: Vec<&'static str>,
    compared: Comparison,
}

/// Records what a session logged as `cargo xtask record` does, and replays the file: with every sample in it, and every event
/// as it was said live.
fn round_trip(scene: &str, session: &Session<'_>) -> Trip {
    static RECORDED: AtomicUsize = AtomicUsize::new(0);
    let number = RECORDED.fetch_add(1, Ordering::Relaxed);
    let file = format!("palpate-round-{number}-{}.csv", std::process::id());
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
    let (found, compared) = (Replayer::of(scene).expect(scene).again)(&rows);
    let said = found.lines().into_iter().map(|(_, (name, _))| name);
    let trip = Trip {
        rows: rows.len(),
        said: said.collect(),
        compared,
    };
    println!("{trip:?}");
    assert_eq!(trip.compared.live, trip.said.len());
    assert_eq!(trip.compared.differences, [""; 0]);
    trip
}

impl Trip {
    /// It is about what it should be about.
    fn has(&self, events: &[&str]) {
        for name in events {
            assert!(self.said.contains(name), "{name}: {:?}", self.said);
        }
    }
}

/// What the log of a normal motion may hold, each with what its reader learns or does.
const NORMAL: [(&str, &str); 20] = [
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
    ("object", "how stiff the object is"),
    ("not-located", "why there is none"),
    ("branch", "what the sensor of joint 2 says of it"),
    ("second-contact", "that another phalanx touches too"),
    ("grasp", "how the object is held"),
    ("calibrating", "what the next closing is for"),
    ("calibrated", "what was learned, how well"),
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

#[test]
fn a_recorded_grasp_is_replayed_to_what_was_said_live() {
    let Some(firmware) = firmware() else { return };
    let session = session(&firmware, "p70", Object::default(), "trace on; run", None);
    let trip = round_trip("p70", &session);
    assert!(trip.rows > 15_000, "{}", trip.rows);
    trip.has(&["friction-recorded", "touch", "located", "stiffness"]);
}

#[test]
fn what_was_kept_and_what_a_closing_is_for_are_in_the_recording() {
    let Some(firmware) = firmware() else { return };
    let run = |commands, flash| session(&firmware, "p70", Object::default(), commands, flash);
    let before = run("record-friction; save", None);
    let flash = before.machine.flash().to_vec();
    let trip = round_trip("p70", &run("trace on; calibrate 21; run", Some(flash)));
    assert!(!trip.said.contains(&"friction-recorded"), "{:?}", trip.said);
    trip.has(&["touch", "located", "calibrated"]);
}

/// The angle of joint 2, which decides between two places, is in the recording with all its digits.
#[test]
fn the_sensor_of_joint_2_is_in_the_recording() {
    let Some(firmware) = support::image(support::HALL) else {
        return;
    };
    let object = Object {
        contact_mm: 10.0,
        theta_1_deg: 95.0,
        ..Object::default()
    };
    let session = session(&firmware, "tendon2-hall", object, "trace on; run", None);
    let samples = session.lines.iter().map(|line| line.event());
    let samples = samples.filter(|event| event.name == "sample");
    let (with, all) = samples.fold((0, 0), |(with, all), event| {
        (
            with + usize::from(event.number("joint_rad").is_some()),
            all + 1,
        )
    });
    assert!(with > 0 && with == all, "{with} of {all}");
    round_trip("tendon2-hall", &session).has(&["friction-recorded", "touch", "located"]);
}

/// A cylinder that two phalanges meet.
fn second_contact(variable: &str, scene: &str, object: Object) {
    let Some(firmware) = support::image(variable) else {
        return;
    };
    let session = session(&firmware, scene, object, "trace on; run", None);
    round_trip(scene, &session).has(&["touch", "second-contact", "grasp"]);
}

#[test]
fn a_second_contact_is_replayed_as_well() {
    let object = Object {
        phalanx: 1,
        contact_mm: 70.0,
        diameter_mm: 70.0,
        theta_1_deg: 40.0,
    };
    second_contact(support::GRASP, "p70-grasp", object);
}

/// Its place is weighed step by step, sample by sample.
#[test]
fn a_second_contact_of_three_phalanges_is_replayed_as_well() {
    let object = Object {
        phalanx: 2,
        contact_mm: 41.5,
        diameter_mm: 61.5,
        theta_1_deg: 49.0,
    };
    second_contact(support::GRASP_TENDON3, "tendon3-grasp", object);
}

/// A place with the stiffness of its object.
#[test]
fn the_stiffness_of_an_object_is_replayed_as_well() {
    let Some(firmware) = firmware() else { return };
    let commands = "trace on; record-friction; run";
    let session = session(&firmware, "p70", Object::default(), commands, None);
    round_trip("p70", &session).has(&["touch", "located", "object"]);
}
