//! What `--help` behind a command prints.

use crate::Command;

/// Commands whose program explains its own options.
const PASS_HELP: &[&str] = &[
    "sim",
    "experiments",
    "replay",
    "recordings",
    "false-contacts",
    "monitor",
    "record",
    "figures",
];

/// The program that recomputes the reference files explains its own options too.
const GENERATOR: &str = "--generator";

/// An option or argument, and what it does.
type Row = (&'static str, &'static str);

/// Options of commands that build or run for long before a program could explain them.
const OPTIONS: &[(&str, &[Row])] = &[
    (
        "faults",
        &[
            (
                "--fault NAME[@TIME_S]",
                "only this fault, at this time; may be given several times",
            ),
            (
                "--matrix",
                "every fault at every phase of a grasp, and the grasp after it",
            ),
            ("--every N", "only every Nth cell of the matrix, N from 1"),
            (
                "--pairs N",
                "so many random pairs of faults at random times, and the grasp after each",
            ),
            ("--scene NAME|FILE", "the finger, p70 without it"),
            ("--seed N", "seed of the simulated noise, 1 without it"),
            ("--json", "one JSON object a line"),
        ],
    ),
    (
        "report",
        &[
            ("--json", "one JSON object a line instead of tables"),
            (
                "--check",
                "fail where a chosen method is beaten, or instruction counts have grown",
            ),
            (
                "--record",
                "record this run's instruction counts for the compiler",
            ),
            ("--out DIR", "folder for the plots and the tables"),
            (
                "--write",
                "record the counts, and write plots and tables into docs",
            ),
        ],
    ),
    (
        "golden",
        &[
            ("DIR", "folder of reference files (*.csv)"),
            ("--json", "one JSON object a file instead of tables"),
            (
                "--generator",
                "recompute the files; --generator --help lists its options",
            ),
        ],
    ),
];

/// Whether help is asked for.
pub fn asked(arguments: &[String]) -> bool {
    arguments
        .iter()
        .any(|word| word == "--help" || word == "-h")
}

/// Whether help is asked for that stands here.
pub fn wanted(command: &str, arguments: &[String]) -> bool {
    let passed = arguments.first().is_some_and(|word| word == GENERATOR);
    asked(arguments) && !passed && !PASS_HELP.contains(&command)
}

/// Usage, what the command does, its options, and a call that can be tried.
pub fn text(command: &Command) -> String {
    let mut text = format!(
        "cargo xtask {} {}\n\n{}\n",
        command.name, command.arguments, command.summary
    );
    let of_it = OPTIONS.iter().filter(|(name, _)| *name == command.name);
    for (option, does) in of_it.flat_map(|(_, rows)| *rows) {
        text += &format!("  {option:<22} {does}\n");
    }
    text + &format!("\nExample: {}\n", command.example)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::COMMANDS;
    use crate::process::words;

    #[test]
    fn who_passes_help_on_is_a_command() {
        for name in PASS_HELP {
            let is_it = |command: &Command| command.name == *name;
            assert!(COMMANDS.iter().any(is_it), "{name}");
        }
    }

    /// Before anything is built or run.
    #[test]
    fn what_takes_long_explains_itself_here() {
        for (name, option) in [
            ("report", "--write"),
            ("faults", "--matrix"),
            ("golden", "DIR"),
        ] {
            let found = COMMANDS.iter().find(|command| command.name == name);
            let told = text(found.expect("a command"));
            assert!(wanted(name, &words("--help")) && wanted(name, &words("--json -h")));
            assert!(!wanted(name, &words("--json")));
            assert!(told.contains(&format!("\n  {option}")), "{told}");
            for internal in ["--elf", "--bench", "--counts"] {
                assert!(!told.contains(internal), "{told}");
            }
        }
        assert!(!wanted("golden", &words("--generator --help")));
        assert!(!wanted("sim", &words("--help")));
    }
}
