//! What each command does.

use std::path::PathBuf;

use crate::firmware::{Build, every_scene, list, scenes};
use crate::help;
use crate::host;
use crate::machine;
use crate::monitor;
use crate::new_scene;
use crate::process::{Failure, Outcome, root, run, step};
use crate::target;
use crate::tools;

/// Takes `--name VALUE` or `--name=VALUE` out of the arguments.
pub fn take(arguments: &mut Vec<String>, name: &str) -> Outcome<Option<String>> {
    let prefix = format!("{name}=");
    let Some(at) = arguments
        .iter()
        .position(|word| word == name || word.starts_with(&prefix))
    else {
        return Ok(None);
    };
    let word = arguments.remove(at);
    if let Some(value) = word.strip_prefix(&prefix) {
        return Ok(Some(value.to_owned()));
    }
    if at >= arguments.len() {
        return Err(Failure::usage(format!("{name} needs a value")));
    }
    Ok(Some(arguments.remove(at)))
}

/// `--scene NAME`, or what `PALPATE_SCENE` names.
pub fn scene(arguments: &mut Vec<String>) -> Outcome<Option<String>> {
    let given = take(arguments, "--scene")?.or_else(|| std::env::var("PALPATE_SCENE").ok());
    let Some(name) = given else {
        return Ok(None);
    };
    let known = scenes()?;
    if known.contains(&name) {
        return Ok(Some(name));
    }
    Err(Failure::usage(format!(
        "there is no scene '{name}'; there are: {}",
        known.join(", ")
    )))
}

/// The arguments with the scene that they or `PALPATE_SCENE` name, for a host program.
pub fn with_scene(arguments: &[String]) -> Outcome<Vec<String>> {
    let mut words = arguments.to_vec();
    if let Some(name) = scene(&mut words)? {
        words.push(format!("--scene={name}"));
    }
    Ok(words)
}

/// No argument is left over.
pub fn none_left(arguments: &[String]) -> Outcome {
    match arguments.first() {
        Some(word) => Err(Failure::usage(format!("unexpected '{word}'"))),
        None => Ok(()),
    }
}

/// Runs a host program.
pub fn host_program(package: &str, arguments: &[String]) -> Outcome {
    run(host::program(package, arguments)?.args(arguments))
}

/// Runs a subcommand of the program that has the experiments.
fn evaluate(subcommand: &str, arguments: &[String]) -> Outcome {
    let words = [&[subcommand.to_owned()], arguments].concat();
    host_program(host::EVALUATION, &words)
}

fn emulate(subcommand: &str, image: &Build, arguments: &[String]) -> Outcome {
    if help::asked(arguments) {
        // Without the image, which takes longer than the program.
        machine::emulator_packages()?;
        return run(host::program(host::EMULATOR, &[])?.args([subcommand, "--help"]));
    }
    run(host::emulator_of(image, subcommand, arguments)?.args(arguments))
}

/// `sim`: the product's main job without a board.
pub fn sim(arguments: &[String]) -> Outcome {
    let mut rest = arguments.to_vec();
    let scene = scene(&mut rest)?;
    let asks = |option: &str| rest.iter().any(|word| word.starts_with(option));
    let features: Vec<&str> = [
        ("--fault", "fault-injection"),
        ("--serial", monitor::SERIAL_LOG),
    ]
    .into_iter()
    .filter_map(|(option, feature)| asks(option).then_some(feature))
    .collect();
    let features = (!features.is_empty()).then(|| features.join(","));
    let build = Build {
        scene: scene.clone(),
        features,
        ..Build::default()
    };
    if let Some(scene) = scene {
        rest.extend(["--scene".to_owned(), scene]);
    }
    monitor::with_page(&mut rest, "A simulated grasp", |rest| {
        emulate("sim", &build, rest)
    })
}

/// The firmware that `[--scene S] [--features F]` asks for.
fn image(arguments: &[String]) -> Outcome<PathBuf> {
    let mut rest = arguments.to_vec();
    let build = Build {
        scene: scene(&mut rest)?,
        features: take(&mut rest, "--features")?,
        ..Build::default()
    };
    none_left(&rest)?;
    build.elf()
}

/// `build`: the ELF alone.
pub fn build(arguments: &[String]) -> Outcome {
    println!("{}", image(arguments)?.display());
    Ok(())
}

/// `flash`: onto a board, with its log.
pub fn flash(arguments: &[String]) -> Outcome {
    let elf = image(arguments)?;
    if machine::find("probe-rs").is_none() {
        return Err(Failure::new(format!(
            "the firmware is built ({}), but probe-rs is not installed: cargo install probe-rs-tools --locked",
            elf.display()
        )));
    }
    run(std::process::Command::new("probe-rs")
        .args(target::RUN)
        .arg(elf))
}

/// `new-scene`: a file for your own finger.
pub fn new_scene(arguments: &[String]) -> Outcome {
    let mut rest = arguments.to_vec();
    let from = take(&mut rest, "--from")?.unwrap_or_else(|| list::DEFAULT.to_owned());
    if rest.is_empty() {
        return Err(Failure::usage("new-scene needs a name"));
    }
    let name = rest.remove(0);
    none_left(&rest)?;
    new_scene::write(&name, &from)
}

/// `size`: what each scene costs.
pub fn size(arguments: &[String]) -> Outcome {
    none_left(arguments)?;
    sizes(&every_scene()?)
}

/// What images of scenes take.
pub fn sizes(images: &[(String, PathBuf)]) -> Outcome {
    let mut words = vec!["size".to_owned()];
    for (scene, elf) in images {
        words.push(format!("{scene}={}", elf.display()));
    }
    host_program("palpate-report", &words)
}

/// `golden`: the library against reference files; with `--generator` the files against their own generator.
pub fn golden(arguments: &[String]) -> Outcome {
    if let Some((first, rest)) = arguments.split_first()
        && first == "--generator"
    {
        return host_program("palpate-golden", &generator(rest));
    }
    let words = [&["golden".to_owned()], arguments].concat();
    host_program("palpate-report", &words)
}

/// The arguments of the generator, with the folder of the project's reference files where the user names none.
fn generator(arguments: &[String]) -> Vec<String> {
    let mut words = arguments.to_vec();
    if !words.iter().any(|word| word.starts_with("--directory")) {
        let usual = root().join("tests/data/golden");
        words.push(format!("--directory={}", usual.display()));
    }
    words
}

/// `faults`: every fault into the running firmware.
pub fn faults(arguments: &[String]) -> Outcome {
    let mut rest = arguments.to_vec();
    let scene = scene(&mut rest)?;
    let build = Build {
        scene: scene.clone(),
        features: Some("fault-injection".to_owned()),
        ..Build::default()
    };
    if let Some(scene) = scene {
        rest.extend(["--scene".to_owned(), scene]);
    }
    emulate("faults", &build, &rest)
}

/// `experiments`: the paper's work again.
pub fn experiments(arguments: &[String]) -> Outcome {
    let mut words = arguments.to_vec();
    if words.iter().any(|word| word == "--write") {
        // The documents show both engines.
        words.push("--engine=mujoco".to_owned());
    }
    evaluate("experiments", &words)
}

/// `replay`: a recorded trace.
pub fn replay(arguments: &[String]) -> Outcome {
    monitor::with_page(&mut arguments.to_vec(), "A recorded grasp", |rest| {
        evaluate("replay", &with_scene(rest)?)
    })
}

/// `recordings`: a folder of them, with their truth.
pub fn recordings(arguments: &[String]) -> Outcome {
    evaluate("recordings", &with_scene(arguments)?)
}

/// `false-contacts`: what each choice of the sensitivity costs.
pub fn false_contacts(arguments: &[String]) -> Outcome {
    evaluate("false-contacts", &with_scene(arguments)?)
}

/// `figures`: pictures of the above.
pub fn figures(arguments: &[String]) -> Outcome {
    evaluate("figures", arguments)
}

/// `setup`: get what is lacking, and nothing else.
pub fn setup(arguments: &[String]) -> Outcome {
    none_left(arguments)?;
    machine::emulator_packages()?;
    machine::firmware_toolchain()?;
    tools::get();
    println!("this machine has what the firmware and the emulator need");
    Ok(())
}

/// Proves of images that their control interrupt cannot panic, allocate or log.
pub fn reach(images: &[PathBuf]) -> Outcome {
    step(
        "what the control interrupt can reach",
        host::program("palpate-reach", &[])?.args(images),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::words;

    #[test]
    fn an_option_is_taken_in_both_spellings_and_the_rest_is_left() {
        for call in ["--json --scene p70 --seed 3", "--json --scene=p70 --seed 3"] {
            let mut rest = words(call);
            assert_eq!(scene(&mut rest).ok().flatten().as_deref(), Some("p70"));
            assert_eq!(rest, words("--json --seed 3"));
        }
    }

    #[test]
    fn reference_files_are_the_project_s_unless_others_are_named() {
        let usual = generator(&words("--rows 3"));
        let folder = usual[2].strip_prefix("--directory=").expect("a folder");
        assert!(
            std::path::Path::new(folder)
                .join("contact_2L.csv")
                .is_file()
        );
        for own in ["--directory DIR --all", "--all --directory=DIR"] {
            assert_eq!(generator(&words(own)), words(own));
        }
    }

    #[test]
    fn a_wrong_call_is_refused_with_status_2() {
        let unknown = scene(&mut words("--scene p71")).expect_err("refused");
        assert_eq!(unknown.code, 2);
        assert!(unknown.message.contains("p71") && unknown.message.contains("p70"));
        assert_eq!(
            take(&mut words("--scene"), "--scene")
                .err()
                .map(|failure| failure.code),
            Some(2)
        );
        assert_eq!(
            none_left(&words("what")).err().map(|failure| failure.code),
            Some(2)
        );
    }
}
