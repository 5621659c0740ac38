//! Embeds the values of every scene, merged with base and defaults and checked.

#[path = "../../build/scene/mod.rs"]
#[expect(dead_code, reason = "the reader serves other build scripts as well")]
mod scene;

use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=../../build/scene");
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let scenes = match scene::load_all(&Path::new(&root).join("../..")) {
        Ok(scenes) => scenes,
        Err(error) => {
            println!("cargo::error={error}");
            return;
        }
    };
    let each: Vec<(&str, String)> = scenes
        .iter()
        .map(|scene| (scene.name.as_str(), scene.values.to_string()))
        .collect();
    let text = format!(
        "/// Name and values of every scene, the default one first.\nconst SCENES: &[(&str, &str)] = &{each:#?};\n"
    );
    let out = env::var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("scenes.rs"), text).expect("OUT_DIR can be written");
}
