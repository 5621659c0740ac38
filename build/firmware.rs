//! What the firmware needs of its build: the memory layout, and the type of the scene that `PALPATE_SCENE` names.

use std::path::{Path, PathBuf};
use std::{env, fs};

use crate::generate;
use crate::scene::{self, Error};

pub fn prepare() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-env-changed=PALPATE_SCENE");
    println!("cargo::rerun-if-changed=memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        fs::copy("memory.x", out.join("memory.x")).expect("memory.x can be copied to OUT_DIR");
        // For the firmware alone: who depends on the library brings a memory layout of their own.
        println!("cargo::rustc-link-arg-bins=-L{}", out.display());
    }
    let root = Path::new(".");
    scene::watch(root);
    let folder = scene::list::folder(root);
    let name = env::var("PALPATE_SCENE").unwrap_or_else(|_| scene::list::DEFAULT.to_owned());
    match scene::load(&folder, &name) {
        Ok(scene) => {
            // Tasks keep the states of what they never await, too: a constant cannot leave them out.
            println!("cargo::rustc-check-cfg=cfg(identify)");
            if scene.flag("identify.fitted") {
                println!("cargo::rustc-cfg=identify");
            }
            if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
                // A firmware whose finger states no weight has no settings of it.
                if !scene.has("finger.mass_kg") {
                    println!("cargo::rustc-cfg=weightless");
                }
                // Where its pins may be. Whole millimetres; what rounding has left of the last one counts.
                let length_m = scene.list("finger.length_m").last().copied();
                let length_mm = (1e3 * length_m.unwrap_or_default() + 1e-3) as u32;
                println!("cargo::rustc-env=PALPATE_LAST_PHALANX_MM={length_mm}");
            }
            let active = generate::type_name(&name);
            let text = format!(
                "{}\n/// The scene that this firmware is built for.\npub type Active = {active};\n",
                generate::rust(&scene)
            );
            fs::write(out.join("active.rs"), text).expect("OUT_DIR can be written");
        }
        Err(error) => println!("cargo::error={error}"),
    }
    fs::write(out.join("scenes.rs"), every_scene(root)).expect("OUT_DIR can be written");
}

/// All scenes, for the library's own tests. A file that is wrong stops those tests, and no firmware but its own.
fn every_scene(root: &Path) -> String {
    let all = || -> Result<String, Error> {
        Ok(generate::module(&scene::load_all(root)?, "$crate::scene"))
    };
    all().unwrap_or_else(|error| format!("compile_error!({:?});", error.to_string()))
}
