//! Reads the scenes' files at run time, so that editing a scene does not recompile the simulated worlds.

#[path = "../../../../build/scene/mod.rs"]
#[expect(
    dead_code,
    reason = "the reader serves the build scripts, which want more of it"
)]
pub(super) mod scene;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use crate::Error;
use toml::Table;

/// Root of the checkout.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Scenes that were already read: editing a file during a long run does not change that run.
static READ: Mutex<BTreeMap<String, Table>> = Mutex::new(BTreeMap::new());

/// Names of the scenes, the default one first; empty if their folder cannot be read.
#[must_use]
pub fn scenes() -> Vec<String> {
    scene::names_of_all(Path::new(ROOT)).unwrap_or_default()
}

/// The scene that a firmware is built for when none is named.
#[must_use]
pub const fn default_scene() -> &'static str {
    scene::list::DEFAULT
}

/// Sections of a scene, checked.
///
/// # Errors
/// [`Error::Scene`]: no such scene, or one with a wrong value.
pub(super) fn values(name: &str) -> Result<Table, Error> {
    // Safe after a panic in another thread: an entry is inserted only when it is complete.
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(values) = read.get(name) {
        return Ok(values.clone());
    }
    let found = scene::find(Path::new(ROOT), name);
    let values = found
        .map_err(|error| Error::Scene(error.to_string()))?
        .values;
    read.insert(name.to_owned(), values.clone());
    Ok(values)
}
