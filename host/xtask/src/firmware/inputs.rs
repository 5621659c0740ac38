//! Whether an image is still that of its sources: checks and tests ask for each scene several times, and all that cargo sees is
//! that another scene was built last.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{output, root};

/// What an image is made from, besides the folder of scenes; what is not there counts as empty.
const SOURCES: &[&str] = &[
    "src",
    "bench",
    "build",
    "build.rs",
    "memory.x",
    "Cargo.toml",
    "Cargo.lock",
    "rust-toolchain.toml",
    ".cargo/config.toml",
    // References of the tests on the chip.
    "tests/data/golden",
];
/// Variables that change what is built; those that the call sets itself are part of it.
const VARIABLES: &[&str] = &[
    "DEFMT_LOG",
    "RUSTFLAGS",
    "PALPATE_SCENE",
    "PALPATE_TOOLCHAIN",
];

/// Digest of everything that decides what `build` produces.
pub fn of(build: &Command, scenes: &Path) -> u64 {
    let mut hasher = DefaultHasher::new();
    format!("{build:?}").hash(&mut hasher);
    output("rustc", &["--version", "--verbose"]).hash(&mut hasher);
    for name in VARIABLES {
        std::env::var_os(name).hash(&mut hasher);
    }
    for (name, value) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("CARGO_PROFILE_") {
            (name, value).hash(&mut hasher);
        }
    }
    for source in SOURCES {
        digest(&root().join(source), &mut hasher);
    }
    digest(scenes, &mut hasher);
    hasher.finish()
}

fn digest(path: &Path, hasher: &mut DefaultHasher) {
    if let Ok(entries) = std::fs::read_dir(path) {
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            path.hash(hasher);
            digest(&path, hasher);
        }
    } else {
        std::fs::read(path).ok().hash(hasher);
    }
}

fn record(image: &Path) -> PathBuf {
    image.with_extension("inputs")
}

/// Whether an image is there and was made from these inputs.
pub fn are(image: &Path, inputs: u64) -> bool {
    let noted = std::fs::read_to_string(record(image)).ok();
    image.exists() && noted.is_some_and(|noted| noted == inputs.to_string())
}

/// Notes what an image was made from. Where that fails, it is built again the next time.
pub fn note(image: &Path, inputs: u64) {
    let _ = std::fs::write(record(image), inputs.to_string());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a build script reads beside its own package is among the sources.
    #[test]
    fn what_build_scripts_read_is_a_source() {
        let script = root().join("bench/build/main.rs");
        let script = std::fs::read_to_string(script).expect("the script");
        let read: Vec<&str> = (script.split("\"../").skip(1))
            .filter_map(|rest| rest.split('"').next())
            .collect();
        assert!(read.contains(&"tests/data/golden"), "{read:?}");
        for path in read {
            let listed = (SOURCES.iter()).any(|source| Path::new(path).starts_with(source));
            assert!(listed, "{path}");
        }
    }

    #[test]
    fn an_image_is_used_again_until_a_source_changes() {
        let folder = std::env::temp_dir().join(format!("palpate-inputs-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        let image = folder.join("image");
        let build = Command::new("cargo");
        let before = of(&build, &folder.join("scenes"));
        assert!(!are(&image, before), "no image yet");
        std::fs::write(&image, "code").expect("written");
        note(&image, before);
        assert!(are(&image, before));
        std::fs::create_dir(folder.join("scenes")).expect("made");
        std::fs::write(folder.join("scenes/own.toml"), "title = \"own\"").expect("written");
        let after = of(&build, &folder.join("scenes"));
        assert!(before != after && !are(&image, after));
        assert_ne!(
            after,
            of(Command::new("cargo").arg("build"), &folder.join("scenes"))
        );
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
