//! `report`: speed against error of every candidate method, on the emulated core.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::commands::take;
use crate::firmware::{Build, every_scene};
use crate::host;
use crate::machine::{self, Toolchain};
use crate::monitor;
use crate::process::{Failure, Outcome, output, root, step, target_dir};

/// The page, its plots and records.
const FOLDER: &str = "docs/report";
/// Instruction counts that `--check` compares with.
const RECORDED: &str = "docs/report/instructions.json";

/// Words of the call that take no value.
const FLAGS: [&str; 4] = ["--json", "--check", "--record", "--write"];

/// Refuses a wrong call before anything is built, and a folder that cannot be written; one that is missing is made.
fn check(arguments: &[String]) -> Outcome {
    let mut rest = arguments.to_vec();
    let folder = take(&mut rest, "--out")?;
    for (at, word) in rest.iter().enumerate() {
        if !FLAGS.contains(&word.as_str()) {
            return Err(Failure::usage(format!(
                "unexpected '{word}'; there are {} and, once, --out DIR",
                FLAGS.join(", ")
            )));
        }
        if rest[..at].contains(word) {
            return Err(Failure::usage(format!("{word} is given twice")));
        }
    }
    let Some(folder) = folder else {
        return Ok(());
    };
    if rest.iter().any(|word| word == "--write") {
        return Err(Failure::usage(format!(
            "--write has a folder of its own, {FOLDER}: leave --out {folder} or --write out"
        )));
    }
    if folder.is_empty() || folder.starts_with('-') {
        return Err(Failure::usage(format!(
            "--out '{folder}': a folder is expected"
        )));
    }
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).map_err(|error| monitor::cannot_write(folder, &error))?;
    // The page, for one.
    monitor::can_be_written(&folder.join("README.md"))
}

/// Builds the bench image and the scenes' firmware, runs them in the emulator, and hands everything to the program that joins
/// it.
pub fn report(arguments: &[String]) -> Outcome {
    check(arguments)?;
    let bench = Build {
        package: Some("palpate-bench"),
        ..Build::default()
    }
    .elf()?;
    let images = every_scene()?;
    let folder = target_dir().join("report");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::new(format!("cannot create {}: {error}", folder.display())))?;
    let counts = emulate(
        "bench",
        &bench,
        &["--watch", "palpate_bench"],
        folder.join("bench.jsonl"),
    )?;
    let mut words = vec![
        "report".to_owned(),
        format!("--bench={}", bench.display()),
        format!("--counts={}", counts.display()),
        format!("--compiler={}", compiler()?),
        format!("--recorded={}", root().join(RECORDED).display()),
    ];
    if let Some((_, firmware)) = images.first() {
        let grasp = emulate(
            "sim",
            firmware,
            &[
                "--counts",
                "--watch",
                "sensing::",
                "--watch",
                "finger::",
                "--watch",
                "numeric::bisect",
                "--apart",
                "sensing::locator",
            ],
            folder.join("sim.jsonl"),
        )?;
        words.push(format!("--grasp={}", grasp.display()));
        for (name, arguments) in OTHERS {
            let counted = ["--counts", "--watch", "sensing::sensor::Sensor"];
            let file = folder.join(format!("sim-{}.jsonl", name.replace(' ', "-")));
            let other = emulate("sim", firmware, &[arguments, &counted].concat(), file)?;
            words.push(format!("--other-grasp={name}={}", other.display()));
        }
    }
    words.extend(
        images
            .iter()
            .map(|(scene, elf)| format!("--image={scene}={}", elf.display())),
    );
    // Checks need no simulation of hundreds of closings.
    if !arguments.iter().any(|word| word == "--check") {
        words.push("--delays".to_owned());
    }
    let writes = arguments.iter().any(|word| word == "--write");
    for word in arguments {
        if word == "--write" {
            let root = root();
            words.push("--record".to_owned());
            words.push(format!("--out={}", root.join(FOLDER).display()));
            words.push(format!(
                "--results={}",
                root.join("docs/RESULTS.md").display()
            ));
        } else if !(writes && word == "--record") {
            words.push(word.clone());
        }
    }
    step(
        "joining errors and costs",
        host::program("palpate-report", &[])?.args(words),
    )
}

/// Other grasps in which the longest update of the sensing is looked for: near the joint, near the tip, on phalanx 1, with friction that
/// wanders.
const OTHERS: [(&str, &[&str]); 4] = [
    ("at 8 mm", &["--contact-mm", "8", "--world", "workshop"]),
    ("at 45 mm", &["--contact-mm", "45", "--world", "workshop"]),
    ("at 62 mm", &["--contact-mm", "62", "--world", "workshop"]),
    ("on phalanx 1", &["--proximal", "--world", "workshop"]),
];

/// Runs an image in the emulator and keeps what it prints.
fn emulate(subcommand: &str, elf: &Path, arguments: &[&str], path: PathBuf) -> Outcome<PathBuf> {
    let file = File::create(&path)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", path.display())))?;
    let mut command = host::emulator(subcommand, elf, &[])?;
    command.arg("--json").args(arguments).stdout(file);
    step(
        &format!("running {} on the emulated chip", elf.display()),
        &mut command,
    )?;
    Ok(path)
}

/// Name and version of the compiler that builds for the chip.
fn compiler() -> Outcome<String> {
    let program = match machine::firmware_toolchain()? {
        Toolchain::Rustup => Command::new("rustc"),
        Toolchain::Debian { .. } => Command::new("/usr/bin/rustc"),
    };
    let version = output(program.get_program(), &["--version"]).unwrap_or_default();
    // Without the date and hash: packages of one release differ in them.
    Ok(version
        .split_whitespace()
        .take(2)
        .collect::<Vec<_>>()
        .join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::words;

    fn checked(call: &str) -> Outcome {
        check(&words(call))
    }

    #[test]
    fn a_wrong_call_is_refused_before_anything_is_built() {
        for (call, told) in [
            ("--chekc", "unexpected '--chekc'; there are --json, --check"),
            ("--json --json", "--json is given twice"),
            ("--out", "--out needs a value"),
            ("--out --json", "a folder is expected"),
            ("--out=a --out=b", "unexpected '--out=b'"),
            ("--write --out here", "leave --out here or --write out"),
            ("--out Cargo.toml/report", "does the folder exist"),
        ] {
            let refused = checked(call).expect_err(call);
            assert_eq!(refused.code, 2, "{call}");
            assert!(refused.message.contains(told), "{}", refused.message);
        }
        assert!(checked("").is_ok() && checked("--json --check --record").is_ok());
    }

    #[test]
    fn a_missing_folder_is_made_and_stays_empty() {
        let above = std::env::temp_dir().join(format!("palpate-report-{}", std::process::id()));
        let folder = above.join("report");
        assert!(checked(&format!("--check --out {}", folder.display())).is_ok());
        let inside = std::fs::read_dir(&folder).map(Iterator::count);
        std::fs::remove_dir_all(&above).expect("it was made");
        assert_eq!(inside.ok(), Some(0));
    }
}
