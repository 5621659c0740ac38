//! What a run of the target's tests printed, on a board or on the emulated chip: every test passed, and the arithmetic has the bits
//! that this PC computes.

use std::path::PathBuf;

use anyhow::{Context, Result};
use palpate::app::log::parse;
use palpate_bench::arithmetic;

/// Tests that must have run, besides those of the arithmetic.
const TESTS: [&str; 6] = [
    "control-step",
    "interrupt-latency",
    "break-input",
    "bridge-off",
    "store",
    "watchdog",
];

/// Options of `target`.
#[derive(clap::Args)]
pub struct Arguments {
    /// What the run printed
    log: PathBuf,
}

/// Judges a run; whether everything passed.
///
/// # Errors
/// The log cannot be read.
pub fn run(arguments: &Arguments) -> Result<bool> {
    let path = &arguments.log;
    let log = std::fs::read_to_string(path).with_context(|| format!("{}", path.display()))?;
    let rows = judge(&log);
    for (name, good, said) in &rows {
        println!("{} {name}: {said}", if *good { "ok    " } else { "FAILED" });
    }
    Ok(rows.iter().all(|(_, good, _)| *good))
}

/// Name, verdict and reason of every test that must have run.
fn judge(log: &str) -> Vec<(String, bool, String)> {
    let lines: Vec<_> = log
        .lines()
        .filter_map(|line| line.find("target test=").map(|at| parse(&line[at..])))
        .collect();
    let mut rows = Vec::new();
    arithmetic::visit(|name, here| {
        let line = lines.iter().find(|line| {
            line.field("test") == Some("arithmetic") && line.field("name") == Some(name)
        });
        let there = line.and_then(|line| {
            // The place in the source may follow.
            let checksum = line.field("checksum")?.split_whitespace().next()?;
            checksum.parse().ok()
        });
        let said = match there {
            Some(there) if there == here => "same bits as here".to_owned(),
            Some(there) => format!("{there}, here {here}"),
            None => "did not run".to_owned(),
        };
        rows.push((format!("arithmetic {name}"), there == Some(here), said));
    });
    for test in TESTS {
        let line = lines.iter().find(|line| line.field("test") == Some(test));
        let good = line.is_some_and(|line| line.field("result") == Some("ok"));
        let said = line.map_or("did not run".to_owned(), |line| {
            let field = |key| line.field(key).unwrap_or_default();
            format!("{}, wanted {}", field("value"), field("want"))
        });
        rows.push((test.to_owned(), good, said));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> String {
        let mut log = String::from("0.1 [INFO ] something else\n");
        arithmetic::visit(|name, sum| {
            log += &format!("0.2 [INFO ] target test=arithmetic name={name} checksum={sum}\n");
        });
        for test in TESTS {
            log += &format!("0.3 [INFO ] target test={test} result=ok value=1 want=1: it works\n");
        }
        log
    }

    fn failed(log: &str) -> Vec<String> {
        let rows = judge(log).into_iter();
        rows.filter(|(_, good, _)| !good).map(|row| row.0).collect()
    }

    #[test]
    fn a_sound_run_passes_and_whatever_is_missing_or_differs_is_named() {
        assert_eq!(failed(&log()), Vec::<String>::new());
        assert_eq!(failed("").len(), 10 + TESTS.len());
        let broken = log().replace("test=store result=ok", "test=store result=failed");
        assert_eq!(failed(&broken), ["store"]);
        let other = log().replace("name=exp checksum=", "name=exp checksum=1");
        assert_eq!(failed(&other), ["arithmetic exp"]);
        let cut: String = log()
            .lines()
            .filter(|l| !l.contains("watchdog"))
            .map(|l| format!("{l}\n"))
            .collect();
        assert_eq!(failed(&cut), ["watchdog"]);
    }
}
