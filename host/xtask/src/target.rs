//! Tests of the chip itself, the same image on a connected board and on the emulated chip.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::Build;
use crate::host;
use crate::machine;
use crate::process::{Failure, Outcome, output, run, step, target_dir};

/// How probe-rs runs an image, as the runner in .cargo/config.toml does: the firmware handles resets and hard faults itself, bridge off first.
pub const RUN: [&str; 5] = [
    "run",
    "--chip",
    "STM32G431RBTx",
    "--no-catch-reset",
    "--no-catch-hardfault",
];

/// Names the probe that probe-rs uses where several are connected.
const CHOSEN: &str = "PROBE_RS_PROBE";

/// The image of the tests.
pub fn image() -> Outcome<PathBuf> {
    let build = Build {
        package: Some("palpate-bench"),
        features: Some("target-tests".to_owned()),
        ..Build::default()
    };
    build.elf()
}

/// Builds the tests, runs them on a board (or else on the emulated chip), and judges what they printed.
pub fn test(board: bool) -> Outcome {
    if board {
        probe()?;
    }
    let elf = image()?;
    let (mut command, what) = if board {
        let mut command = Command::new("probe-rs");
        // Its questions would go into the file: let it fail instead.
        command
            .args(RUN)
            .arg(&elf)
            .env("PROBE_RS_NON_INTERACTIVE", "1");
        (command, "tests on the connected board")
    } else {
        let mut command = host::emulator("bench", &elf, &[])?;
        command.args(["--until", "target done", "--max-s", "60", "--resets"]);
        (command, "tests of the target on the emulated chip")
    };
    let log = keep(&mut command, what)?;
    let words = ["target".to_owned(), log.display().to_string()];
    run(host::program("palpate-report", &words)?.args(words))
}

/// Runs the tests; what they printed.
fn keep(command: &mut Command, what: &str) -> Outcome<PathBuf> {
    let path = target_dir().join("target-tests.log");
    let cannot = |error| Failure::new(format!("cannot write {}: {error}", path.display()));
    command.stdout(File::create(&path).map_err(cannot)?);
    // A run that failed has lines that say where.
    if let Err(failure) = step(what, command) {
        print(&path);
        return Err(failure);
    }
    Ok(path)
}

fn print(path: &Path) {
    if let Ok(log) = std::fs::read_to_string(path) {
        eprint!("{log}");
    }
}

/// A debug probe is connected.
fn probe() -> Outcome {
    if machine::find("probe-rs").is_none() {
        return Err(Failure::new(
            "probe-rs is not installed: cargo install probe-rs-tools --locked",
        ));
    }
    let listed = output("probe-rs", &["list"]).unwrap_or_default();
    match connected(&listed) {
        0 => Err(Failure::new(
            "no debug probe is connected: connect the NUCLEO-G431RB's ST-LINK by USB; `probe-rs list` must show it",
        )),
        // probe-rs would have to ask which one.
        2.. if std::env::var_os(CHOSEN).is_none() => Err(Failure::new(format!(
            "several debug probes are connected: unplug the others, or set {CHOSEN} to VID:PID:SERIAL of one of these\n{listed}"
        ))),
        _ => Ok(()),
    }
}

/// How many probes `probe-rs list` shows: one a line, with a number in brackets.
fn connected(listed: &str) -> usize {
    let numbered = |line: &str| {
        let number = line.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        number.is_some_and(|(number, _)| number.parse::<u32>().is_ok())
    };
    listed.lines().filter(|line| numbered(line)).count()
}

#[cfg(test)]
mod tests {
    use super::{RUN, connected};
    use crate::process::root;

    #[test]
    fn cargo_run_and_xtask_run_an_image_alike() {
        let config = std::fs::read_to_string(root().join(".cargo/config.toml")).expect("a file");
        let runner = format!("runner = \"probe-rs {}\"", RUN.join(" "));
        assert!(config.lines().any(|line| line == runner), "{runner}");
    }

    #[test]
    fn a_probe_is_a_line_with_a_number() {
        assert_eq!(connected(""), 0);
        assert_eq!(connected("No debug probes were found.\n"), 0);
        let one =
            "The following debug probes were found:\n[0]: STLink V3 -- 0483:374e:0031 (ST-LINK)\n";
        assert_eq!(connected(one), 1);
        let two = format!("{one}[1]: CMSIS-DAP -- 0d28:0204:07 (CMSIS-DAP)\n");
        assert_eq!(connected(&two), 2);
    }
}
