//! Tables of docs/MANUAL.md and docs/RESULTS.md agree with code and report; the README stays short.

use palpate::app::console::command::Verb;
use palpate::app::console::settings::Setting;
use palpate::app::identify::Report;
use palpate::app::log::{self, LINES, Parsed};
use palpate::app::selftest::{ExpectedRange, SelfTestStep};
use palpate::drive::Fault;
use palpate::drive::identify::{Identified, Quantity};
use palpate::scene::Scene;
use palpate_scenes::{P70, P70Shunt};

const REPORT: &str = include_str!("../../docs/report/README.md");
const RESULTS: &str = include_str!("../../docs/RESULTS.md");
const MANUAL: &str = include_str!("../../docs/MANUAL.md");
const README: &str = include_str!("../../README.md");
/// A newcomer reads it whole.
const README_WORDS: usize = 1200;

/// Prints the rows that the manual lacks and the whole table, so that a failure can be repaired by copying it.
fn holds(what: &str, rows: &[String]) {
    let missing: Vec<&String> = rows.iter().filter(|row| !MANUAL.contains(*row)).collect();
    assert!(
        missing.is_empty(),
        "docs/MANUAL.md: the table of {what} lacks:\n{}\nThe whole table:\n{}",
        missing
            .iter()
            .map(|row| row.as_str())
            .collect::<Vec<_>>()
            .join("\n"),
        rows.join("\n"),
    );
}

#[test]
fn the_manual_lists_every_fault() {
    let rows: Vec<String> = Fault::ALL
        .iter()
        .map(|fault| {
            format!(
                "| {} | `{}` | {} | {}: {} | {} | {} |",
                fault.number(),
                fault.name(),
                fault.detected_by(),
                fault.limit_us(),
                fault.limit_reason(),
                fault.cause(),
                fault.remedy()
            )
        })
        .collect();
    holds("faults", &rows);
}

#[test]
fn the_manual_lists_every_command() {
    let rows: Vec<String> = Verb::ALL
        .iter()
        .map(|verb| {
            let call = [verb.name(), verb.usage()].join(" ");
            let call = call.trim_end().replace('|', "\\|");
            format!("| `{call}` | {} |", verb.summary())
        })
        .collect();
    holds("commands", &rows);
}

#[test]
fn the_manual_lists_every_setting() {
    let rows: Vec<String> = Setting::ALL
        .into_iter()
        .map(|setting| {
            let (name, range, unit) = (setting.name(), setting.range(), setting.unit());
            format!("| `{name}` | {range} {unit} |")
        })
        .collect();
    holds("settings", &rows);
}

#[test]
fn the_manual_lists_every_log_line_with_its_keys() {
    let (_, section) = MANUAL
        .split_once("## Log lines")
        .expect("a section on the log");
    let rows: Vec<&str> = section
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect();
    for line in LINES {
        // A line of text alone is named without an equals sign.
        let keys = line
            .keys
            .iter()
            .filter(|key| line.format.contains(&format!("{key}={{=")));
        let mut call = line.name().replace(" {=str}", "");
        keys.for_each(|key| call += &format!(" {key}="));
        let call = format!("`{call}`");
        assert!(
            rows.iter().any(|row| row.contains(&call)),
            "docs/MANUAL.md lacks the line {call}"
        );
    }
}

/// The transcripts are what the commands print today: line for line, key for key, what is wanted and in which unit.
#[test]
fn the_manual_s_transcripts_have_the_firmware_s_lines() {
    let transcript = |name: &str| -> Vec<Parsed<'_>> {
        let lines = MANUAL.lines().map(str::trim_start);
        let parsed = lines.filter(|line| line.starts_with(&format!("{name} ")));
        parsed.map(log::parse).collect()
    };
    let keys = |name: &str| {
        let line = LINES.iter().find(|line| line.name() == name);
        line.expect("a line of the log").keys
    };
    let steps = transcript("selftest");
    assert_eq!(steps.len(), SelfTestStep::ALL.len());
    let limits = P70::DRIVE.limits;
    for (told, step) in steps.iter().zip(SelfTestStep::ALL) {
        let wanted = ExpectedRange::of(step, limits.supply_min_v, limits.supply_max_v, false);
        for key in keys("selftest") {
            assert!(told.field(key).is_some(), "{step:?} {key}");
        }
        assert_eq!(told.field("step"), Some(step.name()));
        assert_eq!(told.field("want"), Some(wanted.to_string().as_str()));
    }
    let quantities = transcript("identify");
    assert_eq!(quantities.len(), Quantity::ALL.len());
    for (told, quantity) in quantities.iter().zip(Quantity::ALL) {
        let report = Report::of::<P70Shunt>(quantity, &Identified::default());
        for key in keys("identify") {
            assert!(told.field(key).is_some(), "{quantity:?} {key}");
        }
        assert_eq!(told.field("quantity"), Some(report.name));
        assert_eq!(told.field("unit"), Some(report.unit));
        let datasheet: f32 = told
            .field("datasheet")
            .and_then(|n| n.parse().ok())
            .expect("a number");
        assert!((datasheet / report.datasheet - 1.0).abs() < 1e-5);
    }
}

/// Both are written by one command, `cargo xtask report --write`: the rows in RESULTS must be the report's.
#[test]
fn the_results_are_the_report_s() {
    let (_, rest) = RESULTS
        .split_once("<!-- report: begin")
        .expect("docs/RESULTS.md has the report's markers");
    let (block, _) = rest
        .split_once("<!-- report: end -->")
        .expect("both of them");
    let mut compared = 0;
    for row in block.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let stands = match cells.get(2).and_then(|cell| cell.split_once(" / ")) {
            // A method: its mean and largest count and its error stand in a row of the page.
            Some((mean, max)) if mean.starts_with(|c: char| c.is_ascii_digit()) => {
                let counts = format!("| {mean} | {max} |").replace(',', "");
                compared += 1;
                REPORT
                    .lines()
                    .any(|line| line.contains(&counts) && line.contains(cells[3]))
            }
            // A target stands there as it is.
            _ if row.contains("| met |") || row.contains("| **missed** |") => REPORT.contains(row),
            _ => true,
        };
        assert!(stands, "docs/report knows no {row}");
    }
    assert!(compared >= 5, "docs/RESULTS.md compares {compared} methods");
}

#[test]
fn the_readme_is_short() {
    let words = README.split_whitespace().count();
    println!("README: {words} words");
    assert!(
        words <= README_WORDS,
        "{words} words, at most {README_WORDS}"
    );
}
