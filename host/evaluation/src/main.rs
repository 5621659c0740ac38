//! `experiments`, `replay` and `figures`, called by `cargo xtask`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use palpate_evaluation::experiments::{
    ablation, catalogue, effects, following, job, joint_sensor, result, run, sensitivity,
    soft_objects,
};
use palpate_evaluation::{false_contacts, recordings};
use palpate_plant::{Engine, ObjectMount, World};

mod figures_command;
mod replay_command;
mod scene;
mod studies;
mod written;

type Outcome = Result<(), Box<dyn Error>>;

#[derive(Parser)]
#[command(
    name = "palpate-evaluation",
    bin_name = "cargo xtask",
    about = "Experiments, recordings and figures (simulated)"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The paper's experiments, ours next to the paper's algorithm.
    #[command(
        after_help = "Examples:\n  cargo xtask experiments --quick --only distal\n  cargo xtask experiments --world workshop --engine mujoco"
    )]
    Experiments(Experiments),
    /// The sensing on a recording.
    #[command(
        after_help = "Examples:\n  cargo xtask replay grasp.csv --html grasp.html\n  cargo xtask replay grasp.csv --friction free.csv --calibrate press.csv --calibrate pin.csv@40"
    )]
    Replay(replay_command::Options),
    /// The sensing on a folder of recordings whose truth is known.
    #[command(after_help = "Example:\n  cargo xtask recordings FOLDER --uncalibrated --only w0")]
    Recordings(Recordings),
    /// What each choice of the setting `sensitivity` costs: false contacts in free closings against delay.
    #[command(
        after_help = "Example:\n  cargo xtask false-contacts --world workshop --closings 200"
    )]
    FalseContacts(FalseContacts),
    /// Print the completions of a shell.
    #[command(hide = true)]
    Completions {
        /// Shell.
        shell: palpate_cli::Shell,
    },
    /// Draw the figures as SVG.
    #[command(after_help = "Example:\n  cargo xtask figures docs/figures")]
    Figures(figures_command::Options),
}

#[derive(Args)]
struct Experiments {
    /// One JSON object a line instead of a table.
    #[arg(long)]
    json: bool,
    /// The simulated world: ideal, bench, workshop, harsh, or a file (TOML, as host/plant/default.toml).
    #[arg(long, default_value = "ideal", alias = "plant")]
    world: String,
    /// What computes finger and object: plant, or mujoco.
    #[arg(long)]
    engine: Option<Engine>,
    /// How objects are held: fixed, spring or free, the last with the engine mujoco; the world says the rest.
    #[arg(long)]
    mount: Option<ObjectMount>,
    /// Seed of everything that is drawn at random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A tenth of the free closings, a quarter of the random ones.
    #[arg(long)]
    quick: bool,
    /// Only the experiments whose name begins so.
    #[arg(long, conflicts_with = "write")]
    only: Option<String>,
    /// Write the tables into docs/RESULTS.md and README.md.
    #[arg(long, conflicts_with_all = ["world", "mount", "json"])]
    write: bool,
}

#[derive(Args)]
struct FalseContacts {
    /// A simulated world: ideal, bench, workshop, harsh, or a file; may be given several times. All four without it.
    #[arg(long)]
    world: Vec<String>,
    /// What computes finger and object: plant, or mujoco.
    #[arg(long)]
    engine: Option<Engine>,
    /// The finger: one of scenes/*.toml, by name or file.
    #[arg(long, default_value = palpate_scenes::NAMES[0], value_parser = scene::named)]
    scene: String,
    /// Free closings in each world, at least one.
    #[arg(long, default_value_t = 1000, value_parser = palpate_cli::at_least_one)]
    closings: usize,
    /// Contacts of each finger on the first phalanx that can touch, and on the last; 0 for free closings alone.
    #[arg(long, default_value_t = false_contacts::CONTACTS)]
    contacts: usize,
    /// Seed of everything that is drawn at random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object a line instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct Recordings {
    /// Folder with NAME.csv.gz and NAME.json; names begin with their world and an underscore.
    directory: PathBuf,
    /// The finger of the recordings: one of scenes/*.toml, by name or file.
    #[arg(long, default_value = palpate_scenes::NAMES[0], value_parser = scene::named)]
    scene: String,
    /// Without calibration; what calibrates is left out.
    #[arg(long)]
    uncalibrated: bool,
    /// A scale stands under the pins that calibrate: what it reads sets `force-scale`
    #[arg(long, conflicts_with = "uncalibrated")]
    scale: bool,
    /// Only recordings with this in their name (what calibrates them is replayed all the same).
    #[arg(long)]
    only: Option<String>,
    /// One JSON object a line instead of a table.
    #[arg(long)]
    json: bool,
}

fn plan(
    world: &str,
    engine: Option<Engine>,
    seed: u64,
    quick: bool,
) -> Result<job::Plan, Box<dyn Error>> {
    let mut found = World::named(world)?;
    found.engine = engine.unwrap_or(found.engine);
    Ok(job::Plan {
        parameters: found.of(palpate_plant::default_scene())?,
        place: result::Place {
            world: world.split('@').next().unwrap_or(world).to_owned(),
            engine: found.engine.to_string(),
        },
        world: found,
        seed,
        quick,
    })
}

fn recordings(options: &Recordings) -> Outcome {
    let plan = recordings::Plan {
        directory: options.directory.clone(),
        only: options.only.clone(),
        uncalibrated: options.uncalibrated,
        scale: options.scale,
    };
    let worlds = recordings::run(&options.scene, &plan)?;
    if options.json {
        for line in recordings::json(&worlds) {
            println!("{line}");
        }
    } else {
        print!("{}", recordings::text(&worlds));
    }
    Ok(())
}

fn false_contacts(options: &FalseContacts) -> Outcome {
    let worlds: Vec<&str> = if options.world.is_empty() {
        palpate_plant::world_names().collect()
    } else {
        options.world.iter().map(String::as_str).collect()
    };
    let mut all = Vec::new();
    for world in worlds {
        let plan = plan(world, options.engine, options.seed, false)?;
        let (closings, contacts) = (options.closings, options.contacts);
        let (rows, failed) = false_contacts::study(&plan, &options.scene, closings, contacts)
            .ok_or_else(|| format!("there is no scene '{}'", options.scene))?;
        for (seed, failure) in failed {
            eprintln!("{world}, finger of seed {seed}: {failure}");
        }
        all.extend(rows);
    }
    if options.json {
        for row in &all {
            println!("{}", serde_json::to_string(row)?);
        }
    } else {
        print!("{}", false_contacts::markdown(&all));
    }
    Ok(())
}

/// All that a plan can do.
fn everything(plan: &job::Plan) -> Vec<job::Job> {
    let all = [
        catalogue::all(plan),
        ablation::ablation(plan),
        sensitivity::sensitivity(plan),
        effects::effects(plan),
    ];
    all.into_iter().flatten().collect()
}

fn rows(plan: &job::Plan, jobs: &[job::Job]) -> (Vec<result::Row>, Vec<run::Incomplete>) {
    let (entries, failed) = run::jobs(jobs);
    (run::rows(&plan.place, &entries), failed)
}

fn experiments(options: &Experiments) -> Outcome {
    if options.write {
        return written::write(options.seed, options.quick);
    }
    let mut plan = plan(&options.world, options.engine, options.seed, options.quick)?;
    if options.mount.is_some() {
        plan.world.mount = options.mount;
        plan.parameters = plan.of(palpate_plant::default_scene())?;
    }
    let mut jobs = everything(&plan);
    if let Some(begins) = &options.only {
        studies::begins_a_name(&jobs, begins)?;
        jobs.retain(|job| job.name.starts_with(begins));
    }
    let (rows, failed) = rows(&plan, &jobs);
    if options.json {
        for row in &rows {
            println!("{}", row.json());
        }
    } else {
        println!("{}", result::markdown(&rows));
    }
    // What the simulated firmware refused or could not end is printed next to the table; the rest is valid.
    for job in &failed {
        let reason = job.failure.to_string();
        if options.json {
            let failure =
                serde_json::json!({"type": "failure", "experiment": job.name, "reason": reason});
            println!("{failure}");
        } else {
            eprintln!("{}: {reason}", job.name);
        }
    }
    let is_wanted = |study: &str| match &options.only {
        Some(name) => study.starts_with(name.as_str()),
        None => true,
    };
    let [changes, second_contacts] = following::NAMES.map(is_wanted);
    let soft = is_wanted(soft_objects::NAME);
    let joint = is_wanted(joint_sensor::NAME);
    if is_wanted(studies::CALIBRATION) {
        studies::calibration(&plan, options.json);
    } else if rows.is_empty() && !changes && !second_contacts && !soft && !joint {
        return Err("no experiment ran: does the world suit the finger?".into());
    }
    if changes {
        studies::changes(&plan, options.json);
    }
    if second_contacts {
        studies::second_contacts(&plan, options.json);
    }
    if soft {
        studies::soft_objects(&plan, options.json);
    }
    if joint {
        studies::joint_sensor(&plan, options.json);
    }
    Ok(())
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Experiments(options) => experiments(&options),
        Command::Replay(options) => replay_command::run(&options),
        Command::Recordings(options) => recordings(&options),
        Command::FalseContacts(options) => false_contacts(&options),
        Command::Figures(options) => figures_command::run(&options),
        Command::Completions { shell } => {
            palpate_cli::complete::<Arguments>(shell);
            Ok(())
        }
    };
    palpate_cli::end(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_calls_tell_what_there_is() {
        let call = ["palpate-evaluation", "false-contacts", "--closings", "0"];
        let Err(refused) = Arguments::try_parse_from(call) else {
            panic!("no closing at all");
        };
        assert!(refused.to_string().contains("from 1 on"), "{refused}");
        let call = ["palpate-evaluation", "experiments", "--only", "nope"];
        let Ok(Arguments {
            command: Command::Experiments(options),
        }) = Arguments::try_parse_from(call)
        else {
            panic!("a sound call");
        };
        let told = experiments(&options).expect_err("none").to_string();
        for name in ["nope", "distal", "calibration", "joint sensor"] {
            assert!(told.contains(name), "{told}");
        }
    }

    #[test]
    fn every_command_has_examples_in_its_help() {
        assert_eq!(palpate_cli::without_example::<Arguments>(), [""; 0]);
    }
}
