//! Generates a type for every scene.

#[path = "../../build/generate/mod.rs"]
mod generate;
#[path = "../../build/scene/mod.rs"]
mod scene;

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=../../build");
    let root = Path::new("../..");
    scene::watch(root);
    match scene::load_all(root) {
        Ok(scenes) => {
            let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
            let text = generate::module(&scenes, "$crate");
            fs::write(out.join("scenes.rs"), text).expect("OUT_DIR can be written");
        }
        Err(error) => println!("cargo::error={error}"),
    }
}
