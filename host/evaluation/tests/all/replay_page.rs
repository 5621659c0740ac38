//! `replay --html`, from the file of a recording to the page: the program leaves its events, the page tells them.

use std::process::Command;

use palpate_monitor::page::GraspPage;
use palpate_monitor::{scenes, stream};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{HEADER, Simulation};

/// A contact with its free motion before it, and the truth beside it, as `recordings` has it.
fn write(folder: &std::path::Path) {
    let mut simulation =
        Simulation::<P70>::new(&Parameters::default(), 9).expect("the defaults are valid");
    simulation.traced = true;
    let free = simulation
        .prepare()
        .expect("an idle finger records friction");
    let pin = Shape::Cylinder { diameter_m: 0.012 };
    let outcome = simulation
        .close(&Grasp::touching(2, 0.034, 0.7, pin))
        .expect("the object is clear of the open finger");
    let mut file = format!("{HEADER}\n");
    for row in free.trace.iter().chain(&outcome.trace) {
        file.push_str(&row.csv());
        file.push('\n');
    }
    std::fs::create_dir_all(folder).expect("a folder");
    std::fs::write(folder.join("grasp.csv"), file).expect("room");
    let truth = r#"{"contact":{"phalanx_first":2,"k_first_mm":34.0}}"#;
    std::fs::write(folder.join("grasp.json"), truth).expect("room");
}

#[test]
fn a_recording_becomes_a_page() {
    let folder = std::env::temp_dir().join(format!("palpate-replay-{}", std::process::id()));
    write(&folder);
    let events = folder.join("grasp.jsonl");
    let replay = Command::new(env!("CARGO_BIN_EXE_palpate-evaluation"))
        .arg("replay")
        .arg(folder.join("grasp.csv"))
        .arg("--events")
        .arg(&events)
        .output()
        .expect("the program starts");
    assert!(replay.status.success(), "{replay:?}");
    let printed = String::from_utf8_lossy(&replay.stdout);
    assert!(printed.contains("located phalanx=2"), "{printed}");
    // Samples alone: what a closing was for is not in them.
    let told = String::from_utf8_lossy(&replay.stderr);
    assert!(
        told.contains("does not say which closings calibrate") && told.contains("--calibrate"),
        "{told}"
    );

    let mut page = GraspPage::default();
    let lines = std::fs::read_to_string(&events).expect("the events");
    for message in lines.lines().filter_map(stream::parse) {
        page.take(message);
    }
    let finger = page.scene().and_then(scenes::finger);
    let html = page.html("A recorded grasp", finger);
    std::fs::remove_dir_all(&folder).expect("the folder is there");
    assert!(html.contains("Contact on phalanx 2, <b>3"), "{html}");
    assert!(html.contains("mm off"), "against the truth beside it");
    assert!(
        html.matches("<svg").count() == 4,
        "finger, curve, evidence, posterior"
    );
    assert!(html.contains("<td>located</td>"));
    assert!(html.contains("closing-speed 0."), "settings: {html}");
    assert!(html.contains("Not calibrated"), "{html}");
    assert!(!html.contains("://"), "no network");
}
