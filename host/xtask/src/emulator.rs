//! Running an image on the emulated chip.

use std::path::Path;
use std::process::Command;

use crate::machine;
use crate::process::{Outcome, cargo, step};

const PACKAGE: &str = "palpate-emulator";

/// Gets what the emulator needs of the machine, and builds it.
pub fn build() -> Outcome {
    machine::emulator_packages()?;
    step(
        "building the emulator",
        &mut cargo(["build", "--profile", "host", "--package", PACKAGE]),
    )
}

/// A call of the emulator, once [built](build); it takes more arguments.
pub fn call(subcommand: &str, elf: &Path) -> Command {
    let mut command = cargo([
        "run",
        "--quiet",
        "--profile",
        "host",
        "--package",
        PACKAGE,
        "--",
    ]);
    command.arg(subcommand).arg("--elf").arg(elf);
    command
}
