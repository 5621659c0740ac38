// SPDX-License-Identifier: GPL-2.0-only
//! `faults`: injects every fault into the running firmware and prints a table.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use palpate_cli::progress::{self, ProgressBar};
use palpate_emulator::cortex::account::Calls;
use palpate_emulator::firmware::default_path;
use palpate_emulator::sim::{
    CONTROL_INSTRUCTIONS, FAULTS, Injected, Judgement, Object, Settings, judge,
};
use palpate_emulator::{Error, Firmware};
use palpate_plant::Parameters;
use serde_json::json;

/// Options of `faults`.
#[derive(Args)]
pub struct Options {
    /// Firmware image, built with the feature `fault-injection`
    #[arg(long, hide = true, default_value_os_t = default_path())]
    elf: PathBuf,
    /// Only this one: NAME or NAME@SECONDS
    #[arg(long, value_name = "NAME[@TIME_S]")]
    fault: Vec<Injected>,
    /// Inject every fault at every phase of a grasp, and judge the grasp after it
    #[arg(long)]
    matrix: bool,
    /// Judge only every Nth cell of the matrix, N from 1
    #[arg(long, value_name = "N", default_value_t = 1, requires = "matrix", value_parser = palpate_cli::at_least_one, allow_negative_numbers = true)]
    every: usize,
    /// Number of random pairs of faults to inject at random times; the grasp after each is judged
    #[arg(long, default_value_t = 0)]
    pairs: usize,
    /// The finger, as the image has it
    #[arg(long, default_value_t = palpate_plant::default_scene().to_owned())]
    scene: String,
    /// Seed of the simulated noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
}

/// A run with or without a fault, with its result.
type Row = (Option<Injected>, Result<Judgement, Error>);

/// Runs them all.
pub fn run(options: &Options) -> Result<ExitCode, Error> {
    let firmware = Firmware::load(&options.elf)?;
    let settings = Settings {
        parameters: Parameters::of(&options.scene)?,
        object: Some(Object::default()),
        seed: options.seed,
        max_s: 60.0,
        ..Settings::default()
    };
    if options.matrix || options.pairs > 0 {
        let plan = super::campaign::Plan {
            matrix: options.matrix.then(|| {
                options
                    .fault
                    .iter()
                    .map(|injected| injected.fault.name)
                    .collect()
            }),
            every: options.every,
            pairs: options.pairs,
            seed: options.seed,
            json: options.json,
        };
        return super::campaign::run(&firmware, &settings, &plan);
    }
    let every = || {
        FAULTS.iter().map(|fault| Injected {
            fault,
            at_s: fault.at_s,
        })
    };
    let wanted: Vec<Injected> = if options.fault.is_empty() {
        every().collect()
    } else {
        options.fault.clone()
    };
    // The healthy run with the same seed comes first.
    let runs: Vec<Option<Injected>> = std::iter::once(None)
        .chain(wanted.into_iter().map(Some))
        .collect();
    if !options.json {
        println!(
            "{:<16} {:<18} {:>10} {:>10}  {:<4} detected by",
            "fault", "reported", "off_us", "limit_us", ""
        );
    }
    let all_passed = parallel(&firmware, &settings, options.json, &runs);
    Ok(if all_passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Runs on all cores, prints in order. True if all passed.
fn parallel(
    firmware: &Firmware,
    settings: &Settings,
    json: bool,
    runs: &[Option<Injected>],
) -> bool {
    let next = AtomicUsize::new(0);
    let printer = Mutex::new(Printer {
        json,
        rows: runs.iter().map(|_| None).collect(),
        next: 0,
        passed: true,
        control: Calls::default(),
        progress: progress::bar(runs.len(), "runs"),
    });
    let workers = std::thread::available_parallelism()
        .map_or(1, usize::from)
        .min(runs.len());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&injected) = runs.get(index) else {
                        break;
                    };
                    let outcome = judge(firmware, settings.clone(), injected);
                    if let Ok(mut printer) = printer.lock() {
                        printer.take(index, (injected, outcome));
                    }
                }
            });
        }
    });
    printer.into_inner().is_ok_and(|printer| {
        printer.progress.finish_and_clear();
        printer.print_control();
        printer.passed && printer.next == runs.len()
    })
}

struct Printer {
    json: bool,
    rows: Vec<Option<Row>>,
    next: usize,
    passed: bool,
    /// The longest control interrupt of all runs.
    control: Calls,
    progress: ProgressBar,
}

/// Cycles of one control period, 50 us at 170 MHz.
const PERIOD_CYCLES: f64 = 8500.0;

impl Printer {
    /// Worst case of the control interrupt over all runs.
    fn print_control(&self) {
        let worst = self.control.max;
        let share = |cycles: u64| 100.0 * cycles as f64 / PERIOD_CYCLES;
        let (low, high) = (share(worst.cycles_low), share(worst.cycles_high));
        if self.json {
            println!(
                "{}",
                json!({
                    "type": "control", "instructions_max": worst.instructions,
                    "instructions_limit": CONTROL_INSTRUCTIONS, "cycles_low": worst.cycles_low,
                    "cycles_high": worst.cycles_high, "period_percent_low": low, "period_percent_high": high,
                })
            );
        } else {
            println!(
                "\ncontrol interrupt: at most {} instructions (limit {CONTROL_INSTRUCTIONS}), {} to {} cycles, {low:.0} to {high:.0} % of its period",
                worst.instructions, worst.cycles_low, worst.cycles_high
            );
        }
    }

    fn take(&mut self, index: usize, row: Row) {
        self.rows[index] = Some(row);
        self.progress.inc(1);
        while let Some(row) = self.rows.get_mut(self.next).and_then(Option::take) {
            self.next += 1;
            self.progress.clone().suspend(|| self.print(&row));
        }
    }

    fn print(&mut self, (injected, outcome): &Row) {
        let name = injected.map_or("healthy", |i| i.fault.name);
        let detected_by = injected.map_or("nothing", |i| i.fault.detected_by);
        let limit_us = injected
            .map(|i| i.fault.limit_us)
            .filter(|&limit| limit > 0.0);
        let (off_us, reported, failures) = match outcome {
            Ok(verdict) => (
                verdict.off_us,
                verdict.reported.join(" "),
                verdict.failures.clone(),
            ),
            Err(error) => (None, String::new(), vec![error.to_string()]),
        };
        if let Ok(verdict) = outcome
            && verdict.control.max.instructions > self.control.max.instructions
        {
            self.control = verdict.control;
        }
        let pass = failures.is_empty();
        self.passed &= pass;
        if self.json {
            let reported = (!reported.is_empty()).then_some(&reported);
            println!(
                "{}",
                json!({
                    "type": "fault", "name": name, "detected_by": detected_by, "off_us": off_us,
                    "limit_us": limit_us, "reported": reported, "pass": pass, "failures": failures,
                })
            );
            return;
        }
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.1}"));
        let mark = if pass { "ok" } else { "FAIL" };
        println!(
            "{name:<16} {reported:<18} {:>10} {:>10}  {mark:<4} {detected_by}",
            number(off_us),
            number(limit_us)
        );
        for failure in failures {
            println!("{:16} {failure}", "");
        }
    }
}
