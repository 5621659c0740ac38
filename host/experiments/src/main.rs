//! `experiments`, `replay` and `figures`, called by `cargo xtask`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use palpate_experiments::experiments::{catalogue, result, run};
use palpate_experiments::figures;
use palpate_plant::Parameters;

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[derive(Parser)]
#[command(
    name = "palpate-experiments",
    about = "Experiments, recordings and figures (simulated)"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The paper's experiments, ours beside the paper's algorithm.
    Experiments(Experiments),
    /// Draw the figures as SVG and PNG.
    Figures {
        /// Where to.
        #[arg(default_value = "docs/figures")]
        directory: PathBuf,
    },
}

#[derive(Args)]
struct Experiments {
    /// One JSON object a line instead of a table.
    #[arg(long)]
    json: bool,
    /// Parameters of the simulated world (TOML, as host/plant/default.toml).
    #[arg(long)]
    plant: Option<PathBuf>,
    /// Everything random follows from it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A tenth of the free and of the random closings.
    #[arg(long)]
    quick: bool,
}

fn parameters(file: Option<&PathBuf>) -> Result<Parameters, Box<dyn std::error::Error>> {
    match file {
        None => Ok(Parameters::default()),
        Some(file) => {
            let text = std::fs::read_to_string(file)
                .map_err(|error| format!("{}: {error}", file.display()))?;
            Parameters::from_toml(&text)
                .map_err(|error| format!("{}: {error}", file.display()).into())
        }
    }
}

fn experiments(options: &Experiments) -> Outcome {
    let plan = catalogue::Plan {
        parameters: parameters(options.plant.as_ref())?,
        seed: options.seed,
        quick: options.quick,
    };
    let rows = run::rows(&run::jobs(&catalogue::all(&plan))?);
    if options.json {
        for row in &rows {
            println!("{}", serde_json::to_string(row)?);
        }
    } else {
        println!("{}", result::markdown(&rows));
    }
    Ok(())
}

fn figures(directory: &std::path::Path) -> Outcome {
    for (what, difference) in figures::mechanics(directory)? {
        println!("K_c, {what}: library f32 against f64 at most {difference:.1e} relative");
    }
    Ok(())
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Experiments(options) => experiments(&options),
        Command::Figures { directory } => figures(&directory),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
