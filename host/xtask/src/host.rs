//! Building and calling the host programs of this workspace.

use std::path::Path;
use std::process::Command;

use crate::firmware::Build;
use crate::machine;
use crate::mujoco;
use crate::own_scene;
use crate::process::{Outcome, cargo, step, target_dir, together};

/// The program that emulates the chip.
pub const EMULATOR: &str = "palpate-emulator";
/// The program that replays recordings and runs experiments.
pub const EVALUATION: &str = "palpate-evaluation";
/// The cargo profile of every host program and test.
pub const PROFILE: &str = "host";

/// A cargo call for all host packages: with MuJoCo's worlds where its library is at hand.
///
/// Every call names the whole workspace, so that programs, tests and lints agree on the features of each dependency and share one
/// build of it. The firmware's package stays out: its default features would change what the others see of the library.
pub fn workspace(subcommand: &str, library: Option<&Path>) -> Command {
    let words = [subcommand, "--profile", PROFILE, "--workspace"];
    let mut command = cargo(words);
    command.args(["--exclude", "palpate"]);
    if let Some(folder) = library {
        command.args(["--features", mujoco::FEATURES]);
        mujoco::link(&mut command, folder);
    }
    command
}

/// A host program, built; `arguments` are those of its user, who may ask for a world that needs MuJoCo.
pub fn program(package: &str, arguments: &[String]) -> Outcome<Command> {
    program_with(package, None, arguments)
}

/// The same with a feature that only this call wants, as `package/feature`.
pub fn program_with(
    package: &str,
    feature: Option<&str>,
    arguments: &[String],
) -> Outcome<Command> {
    let library = mujoco::library_for(arguments)?;
    build(package, feature, library.as_deref())?;
    Ok(call(package, library.as_deref()))
}

/// The call of a program that is built: where its user is, for the paths that the user gives are relative to that folder.
fn call(package: &str, library: Option<&Path>) -> Command {
    let mut command = Command::new(target_dir().join(PROFILE).join(package));
    own_scene::pass_on(&mut command);
    if let Some(folder) = library {
        mujoco::link(&mut command, folder);
    }
    command
}

/// The emulator with an image that is built; it takes more arguments.
pub fn emulator(subcommand: &str, elf: &Path, arguments: &[String]) -> Outcome<Command> {
    machine::emulator_packages()?;
    let mut command = program(EMULATOR, arguments)?;
    command.arg(subcommand).arg("--elf").arg(elf);
    Ok(command)
}

/// The emulator with an image: both are built, side by side.
pub fn emulator_of(image: &Build, subcommand: &str, arguments: &[String]) -> Outcome<Command> {
    machine::emulator_packages()?;
    let emulator = || program(EMULATOR, arguments);
    let (elf, mut command) = together(|| image.elf(), emulator)?;
    command.arg(subcommand).arg("--elf").arg(elf);
    Ok(command)
}

fn build(package: &str, feature: Option<&str>, library: Option<&Path>) -> Outcome {
    let mut command = workspace("build", library);
    if let Some(feature) = feature {
        command.args(["--features", feature]);
    }
    step(
        &format!("building {package}"),
        command.args(["--bin", package]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_runs_where_its_user_is() {
        let call = call(EMULATOR, None);
        assert_eq!(call.get_current_dir(), None);
        assert!(Path::new(call.get_program()).is_absolute());
    }
}
