//! MuJoCo's library, for worlds that ask for it, and the builds that link it.
//!
//! The library comes out of the Python wheel `mujoco`, which pip brings (26 MB, once); no Python runs afterwards.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::machine;
use crate::process::{Failure, Outcome, step, target_dir};

/// The version that the bindings (`mujoco-rs` in host/mujoco) are made for.
const VERSION: &str = "3.17.0";
/// The cargo features that link it, of every package that has worlds.
pub const FEATURES: &str = "palpate-mujoco/engine,palpate-emulator/mujoco,palpate-simulation/mujoco,palpate-evaluation/mujoco";
/// Where the bindings look for the library; a user may have set it.
const FOLDER: &str = "MUJOCO_DYNAMIC_LINK_DIR";
/// The file that is linked.
const LINKED: &str = "libmujoco.so";

/// Whether a call asks for the engine: `--engine mujoco`, `--engine=mujoco`, or a world's name with `@mujoco`.
pub fn asked(arguments: &[String]) -> bool {
    let named = |pair: &[String]| pair[0] == "--engine" && pair[1] == "mujoco";
    arguments.windows(2).any(named)
        || arguments
            .iter()
            .any(|word| word == "--engine=mujoco" || word.ends_with("@mujoco"))
}

/// Lets a command link the library and find it when it runs.
pub fn link(command: &mut Command, folder: &Path) {
    let mut folders = vec![folder.to_path_buf()];
    if let Some(others) = std::env::var_os("LD_LIBRARY_PATH") {
        folders.extend(std::env::split_paths(&others));
    }
    command.env(FOLDER, folder);
    if let Ok(joined) = std::env::join_paths(folders) {
        command.env("LD_LIBRARY_PATH", joined);
    }
}

/// The folder of the library for a program that is called with `arguments`: fetched if they ask for the engine; else that which is
/// there already, so that programs are not built once with and once without it.
pub fn library_for(arguments: &[String]) -> Outcome<Option<PathBuf>> {
    if asked(arguments) {
        return library().map(Some);
    }
    let folder = folder();
    Ok(folder.join(LINKED).exists().then_some(folder))
}

/// Where the library is, or belongs.
fn folder() -> PathBuf {
    std::env::var_os(FOLDER).map_or_else(
        || target_dir().join(format!("mujoco-{VERSION}")),
        // Cargo and the programs run in other folders than the user's.
        |folder| std::path::absolute(&folder).unwrap_or_else(|_| folder.into()),
    )
}

/// The folder with the library; gets it where it is missing.
pub fn library() -> Outcome<PathBuf> {
    let folder = folder();
    let linked = folder.join(LINKED);
    if linked.exists() || std::env::var_os(FOLDER).is_some() {
        return Ok(folder);
    }
    if !cfg!(target_os = "linux") {
        return Err(Failure::new(format!(
            "MuJoCo {VERSION} is fetched on Linux only; set {FOLDER} to a folder that holds its library"
        )));
    }
    if !has_pip() {
        machine::install(&["python3", "python3-pip"], "fetching MuJoCo")?;
    }
    let place = folder.display().to_string();
    let package = format!("mujoco=={VERSION}");
    step(
        &format!("fetching {package} with pip, for its library"),
        Command::new("python3")
            .args(["-m", "pip", "download", "--no-deps"])
            .args(["--only-binary", ":all:", "--dest", &place, &package])
            // How far it is; standard output belongs to what comes after.
            .stdout(machine::progress()),
    )?;
    let name = format!("libmujoco.so.{VERSION}");
    step(
        &format!("unpacking {name}"),
        Command::new("python3").args(["-c", UNPACK, &place, &name]),
    )?;
    std::fs::copy(folder.join(name), &linked)
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", linked.display())))?;
    Ok(folder)
}

/// The folder with the library, or a warning: a machine without it and without a way to it still checks all the rest.
pub fn library_if_possible() -> Option<PathBuf> {
    library()
        .inspect_err(|failure| {
            eprintln!(
                "==> WARNING: the MuJoCo worlds are left out: {}",
                failure.message
            );
        })
        .ok()
}

/// Takes one file out of the wheel in a folder.
const UNPACK: &str = "import glob, sys, zipfile
folder, name = sys.argv[1:]
wheel = glob.glob(folder + '/mujoco-*.whl')[0]
with zipfile.ZipFile(wheel) as archive, open(folder + '/' + name, 'wb') as library:
    library.write(archive.read('mujoco/' + name))";

fn has_pip() -> bool {
    crate::process::output("python3", &["-m", "pip", "--version"]).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::words;

    fn asks(call: &str) -> bool {
        asked(&words(call))
    }

    #[test]
    fn the_engine_is_asked_for_in_three_spellings() {
        assert!(asks("--engine mujoco") && asks("--free --engine=mujoco --json"));
        assert!(asks("--world workshop@mujoco"));
        assert!(!asks("--engine plant") && !asks("--world bench") && !asks("mujoco"));
    }
}
