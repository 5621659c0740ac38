//! The README's tables say what the code says.

use palpate::app::command::COMMANDS;
use palpate::app::decimal::Decimal;
use palpate::app::settings::Setting;
use palpate::drive::Fault;

const README: &str = include_str!("../README.md");

/// Prints what should stand between the markers, so that a failure can be mended by copying it.
fn holds(what: &str, rows: &[String]) {
    let missing: Vec<&String> = rows.iter().filter(|row| !README.contains(*row)).collect();
    assert!(
        missing.is_empty(),
        "the README's table of {what} lacks:\n{}\nThe whole table:\n{}",
        missing
            .iter()
            .map(|row| row.as_str())
            .collect::<Vec<_>>()
            .join("\n"),
        rows.join("\n"),
    );
}

#[test]
fn the_readme_lists_every_fault() {
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
fn the_readme_lists_every_command() {
    let rows: Vec<String> = COMMANDS
        .iter()
        .map(|(name, usage, summary)| {
            let call = [*name, *usage].join(" ");
            format!("| `{}` | {summary} |", call.trim_end().replace('|', "\\|"))
        })
        .collect();
    holds("commands", &rows);
}

#[test]
fn the_readme_lists_every_setting() {
    let rows: Vec<String> = Setting::TABLE
        .iter()
        .map(|row| {
            let (min, max) = (Decimal(row.min), Decimal(row.max));
            format!("| `{}` | {min} to {max} {} |", row.name, row.unit)
        })
        .collect();
    holds("settings", &rows);
}
