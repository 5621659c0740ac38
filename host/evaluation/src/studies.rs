//! Prints the studies that stand beside the table of experiments.

use std::fmt::Display;

use palpate_evaluation::experiments::job::{Job, Plan};
use palpate_evaluation::experiments::{calibration, following, joint_sensor, soft_objects};

/// The study of calibrated fingers.
pub const CALIBRATION: &str = "calibration";

/// Checks that `--only` begins the name of an experiment that there is: of these jobs, or of a study.
///
/// # Errors
/// None begins so; the names.
pub fn begins_a_name(jobs: &[Job], begins: &str) -> Result<(), String> {
    let jobs = jobs.iter().map(|job| job.name.as_str());
    let studies = [CALIBRATION, soft_objects::NAME, joint_sensor::NAME];
    let mut names = Vec::new();
    for name in jobs.chain(studies).chain(following::NAMES) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.iter().any(|name| name.starts_with(begins)) {
        return Ok(());
    }
    let names = names.join(", ");
    Err(format!(
        "no experiment's name begins with '{begins}'; there are: {names}"
    ))
}

/// Prints lines of JSON or a table, and to the error output what could not be done: the finger's seed, and why.
fn print<E: Display>(
    what: &str,
    lines: Option<impl IntoIterator<Item = impl Display>>,
    table: impl FnOnce() -> String,
    failed: &[(u64, E)],
) {
    let is_json = lines.is_some();
    match lines {
        Some(lines) => lines.into_iter().for_each(|line| println!("{line}")),
        None => println!("{}", table()),
    }
    for (seed, error) in failed {
        if is_json {
            let reason = error.to_string();
            let failure = serde_json::json!({"type": "failure", "experiment": what, "finger": seed, "reason": reason});
            println!("{failure}");
        } else {
            eprintln!("{what}, finger {seed}: {error}");
        }
    }
}

/// What becomes of held contacts.
pub fn changes(plan: &Plan, json: bool) {
    let (scores, failed) = following::changes(plan);
    let lines = json.then(|| following::changes_json(plan, &scores));
    print(
        "changes",
        lines,
        || following::changes_table(&scores),
        &failed,
    );
}

/// Second contacts.
pub fn second_contacts(plan: &Plan, json: bool) {
    let (scores, failed) = following::second_contacts(plan);
    let lines = json.then(|| following::second_contacts_json(plan, &scores));
    let table = || following::second_contacts_table(&scores);
    print("second contacts", lines, table, &failed);
}

/// Objects that give way.
pub fn soft_objects(plan: &Plan, json: bool) {
    let (scores, failed) = soft_objects::study(plan);
    let lines = json.then(|| soft_objects::lines(plan, &scores));
    print(
        soft_objects::NAME,
        lines,
        || soft_objects::table(&scores),
        &failed,
    );
}

/// The sensor of joint 2.
pub fn joint_sensor(plan: &Plan, json: bool) {
    let (scores, failed) = joint_sensor::study(plan);
    let lines = json.then(|| joint_sensor::lines(plan, &scores));
    let table = || joint_sensor::table(&scores);
    print(joint_sensor::NAME, lines, table, &failed);
}

/// The guided calibration on fingers with hidden values of their own.
pub fn calibration(plan: &Plan, json: bool) {
    let (fingers, failed) = calibration::study(plan);
    let summary = calibration::Summary::of(&fingers);
    let lines = json.then(|| {
        let each = fingers.iter().map(|finger| finger.json());
        each.chain([summary.json()]).collect::<Vec<_>>()
    });
    print("calibration", lines, || summary.markdown(), &failed);
}
