//! Scenes on the command line.

use palpate_scenes::NAMES;

/// A scene's name, from its name or from its file: scenes are compiled, so a file must be one of those in `scenes/`.
pub fn named(text: &str) -> Result<String, String> {
    let file = std::path::Path::new(text);
    let name = if file.extension().is_some_and(|ending| ending == "toml") {
        file.file_stem().and_then(|stem| stem.to_str())
    } else {
        Some(text)
    };
    match name {
        Some(name) if NAMES.contains(&name) => Ok(name.to_owned()),
        _ => Err(format!(
            "there is no scene '{text}'; there are: {}. A scene of your own is a file in scenes/, known after the next build",
            NAMES.join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_named_or_its_file_and_another_is_refused() {
        assert_eq!(named("tendon2-hall"), Ok("tendon2-hall".to_owned()));
        assert_eq!(named("scenes/p70-rigid.toml"), Ok("p70-rigid".to_owned()));
        let error = named("p71").expect_err("refused");
        assert!(error.contains("p71") && error.contains("p70"), "{error}");
    }
}
