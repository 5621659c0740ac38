// SPDX-License-Identifier: GPL-2.0-only
//! `palpate-emulator`: runs the firmware image without a board.

mod command;

use std::process::ExitCode;

use clap::Parser;

/// Runs the firmware image on an emulated STM32G431RB against a simulated finger.
#[derive(Parser)]
#[command(name = "palpate-emulator", version)]
enum Command {
    /// Close the simulated finger on an object and print the log
    Sim(Box<command::sim::Options>),
    /// Inject every fault into the running firmware and print what came of it
    Faults(command::faults::Options),
    /// Run a benchmark image to its end and count instructions
    Bench(command::bench::Options),
}

fn main() -> ExitCode {
    let result = match Command::parse() {
        Command::Sim(options) => command::sim::run(&options),
        Command::Bench(options) => command::bench::run(&options),
        Command::Faults(options) => command::faults::run(&options),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        command::exit_code(&error)
    })
}
