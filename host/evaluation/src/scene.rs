//! Scenes by name on the command line.

use std::str::FromStr;

use palpate::scene::{Linkage3, P70, P70Rigid, Scene, Tendon2, Tendon2Hall, Tendon3};

/// A scene that this program was built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneName {
    /// [`P70`].
    P70,
    /// [`P70Rigid`].
    P70Rigid,
    /// [`Tendon2`].
    Tendon2,
    /// [`Tendon2Hall`].
    Tendon2Hall,
    /// [`Tendon3`].
    Tendon3,
    /// [`Linkage3`].
    Linkage3,
}

const NAMES: [(&str, SceneName); 6] = [
    (P70::NAME, SceneName::P70),
    (P70Rigid::NAME, SceneName::P70Rigid),
    (Tendon2::NAME, SceneName::Tendon2),
    (Tendon2Hall::NAME, SceneName::Tendon2Hall),
    (Tendon3::NAME, SceneName::Tendon3),
    (Linkage3::NAME, SceneName::Linkage3),
];

impl FromStr for SceneName {
    type Err = String;

    /// By name, or by the file that it was built from.
    fn from_str(text: &str) -> Result<Self, String> {
        let file = std::path::Path::new(text);
        let name = if file.extension().is_some_and(|ending| ending == "toml") {
            file.file_stem().and_then(|stem| stem.to_str())
        } else {
            Some(text)
        };
        let known = NAMES.iter().find(|(known, _)| Some(*known) == name);
        known.map(|(_, scene)| *scene).ok_or_else(|| {
            let names: Vec<_> = NAMES.iter().map(|(name, _)| *name).collect();
            format!(
                "there is no scene '{text}'; there are: {}. A scene of your own is a file in scenes/, known after the next build",
                names.join(", ")
            )
        })
    }
}

/// Calls a function that is generic over the scene.
macro_rules! with_scene {
    ($name:expr, $function:path, $($argument:expr),+) => {{
        use palpate::scene::{Linkage3, P70, P70Rigid, Tendon2, Tendon2Hall, Tendon3};
        use $function as function;
        match $name {
            $crate::scene::SceneName::P70 => function::<P70>($($argument),+),
            $crate::scene::SceneName::P70Rigid => function::<P70Rigid>($($argument),+),
            $crate::scene::SceneName::Tendon2 => function::<Tendon2>($($argument),+),
            $crate::scene::SceneName::Tendon2Hall => function::<Tendon2Hall>($($argument),+),
            $crate::scene::SceneName::Tendon3 => function::<Tendon3>($($argument),+),
            $crate::scene::SceneName::Linkage3 => function::<Linkage3>($($argument),+),
        }
    }};
}

pub(crate) use with_scene;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_named_or_its_file_and_another_is_refused() {
        assert_eq!("tendon2-hall".parse(), Ok(SceneName::Tendon2Hall));
        assert_eq!("scenes/p70-rigid.toml".parse(), Ok(SceneName::P70Rigid));
        let error = "p71".parse::<SceneName>().expect_err("refused");
        assert!(error.contains("p71") && error.contains("p70"), "{error}");
    }
}
