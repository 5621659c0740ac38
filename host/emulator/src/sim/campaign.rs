// SPDX-License-Identifier: GPL-2.0-only
//! Faults at every phase of a grasp, one or two at a time: which cases there are, and all of them run on all cores.

mod aftermath;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use aftermath::Aftermath;

use super::fault::{FAULTS, Fault};
use super::script::Script;
use super::session::{Settings, end_of};
use crate::{Error, Firmware};

/// Phases of a grasp, as the log names them, in their order.
pub const PHASES: &[&str] = &[
    "calibrate-offset",
    "home",
    "record-closing",
    "record-opening",
    "close",
    "probe",
    "hold",
    "open",
];

/// When a fault comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// So many milliseconds after this phase was reported.
    Phase(&'static str, u32),
    /// At this time, second.
    At(f64),
}

/// Faults of one run.
#[derive(Clone, Debug)]
pub struct Case {
    /// Each with its moment.
    pub faults: Vec<(&'static Fault, When)>,
    /// Seed of the simulated noise.
    pub seed: u64,
}

impl Case {
    /// For messages.
    #[must_use]
    pub fn name(&self) -> String {
        let one = |(fault, when): &(&Fault, When)| match when {
            When::Phase(phase, ms) => format!("{}@{phase}+{ms}ms", fault.name),
            When::At(s) => format!("{}@{s:.3}s", fault.name),
        };
        self.faults.iter().map(one).collect::<Vec<_>>().join(" ")
    }

    /// Friction is recorded in this run, not before it.
    fn records(&self) -> bool {
        let recording =
            |when: &When| matches!(when, When::Phase(phase, _) if phase.starts_with("record"));
        self.faults.iter().any(|(_, when)| recording(when))
    }
}

/// Every fault at every phase, or those of these names.
#[must_use]
pub fn matrix(seed: u64, names: &[&str]) -> Vec<Case> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let cells = FAULTS
        .iter()
        .flat_map(|fault| PHASES.iter().map(move |phase| (fault, *phase)));
    cells
        .map(|(fault, phase)| Case {
            faults: vec![(fault, When::Phase(phase, random.random_range(10..160)))],
            seed,
        })
        .filter(|case| names.is_empty() || names.contains(&case.faults[0].0.name))
        .collect()
}

/// Pairs of different faults at random times of a grasp of 9 s.
#[must_use]
pub fn pairs(count: usize, seed: u64) -> Vec<Case> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    // A log that nobody reads is no second fault: it hides the first one's name.
    let faults: Vec<&'static Fault> = FAULTS.iter().filter(|f| !f.reported.is_empty()).collect();
    let when = |random: &mut Pcg64Mcg| When::At(random.random_range(0.15..9.15));
    (0..count)
        .map(|_| {
            let first = random.random_range(0..faults.len());
            let second = (first + random.random_range(1..faults.len())) % faults.len();
            Case {
                faults: vec![
                    (faults[first], when(&mut random)),
                    (faults[second], when(&mut random)),
                ],
                seed: seed + random.random_range(0..1000),
            }
        })
        .collect()
}

/// Flash of a finger that has recorded its friction and kept it, so that a run grasps at once.
///
/// # Errors
/// As [`end_of`].
pub fn prepared(firmware: &Firmware, settings: &Settings) -> Result<Vec<u8>, Error> {
    let settings = Settings {
        object: None,
        script: Script::parse("record-friction; save"),
        ..settings.clone()
    };
    Ok(end_of(firmware, settings)?.machine.flash().to_vec())
}

/// Runs cases on all cores; `told` hears of each as it ends, in any order. A run that the emulator ends, because the firmware
/// misuses the chip, is one that failed.
///
/// # Errors
/// As [`prepared`].
pub fn run(
    firmware: &Firmware,
    settings: &Settings,
    cases: &[Case],
    told: impl Fn(&Case, &Aftermath) + Sync,
) -> Result<Vec<Aftermath>, Error> {
    let flash = prepared(firmware, settings)?;
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Aftermath>> = Mutex::new(vec![Aftermath::default(); cases.len()]);
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers.min(cases.len()) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else {
                        break;
                    };
                    let mut aftermath = Aftermath::default();
                    if let Err(error) = aftermath.follow(firmware, settings, &flash, case) {
                        aftermath.failures.push(error.to_string());
                    }
                    told(case, &aftermath);
                    if let Ok(mut results) = results.lock() {
                        results[index] = aftermath;
                    }
                }
            });
        }
    });
    Ok(results.into_inner().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_has_every_cell_and_pairs_are_of_two() {
        assert_eq!(matrix(1, &[]).len(), FAULTS.len() * PHASES.len());
        let names = |seed| pairs(50, seed).iter().map(Case::name).collect::<Vec<_>>();
        assert_eq!(names(3), names(3));
        assert_ne!(names(3), names(4));
        for case in pairs(500, 1) {
            assert_ne!(case.faults[0].0.name, case.faults[1].0.name);
        }
    }
}
