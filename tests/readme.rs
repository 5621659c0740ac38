//! The README's tables say what the code says.

use palpate::app::console::command::Verb;
use palpate::app::console::settings::Setting;
use palpate::drive::Fault;

const REPORT: &str = include_str!("../docs/report/README.md");
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
fn the_readme_lists_every_setting() {
    let rows: Vec<String> = Setting::ALL
        .into_iter()
        .map(|setting| {
            let (name, range, unit) = (setting.name(), setting.range(), setting.unit());
            format!("| `{name}` | {range} {unit} |")
        })
        .collect();
    holds("settings", &rows);
}

/// Both are written by one command, `cargo xtask report --write`: the README's rows must be the page's.
#[test]
fn the_readme_s_numbers_are_the_report_s() {
    let (_, rest) = README
        .split_once("<!-- report: begin")
        .expect("the README has the report's markers");
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
    assert!(compared >= 5, "the README compares {compared} methods");
}
