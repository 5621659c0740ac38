//! `cargo xtask`: the one entry point to everything that can be built, run, tested or measured here.
//!
//! It stays free of dependencies, so that the first command on a new machine starts within seconds; what needs
//! a crate lives in the program that the command starts.

mod commands;
mod emulator;
mod firmware;
mod machine;
mod mujoco;
mod process;
mod report;

use std::process::ExitCode;

/// One command: its name, what follows it, and what it does.
struct Command {
    name: &'static str,
    arguments: &'static str,
    summary: &'static str,
    run: fn(&[String]) -> process::Outcome,
}

const COMMANDS: &[Command] = &[
    Command {
        name: "sim",
        arguments: "[OPTIONS]",
        summary: "run the firmware on the emulated chip against a simulated finger (sim --help)",
        run: commands::sim,
    },
    Command {
        name: "test",
        arguments: "",
        summary: "every test that can run here: library, host programs, emulated firmware",
        run: commands::test,
    },
    Command {
        name: "flash",
        arguments: "[--scene S]",
        summary: "build the firmware, flash a connected NUCLEO-G431RB and show its log",
        run: commands::flash,
    },
    Command {
        name: "build",
        arguments: "[--scene S] [--features F]",
        summary: "build the firmware and print the path of its ELF",
        run: commands::build,
    },
    Command {
        name: "size",
        arguments: "",
        summary: "flash and RAM of the firmware, scene by scene",
        run: commands::size,
    },
    Command {
        name: "golden",
        arguments: "DIR [--json] | --generator [OPTIONS]",
        summary: "the library against a folder of reference files, or those recomputed (--generator --help)",
        run: commands::golden,
    },
    Command {
        name: "faults",
        arguments: "[--json]",
        summary: "inject every fault into the running firmware and time how fast the bridge is off",
        run: commands::faults,
    },
    Command {
        name: "experiments",
        arguments: "[OPTIONS]",
        summary: "the paper's experiments, ours beside the paper's algorithm (simulated)",
        run: commands::experiments,
    },
    Command {
        name: "replay",
        arguments: "FILE.csv [OPTIONS]",
        summary: "the sensing on a recorded trace",
        run: commands::replay,
    },
    Command {
        name: "recordings",
        arguments: "DIR [--json] [--uncalibrated] [--only PART]",
        summary: "the sensing on a folder of recordings whose truth is known, scored",
        run: commands::recordings,
    },
    Command {
        name: "figures",
        arguments: "[DIR]",
        summary: "draw the figures (SVG)",
        run: commands::figures,
    },
    Command {
        name: "report",
        arguments: "[--json] [--check] [--record] [--out DIR] [--write]",
        summary: "speed against error of every candidate method, on the emulated core",
        run: report::report,
    },
    Command {
        name: "check",
        arguments: "",
        summary: "formatting, lints on host and target, documentation, size, no panic in the control interrupt",
        run: commands::check,
    },
    Command {
        name: "setup",
        arguments: "",
        summary: "look for what this machine lacks, and get it",
        run: commands::setup,
    },
];

fn usage() {
    println!("cargo xtask COMMAND\n");
    for command in COMMANDS {
        let call = format!("{} {}", command.name, command.arguments);
        println!("  {call:<34} {}", command.summary);
    }
    println!("\nOn a machine with a board, `cargo run --release` is `cargo xtask flash`.");
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some((name, rest)) = arguments.split_first() else {
        usage();
        return ExitCode::SUCCESS;
    };
    if matches!(name.as_str(), "help" | "--help" | "-h") {
        usage();
        return ExitCode::SUCCESS;
    }
    let Some(command) = COMMANDS.iter().find(|command| command.name == name) else {
        eprintln!("xtask: there is no command '{name}'; `cargo xtask` lists them");
        return ExitCode::from(2);
    };
    match (command.run)(rest) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.message.is_empty() {
                eprintln!("xtask {name}: {}", failure.message);
            }
            ExitCode::from(failure.code)
        }
    }
}
