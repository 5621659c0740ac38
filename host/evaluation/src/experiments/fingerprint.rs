//! Fingerprint of the code that a table describes.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Sources that decide the results, from the root of the checkout.
const SOURCES: &[&str] = &[
    "build/generate",
    "build/scene",
    "scenes",
    "src/app/grasp",
    "src/app/console/settings.rs",
    "src/drive",
    "src/finger",
    "src/joint_sensor.rs",
    "src/numeric",
    "src/scene",
    "src/sensing",
    "src/sample.rs",
    "host/plant/src",
    "host/plant/default.toml",
    "host/plant/worlds",
    "host/mujoco/src",
    "host/simulation/src",
    "host/evaluation/src/experiments",
    "host/evaluation/src/paper",
    "host/evaluation/src/score",
];

/// Root of the checkout.
#[must_use]
pub fn root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Collects all files except those of unit tests: `tests.rs`, and folders `tests`.
fn files(at: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if at.file_stem().is_some_and(|name| name == "tests") {
        return Ok(());
    }
    if at.is_dir() {
        for entry in std::fs::read_dir(at)? {
            files(&entry?.path(), found)?;
        }
    } else {
        found.push(at.to_path_buf());
    }
    Ok(())
}

/// Scenes that a user has added and git does not track: the tables do not have them. None without git.
fn own_scenes(root: &Path) -> Vec<PathBuf> {
    let listed = Command::new("git")
        .args(["ls-files", "--others", "-z", "scenes"])
        .current_dir(root)
        .output();
    listed.map_or_else(
        |_| Vec::new(),
        |listed| {
            let names = String::from_utf8_lossy(&listed.stdout);
            let names = names.split('\0').filter(|name| !name.is_empty());
            names.map(|name| root.join(name)).collect()
        },
    )
}

/// FNV-1a, 64 bit: to notice a change, not to withstand an attack.
struct Hash(u64);

impl Hash {
    fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// The text up to its unit tests, which stand at the end of a file.
fn without_tests(text: &str) -> &str {
    text.split_once("\n#[cfg(test)]\nmod tests {")
        .map_or(text, |(code, _)| code)
}

/// A number that changes when code that decides the results changes; comments, blank lines and unit tests do not count.
///
/// # Errors
/// A source that cannot be read.
pub fn fingerprint() -> std::io::Result<String> {
    let root = root();
    let mut paths = Vec::new();
    for source in SOURCES {
        files(&root.join(source), &mut paths)?;
    }
    let own = own_scenes(&root);
    paths.retain(|path| !own.contains(path));
    paths.sort();
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    for path in paths {
        let name = path.strip_prefix(&root).unwrap_or(&path);
        hash.take(name.to_string_lossy().replace('\\', "/").as_bytes());
        for line in without_tests(&std::fs::read_to_string(&path)?).lines() {
            let line = line.trim();
            if !(line.is_empty() || line.starts_with("//") || line.starts_with('#')) {
                hash.take(line.as_bytes());
                hash.take(b"\n");
            }
        }
    }
    Ok(format!("{:016x}", hash.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_tests_do_not_count_but_what_only_names_them_does() {
        assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {\nb\n}\n"), "a");
        assert_eq!(
            without_tests("#[cfg(test)]\nmod tests;\na\n"),
            "#[cfg(test)]\nmod tests;\na\n"
        );
    }

    #[test]
    fn files_of_tests_do_not_count() {
        let mut found = Vec::new();
        files(&root().join("src/sensing"), &mut found).unwrap();
        let tests = |path: &PathBuf| path.components().any(|part| part.as_os_str() == "tests");
        assert!(found.len() > 20 && !found.iter().any(tests));
        assert!(!found.iter().any(|path| path.ends_with("tests.rs")));
    }

    #[test]
    fn a_scene_of_a_user_s_own_does_not_count() {
        let name = format!("palpate-own-scenes-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let git = |arguments: &[&str]| {
            let status = Command::new("git")
                .args(arguments)
                .current_dir(&folder)
                .status();
            assert!(status.unwrap().success(), "{arguments:?}");
        };
        std::fs::create_dir_all(folder.join("scenes")).unwrap();
        for name in ["kept.toml", "mine.toml"] {
            std::fs::write(folder.join("scenes").join(name), "").unwrap();
        }
        git(&["init", "--quiet"]);
        git(&["add", "scenes/kept.toml"]);
        let own = own_scenes(&folder);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(own, [folder.join("scenes/mine.toml")]);
    }

    #[test]
    fn it_is_the_same_twice_and_every_source_is_there() {
        for source in SOURCES {
            assert!(root().join(source).exists(), "{source}");
        }
        assert_eq!(fingerprint().unwrap(), fingerprint().unwrap());
    }
}
