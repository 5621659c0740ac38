//! Building the firmware, whichever compiler the machine has for the chip.

mod inputs;

use std::path::PathBuf;
use std::process::Command;

use crate::machine::{self, THUMB, Toolchain};
use crate::own_scene;
use crate::process::{Failure, Outcome, cargo, root, step, target_dir};

// The list that the build scripts use: the names alone, without a TOML reader.
#[path = "../../../build/scene/list.rs"]
pub mod list;

/// The folder of the scenes of this call.
fn folder_of_scenes() -> PathBuf {
    own_scene::folder().map_or_else(|| list::folder(&root()), PathBuf::from)
}

/// Names of the scenes, first the default.
pub fn scenes() -> Outcome<Vec<String>> {
    let folder = folder_of_scenes();
    list::names(&folder).map_err(|error| Failure::new(format!("{}: {error}", folder.display())))
}

/// What to build for the chip.
#[derive(Clone, Default)]
pub struct Build {
    /// Scene, or the default one.
    pub scene: Option<String>,
    /// Further cargo features, separated by commas.
    pub features: Option<String>,
    /// Another package than the firmware's; its binary has its name.
    pub package: Option<&'static str>,
    /// That package is a library: it can be linted, and has no ELF.
    pub library: bool,
}

/// The firmware of every scene, with the scene's name; first the default.
pub fn every_scene() -> Outcome<Vec<(String, PathBuf)>> {
    let each = |scene: String| Build::of_scene(&scene).elf().map(|elf| (scene, elf));
    scenes()?.into_iter().map(each).collect()
}

impl Build {
    /// The firmware for a scene.
    pub fn of_scene(scene: &str) -> Self {
        Self {
            scene: Some(scene.to_owned()),
            ..Self::default()
        }
    }

    fn package(&self) -> &str {
        self.package.unwrap_or("palpate")
    }

    /// What distinguishes this ELF from the others.
    fn name(&self) -> String {
        let mut name = self.package().to_owned();
        for part in [&self.scene, &self.features].into_iter().flatten() {
            name.push('-');
            name.push_str(&part.replace([',', ' '], "-"));
        }
        name
    }

    /// A folder for each compiler: two that share one would rebuild everything at every change between them.
    fn target_dir(toolchain: &Toolchain) -> PathBuf {
        target_dir().join(match toolchain {
            Toolchain::Rustup => "firmware",
            Toolchain::Debian { .. } => "firmware-debian",
        })
    }

    /// The cargo call `subcommand` for this build; `check` lints the same code that `build` compiles.
    fn cargo(&self, subcommand: &str, toolchain: &Toolchain) -> Command {
        let mut command = cargo([subcommand, "--release", "--target", THUMB]);
        // As configuration, not as a variable: this joins the flags in .cargo/config.toml, and paths may hold blanks.
        let flags: Vec<String> = machine::source_folders(toolchain)
            .iter()
            .map(|folder| format!("'--remap-path-prefix={}='", folder.display()))
            .collect();
        command
            .arg("--config")
            .arg(format!("target.{THUMB}.rustflags=[{}]", flags.join(", ")))
            .args(["--package", self.package()])
            .arg("--target-dir")
            .arg(Self::target_dir(toolchain));
        if self.library {
            command.arg("--lib");
        } else {
            command.args(["--bin", self.package()]);
        }
        if let Some(features) = &self.features {
            command.args(["--features", features]);
        }
        if let Some(scene) = &self.scene {
            command.env("PALPATE_SCENE", scene);
        }
        if let Toolchain::Debian { linker } = toolchain {
            command
                .arg("-Zbuild-std=core,alloc")
                .env("RUSTC", "/usr/bin/rustc")
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
        command
    }

    /// Builds the ELF and returns its path.
    pub fn elf(&self) -> Outcome<PathBuf> {
        let toolchain = machine::firmware_toolchain()?;
        machine::fetch_sources()?;
        let folder = Self::target_dir(&toolchain);
        // The next scene is built over this one: keep it under a name of its own.
        let kept = folder.join("elf").join(self.name());
        let mut call = self.cargo("build", &toolchain);
        let inputs = inputs::of(&call, &folder_of_scenes());
        if inputs::are(&kept, inputs) {
            return Ok(kept);
        }
        let what = format!("building for the chip: {}", self.name());
        step(&what, &mut call).map_err(|failure| Failure {
            message: format!("{}{}", failure.message, machine::hint(&toolchain)),
            ..failure
        })?;
        let built = folder.join(THUMB).join("release").join(self.package());
        std::fs::create_dir_all(folder.join("elf"))
            .and_then(|()| std::fs::copy(&built, &kept))
            .map_err(|error| Failure::new(format!("cannot keep {}: {error}", kept.display())))?;
        inputs::note(&kept, inputs);
        Ok(kept)
    }

    /// Lints the code as the chip will run it.
    pub fn clippy(&self) -> Outcome {
        let toolchain = machine::firmware_toolchain()?;
        machine::fetch_sources()?;
        let mut command = match toolchain {
            Toolchain::Rustup => {
                let mut command = self.cargo("clippy", &toolchain);
                command.args(["--", "-D", "warnings"]);
                command
            }
            // `cargo clippy` would take the wrong compiler's driver: do by hand what it does.
            Toolchain::Debian { .. } => {
                let mut command = self.cargo("check", &toolchain);
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
