//! Running an image on the emulated chip.

use std::path::Path;
use std::process::Command;

use crate::machine;
use crate::mujoco;
use crate::process::{Outcome, step};

const PACKAGE: &str = "palpate-emulator";

/// Gets what the emulator needs of the machine, and builds it.
///
/// With the folder of MuJoCo's library it is built for worlds that ask for that.
pub fn build(mujoco: Option<&Path>) -> Outcome {
    machine::emulator_packages()?;
    let words = ["build", "--profile", "host", "--package", PACKAGE];
    step(
        "building the emulator",
        &mut mujoco::cargo_with(mujoco, words),
    )
}

/// A call of the emulator, once [built](build); it takes more arguments.
pub fn call(subcommand: &str, elf: &Path, mujoco: Option<&Path>) -> Command {
    let words = ["run", "--quiet", "--profile", "host", "--package", PACKAGE];
    let mut command = mujoco::cargo_with(mujoco, words);
    command.arg("--").arg(subcommand).arg("--elf").arg(elf);
    command
}
