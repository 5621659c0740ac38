//! Does what a new user does: makes a finger, by the commands of the manual and without opening a Rust file.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::list;
use crate::host;
use crate::mujoco;
use crate::own_scene;
use crate::process::{Failure, Outcome, root, step, target_dir};

const NAME: &str = "own";
/// The finger: keys of the copied file with the values that its user gives them.
const FINGER: &[(&str, &str)] = &[
    ("length_m", "[0.080, 0.060]"),
    ("driving_m", "[0.052]"),
    ("coupler_m", "[0.092]"),
    ("driven_m", "[0.027]"),
];
/// What a hurried user writes for the first of them.
const MILLIMETRES: &str = "[80, 60]";
/// Where it meets the object, and how far from there it may be located.
const CONTACT_MM: f64 = 25.0;
const TOLERANCE_MM: f64 = 6.0;

/// A folder of scenes that is gone when this goes.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Makes a finger, refuses a wrong value of it, builds its firmware, simulates it, and replays the recording of that; a page about
/// each.
pub fn check() -> Outcome {
    eprintln!(
        "==> a new user's finger: new scene, wrong value, firmware, simulation, replay, pages"
    );
    let folder = Folder(target_dir().join("own-finger"));
    prepare(&folder.0)?;
    let call = |words: &[&str]| Call::new(&folder.0, words);

    call(&["new-scene", NAME, "--from", list::DEFAULT]).succeeds()?;
    let file = folder.0.join(format!("{NAME}.toml"));
    for &(key, value) in FINGER {
        set(&file, key, value)?;
    }
    programs(&folder.0)?;
    let build = call(&["build", "--scene", NAME]);
    refuses_a_wrong_value(&file, &build)?;
    build.succeeds()?;

    let [trace, page] = ["recording.csv", "page.html"].map(|name| folder.0.join(name));
    let (trace, contact) = (trace.to_string_lossy(), CONTACT_MM.to_string());
    let html = ["--html", &page.to_string_lossy()];
    let at = ["--contact-mm", &contact, "--json", "--trace", &trace];
    let simulated = call(&[&["sim", "--scene", NAME], &at[..], &html].concat());
    is_located("the simulation", &simulated.succeeds()?)?;
    is_page(&page, "The truth is phalanx 2")?;
    let replayed = call(&[&["replay", &trace, "--scene", NAME, "--json"], &html[..]].concat());
    is_located("the replay of its recording", &replayed.succeeds()?)?;
    is_page(&page, "<td>located</td>")
}

/// Builds in one call the programs that the commands would build one after the other: each has parts that keep one core busy alone.
fn programs(scenes: &Path) -> Outcome {
    let library = mujoco::library_if_possible();
    let mut build = host::workspace("build", library.as_deref());
    build.env(list::VARIABLE, scenes);
    for program in [host::EMULATOR, host::EVALUATION] {
        build.args(["--bin", program]);
    }
    step("programs for a new user's finger", &mut build)
}

/// A page tells the contact with its pictures, and something that only this one has; it is gone then, so that it cannot stand for the
/// next.
fn is_page(file: &Path, own: &str) -> Outcome {
    let failed = |what: String| Failure::new(format!("{}: {what}", file.display()));
    let html = std::fs::read_to_string(file).map_err(|error| failed(error.to_string()))?;
    for part in [
        "<!doctype html>",
        "Contact on phalanx 2",
        "<svg",
        own,
        "</html>",
    ] {
        if !html.contains(part) {
            return Err(failed(format!("the page has no '{part}'")));
        }
    }
    std::fs::remove_file(file).map_err(|error| failed(error.to_string()))
}

/// A folder with the default scene and what all scenes share, so that a file of the user's is never touched.
fn prepare(folder: &Path) -> Outcome {
    if folder.exists() {
        let told = |error| Failure::new(format!("{}: {error}", folder.display()));
        std::fs::remove_dir_all(folder).map_err(told)?;
    }
    let default = format!("{}.toml", list::DEFAULT);
    own_scene::copy_folder(&root().join("scenes"), folder, |name| name == default)
}

/// Writes another value behind a key, as an editor would.
fn set(file: &Path, key: &str, value: &str) -> Outcome {
    let failed = |what: String| Failure::new(format!("{}: {what}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| failed(error.to_string()))?;
    let changed = with(&text, key, value).ok_or_else(|| failed(format!("there is no {key}")))?;
    std::fs::write(file, changed).map_err(|error| failed(error.to_string()))
}

fn with(text: &str, key: &str, value: &str) -> Option<String> {
    let is_its = |line: &&str| line.split_once('=').is_some_and(|(k, _)| k.trim() == key);
    let line = text.lines().find(is_its)?;
    Some(text.replacen(line, &format!("{key} = {value}"), 1))
}

/// A wrong value stops the build with key, value and range; the right one is put back.
fn refuses_a_wrong_value(file: &Path, build: &Call) -> Outcome {
    let (key, right) = FINGER[0];
    set(file, key, MILLIMETRES)?;
    let told = build.fails()?;
    for part in [NAME, "`finger.length_m[0]` = 80", "out of range, allowed"] {
        if !told.contains(part) {
            return Err(Failure::new(format!(
                "a wrong value stops the build without '{part}':\n{told}"
            )));
        }
    }
    set(file, key, right)
}

/// The last place that a run tells, as JSON lines, is that of the object.
fn is_located(what: &str, lines: &str) -> Outcome {
    let place = lines.lines().rev().find_map(|line| {
        let located = line.contains("\"name\":\"located\"");
        located.then(|| Some((number(line, "phalanx")?, number(line, "k_mm")?)))?
    });
    match place {
        Some((phalanx, k_mm)) if phalanx == 2.0 && (k_mm - CONTACT_MM).abs() <= TOLERANCE_MM => {
            Ok(())
        }
        other => Err(Failure::new(format!(
            "{what} tells phalanx and k_mm {other:?} for a contact at {CONTACT_MM} mm of phalanx 2:\n{lines}"
        ))),
    }
}

/// A number of a JSON line.
fn number(line: &str, key: &str) -> Option<f64> {
    let (_, rest) = line.split_once(&format!("\"{key}\":"))?;
    rest.split([',', '}']).next()?.trim().parse().ok()
}

/// A call of this program by its user.
struct Call {
    words: Vec<String>,
    scenes: PathBuf,
}

impl Call {
    fn new(scenes: &Path, words: &[&str]) -> Self {
        Self {
            words: words.iter().map(|&word| word.to_owned()).collect(),
            scenes: scenes.to_path_buf(),
        }
    }

    /// Whether it ends well, and what it prints to standard output and to standard error.
    fn run(&self) -> Outcome<(bool, String, String)> {
        eprintln!("    cargo xtask {}", self.words.join(" "));
        let output = std::env::current_exe()
            .and_then(|program| {
                Command::new(program)
                    .args(&self.words)
                    .env(list::VARIABLE, &self.scenes)
                    .output()
            })
            .map_err(|error| Failure::new(format!("cannot start xtask: {error}")))?;
        let [out, told] = [output.stdout, output.stderr]
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        Ok((output.status.success(), out, told))
    }

    fn succeeds(&self) -> Outcome<String> {
        match self.run()? {
            (true, out, _) => Ok(out),
            (false, _, told) => Err(Failure::new(format!(
                "{} fails:\n{told}",
                self.words.join(" ")
            ))),
        }
    }

    fn fails(&self) -> Outcome<String> {
        match self.run()? {
            (false, _, told) => Ok(told),
            (true, out, _) => Err(Failure::new(format!(
                "{} does not fail:\n{out}",
                self.words.join(" ")
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_is_changed() {
        let text = "# length_m = 1\n[finger] # two\nlength_m = [0.09]\nlength_mm = 3\n";
        let changed = with(text, "length_m", "[0.08]").expect("a key");
        assert_eq!(
            changed,
            text.replace("length_m = [0.09]", "length_m = [0.08]")
        );
        assert_eq!(with(text, "width_m", "1"), None);
    }

    #[test]
    fn a_page_that_tells_nothing_is_none() {
        let file = std::env::temp_dir().join(format!("own-page-{}.html", std::process::id()));
        assert!(is_page(&file, "").is_err());
        let page = "<!doctype html>Contact on phalanx 2<svg>own</html>";
        std::fs::write(&file, page).expect("a temporary file");
        assert!(is_page(&file, "another").is_err());
        assert!(is_page(&file, "own").is_ok() && !file.exists());
    }

    #[test]
    fn a_place_far_from_the_object_is_none() {
        let line =
            |k: &str| format!("{{\"name\":\"located\",\"phalanx\":2,\"k_mm\":{k},\"x\":1}}\n{{}}");
        assert!(is_located("", &line("24.1")).is_ok());
        assert!(is_located("", &line("42.0")).is_err());
        assert!(is_located("", "{\"name\":\"touch\"}").is_err());
    }
}
