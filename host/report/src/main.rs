//! `palpate-report`: what `cargo xtask golden`, `size` and `report` run.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use palpate_report::{golden, report, size, target};

#[derive(Parser)]
#[command(about = "Reference data, speed against error, what an ELF weighs")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The library against a folder of reference files.
    Golden(golden::Arguments),
    /// Speed against error of every candidate method.
    Report(report::Arguments),
    /// Flash and RAM of firmware images, and what they must not carry.
    Size(size::Arguments),
    /// What a run of the target's tests printed, on a board or on the emulated chip.
    Target(target::Arguments),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Golden(arguments) => golden::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Size(arguments) => size::run(&arguments),
        Command::Target(arguments) => target::run(&arguments),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("palpate-report: {error:#}");
            ExitCode::from(2)
        }
    }
}
