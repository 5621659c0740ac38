//! The reader of scenes as the build scripts use it, on folders of a test's own.

#[path = "../../../../build/scene/mod.rs"]
#[allow(dead_code, reason = "the reader serves the build scripts as well")]
pub mod scene;

use std::fs;
use std::path::{Path, PathBuf};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");

/// A folder with the defaults, the scenes that are named, and one more.
pub fn folder(test: &str, bases: &[&str], own: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    fs::create_dir_all(folder.join("common")).expect("a folder for the test");
    for base in bases.iter().chain(&["common/defaults"]) {
        let file = format!("{base}.toml");
        fs::copy(Path::new(SCENES).join(&file), folder.join(&file)).expect("a scene to copy");
    }
    fs::write(folder.join("own.toml"), own).expect("a scene to write");
    folder
}
