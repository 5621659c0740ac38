//! `--check`: the choice of methods must hold, and instruction counts must not grow.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};

use super::row::Row;

/// Growth of a mean instruction count that is still taken for the same code.
const GROWTH: f64 = 1.05;

/// Mean instructions by compiler, then by `task name`.
pub type Recorded = BTreeMap<String, BTreeMap<String, f64>>;

/// Reads the recorded counts.
pub fn read(path: &Path) -> Result<Recorded> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text)
        .with_context(|| format!("{} is no record of instruction counts", path.display()))
}

fn key(row: &Row) -> String {
    format!("{} {}", row.task, row.name)
}

/// Puts this run's counts in place of the compiler's old ones.
pub fn record(path: &Path, compiler: &str, rows: &[Row]) -> Result<()> {
    let mut recorded = if path.exists() {
        read(path)?
    } else {
        Recorded::new()
    };
    let counts = rows
        .iter()
        .filter(|row| row.on_chip.is_some())
        .map(|row| (key(row), (row.instructions() * 10.0).round() / 10.0))
        .collect();
    recorded.insert(compiler.to_owned(), counts);
    let text = serde_json::to_string_pretty(&recorded)? + "\n";
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Methods of the firmware that another one beats on both counts, and that stay: the logarithm is `micromath`'s, which the
/// project is asked to use wherever its error is far below what the place needs. libm's takes some ten instructions less.
const KEPT_ALTHOUGH_BEATEN: &[&str] = &["ln library_micromath"];

/// What is wrong, a line each; and what could not be judged.
pub fn check(rows: &[Row], recorded: &Recorded, compiler: &str) -> (Vec<String>, Vec<String>) {
    let (mut wrong, mut unknown) = (Vec::new(), Vec::new());
    for chosen in rows
        .iter()
        .filter(|row| row.chosen && !KEPT_ALTHOUGH_BEATEN.contains(&key(row).as_str()))
    {
        for better in rows.iter().filter(|row| row.beats(chosen)) {
            wrong.push(format!(
                "{}: {} is chosen, but {} has a smaller error ({:.1e} < {:.1e}) and costs less ({:.0} < {:.0} instructions)",
                chosen.task, chosen.name, better.name, better.error.error_max, chosen.error.error_max,
                better.instructions(), chosen.instructions()
            ));
        }
    }
    let differs = |row: &&Row| row.on_chip.is_some_and(|chip| !chip.same_bits);
    for row in rows.iter().filter(differs) {
        wrong.push(format!(
            "{}: {} computes other bits on the chip than on the PC",
            row.task, row.name
        ));
    }
    match recorded.get(compiler) {
        None => unknown.push(format!(
            "no instruction counts are recorded for {compiler}: growth is not judged"
        )),
        Some(counts) => {
            for row in rows.iter().filter(|row| row.on_chip.is_some()) {
                let now = row.instructions();
                match counts.get(&key(row)) {
                    Some(&before) if now > before * GROWTH + 0.5 => wrong.push(format!(
                        "{}: {} takes {now:.1} instructions, {before:.1} are recorded for {compiler}",
                        row.task, row.name
                    )),
                    Some(_) => {}
                    None => unknown.push(format!("{}: no instruction count is recorded for {}", row.task, row.name)),
                }
            }
        }
    }
    (wrong, unknown)
}

#[cfg(test)]
mod tests {
    use super::super::row::{Cost, Error, OnChip, Row};
    use super::{Recorded, check};

    fn row(name: &str, error_max: f64, instructions_mean: f64, chosen: bool) -> Row {
        Row {
            kind: "candidate",
            task: "t".into(),
            name: name.into(),
            error: Error {
                error_max,
                ..Error::default()
            },
            on_chip: Some(OnChip {
                cost: Cost {
                    instructions_mean,
                    ..Cost::default()
                },
                flash_bytes: 0,
                same_bits: true,
            }),
            chosen,
            check: false,
            why: None,
        }
    }

    fn recorded(name: &str, count: f64) -> Recorded {
        [("rustc 1".to_owned(), [(format!("t {name}"), count)].into())].into()
    }

    #[test]
    fn a_choice_that_is_beaten_in_both_fails() {
        let rows = [row("a", 1.0, 100.0, true), row("b", 0.5, 90.0, false)];
        assert_eq!(check(&rows, &Recorded::new(), "rustc 1").0.len(), 1);
        let rows = [
            row("a", 1.0, 100.0, true),
            row("b", 0.5, 110.0, false),
            row("c", 2.0, 10.0, false),
        ];
        assert!(check(&rows, &Recorded::new(), "rustc 1").0.is_empty());
    }

    #[test]
    fn a_fast_method_that_lacks_answers_beats_nothing() {
        let mut quick = row("b", 0.5, 90.0, false);
        quick.error.nonfinite = 1;
        assert!(
            check(
                &[row("a", 1.0, 100.0, true), quick],
                &Recorded::new(),
                "rustc 1"
            )
            .0
            .is_empty()
        );
    }

    #[test]
    fn growth_is_judged_for_a_known_compiler_only() {
        let rows = [row("a", 1.0, 106.0, true)];
        assert_eq!(check(&rows, &recorded("a", 100.0), "rustc 1").0.len(), 1);
        assert!(check(&rows, &recorded("a", 102.0), "rustc 1").0.is_empty());
        let (wrong, unknown) = check(&rows, &recorded("a", 1.0), "rustc 2");
        assert!(wrong.is_empty() && unknown.len() == 1);
    }
}
