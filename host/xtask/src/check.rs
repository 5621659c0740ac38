//! `check`: what a reviewer should not have to say.

use std::path::{Path, PathBuf};

use crate::commands::{none_left, reach, sizes};
use crate::firmware::{Build, every_scene};
use crate::host;
use crate::machine;
use crate::mujoco;
use crate::own_finger;
use crate::process::{Outcome, cargo, step, target_dir, together};

/// What turns a lint into a failure, in everything that is compiled.
const LINTS: [&str; 4] = ["--all-targets", "--", "-D", "warnings"];

/// Formatting, lints, documentation, a new user's finger, sizes, and what the control interrupt can reach.
pub fn check(arguments: &[String]) -> Outcome {
    none_left(arguments)?;
    machine::emulator_packages()?;
    step("formatting", &mut cargo(["fmt", "--all", "--check"]))?;
    let library = mujoco::library_if_possible();
    // The firmware's one optimised unit keeps one core busy; the other does the rest.
    let (images, ()) = together(for_the_chip, || {
        for_the_host(library.as_deref())?;
        // Last: its firmware would wait for that of every other scene.
        own_finger::check()
    })?;
    sizes(&images)?;
    let elfs: Vec<PathBuf> = images.into_iter().map(|(_, elf)| elf).collect();
    reach(&elfs)
}

/// Lints the code of the chip and builds the firmware of every scene.
fn for_the_chip() -> Outcome<Vec<(String, PathBuf)>> {
    Build::default().clippy()?;
    // What a firmware of another controller would write still compiles for such a chip.
    Build {
        package: Some("palpate-own-controller"),
        library: true,
        ..Build::default()
    }
    .clippy()?;
    every_scene()
}

/// Lints and documentation of what runs on a PC.
fn for_the_host(library: Option<&Path>) -> Outcome {
    step(
        "lints, host",
        host::workspace("clippy", library).args(LINTS),
    )?;
    step(
        "lints, library",
        cargo(["clippy", "--profile", host::PROFILE, "--package", "palpate"]).args(LINTS),
    )?;
    fuzz_targets()?;
    // As the lints: of the same features, so that dependencies are checked once.
    step(
        "documentation, host",
        host::workspace("doc", library)
            .arg("--no-deps")
            .env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    step(
        "documentation, library",
        cargo([
            "doc",
            "--profile",
            host::PROFILE,
            "--package",
            "palpate",
            "--no-deps",
        ])
        .env("RUSTDOCFLAGS", "-D warnings"),
    )
}

/// Lints the fuzz targets, a workspace of their own. Fuzzing needs a nightly toolchain, this does not.
fn fuzz_targets() -> Outcome {
    let manifest = ["clippy", "--manifest-path", "fuzz/Cargo.toml"];
    let folder = target_dir().join("fuzz");
    step(
        "lints, fuzz targets",
        cargo(manifest)
            .arg("--target-dir")
            .arg(folder)
            // A library of one's own, which nothing links here: libFuzzer's would ask for a C++ compiler.
            .env("CUSTOM_LIBFUZZER_PATH", "none/libfuzzer.a")
            .args(LINTS),
    )
}
