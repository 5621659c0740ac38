//! The live view, recordings and pages: programs that read what the firmware says.

use crate::commands::take;
use crate::emulator;
use crate::firmware::Build;
use crate::mujoco;
use crate::process::{Outcome, run, target_dir};

const PACKAGE: &str = "palpate-monitor";

/// `monitor`: the finger, live in the terminal.
pub fn monitor(arguments: &[String]) -> Outcome {
    live("watch", arguments)
}

/// `record`: samples into a file.
pub fn record(arguments: &[String]) -> Outcome {
    live("record", arguments)
}

/// Builds what the source needs and hands over.
fn live(subcommand: &str, arguments: &[String]) -> Outcome {
    let mut words = vec![subcommand.to_owned()];
    let help = arguments
        .iter()
        .any(|word| matches!(word.as_str(), "--help" | "-h"));
    let from = take(&mut arguments.to_vec(), "--from")?.unwrap_or_else(|| "sim".to_owned());
    let simulated = matches!(from.as_str(), "sim" | "emulator");
    if !help && (simulated || from == "probe") {
        let build = Build {
            scene: take(&mut arguments.to_vec(), "--scene")?,
            ..Build::default()
        };
        words.extend(["--elf".to_owned(), build.elf()?.display().to_string()]);
    }
    let library = mujoco::wanted(arguments)?;
    if !help && simulated {
        emulator::build(library.as_deref())?;
        let program = target_dir().join("host").join("palpate-emulator");
        words.extend(["--emulator".to_owned(), program.display().to_string()]);
    }
    words.extend_from_slice(arguments);
    let mut command = crate::commands::host_program(PACKAGE, &words);
    if let Some(folder) = &library {
        mujoco::link(&mut command, folder);
    }
    run(&mut command)
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
    let events = target_dir().join(format!("page-{}.jsonl", std::process::id()));
    let events_text = events.display().to_string();
    arguments.extend(["--events".to_owned(), events_text.clone()]);
    // A grasp that ends in a fault is worth a page as well.
    let outcome = command(arguments);
    let words = ["page", &events_text, "--out", &page, "--title", title].map(str::to_owned);
    let written = run(&mut crate::commands::host_program(PACKAGE, &words));
    // One that cannot be removed lies in the folder of build products.
    let _ = std::fs::remove_file(&events);
    outcome.and(written)
}
