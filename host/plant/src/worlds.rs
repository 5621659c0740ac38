//! Named worlds: files that come with the program, laid over `default.toml`.

use crate::{Error, World};

/// Names and texts, from the mildest to the worst.
const WORLDS: [(&str, &str); 4] = [
    ("ideal", include_str!("../worlds/ideal.toml")),
    ("bench", include_str!("../worlds/bench.toml")),
    ("workshop", include_str!("../worlds/workshop.toml")),
    ("harsh", include_str!("../worlds/harsh.toml")),
];

/// Names of the worlds, from the mildest to the worst.
pub fn world_names() -> impl Iterator<Item = &'static str> {
    WORLDS.iter().map(|(name, _)| *name)
}

impl World {
    /// A world by its name (one of [`world_names`]) or from a file, with `@mujoco` behind it for the other engine.
    ///
    /// # Errors
    /// What cannot be read or is not valid, and the names that there are.
    pub fn named(name_or_file: &str) -> Result<Self, String> {
        if let Some((world, engine)) = name_or_file.rsplit_once('@') {
            let mut world = Self::named(world)?;
            world.engine = engine.parse()?;
            return Ok(world);
        }
        let told = |error: Error| format!("world '{name_or_file}': {error}");
        if let Some((_, text)) = WORLDS.iter().find(|(name, _)| *name == name_or_file) {
            return Self::from_toml(text).map_err(told);
        }
        let text = std::fs::read_to_string(name_or_file).map_err(|error| {
            let names = world_names().collect::<Vec<_>>().join(", ");
            format!("world '{name_or_file}' is none of {names}, and no file: {error}")
        })?;
        Self::from_toml(&text).map_err(told)
    }
}
