// SPDX-License-Identifier: GPL-2.0-only
//! `bench`: runs a firmware that needs no finger, to its end, and counts instructions.
//!
//! The core's cycle counter counts executed instructions exactly here, so a benchmark that reads it before and after
//! measures instructions on the emulated chip and cycles on a real one.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use palpate_emulator::sim::event_json;
use palpate_emulator::time::{TICKS_PER_MS, ticks};
use palpate_emulator::{Error, Firmware, Machine, Pause, Setup};

/// Options of `bench`.
#[derive(Args)]
pub struct Options {
    /// Firmware image
    #[arg(long)]
    elf: PathBuf,
    /// Counts the calls of every function with this in its name
    #[arg(long, value_name = "NAME")]
    watch: Vec<String>,
    /// One JSON object a line
    #[arg(long)]
    json: bool,
    /// The run ends with the first log line that begins with this, or with a semihosting exit
    #[arg(long, value_name = "TEXT", default_value = "bench done")]
    until: String,
    /// A reset is part of the run
    #[arg(long)]
    resets: bool,
    /// Simulated seconds after which the run is given up
    #[arg(long, value_name = "S", default_value_t = 600.0)]
    max_s: f64,
}

/// Runs it.
pub fn run(options: &Options) -> Result<ExitCode, Error> {
    let firmware = Firmware::load(&options.elf)?;
    let setup = Setup {
        count_instructions: true,
        watch: options.watch.clone(),
        ..Setup::default()
    };
    let mut machine = Machine::new(&firmware, None, &setup)?;
    let end = ticks(options.max_s);
    let mut result = None;
    let progress = palpate_cli::progress::spinner();
    while result.is_none() && machine.now() < end {
        let pause = machine.run_until(machine.now() + TICKS_PER_MS)?;
        if pause != Pause::Time {
            machine.finish();
        }
        progress.set_message(format!("{:.1} s simulated", machine.time_s()));
        for line in machine.take_lines() {
            progress.suspend(|| {
                if options.json {
                    println!("{}", event_json(&line));
                } else {
                    println!("{line}");
                }
            });
            if line.message.starts_with(&options.until) {
                result = Some(ExitCode::SUCCESS);
            }
        }
        for note in machine.take_notes() {
            eprintln!("chip: {note}");
        }
        match pause {
            Pause::Exit(0) => result = Some(ExitCode::SUCCESS),
            Pause::Time => {}
            Pause::Reset(_) if options.resets => {}
            _ => result = Some(ExitCode::FAILURE),
        }
    }
    progress.finish_and_clear();
    super::counts::print(&machine, options.json);
    Ok(result.unwrap_or_else(|| {
        eprintln!(
            "error: '{}' was not logged within {} s",
            options.until, options.max_s
        );
        ExitCode::FAILURE
    }))
}
