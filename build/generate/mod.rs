//! Writes a scene as the Rust type that the library's `Scene` trait describes.
//!
//! What a scene does not have is chosen by type, so that it is not compiled in: a finger without a spring at joint 1, a
//! transmission, a cable, a joint sensor, what follows the first contact.

mod finger;
mod implementation;

use std::fmt::Write as _;

use crate::scene::Scene;
pub use implementation::rust;

/// Type of a scene: `p70-rigid` is `P70Rigid`.
pub fn type_name(scene: &str) -> String {
    let part = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    scene.split('-').map(part).collect()
}

/// Types of several scenes, their names, and macros that choose among them. `path` is where a macro can name the types.
pub fn module(scenes: &[Scene], path: &str) -> String {
    let mut text = String::new();
    let (mut arms, mut each) = (String::new(), String::new());
    for scene in scenes {
        let (name, of) = (&scene.name, type_name(&scene.name));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", rust(scene));
        let _ = writeln!(
            arms,
            "            {name:?} => {{ type $scene = {path}::{of}; ::core::option::Option::Some($body) }}"
        );
        let _ = writeln!(each, "        {{ type $scene = {path}::{of}; $body; }}");
    }
    let names: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    let _ = write!(
        text,
        "/// Names of the scenes, the default one first.
pub const NAMES: &[&str] = &{names:?};

/// Does something with the type of a scene that is known by its name: `for_scene!(name, |S| run::<S>())` is `Some` of what the
/// body gives, `None` where there is no such scene.
#[macro_export]
macro_rules! for_scene {{
    ($name:expr, |$scene:ident| $body:expr) => {{
        match $name {{
{arms}            _ => ::core::option::Option::None,
        }}
    }};
}}

/// Does something with the type of every scene: `for_each_scene!(|S| check::<S>())`.
#[macro_export]
macro_rules! for_each_scene {{
    (|$scene:ident| $body:expr) => {{{{
{each}    }}}};
}}
"
    );
    text
}

/// A number as the firmware has it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the firmware computes in single precision"
)]
fn literal(value: f64) -> String {
    format!("{:?}", value as f32)
}

fn list(values: &[f64]) -> String {
    let each: Vec<String> = values.iter().copied().map(literal).collect();
    format!("[{}]", each.join(", "))
}
