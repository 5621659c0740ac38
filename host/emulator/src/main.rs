// SPDX-License-Identifier: GPL-2.0-only
//! `palpate-emulator`: runs the firmware image without a board.

mod command;

use std::process::ExitCode;

use clap::Parser;

/// Runs the firmware image on an emulated STM32G431RB against a simulated finger.
#[derive(Parser)]
#[command(name = "palpate-emulator", bin_name = "cargo xtask", version)]
enum Command {
    /// Close the simulated finger on an object and print the log
    #[command(
        after_help = "Examples:\n  cargo xtask sim --contact-mm 45 --world workshop\n  cargo xtask sim --calibrate 20,50 --html grasp.html\n  cargo xtask sim --commands 'trace on;run' --json\n  cargo xtask sim --keep-running --speed 1 --rtt-port 19021 --gdb-port 3333"
    )]
    Sim(Box<command::sim::Options>),
    /// Inject every fault into the running firmware and print what came of it
    #[command(
        after_help = "Examples:\n  cargo xtask faults\n  cargo xtask faults --fault encoder-cut@12"
    )]
    Faults(command::faults::Options),
    /// Run a benchmark image to its end and count instructions
    #[command(
        override_usage = "palpate-emulator bench [OPTIONS]",
        after_help = "Example:\n  palpate-emulator bench --elf IMAGE --watch solve"
    )]
    Bench(command::bench::Options),
    /// Print the completions of a shell
    #[command(hide = true)]
    Completions {
        /// Shell
        shell: palpate_cli::Shell,
    },
}

fn main() -> ExitCode {
    let result = match Command::parse() {
        Command::Sim(options) => command::sim::run(&options),
        Command::Bench(options) => command::bench::run(&options),
        Command::Faults(options) => command::faults::run(&options),
        Command::Completions { shell } => {
            palpate_cli::complete::<Command>(shell);
            Ok(ExitCode::SUCCESS)
        }
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        command::exit_code(&error)
    })
}
