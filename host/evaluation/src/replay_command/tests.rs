//! `replay` of recordings that cannot be judged, and of files that teach nothing.

use super::*;
use clap::Parser;

#[derive(Parser)]
struct Call {
    #[command(flatten)]
    options: Options,
}

/// A recording of the project's, which has a friction record of its own.
fn recording(name: &str) -> String {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/recordings");
    format!("{root}/{name}.csv.gz")
}

/// Runs a call; why it fails.
fn fails(words: &[&str]) -> Option<String> {
    let call = Call::try_parse_from(["replay"].iter().chain(words));
    let options = call.unwrap_or_else(|error| panic!("{error}")).options;
    run(&options).err().map(|error| error.to_string())
}

/// A recording's rows of some time, as a file.
fn part(name: &str, of: &str, seconds: std::ops::Range<f64>) -> String {
    let rows = recordings::open(Path::new(&recording(of))).expect("a recording");
    let text = std::io::read_to_string(rows).expect("text");
    let within = |row: &&str| match row.split(',').next().map(str::parse) {
        Some(Ok(time_s)) => seconds.contains(&time_s),
        // The head.
        _ => true,
    };
    let rows: Vec<&str> = text.lines().filter(within).collect();
    let file = std::env::temp_dir().join(format!("palpate-{name}-{}", std::process::id()));
    std::fs::write(&file, rows.join("\n")).expect("a temporary file");
    file.display().to_string()
}

#[test]
fn a_recording_without_friction_is_no_success() {
    // `w1_d0` closes freely, opens, and then closes on its object from 10.6 s on; `w1_free0` closes freely there.
    let grasp = part("grasp", "w1_d0", 10.5..99.0);
    let closing = part("closing", "w1_free0", 0.0..5.3);
    let both = recording("w1_free0");
    let told = fails(&[&grasp]).expect("no friction");
    assert!(told.contains("friction was not recorded") && told.contains("with --friction"));
    let told = fails(&[&grasp, "--friction", &closing]).expect("one way alone");
    assert!(
        told.contains(&format!("--friction {closing}: no opening")),
        "{told}"
    );
    // The closing behind its opening does not spoil the record.
    assert_eq!(fails(&[&grasp, "--friction", &both]), None);
    for file in [grasp, closing] {
        std::fs::remove_file(file).expect("it is there");
    }
}

#[test]
fn a_calibration_that_teaches_nothing_is_told() {
    let grasp = recording("w1_d0");
    let [pin, elsewhere] = ["21", "60"].map(|mm| format!("{}@{mm}", recording("w1_pin21")));
    assert_eq!(fails(&[&grasp, "--calibrate", &pin]), None);
    let told = fails(&[&grasp, "--calibrate", &pin, "--calibrate", &elsewhere]);
    let told = told.expect("another place");
    assert_eq!(
        told,
        format!("--calibrate {elsewhere}: nothing was learned from it")
    );
}
