//! MuJoCo's library, for worlds that ask for it, and the builds that link it.
//!
//! The library comes out of the Python wheel `mujoco`, which pip brings (26 MB, once); no Python runs afterwards.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::machine;
use crate::process::{Failure, Outcome, cargo, step, target_dir};

/// The version that the bindings (`mujoco-rs` in host/mujoco) are made for.
const VERSION: &str = "3.17.0";
/// Name of the cargo feature, in every package that has worlds.
const FEATURE: &str = "mujoco";
/// Where the bindings look for the library; a user may have set it.
const FOLDER: &str = "MUJOCO_DYNAMIC_LINK_DIR";

/// Whether a call asks for the engine: `--engine mujoco`, `--engine=mujoco`, or a world's name with `@mujoco`.
pub fn asked(arguments: &[String]) -> bool {
    let named = |pair: &[String]| pair[0] == "--engine" && pair[1] == "mujoco";
    arguments.windows(2).any(named)
        || arguments
            .iter()
            .any(|word| word == "--engine=mujoco" || word.ends_with("@mujoco"))
}

/// A cargo call with the feature and the library, where `folder` is there.
pub fn cargo_with<'a>(folder: Option<&Path>, words: impl IntoIterator<Item = &'a str>) -> Command {
    let mut command = cargo(words);
    if let Some(folder) = folder {
        command.args(["--features", FEATURE]);
        link(&mut command, folder);
    }
    command
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

/// The folder of the library if a call asks for the engine.
pub fn wanted(arguments: &[String]) -> Outcome<Option<PathBuf>> {
    asked(arguments).then(library).transpose()
}

/// The folder with the library; gets it where it is missing.
pub fn library() -> Outcome<PathBuf> {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return Ok(PathBuf::from(folder));
    }
    let folder = target_dir().join(format!("mujoco-{VERSION}"));
    let linked = folder.join("libmujoco.so");
    if linked.exists() {
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
            .args(["-m", "pip", "download", "--quiet", "--no-deps"])
            .args(["--only-binary", ":all:", "--dest", &place, &package]),
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

    fn asks(call: &str) -> bool {
        let words: Vec<String> = call.split_whitespace().map(str::to_owned).collect();
        asked(&words)
    }

    #[test]
    fn the_engine_is_asked_for_in_three_spellings() {
        assert!(asks("--engine mujoco") && asks("--free --engine=mujoco --json"));
        assert!(asks("--world workshop@mujoco"));
        assert!(!asks("--engine plant") && !asks("--world bench") && !asks("mujoco"));
    }
}
