//! `cargo xtask`: the one entry point to everything that can be built, run, tested or measured here.
//!
//! It stays free of dependencies, so that the first command on a new machine starts within seconds; what needs
//! a crate lives in the program that the command starts.

mod check;
mod commands;
mod completions;
mod firmware;
mod help;
mod host;
mod machine;
mod monitor;
mod mujoco;
mod new_scene;
mod own_finger;
mod own_scene;
mod process;
mod report;
mod target;
mod test;
mod tools;
mod wiring;

use std::process::ExitCode;

/// One command: its name, what follows it, what it does, and a call.
struct Command {
    name: &'static str,
    arguments: &'static str,
    summary: &'static str,
    /// A call that can be tried as it is, where its files are.
    example: &'static str,
    run: fn(&[String]) -> process::Outcome,
}

const COMMANDS: &[Command] = &[
    Command {
        name: "sim",
        arguments: "[OPTIONS]",
        summary: "run the firmware on the emulated chip against a simulated finger (sim --help)",
        example: "cargo xtask sim --scene tendon2 --phalanx 2 --contact-mm 25",
        run: commands::sim,
    },
    Command {
        name: "test",
        arguments: "[--board | --target]",
        summary: "every test that can run here: library, host programs, emulated firmware; --board: the chip's own on a connected \
                  board, --target: the same on the emulated chip",
        example: "cargo xtask test",
        run: test::test,
    },
    Command {
        name: "flash",
        arguments: "[--scene S] [--features F]",
        summary: "build the firmware, flash a connected NUCLEO-G431RB and show its log",
        example: "cargo xtask flash --scene tendon2",
        run: commands::flash,
    },
    Command {
        name: "build",
        arguments: "[--scene S] [--features F]",
        summary: "build the firmware and print the path of its ELF",
        example: "cargo xtask build --scene p70-rigid",
        run: commands::build,
    },
    Command {
        name: "new-scene",
        arguments: "NAME [--from SCENE]",
        summary: "begin the file of a finger of your own, scenes/NAME.toml, as a copy of another (p70)",
        example: "cargo xtask new-scene mine --from tendon2",
        run: commands::new_scene,
    },
    Command {
        name: "size",
        arguments: "",
        summary: "flash and RAM of the firmware, scene by scene",
        example: "cargo xtask size",
        run: commands::size,
    },
    Command {
        name: "golden",
        arguments: "DIR [--json] | --generator [OPTIONS]",
        summary: "the library against a folder of reference files, or those recomputed (--generator --help)",
        example: "cargo xtask golden tests/data/golden",
        run: commands::golden,
    },
    Command {
        name: "faults",
        arguments: "[--matrix] [--pairs N] [--scene S]",
        summary: "inject every fault into the running firmware and time how fast the bridge is off",
        example: "cargo xtask faults --json",
        run: commands::faults,
    },
    Command {
        name: "experiments",
        arguments: "[OPTIONS]",
        summary: "the paper's experiments, ours next to the paper's algorithm (simulated)",
        example: "cargo xtask experiments --quick --only distal",
        run: commands::experiments,
    },
    Command {
        name: "replay",
        arguments: "FILE.csv [OPTIONS]",
        summary: "the sensing on a recorded trace",
        example: "cargo xtask replay recording.csv --scene p70",
        run: commands::replay,
    },
    Command {
        name: "recordings",
        arguments: "DIR [--json] [--uncalibrated] [--only PART] [--scene S] [--scale]",
        summary: "the sensing on a folder of recordings whose truth is known, scored",
        example: "cargo xtask recordings recordings --uncalibrated",
        run: commands::recordings,
    },
    Command {
        name: "false-contacts",
        arguments: "[--scene S] [--world W] [--closings N] [--json]",
        summary: "what each choice of the setting sensitivity costs: false contacts against delay (simulated)",
        example: "cargo xtask false-contacts --world workshop --closings 200",
        run: commands::false_contacts,
    },
    Command {
        name: "monitor",
        arguments: "[--from sim|probe|tcp:HOST:PORT|PORT|FILE] [--scene S] [--world W]",
        summary: "show the finger live in the terminal, with a command line",
        example: "cargo xtask monitor --scene tendon2",
        run: monitor::monitor,
    },
    Command {
        name: "record",
        arguments: "FILE.csv [--from sim|probe|tcp:HOST:PORT|PORT] [--scene S] [--world W]",
        summary: "write the firmware's samples to a file that replay reads",
        example: "cargo xtask record grasp.csv",
        run: monitor::record,
    },
    Command {
        name: "figures",
        arguments: "[DIR]",
        summary: "draw the figures (SVG)",
        example: "cargo xtask figures",
        run: commands::figures,
    },
    Command {
        name: "wiring",
        arguments: "",
        summary: "check the wiring tables of docs/HARDWARE.md and draw them (SVG)",
        example: "cargo xtask wiring",
        run: wiring::wiring,
    },
    Command {
        name: "report",
        arguments: "[--json] [--check] [--record] [--out DIR] [--write]",
        summary: "speed against error of every candidate method, on the emulated core",
        example: "cargo xtask report --check",
        run: report::report,
    },
    Command {
        name: "check",
        arguments: "",
        summary: "formatting, lints (fuzz targets too), documentation, a new user's finger, size, no panic in the control interrupt",
        example: "cargo xtask check",
        run: check::check,
    },
    Command {
        name: "completions",
        arguments: "bash|zsh|fish|elvish|powershell",
        summary: "print completions for a shell: bash completes cargo xtask itself, others the programs in target/host",
        example: "source <(cargo xtask completions bash)",
        run: completions,
    },
    Command {
        name: "setup",
        arguments: "",
        summary: "look for what this machine lacks, and get it",
        example: "cargo xtask setup",
        run: commands::setup,
    },
];

fn completions(arguments: &[String]) -> process::Outcome {
    let names: Vec<&str> = COMMANDS.iter().map(|command| command.name).collect();
    completions::print(&names, arguments)
}

fn usage() {
    println!("cargo xtask COMMAND\n");
    for command in COMMANDS {
        let call = format!("{} {}", command.name, command.arguments);
        println!("  {call}\n      {}", command.summary);
    }
    println!("\n`cargo xtask COMMAND --help` shows an example of each.");
    println!("On a machine with a board, `cargo run --release` is `cargo xtask flash`.");
}

/// Exit status of a call that cannot be understood.
const WRONG_CALL: u8 = 2;

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
        return ExitCode::from(WRONG_CALL);
    };
    if help::wanted(command.name, rest) {
        print!("{}", help::text(command));
        return ExitCode::SUCCESS;
    }
    match own_scene::adopt(rest).and_then(|rest| (command.run)(&rest)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.message.is_empty() {
                eprintln!("xtask {name}: {}", failure.message);
                if failure.code == WRONG_CALL {
                    eprintln!("`cargo xtask {name} --help` shows what it takes");
                }
            }
            ExitCode::from(failure.code)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_an_example_of_itself() {
        for command in COMMANDS {
            let call = format!("cargo xtask {}", command.name);
            let (before, after) = command.example.split_once(&call).expect(command.name);
            assert!(["", "source <("].contains(&before), "{}", command.example);
            assert!(["", " "].contains(&after.get(..1).unwrap_or_default()));
        }
    }

    /// Bash loads a file of its folder of completions for a program of that name alone: the call of the manual works, a file does not.
    #[test]
    fn completions_are_used_as_the_manual_says() {
        let manual = process::root().join("docs/MANUAL.md");
        let manual = std::fs::read_to_string(manual).expect("the manual");
        let is_it = |command: &&Command| command.name == "completions";
        let example = COMMANDS.iter().find(is_it).expect("a command").example;
        assert!(manual.contains(&format!("`{example}`")), "{example}");
    }
}
