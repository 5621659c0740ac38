//! Named worlds: files that come with the program, laid over `default.toml`.

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

/// Text of a world: one of [`world_names`], or a file.
///
/// # Errors
/// What cannot be read, and the names that there are.
pub fn world_text(name_or_file: &str) -> Result<String, String> {
    if let Some((_, text)) = WORLDS.iter().find(|(name, _)| *name == name_or_file) {
        return Ok((*text).to_owned());
    }
    std::fs::read_to_string(name_or_file).map_err(|error| {
        let names = world_names().collect::<Vec<_>>().join(", ");
        format!("world '{name_or_file}' is none of {names}, and no file: {error}")
    })
}
