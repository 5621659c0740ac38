//! `test`: everything that can be tested here.

use std::path::PathBuf;
use std::process::Command;

use crate::commands::{none_left, reach};
use crate::firmware::{Build, list};
use crate::host;
use crate::machine;
use crate::monitor;
use crate::mujoco;
use crate::process::{Outcome, cargo, step, together};
use crate::target;
use crate::tools;

/// The images that tests run on the emulated chip: the variable that names the ELF, the scene, a feature beside the default.
const IMAGES: [(&str, &str, Option<&str>); 11] = [
    ("PALPATE_ELF", list::DEFAULT, None),
    ("PALPATE_FAULT_ELF", list::DEFAULT, Some("fault-injection")),
    (
        "PALPATE_FAULT_TENDON3_ELF",
        "tendon3",
        Some("fault-injection"),
    ),
    (
        "PALPATE_SERIAL_ELF",
        list::DEFAULT,
        Some(monitor::SERIAL_LOG),
    ),
    ("PALPATE_HALL_ELF", "tendon2-hall", None),
    ("PALPATE_RIGID_ELF", "p70-rigid", None),
    ("PALPATE_SHUNT_ELF", "p70-shunt", None),
    ("PALPATE_GRASP_ELF", "p70-grasp", None),
    ("PALPATE_GRASP_TENDON3_ELF", "tendon3-grasp", None),
    ("PALPATE_GRASP_LINKAGE3_ELF", "linkage3-grasp", None),
    ("PALPATE_DIRECT_ELF", "direct2", None),
];

/// Tests of the library, of the host programs, of the firmware on the emulated chip; or those of the chip itself alone.
pub fn test(arguments: &[String]) -> Outcome {
    match arguments {
        [word] if word == "--board" => return target::test(true),
        [word] if word == "--target" => return target::test(false),
        _ => none_left(arguments)?,
    }
    machine::emulator_packages()?;
    let library = mujoco::library_if_possible();
    let host_tests = || host::workspace("test", library.as_deref());
    // The firmware's one optimised unit keeps one core busy; the other compiles the tests.
    let prepare = || {
        target::image()?;
        Ok((images()?, tools::get_packages()))
    };
    let ((images, tools), ()) = together(prepare, || {
        step(
            "compiling the tests of the library",
            library_tests().arg("--no-run"),
        )?;
        step(
            "compiling the tests of the host programs",
            host_tests().arg("--no-run"),
        )
    })?;
    let elfs: Vec<PathBuf> = images.iter().map(|(_, elf)| elf.clone()).collect();
    reach(&elfs)?;
    step("tests of the library", &mut library_tests())?;
    step(
        "tests of the host programs and of the emulated firmware",
        host_tests()
            .arg("--no-fail-fast")
            .envs(images)
            .envs(tools.found.iter().map(|(variable, path)| (variable, path)))
            .env("PALPATE_ENDURANCE_S", "600"),
    )?;
    target::test(false)?;
    // Again, where it is read.
    tools.warn();
    Ok(())
}

/// Of the same profile as the host programs: one build of what both depend on.
fn library_tests() -> Command {
    cargo(["test", "--profile", host::PROFILE, "--package", "palpate"])
}

fn images() -> Outcome<Vec<(&'static str, PathBuf)>> {
    let each = |(variable, scene, features): (&'static str, &str, Option<&str>)| {
        let build = Build {
            features: features.map(str::to_owned),
            ..Build::of_scene(scene)
        };
        Ok((variable, build.elf()?))
    };
    IMAGES.into_iter().map(each).collect()
}
