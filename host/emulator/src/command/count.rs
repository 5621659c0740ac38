// SPDX-License-Identifier: GPL-2.0-only
//! `count`: runs an image to its own end and says what each of its functions cost.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use palpate_emulator::cortex::account::{Calls, Cost};
use palpate_emulator::time::TICKS_PER_MS;
use palpate_emulator::{Error, Firmware, Machine, Pause, Setup};
use serde_json::{Value, json};

/// Options of `count`.
#[derive(Args)]
pub struct Options {
    /// Image that ends itself by a semihosting exit
    #[arg(long)]
    elf: PathBuf,
    /// Part of the names of the functions whose calls are counted
    #[arg(long, value_name = "PART")]
    watch: Vec<String>,
    /// Simulated seconds after which the run is given up
    #[arg(long, value_name = "S", default_value_t = 60)]
    max_s: u64,
}

fn cost(cost: Cost) -> Value {
    json!({
        "instructions": cost.instructions, "cycles_low": cost.cycles_low, "cycles_high": cost.cycles_high,
    })
}

fn calls(name: &str, address: Option<u32>, calls: &Calls) -> Value {
    json!({
        "type": "calls", "function": name, "address": address, "calls": calls.count,
        "total": cost(calls.total), "max": cost(calls.max),
    })
}

/// Prints what watched functions and exception handlers cost, one JSON object a line, and the run as a whole.
pub fn books(firmware: &Firmware, watch: &[String], machine: &Machine<'_>) {
    let account = machine.account();
    // Watches are numbered in this order.
    let watched = watch.iter().flat_map(|part| firmware.functions(part));
    for (function, (name, counted)) in watched.zip(account.functions()) {
        if counted.count > 0 {
            println!("{}", calls(name, Some(function.address), counted));
        }
    }
    for (number, counted) in account.exceptions() {
        println!("{}", calls(&format!("exception {number}"), None, counted));
    }
    println!(
        "{}",
        json!({
            "type": "run", "emulated_s": machine.time_s(), "total": cost(account.total()),
            "stack_bytes": machine.stack_used(),
        })
    );
}

/// Runs it; prints JSON objects, one a line: log lines, then the counted functions.
pub fn run(options: &Options) -> Result<ExitCode, Error> {
    let firmware = Firmware::load(&options.elf)?;
    let setup = Setup {
        count_instructions: true,
        watch: options.watch.clone(),
        ..Setup::default()
    };
    let mut machine = Machine::new(&firmware, None, &setup)?;
    let code = loop {
        let until = machine.now() + 10 * TICKS_PER_MS;
        let pause = machine.run_until(until)?;
        if let Pause::Exit(_) = pause {
            machine.finish();
        }
        for line in machine.take_lines() {
            println!("{}", json!({ "type": "line", "text": line.message }));
        }
        match pause {
            Pause::Exit(code) => break Some(code),
            Pause::Time if machine.time_s() < options.max_s as f64 => {}
            _ => break None,
        }
    };
    books(&firmware, &options.watch, &machine);
    if code.is_none() {
        eprintln!(
            "error: the image did not end itself within {} s, at {}",
            options.max_s,
            machine.position()
        );
    }
    Ok(if code == Some(0) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
