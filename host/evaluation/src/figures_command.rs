//! `figures`: the figures of the documents, as SVG.

use std::path::{Path, PathBuf};

use clap::Args;
use palpate_evaluation::experiments::{calibration, fingerprint, job};
use palpate_evaluation::figures;
use palpate_plant::Engine;

use super::{Outcome, plan};

/// Of the command line.
#[derive(Args)]
pub struct Options {
    /// Folder to write the figures into [default: docs/figures of the project].
    directory: Option<PathBuf>,
    /// The simulated world: ideal, bench, workshop, harsh, or a file.
    #[arg(long, default_value = "ideal", alias = "plant")]
    world: String,
    /// What computes finger and object: plant, or mujoco.
    #[arg(long)]
    engine: Option<Engine>,
    /// Seed of everything that is drawn at random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs the command.
///
/// # Errors
/// No such world, or a folder that cannot be written.
pub fn run(options: &Options) -> Outcome {
    let plan = plan(&options.world, options.engine, options.seed, false)?;
    let directory = options.directory.clone().unwrap_or_else(usual_figures);
    draw(&directory, &plan)
}

/// The folder of the project's figures, from where the user is if it lies below.
fn usual_figures() -> PathBuf {
    let root = fingerprint::root();
    let folder = root.canonicalize().unwrap_or(root).join("docs/figures");
    let here = std::env::current_dir().unwrap_or_default();
    match folder.strip_prefix(&here) {
        Ok(below) if below != Path::new("") => below.to_path_buf(),
        _ => folder,
    }
}

/// Draws the figures into a folder, which is made where it is missing.
fn draw(directory: &Path, plan: &job::Plan) -> Outcome {
    std::fs::create_dir_all(directory)
        .map_err(|error| palpate_cli::cannot_write(directory, &error))?;
    drawn(directory, plan).map_err(|error| format!("{}: {error}", directory.display()).into())
}

/// Draws the figures into a folder that is there.
fn drawn(directory: &Path, plan: &job::Plan) -> Outcome {
    let bar = palpate_cli::progress::bar(3, "groups of figures");
    for (what, difference) in figures::mechanics(directory)? {
        bar.suspend(|| {
            println!("K_c, {what}: library f32 against f64 at most {difference:.1e} relative");
        });
    }
    bar.inc(1);
    figures::simulated(directory, plan)?;
    bar.inc(1);
    let (study, failed) = bar.suspend(|| calibration::study(plan));
    for (seed, failure) in &failed {
        bar.suspend(|| eprintln!("calibration of finger {seed}: {failure}"));
    }
    figures::calibration(directory, &study)?;
    bar.finish_and_clear();
    println!("figures are in {}", directory.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever the call is made, here in the folder of this package.
    #[test]
    fn figures_are_the_project_s_unless_told() {
        let folder = usual_figures();
        assert!(folder.ends_with("docs/figures"), "{}", folder.display());
        assert!(folder.join("calibration.svg").is_file());
    }

    /// Before anything is computed, and with the folder's name.
    #[test]
    fn figures_name_a_folder_that_cannot_be() {
        let plan = plan("ideal", None, 1, true).expect("a world");
        let below_a_file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml/figures");
        let told = draw(&below_a_file, &plan).expect_err("none").to_string();
        for part in ["Cargo.toml/figures: ", "does the folder exist"] {
            assert!(told.contains(part), "{told}");
        }
    }
}
