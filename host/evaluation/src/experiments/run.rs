//! Runs jobs on all processors, with a progress bar, and puts their entries together.

use std::collections::BTreeMap;

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::catalogue::{Entry, Job};
use super::live::Failure;
use super::result::{Method, Row, Trial, summarise};

/// A bar that counts to `total`; silent where standard error is no terminal.
#[must_use]
pub fn bar(total: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(total as u64);
    let style =
        ProgressStyle::with_template(&format!("{{bar:30}} {{pos}}/{{len}} {what}, {{eta}} left"));
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

/// Work that could not be done, or not to its end.
#[derive(Debug)]
pub struct Incomplete {
    /// Which job.
    pub name: String,
    /// Why.
    pub failure: Failure,
}

/// Does all jobs; the order of the entries does not depend on the number of workers. What failed is told beside them.
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

/// One row for each experiment, method and calibration, in the order of their first entries.
#[must_use]
pub fn rows(entries: &[Entry]) -> Vec<Row> {
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
        for (method, calibrated) in [
            (Method::Ours, true),
            (Method::Ours, false),
            (Method::Paper, true),
            (Method::Paper, false),
        ] {
            if let Some(trials) = groups.get(&(experiment, method, calibrated)) {
                rows.push(summarise(experiment, method, calibrated, trials));
            }
        }
    }
    rows
}
