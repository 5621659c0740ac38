//! The live view, recordings and pages: programs that read what the firmware says.

use std::fs::File;
use std::path::Path;

use crate::commands::{host_program, scene, take, with_scene};
use crate::firmware::{Build, list};
use crate::host;
use crate::machine;
use crate::process::{Failure, Outcome, run, target_dir};

const PACKAGE: &str = "palpate-monitor";

/// The firmware's feature that sends the log over the serial port.
pub const SERIAL_LOG: &str = "serial-log";

/// `monitor`: the finger, live in the terminal.
pub fn monitor(arguments: &[String]) -> Outcome {
    live("monitor", arguments)
}

/// `record`: samples into a file.
pub fn record(arguments: &[String]) -> Outcome {
    live("record", arguments)
}

/// Builds what the source needs and hands over.
fn live(subcommand: &str, arguments: &[String]) -> Outcome {
    let help = arguments
        .iter()
        .any(|word| matches!(word.as_str(), "--help" | "-h"));
    let from = take(&mut arguments.to_vec(), "--from")?.unwrap_or_else(|| "sim".to_owned());
    let simulated = matches!(from.as_str(), "sim" | "emulator");
    let serial = from.starts_with("/dev/") || from.starts_with("COM");
    let framed = serial || from == "probe" || from.starts_with("tcp:");
    let given = arguments.iter().any(|word| word.starts_with("--elf"));
    let mut image = None;
    if !help && !given && (simulated || framed) {
        let build = Build {
            scene: scene(&mut arguments.to_vec())?,
            // The image that sends its log there.
            features: serial.then(|| SERIAL_LOG.to_owned()),
            ..Build::default()
        };
        image = Some(build.elf()?);
    }
    let mut words = call(subcommand, image.as_deref(), arguments)?;
    if !help && simulated {
        machine::emulator_packages()?;
        let emulator = host::program(host::EMULATOR, arguments)?;
        let program = emulator.get_program().to_string_lossy().into_owned();
        words.splice(1..1, ["--emulator".to_owned(), program]);
    }
    let probe = (from == "probe").then_some("palpate-monitor/probe");
    run(host::program_with(PACKAGE, probe, arguments)?.args(words))
}

/// The program's call, with the image that was built and its scene, the default one too: a board that runs on does not name its own.
fn call(subcommand: &str, image: Option<&Path>, arguments: &[String]) -> Outcome<Vec<String>> {
    let mut words = vec![subcommand.to_owned()];
    if let Some(image) = image {
        words.extend(["--elf".to_owned(), image.display().to_string()]);
        if scene(&mut arguments.to_vec())?.is_none() {
            words.push(format!("--scene={}", list::DEFAULT));
        }
    }
    words.extend(with_scene(arguments)?);
    Ok(words)
}

/// Runs a command; with `--html FILE` it leaves its events, of which a page is made.
pub fn with_page(
    arguments: &mut Vec<String>,
    title: &str,
    command: impl FnOnce(&[String]) -> Outcome,
) -> Outcome {
    let Some(page) = take(arguments, "--html")? else {
        return command(arguments);
    };
    can_be_written(Path::new(&page))?;
    let events = target_dir().join(format!("page-{}.jsonl", std::process::id()));
    let events_text = events.display().to_string();
    arguments.extend(["--events".to_owned(), events_text.clone()]);
    // A grasp that ends in a fault is worth a page as well.
    let outcome = command(arguments);
    let words = ["page", &events_text, "--out", &page, "--title", title].map(str::to_owned);
    let written = host_program(PACKAGE, &words);
    // One that cannot be removed lies in the folder of build products.
    let _ = std::fs::remove_file(&events);
    outcome.and(written)
}

/// Finds out before a long run whether a file can be written after it. A file that is there stays, and one that was not is not left
/// behind.
pub fn can_be_written(path: &Path) -> Outcome {
    let tried = if path.exists() {
        File::options().append(true).open(path).map(drop)
    } else {
        File::create_new(path).and_then(|_| std::fs::remove_file(path))
    };
    tried.map_err(|error| cannot_write(path, &error))
}

/// A file or folder of the user's that cannot be written.
pub fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::usage(format!(
        "cannot write {}: {error}; does the folder exist, and may you write there?",
        path.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::words;

    /// Without a line from its start a board says nothing of its scene, and the monitor draws the one that it is called with.
    #[test]
    fn the_scene_of_an_image_that_is_built_is_named() {
        let image = Some(Path::new("palpate"));
        let scenes = |image, arguments: &str| {
            let words =
                call("monitor", image, &words(arguments)).map_err(|failure| failure.message);
            let words = words.expect("a call");
            let scenes = words.iter().filter(|word| word.starts_with("--scene"));
            scenes.cloned().collect::<Vec<_>>()
        };
        assert_eq!(scenes(image, "--from probe"), ["--scene=p70"]);
        assert_eq!(
            scenes(image, "--from probe --scene tendon2"),
            ["--scene=tendon2"]
        );
        assert!(scenes(None, "--from grasp.csv").is_empty());
    }

    #[test]
    fn a_page_that_cannot_be_written_is_refused_before_the_run() {
        let page = std::env::temp_dir().join(format!("palpate-page-{}.html", std::process::id()));
        let path = |page: &Path| ["--html".to_owned(), page.display().to_string()].to_vec();
        let refused = with_page(&mut path(&page.join("page.html")), "", |_| {
            panic!("it must not run")
        });
        let told = refused.expect_err("no such folder").message;
        assert!(told.contains("does the folder exist"), "{told}");
        assert!(can_be_written(&page).is_ok() && !page.exists());
        // Where the user is, here in the folder of this package: the root has no such folder.
        assert!(can_be_written(Path::new("src/wiring/page.html")).is_ok());
        std::fs::write(&page, "there").expect("a temporary file");
        assert!(can_be_written(&page).is_ok());
        let left = std::fs::read_to_string(&page).expect("still there");
        std::fs::remove_file(&page).expect("removed");
        assert_eq!(left, "there");
    }
}
