//! Building the firmware, whichever compiler the machine has for the chip.

use std::path::PathBuf;
use std::process::Command;

use crate::machine::{self, THUMB, Toolchain};
use crate::process::{Outcome, cargo, step, target_dir};

/// The scenes that a firmware can be built for, first the default.
pub const SCENES: &[&str] = &["p70", "tendon2", "tendon3", "linkage3"];

/// Package and binary of the benchmarks.
const BENCH: &str = "palpate-bench";

/// What to build.
#[derive(Clone, Default)]
pub struct Build {
    /// Scene, or the default one.
    pub scene: Option<String>,
    /// Further cargo features, separated by commas.
    pub features: Option<String>,
    /// Another binary than the firmware itself.
    pub bin: Option<String>,
}

impl Build {
    fn bin(&self) -> &str {
        self.bin.as_deref().unwrap_or("palpate")
    }

    /// The benchmarks' image: every candidate method, timed on the chip.
    pub fn bench() -> Self {
        Self {
            bin: Some(BENCH.to_owned()),
            ..Self::default()
        }
    }

    /// Folder of its own for each scene and feature set, so that going from one to another builds nothing twice.
    fn target_dir(&self) -> PathBuf {
        let scene = match self.bin() {
            BENCH => BENCH,
            _ => self.scene.as_deref().unwrap_or(SCENES[0]),
        };
        let name = match &self.features {
            Some(features) => format!("{scene}-{}", features.replace([',', ' '], "-")),
            None => scene.to_owned(),
        };
        let compiler = match std::env::var("PALPATE_TOOLCHAIN").as_deref() {
            Ok("debian") => "firmware-debian",
            _ => "firmware",
        };
        target_dir().join(compiler).join(name)
    }

    /// The cargo call `subcommand` for this build; `check` lints the same code that `build` compiles.
    fn cargo(&self, subcommand: &str, toolchain: &Toolchain) -> Outcome<Command> {
        let mut command = cargo([
            subcommand,
            "--release",
            "--target",
            THUMB,
        ]);
        // Every image has a package of its own name.
        command
            .args(["--package", self.bin(), "--bin", self.bin()])
            .arg("--target-dir")
            .arg(self.target_dir());
        let mut features: Vec<String> = self.features.iter().cloned().collect();
        if let Some(scene) = &self.scene {
            command.arg("--no-default-features");
            features.push(format!("scene-{scene}"));
        }
        if !features.is_empty() {
            command.args(["--features", &features.join(",")]);
        }
        if let Toolchain::Debian { linker } = toolchain {
            command
                .arg("-Zbuild-std=core,alloc")
                .env("RUSTC", "/usr/bin/rustc")
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
        Ok(command)
    }

    /// Builds the ELF and returns its path.
    pub fn elf(&self) -> Outcome<PathBuf> {
        let toolchain = machine::firmware_toolchain()?;
        let what = format!(
            "building the firmware, scene {}",
            self.scene.as_deref().unwrap_or(SCENES[0])
        );
        step(&what, &mut self.cargo("build", &toolchain)?)?;
        Ok(self
            .target_dir()
            .join(THUMB)
            .join("release")
            .join(self.bin()))
    }

    /// Lints the code as the chip will run it.
    pub fn clippy(&self) -> Outcome {
        let toolchain = machine::firmware_toolchain()?;
        let mut command = match toolchain {
            Toolchain::Rustup => {
                let mut command = self.cargo("clippy", &toolchain)?;
                command.args(["--", "-D", "warnings"]);
                command
            }
            // `cargo clippy` would take the wrong compiler's driver: do by hand what it does.
            Toolchain::Debian { .. } => {
                let mut command = self.cargo("check", &toolchain)?;
                command
                    .env("RUSTC_WORKSPACE_WRAPPER", machine::debian_clippy()?)
                    .env(
                        "CLIPPY_ARGS",
                        "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__",
                    );
                command
            }
        };
        step("lints, target", &mut command)
    }
}
