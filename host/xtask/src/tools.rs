//! Tools of others that tests use: got once where the machine lacks them. A machine that cannot get one still runs all other tests.

use std::path::{Path, PathBuf};

use crate::machine::{find, install};
use crate::process::{Failure, Outcome, cargo, step, target_dir};

/// The reader of defmt frames whose output the manual shows.
const DEFMT_PRINT: &str = "defmt-print";
/// Its version: of the same generation as the decoder in Cargo.lock.
const DEFMT_PRINT_VERSION: &str = "1.2.0";
/// Debuggers that know the chip's core: Debian's, and that of Arm's toolchain.
const DEBUGGERS: [&str; 2] = ["gdb-multiarch", "arm-none-eabi-gdb"];

/// What the tests are told by variables of the environment.
pub struct Tools {
    /// Programs that are there: the variable that names one, and its path.
    pub found: Vec<(&'static str, PathBuf)>,
    /// What could not be got and why, a line each.
    pub missing: Vec<String>,
}

/// Looks for the tools, and gets what is missing.
pub fn get() -> Tools {
    with(defmt_print().or_else(|_| build_defmt_print()))
}

/// Looks for the tools, and gets what is a Debian package. `defmt-print` takes two minutes to compile, and what it shows is tested
/// without it too, by the decoder that it is made of.
pub fn get_packages() -> Tools {
    with(defmt_print())
}

fn with(defmt_print: Outcome<PathBuf>) -> Tools {
    let mut tools = Tools {
        found: Vec::new(),
        missing: Vec::new(),
    };
    for (variable, got) in [
        ("PALPATE_DEFMT_PRINT", defmt_print),
        ("PALPATE_GDB", debugger()),
    ] {
        match got {
            Ok(program) => tools.found.push((variable, program)),
            Err(failure) => tools.missing.push(failure.message),
        }
    }
    tools
        .missing
        .extend(tmux().err().map(|failure| failure.message));
    tools.warn();
    tools
}

impl Tools {
    /// Says which tests are left out.
    pub fn warn(&self) {
        for missing in &self.missing {
            eprintln!("==> WARNING: a test is left out: {missing}");
        }
    }
}

/// Where this project's own tools are installed.
fn folder() -> PathBuf {
    target_dir().join("tools")
}

/// `defmt-print` from the path, or from among the build products.
fn defmt_print() -> Outcome<PathBuf> {
    let built = folder()
        .join("bin")
        .join(format!("{DEFMT_PRINT}{}", std::env::consts::EXE_SUFFIX));
    find(DEFMT_PRINT)
        .or_else(|| built.exists().then_some(built))
        .ok_or_else(|| {
            Failure::new(format!(
                "{DEFMT_PRINT} is missing: `cargo xtask setup` builds it"
            ))
        })
}

/// Builds `defmt-print` by cargo among the build products.
fn build_defmt_print() -> Outcome<PathBuf> {
    let folder = folder();
    let mut call = cargo(["install", DEFMT_PRINT, "--locked"]);
    call.args(["--version", DEFMT_PRINT_VERSION])
        // Neither optimised nor for a debugger: it is built in half the time, and prints some lines.
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .args(["--debug", "--root"])
        .arg(&folder)
        .arg("--target-dir")
        .arg(folder.join("build"));
    step(
        &format!("installing {DEFMT_PRINT} {DEFMT_PRINT_VERSION} below target/tools, once: it decodes the log in a test"),
        &mut call,
    )
    .map_err(|_| {
        Failure::new(format!(
            "{DEFMT_PRINT} could not be installed (is there a network?): cargo install {DEFMT_PRINT} --locked"
        ))
    })?;
    remove(&folder.join("build"));
    defmt_print()
}

/// Build products of a tool that is installed.
fn remove(folder: &Path) {
    // What cannot be removed takes room, and nothing else.
    let _ = std::fs::remove_dir_all(folder);
}

/// A debugger from the path, or Debian's.
fn debugger() -> Outcome<PathBuf> {
    let there = || DEBUGGERS.into_iter().find_map(find);
    if let Some(program) = there() {
        return Ok(program);
    }
    install(&DEBUGGERS[..1], "the test of the debugger's port")?;
    there().ok_or_else(|| Failure::new("gdb-multiarch was installed and is not on the path"))
}

/// The terminal in which the monitor is tested; its tests find it on the path.
fn tmux() -> Outcome {
    if find("tmux").is_some() {
        return Ok(());
    }
    install(&["tmux"], "the tests of the monitor in a terminal")
}
