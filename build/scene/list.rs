//! Which scenes there are. Without a TOML reader, for programs that only need the names.

use std::path::{Path, PathBuf};

/// The scene that a firmware is built for unless `PALPATE_SCENE` names another.
pub const DEFAULT: &str = "p70";

/// Folder of the scenes below the root of the package, unless [`VARIABLE`] names another.
pub const FOLDER: &str = "scenes";

/// Variable that names another folder of scenes.
pub const VARIABLE: &str = "PALPATE_SCENES";

/// The folder of the scenes: the one that [`VARIABLE`] names, or `scenes` below the root of the package.
pub fn folder(root: &Path) -> PathBuf {
    std::env::var_os(VARIABLE).map_or_else(|| root.join(FOLDER), PathBuf::from)
}

/// Names of the scenes in a folder: the default one first, the others sorted.
///
/// # Errors
/// A folder that cannot be read.
pub fn names(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut names: Vec<String> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort_by_key(|name| (name != DEFAULT, name.clone()));
    Ok(names)
}
