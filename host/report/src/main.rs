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
    #[command(after_help = "Example:\n  cargo xtask golden tests/data/golden --json")]
    Golden(golden::Arguments),
    /// Speed against error of every candidate method.
    #[command(after_help = "Examples:\n  cargo xtask report\n  cargo xtask report --check")]
    Report(report::Arguments),
    /// Flash and RAM of firmware images, and what they must not carry.
    #[command(after_help = "Example:\n  cargo xtask size")]
    Size(size::Arguments),
    /// What a run of the target's tests printed, on a board or on the emulated chip.
    #[command(after_help = "Example:\n  cargo xtask test --target")]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_examples_in_its_help() {
        assert_eq!(palpate_cli::without_example::<Arguments>(), [""; 0]);
    }
}
