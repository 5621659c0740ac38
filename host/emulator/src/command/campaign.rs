// SPDX-License-Identifier: GPL-2.0-only
//! `faults --matrix` and `faults --pairs N`: many faults at many moments, with the grasp after each, as one table.

use std::collections::BTreeMap;
use std::process::ExitCode;

use palpate_emulator::sim::campaign::{self, Aftermath, Case, PHASES};
use palpate_emulator::sim::{CONTROL_INSTRUCTIONS, FAULTS, Settings};
use palpate_emulator::{Error, Firmware};
use serde_json::json;

/// Which cases to run.
pub struct Plan {
    /// Every fault at every phase, or those of these names.
    pub matrix: Option<Vec<&'static str>>,
    /// Only every n-th of them.
    pub every: usize,
    /// Number of random pairs.
    pub pairs: usize,
    /// Seed of cases and noise.
    pub seed: u64,
    /// One JSON object a line.
    pub json: bool,
}

/// Sums of a row.
#[derive(Default)]
struct Row {
    runs: u32,
    failed: u32,
    timed: u32,
    worst_us: f64,
    later: u32,
    unseen: u32,
    second_grasps: u32,
    located: u32,
    place_mm: f64,
}

/// Runs the cases; prints failures as they occur.
///
/// # Errors
/// As [`campaign::run`].
pub fn run(firmware: &Firmware, settings: &Settings, plan: &Plan) -> Result<ExitCode, Error> {
    let mut cases = Vec::new();
    if let Some(names) = &plan.matrix {
        let cells = campaign::matrix(plan.seed, names);
        cases.extend(cells.into_iter().step_by(plan.every));
    }
    cases.extend(campaign::pairs(plan.pairs, plan.seed));
    let bar = palpate_cli::progress::bar(cases.len(), "runs");
    let results = campaign::run(firmware, settings, &cases, |case, aftermath| {
        bar.suspend(|| tell(case, aftermath, plan.json));
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    let mut rows: BTreeMap<&str, Row> = BTreeMap::new();
    let (mut failed, mut instructions) = (0, 0);
    for (case, aftermath) in cases.iter().zip(&results) {
        let name = match &case.faults[..] {
            [(fault, _)] => fault.name,
            _ => "pairs",
        };
        let row = rows.entry(name).or_default();
        row.runs += 1;
        row.failed += u32::from(!aftermath.failures.is_empty());
        row.second_grasps += u32::from(aftermath.grasps > 1);
        if let Some((off_mm, _)) = aftermath.place_mm {
            row.located += 1;
            row.place_mm = row.place_mm.max(off_mm);
        }
        match aftermath.off_us {
            Some(us) if aftermath.timed => {
                row.timed += 1;
                row.worst_us = row.worst_us.max(us);
            }
            Some(_) => row.later += 1,
            None => row.unseen += 1,
        }
        failed += u32::from(!aftermath.failures.is_empty());
        instructions = instructions.max(aftermath.instructions);
    }
    if !plan.json {
        table(&rows, &results, failed, instructions);
    }
    Ok(if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn tell(case: &Case, aftermath: &Aftermath, json: bool) {
    if json {
        println!(
            "{}",
            json!({
                "type": "case", "faults": case.name(), "phase": aftermath.phase, "reported": aftermath.reported,
                "off_us": aftermath.off_us, "timed": aftermath.timed, "grasps": aftermath.grasps,
                "instructions": aftermath.instructions, "failures": aftermath.failures,
                "place_off_mm": aftermath.place_mm.map(|(off_mm, _)| off_mm),
                "place_sigma_mm": aftermath.place_mm.map(|(_, sigma_mm)| sigma_mm),
                // Of a run that failed.
                "log": aftermath.log,
            })
        );
    } else if !aftermath.failures.is_empty() {
        println!(
            "FAIL {} in {}: reported {:?}: {}",
            case.name(),
            aftermath.phase,
            aftermath.reported,
            aftermath.failures.join("; ")
        );
        for line in &aftermath.log {
            println!("     {line}");
        }
    }
}

fn table(rows: &BTreeMap<&str, Row>, results: &[Aftermath], failed: u32, instructions: u64) {
    println!(
        "| fault | runs | seen at once | bridge off at worst, us | limit, us | seen later | not seen | second grasp | located | place off at worst, mm | failed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, row) in rows {
        let limit_us = FAULTS.iter().find(|fault| fault.name == *name);
        let limit =
            limit_us.map_or_else(|| "-".to_owned(), |fault| format!("{:.0}", fault.limit_us));
        println!(
            "| `{name}` | {} | {} | {:.0} | {limit} | {} | {} | {} | {} | {:.1} | {} |",
            row.runs,
            row.timed,
            row.worst_us,
            row.later,
            row.unseen,
            row.second_grasps,
            row.located,
            row.place_mm,
            row.failed
        );
    }
    println!(
        "\n{} runs in {} phases, {failed} failed; control interrupt at most {instructions} instructions (limit {CONTROL_INSTRUCTIONS})",
        results.len(),
        PHASES.len()
    );
}
