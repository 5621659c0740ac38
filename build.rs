//! The firmware's memory layout and scene; nothing for the library alone.

#[cfg(feature = "firmware")]
#[path = "build/firmware.rs"]
mod firmware;

// `generate` and `firmware` find the reader of scenes here, as they do in the other build scripts that include it.
#[cfg(feature = "firmware")]
#[path = "build/scene/mod.rs"]
mod scene;

#[cfg(feature = "firmware")]
#[path = "build/generate/mod.rs"]
mod generate;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rustc-check-cfg=cfg(weightless)");
    #[cfg(feature = "firmware")]
    firmware::prepare();
}
