//! The short tables of docs/RESULTS.md, written between two markers.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use palpate_document::section::Markers;
use palpate_document::table::head;

use super::row::Row;
use super::target::{self, Target};
use super::whole::{CONTROL, Grasp, TYPICAL, WITH_FIT};
use super::{delay, delay_table};

/// Where the tables stand.
const SECTION: Markers = Markers {
    begin: "<!-- report: begin, written by `cargo xtask report --write` -->",
    end: "<!-- report: end -->",
};

/// What a reader compares: its words, task and candidate.
const COMPARED: &[(&str, &str, &str)] = &[
    ("closed form", "k2_2p", "library_closed"),
    ("bisection", "k2_2p", "library_bisection"),
    (
        "finite step of torque",
        "k2_2p_step",
        "finite_step_one_unknown",
    ),
    (
        "nalgebra and a published root finder, f32",
        "k2_2p",
        "nalgebra_numeris_f32_libm",
    ),
    ("the same in f64", "k2_2p", "nalgebra_numeris_f64_libm"),
];

/// The block between the markers.
pub fn block(
    compiler: &str,
    rows: &[Row],
    grasp: Option<&Grasp>,
    delays: &[delay::Row],
    targets: &[Target],
) -> String {
    let mut text = format!(
        "Executed instructions on the emulated core, exact ({compiler}, not silicon), against the error over the reference \
         rows:\n\n{}",
        head(
            "place of a contact, two phalanges | instructions, mean / max | 99 % error, % of the phalanx | not found"
        )
    );
    for (words, task, name) in COMPARED {
        let Some((row, chip)) = rows
            .iter()
            .find(|row| row.task == *task && row.name == *name)
            .and_then(|row| Some((row, row.on_chip?)))
        else {
            continue;
        };
        let _ = writeln!(
            text,
            "| {words} | {:.0} / {} | {:.1e} | {} |",
            chip.cost.instructions_mean,
            chip.cost.instructions_max,
            row.error.error_p99,
            row.error.nonfinite
        );
    }
    if let Some(grasp) = grasp {
        text.push('\n');
        for what in [CONTROL, TYPICAL, WITH_FIT] {
            if let Some(figure) = grasp.of(what) {
                let _ = writeln!(
                    text,
                    "- {what}: {:.0} instructions, {} at most; {} calls in a grasp",
                    figure.part.instructions_mean, figure.part.instructions_max, figure.part.calls
                );
            }
        }
    }
    if !delays.is_empty() {
        text += "\nThe user's trade, simulated, medians over calibrated fingers and many objects, from the true first contact:\n\n";
        text += &delay_table::short_table(delays);
        text += "\n![Error against delay](report/delay.svg)\n";
    }
    text + "\n" + &target::table(targets)
}

/// Puts a block between the markers of a file.
pub fn write(path: &Path, block: &str) -> Result<()> {
    SECTION
        .write(path, "", block)
        .with_context(|| format!("cannot write {}", path.display()))
}
