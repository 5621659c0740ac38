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
