//! `--scene FILE`: a scene's file that is not in the folder of the scenes.
//!
//! Builds and simulated worlds take their scenes from one folder. For a file from elsewhere that folder is a copy of the usual one with
//! the file in it, below the build products; every build and every program of this call then uses the copy.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::firmware::list;
use crate::process::{Failure, Outcome, root, target_dir};

static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// The folder with the user's own scene, where there is one.
pub fn folder() -> Option<&'static Path> {
    FOLDER.get().map(PathBuf::as_path)
}

/// Lets a program find the user's own scene or folder of scenes, where there is one, whatever folder the program runs in.
pub fn pass_on(command: &mut Command) {
    let folder = FOLDER.get().cloned().or_else(|| {
        let folder = std::env::var_os(list::VARIABLE)?;
        std::path::absolute(folder).ok()
    });
    if let Some(folder) = folder {
        command.env(list::VARIABLE, folder);
    }
}

/// The arguments with the name of the scene instead of its file, which is from now on one of the scenes.
///
/// # Errors
/// The file cannot be read, or is named like another scene.
pub fn adopt(arguments: &[String]) -> Outcome<Vec<String>> {
    let mut words = arguments.to_vec();
    let place = words.iter().position(|word| word == "--scene");
    let value = match place {
        Some(at) => words.get_mut(at + 1),
        None => words.iter_mut().find(|word| word.starts_with("--scene=")),
    };
    let Some(value) = value else {
        return Ok(words);
    };
    let (option, file) = value
        .strip_prefix("--scene=")
        .map_or(("", value.as_str()), |file| ("--scene=", file));
    if Path::new(file)
        .extension()
        .is_none_or(|ending| ending != "toml")
    {
        return Ok(words);
    }
    let usual = list::folder(&root());
    let (name, copy) = copied(Path::new(file), &usual, &target_dir().join("scenes"))?;
    if let Some(copy) = copy {
        // Once a call: the first file counts.
        let _ = FOLDER.set(copy);
    }
    *value = format!("{option}{name}");
    Ok(words)
}

/// The name of a scene's file, and the folder that has it where the usual one does not.
fn copied(file: &Path, usual: &Path, copy: &Path) -> Outcome<(String, Option<PathBuf>)> {
    let text = fs::read(file).map_err(|error| told(file, error))?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let known = usual.join(format!("{name}.toml"));
    match fs::read(&known) {
        Ok(other) if other == text => return Ok((name.into_owned(), None)),
        Ok(_) => {
            return Err(Failure::usage(format!(
                "scene file {}: there is another scene of that name, {}: rename the file",
                file.display(),
                known.display()
            )));
        }
        Err(_) => {}
    }
    copy_folder(usual, copy, |_| true)?;
    let own = copy.join(format!("{name}.toml"));
    update(&own, &text).map_err(|error| told(&own, error))?;
    // An earlier call's own scene would still be there.
    for path in files(copy).map_err(|error| told(copy, error))? {
        if path != own && !usual.join(path.file_name().unwrap_or_default()).exists() {
            fs::remove_file(&path).map_err(|error| told(&path, error))?;
        }
    }
    Ok((name.into_owned(), Some(copy.to_path_buf())))
}

/// Copies a folder of scenes: what they share, and the scenes whose file names are wanted. Files that are already as they should
/// be keep their time.
///
/// # Errors
/// A file that cannot be read or written.
pub fn copy_folder(from: &Path, to: &Path, wanted: impl Fn(&str) -> bool) -> Outcome {
    for inner in ["", "common"] {
        let (from, to) = (from.join(inner), to.join(inner));
        fs::create_dir_all(&to).map_err(|error| told(&to, error))?;
        for path in files(&from).map_err(|error| told(&from, error))? {
            let name = path.file_name().unwrap_or_default();
            if inner.is_empty() && !wanted(&name.to_string_lossy()) {
                continue;
            }
            let to = to.join(name);
            let bytes = fs::read(&path).map_err(|error| told(&path, error))?;
            update(&to, &bytes).map_err(|error| told(&to, error))?;
        }
    }
    Ok(())
}

fn told(path: &Path, error: std::io::Error) -> Failure {
    Failure::new(format!("scene file {}: {error}", path.display()))
}

/// The files of a folder, without its folders.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let paths = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = paths.collect::<std::io::Result<Vec<_>>>()?;
    paths.retain(|path| path.is_file());
    Ok(paths)
}

/// Writes a file unless it is as wanted: a file that looks newer would be built again.
fn update(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if fs::read(path).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    fs::write(path, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_from_elsewhere_joins_the_scenes_and_another_of_a_known_name_is_refused() {
        let usual = list::folder(&root());
        let here = std::env::temp_dir().join(format!("own-scene-{}", std::process::id()));
        fs::create_dir_all(&here).expect("a folder");
        let (own, copy) = (here.join("mine.toml"), here.join("scenes"));
        fs::write(&own, "base = \"p70\"\n").expect("written");
        let (name, folder) = copied(&own, &usual, &copy).expect("adopted");
        assert_eq!((name.as_str(), folder.as_deref()), ("mine", Some(&*copy)));
        let names = list::names(&copy).expect("scenes");
        assert!(names.contains(&"mine".to_owned()) && names[0] == list::DEFAULT);
        assert!(copy.join("common/defaults.toml").is_file());
        // Another file of one's own takes its place.
        let second = here.join("second.toml");
        fs::write(&second, "base = \"tendon2\"\n").expect("written");
        assert!(copied(&second, &usual, &copy).is_ok());
        let names = list::names(&copy).expect("scenes");
        assert!(names.contains(&"second".to_owned()) && !names.contains(&"mine".to_owned()));
        // The usual file by its path is no scene of one's own.
        let usual_file = usual.join("p70.toml");
        let (name, folder) = copied(&usual_file, &usual, &copy).expect("known");
        assert_eq!((name.as_str(), folder), ("p70", None));
        let other = here.join("p70.toml");
        fs::write(&other, "base = \"tendon2\"\n").expect("written");
        let refused = copied(&other, &usual, &copy).expect_err("refused");
        assert!(refused.message.contains("p70.toml"), "{}", refused.message);
        fs::remove_dir_all(&here).expect("removed");
    }
}
