//! Runs jobs on all processors, with a progress bar, and puts their entries together.

use std::collections::BTreeMap;

use palpate_cli::progress::bar;
use rayon::prelude::*;

use super::job::{Entry, Job};
use super::live::Failure;
use super::result::{Method, Place, Row};
use crate::paper::STEPS_NM;
use crate::score::Trial;

/// Work that could not be done, or not to its end.
#[derive(Debug)]
pub struct Incomplete {
    /// Which job.
    pub name: String,
    /// Why.
    pub failure: Failure,
}

/// Does all jobs; the order of the entries does not depend on the number of workers. Failures are reported next to them.
#[must_use]
pub fn jobs(jobs: &[Job]) -> (Vec<Entry>, Vec<Incomplete>) {
    let bar = bar(
        jobs.iter().map(|job| job.closings).sum(),
        "simulated closings",
    );
    let found: Vec<(Vec<Entry>, Option<Incomplete>)> = jobs
        .par_iter()
        .map(|job| {
            let mut entries = Vec::new();
            let failed = (job.run)(&mut entries).err().map(|failure| Incomplete {
                name: job.name.clone(),
                failure,
            });
            bar.inc(job.closings as u64);
            (entries, failed)
        })
        .collect();
    bar.finish_and_clear();
    let (entries, failed): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    (
        entries.into_iter().flatten().collect(),
        failed.into_iter().flatten().collect(),
    )
}

/// One row for each experiment, method and calibration, in the order of their first entries; of the paper's steps the
/// best.
#[must_use]
pub fn rows(place: &Place, entries: &[Entry]) -> Vec<Row> {
    let mut order: Vec<&str> = Vec::new();
    let mut groups: BTreeMap<(&str, Method, bool), Vec<Trial>> = BTreeMap::new();
    for entry in entries {
        if !order.contains(&entry.experiment.as_str()) {
            order.push(&entry.experiment);
        }
        groups
            .entry((&entry.experiment, entry.method, entry.calibrated))
            .or_default()
            .push(entry.trial);
    }
    let mut rows = Vec::new();
    for experiment in order {
        let row = |method: Method, calibrated: bool| {
            let trials = groups.get(&(experiment, method, calibrated))?;
            Some(Row::of(place, experiment, method, calibrated, trials))
        };
        let both = [true, false];
        rows.extend(
            both.into_iter()
                .filter_map(|calibrated| row(Method::Ours, calibrated)),
        );
        rows.extend(both.into_iter().filter_map(|calibrated| {
            let steps = 0..STEPS_NM.len();
            Row::best(
                steps
                    .filter_map(|step| row(Method::Paper(step), calibrated))
                    .collect(),
            )
        }));
        let two = both.into_iter();
        rows.extend(two.filter_map(|calibrated| row(Method::PaperTwoLevels, calibrated)));
    }
    rows
}
