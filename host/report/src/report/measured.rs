//! What the emulator counted: the image's own lines and the cycles of its functions.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use super::row::Cost;

#[derive(Clone, Copy, Deserialize)]
struct Counted {
    cycles_low: u64,
    cycles_high: u64,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Record {
    Line {
        text: String,
    },
    /// A watched function, or an exception handler, which has no address.
    Calls {
        address: Option<u64>,
        calls: u64,
        total: Counted,
    },
    Run {},
}

/// A candidate on the chip.
pub struct Measured {
    /// Task.
    pub task: String,
    /// Candidate.
    pub name: String,
    /// Of its results.
    pub checksum: u32,
    /// Where its function is.
    pub address: u64,
    /// What a call costs.
    pub cost: Cost,
}

/// Reads `palpate-emulator count`'s output.
pub fn read(path: &Path) -> Result<Vec<Measured>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut lines = Vec::new();
    let mut cycles = HashMap::new();
    for line in text.lines() {
        match serde_json::from_str(line)? {
            Record::Line { text } => lines.push(text),
            Record::Calls {
                address: Some(address),
                calls,
                total,
            } => {
                let mean = |sum: u64| sum as f64 / calls.max(1) as f64;
                cycles.insert(
                    address & !1,
                    (mean(total.cycles_low), mean(total.cycles_high)),
                );
            }
            Record::Calls { .. } | Record::Run {} => {}
        }
    }
    if !lines.iter().any(|line| line == "bench done") {
        bail!(
            "the run on the emulated chip did not end: {:?}",
            lines.last()
        );
    }
    lines
        .iter()
        .filter(|line| line.starts_with("bench task="))
        .map(|line| one(line, &cycles))
        .collect()
}

fn one(line: &str, cycles: &HashMap<u64, (f64, f64)>) -> Result<Measured> {
    let fields: HashMap<&str, &str> = line
        .split(' ')
        .filter_map(|word| word.split_once('='))
        .collect();
    let text = |key: &str| {
        fields
            .get(key)
            .copied()
            .with_context(|| format!("no {key} in '{line}'"))
    };
    let number = |key: &str| -> Result<u64> { Ok(text(key)?.parse()?) };
    let address = number("address")? & !1;
    let of = |address: u64| {
        cycles
            .get(&address)
            .copied()
            .unwrap_or((f64::NAN, f64::NAN))
    };
    let (own, nothing) = (of(address), of(number("nothing")? & !1));
    Ok(Measured {
        task: text("task")?.to_owned(),
        name: text("name")?.to_owned(),
        checksum: u32::try_from(number("checksum")?)?,
        address,
        cost: Cost {
            instructions_mean: number("total")? as f64 / number("calls")?.max(1) as f64,
            instructions_max: number("max")?,
            cycles_low: own.0 - nothing.0,
            // A function of one instruction is not dearer than the empty one.
            cycles_high: (own.1 - nothing.1).max(own.0 - nothing.0),
        },
    })
}
