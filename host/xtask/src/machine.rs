//! Installs what the machine lacks: the project's two commands must do all the set-up on a fresh Debian
//! machine that has rustup, and say clearly what to install elsewhere.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::process::{Failure, Outcome, cargo, output, step};

/// The chip's architecture: Cortex-M4 with single-precision floating point.
pub const THUMB: &str = "thumbv7em-none-eabihf";

/// Debian's compiler and its source, new enough for this project, for where rustup cannot bring the target.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CORE: &str = "/usr/lib/rustlib/src/rust/library/core/src/lib.rs";

/// The compiler that builds the firmware.
pub enum Toolchain {
    /// The toolchain in use has the target's core library.
    Rustup,
    /// Debian's compiler; the core library is built from its source.
    Debian {
        /// Linker to name to it.
        linker: PathBuf,
    },
}

/// The compiler that rustup brought when images were built and measured last.
const TRIED: &str = "1.95.0";

/// Finds or gets a compiler for the chip. `PALPATE_TOOLCHAIN=rustup` or `debian` forces one.
pub fn firmware_toolchain() -> Outcome<Toolchain> {
    match std::env::var("PALPATE_TOOLCHAIN").as_deref() {
        Ok("debian") => return debian_toolchain(),
        Ok("rustup") if has_thumb_target() || add_thumb_target() => return Ok(Toolchain::Rustup),
        Ok("rustup") => {
            return Err(Failure::new(format!(
                "rustup cannot add the target {THUMB} here"
            )));
        }
        Ok(other) => {
            return Err(Failure::usage(format!(
                "PALPATE_TOOLCHAIN is '{other}'; it may be 'rustup' or 'debian'"
            )));
        }
        Err(_) => {}
    }
    if has_thumb_target() || (!has_debian_toolchain() && add_thumb_target()) {
        return Ok(Toolchain::Rustup);
    }
    debian_toolchain()
}

/// What to do where the chip's image does not build with a compiler that nobody has tried: the options of `.cargo/config.toml` are
/// LLVM's own, and the image just fits. Nothing with the one that was tried.
pub fn hint(toolchain: &Toolchain) -> String {
    let version = output("rustc", &["--version"]).unwrap_or_default();
    match toolchain {
        Toolchain::Rustup => hint_for(&version),
        Toolchain::Debian { .. } => String::new(),
    }
}

fn hint_for(version: &str) -> String {
    if version.split_whitespace().nth(1) == Some(TRIED) {
        return String::new();
    }
    format!(
        "\n{version} was not tried. If it refuses an option, or the image no longer fits: rustup toolchain install {TRIED} --target \
         {THUMB}, then RUSTUP_TOOLCHAIN={TRIED} in front of the command"
    )
}

fn sysroot() -> Option<PathBuf> {
    output("rustc", &["--print", "sysroot"]).map(PathBuf::from)
}

fn has_thumb_target() -> bool {
    sysroot().is_some_and(|sysroot| sysroot.join("lib/rustlib").join(THUMB).join("lib").is_dir())
}

fn add_thumb_target() -> bool {
    eprintln!("==> rustup target add {THUMB}");
    let added = Command::new("rustup")
        .args(["target", "add", THUMB])
        .stdin(Stdio::null())
        .status();
    matches!(added, Ok(status) if status.success()) && has_thumb_target()
}

fn has_debian_toolchain() -> bool {
    Path::new(DEBIAN_RUSTC).exists() && Path::new(DEBIAN_CORE).exists()
}

fn debian_toolchain() -> Outcome<Toolchain> {
    let mut packages = Vec::new();
    if !has_debian_toolchain() {
        packages.extend(["rustc-web", "rust-web-src"]);
    }
    if linker().is_none() {
        packages.push("lld");
    }
    install(&packages, "a compiler for the chip")?;
    match linker() {
        Some(linker) if has_debian_toolchain() => Ok(Toolchain::Debian { linker }),
        _ => Err(Failure::new(format!(
            "no compiler for the chip: install the Rust target {THUMB} (rustup target add {THUMB})"
        ))),
    }
}

/// rustup brings rust-lld in a folder that is not on the path; Debian's lld is the same linker.
fn linker() -> Option<PathBuf> {
    let host = output("rustc", &["-vV"])?
        .lines()
        .find_map(|line| line.strip_prefix("host: ").map(str::to_owned))?;
    let rust_lld = sysroot()?
        .join("lib/rustlib")
        .join(host)
        .join("bin/rust-lld");
    if rust_lld.exists() {
        Some(rust_lld)
    } else {
        find("ld.lld")
    }
}

/// Where the sources of other crates and of the core library lie. A panic tells its file: with these folders in front of it
/// the image would be larger, and another one on every machine.
pub fn source_folders(toolchain: &Toolchain) -> Vec<PathBuf> {
    let mut folders = registries();
    let library = match toolchain {
        Toolchain::Rustup => sysroot().map(|sysroot| sysroot.join("lib/rustlib/src/rust/library")),
        Toolchain::Debian { .. } => Path::new(DEBIAN_CORE)
            .ancestors()
            .nth(3)
            .map(Path::to_path_buf),
    };
    folders.extend(library);
    // Ending in a separator, which is to go as well.
    folders.iter().map(|folder| folder.join("")).collect()
}

/// Folders of unpacked crates, one for each registry in use.
fn registries() -> Vec<PathBuf> {
    let cargo_home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let entries = cargo_home.and_then(|home| std::fs::read_dir(home.join("registry/src")).ok());
    let mut folders: Vec<PathBuf> = entries
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    folders.sort();
    folders
}

/// On a fresh machine, unpacks the crates: only then is it known where they lie.
pub fn fetch_sources() -> Outcome {
    if !registries().is_empty() {
        return Ok(());
    }
    step("fetching crates", &mut cargo(["fetch"]))
}

/// Debian's clippy for the target, where Debian's compiler builds the firmware.
pub fn debian_clippy() -> Outcome<PathBuf> {
    let driver = PathBuf::from("/usr/bin/clippy-driver");
    if !driver.exists() {
        install(&["rust-web-clippy"], "lints for the chip's code")?;
    }
    Ok(driver)
}

/// What host programs need to link: a C compiler.
pub fn emulator_packages() -> Outcome {
    let missing = find("cc").is_none().then_some("gcc");
    install(missing.as_slice(), "linking host programs")
}

/// A program on the path.
pub fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// Where an installer tells how far it is: on a terminal, and not on the output of a command that asked for it.
pub fn progress() -> Stdio {
    if std::io::stderr().is_terminal() {
        Stdio::from(std::io::stderr())
    } else {
        Stdio::null()
    }
}

/// Installs Debian packages; elsewhere says what to install and stops.
pub fn install(packages: &[&str], purpose: &str) -> Outcome {
    if packages.is_empty() {
        return Ok(());
    }
    let list = packages.join(" ");
    if find("apt-get").is_none() {
        return Err(Failure::new(format!(
            "this machine lacks what {purpose} needs; install the equivalent of these Debian packages: {list}"
        )));
    }
    let is_root = output("id", &["-u"]).as_deref() == Some("0");
    if !is_root && find("sudo").is_none() {
        return Err(Failure::new(format!(
            "{purpose} needs: apt-get install {list} (as root)"
        )));
    }
    let prefix: &[&str] = if is_root { &[] } else { &["sudo"] };
    for call in [
        &["apt-get", "update"][..],
        &[
            &["apt-get", "install", "-y", "--no-install-recommends"],
            packages,
        ]
        .concat(),
    ] {
        let words: Vec<&str> = prefix.iter().chain(call).copied().collect();
        eprintln!("==> {}  (for {purpose})", words.join(" "));
        let status = Command::new(words[0])
            .args(&words[1..])
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdout(progress())
            .status();
        if !matches!(status, Ok(status) if status.success()) {
            return Err(Failure::new(format!(
                "'{}' failed; {purpose} needs: {list}",
                words.join(" ")
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compiler_that_was_not_tried_is_named() {
        assert_eq!(
            hint_for(&format!("rustc {TRIED} (59807616e 2026-04-14)")),
            ""
        );
        for version in ["rustc 1.99.0 (0 2027-01-01)", "rustc 1.95.1-nightly", ""] {
            let hint = hint_for(version);
            assert!(hint.contains(version) && hint.contains("RUSTUP_TOOLCHAIN=1.95.0"));
        }
    }
}
