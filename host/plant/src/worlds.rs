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
    /// A world by its name (one of [`world_names`]) or from a file, with `@mujoco` behind it for another engine.
    ///
    /// # Errors
    /// A file that cannot be read or is not valid; names the existing worlds.
    pub fn named(name: &str) -> Result<Self, String> {
        let (world, engine) = name.split_once('@').unwrap_or((name, "plant"));
        let told = |error: Error| format!("world '{world}': {error}");
        let embedded = WORLDS.iter().find(|(known, _)| *known == world);
        let mut found = match embedded {
            Some((_, text)) => Self::from_toml(text).map_err(told)?,
            None => {
                let text = std::fs::read_to_string(world).map_err(|error| {
                    let names = world_names().collect::<Vec<_>>().join(", ");
                    format!("world '{world}' is none of {names}, and no file: {error}")
                })?;
                Self::from_toml(&text).map_err(told)?
            }
        };
        found.engine = engine.parse()?;
        Ok(found)
    }
}
