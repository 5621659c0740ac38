//! A folder of recordings with their truth, replayed by the product's own sensing, and scored.
//!
//! A world is one finger with its drivetrain; its recordings share the name up to the first underscore. In each world the
//! press and the pins calibrate first, then everything else is judged with that calibration.

pub mod protocol;
mod show;
mod truth;
mod world;

use std::path::{Path, PathBuf};

use palpate::sample::Sample;
use palpate_simulation::Simulated;
use rayon::prelude::*;

use palpate_cli::progress::bar;

use crate::trace;

pub use show::{json, text};
pub use truth::{Class, Truth};
pub use world::{Calibrated, Line, World};

/// Supply of the recordings' bridge, volt: the nominal voltage of the motor's winding. Duty times supply is the motor's voltage.
const SUPPLY_V: f64 = 12.0;

/// What is replayed, and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Folder with `NAME.csv.gz` (or `NAME.csv`) and `NAME.json`.
    pub directory: PathBuf,
    /// Only recordings whose name contains this; those that calibrate are replayed all the same, and not told.
    pub only: Option<String>,
    /// No calibration: what calibrates is left out.
    pub uncalibrated: bool,
    /// What a scale under the pins reads sets the scale of forces.
    pub scale: bool,
}

/// A recording that has been read.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Name of the file without its endings.
    pub name: String,
    /// The samples; their clock starts with the file's first row.
    pub samples: Vec<Sample>,
    /// Time of the file's first row, second.
    pub origin_s: f64,
    /// What is known of it.
    pub truth: Truth,
}

/// Text of a file, unpacked if its name ends in `gz`.
///
/// # Errors
/// What cannot be read, with the file's name.
pub fn open(file: &Path) -> Result<Box<dyn std::io::Read>, String> {
    let opened = std::fs::File::open(file).map_err(|error| {
        let file = file.display();
        format!("cannot read {file}: {error}; `cargo xtask record FILE.csv` makes a recording")
    })?;
    let buffered = std::io::BufReader::new(opened);
    Ok(if file.extension().is_some_and(|ending| ending == "gz") {
        Box::new(flate2::read::MultiGzDecoder::new(buffered))
    } else {
        Box::new(buffered)
    })
}

fn read(directory: &Path, name: &str, ohm: f64) -> Result<Recording, String> {
    let json = directory.join(format!("{name}.json"));
    let text = std::fs::read_to_string(&json).map_err(|error| {
        format!(
            "{}: {error}; it tells the truth of the recording beside it",
            json.display()
        )
    })?;
    let truth: Truth =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", json.display()))?;
    let packed = directory.join(format!("{name}.csv.gz"));
    let file = if packed.exists() {
        packed
    } else {
        directory.join(format!("{name}.csv"))
    };
    let (rows, _) =
        trace::read(open(&file)?).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut samples = trace::resample(&rows, 0).samples;
    protocol::remove_offset(&mut samples);
    let supply = trace::Supply {
        supply_v: SUPPLY_V,
        ohm,
    };
    trace::back_emf_from_duty(&mut samples, &rows, supply);
    Ok(Recording {
        name: name.to_owned(),
        samples,
        origin_s: rows.first().map_or(0.0, |row| row.time_s),
        truth,
    })
}

/// Names of a folder's recordings, world by world: the worlds and the names sorted, within a world what calibrates first.
fn names(directory: &Path) -> Result<Vec<(String, Vec<String>)>, String> {
    let failed = |error: std::io::Error| {
        let folder = directory.display();
        format!("cannot read {folder}: {error}; name a folder of NAME.csv.gz and NAME.json")
    };
    let mut found = std::collections::BTreeMap::<String, Vec<String>>::new();
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        let file = entry.map_err(failed)?.file_name();
        let Some(name) = file
            .to_str()
            .and_then(|file| file.strip_suffix(".csv.gz").or(file.strip_suffix(".csv")))
        else {
            continue;
        };
        let world = name.split_once('_').map_or("", |(world, _)| world);
        found
            .entry(world.to_owned())
            .or_default()
            .push(name.to_owned());
    }
    if found.is_empty() {
        return Err(format!(
            "{}: no recording there; needed are NAME.csv.gz with NAME.json",
            directory.display()
        ));
    }
    for names in found.values_mut() {
        names.sort();
        // One that lies there twice, compressed and not, counts once.
        names.dedup();
    }
    Ok(found.into_iter().collect())
}

/// Replays a folder with the sensing of a scene, all worlds at once.
///
/// # Errors
/// No such scene, or a folder or a file that cannot be read, with its name.
pub fn run(scene: &str, plan: &Plan) -> Result<Vec<World>, String> {
    palpate_scenes::for_scene!(scene, |S| with_sensing_of::<S>(plan))
        .unwrap_or_else(|| Err(format!("there is no scene '{scene}'")))
}

fn with_sensing_of<S: Simulated>(plan: &Plan) -> Result<Vec<World>, String> {
    let names = names(&plan.directory)?;
    // No choke is told of.
    let ohm = f64::from(S::DRIVE.motor.resistance_ohm);
    let bar = bar(
        names.iter().map(|(_, names)| names.len()).sum(),
        "recordings",
    );
    let worlds = names
        .par_iter()
        .map(|(world, names)| {
            let wanted = |name: &str| plan.only.as_ref().is_none_or(|part| name.contains(part));
            if !names.iter().any(|name| wanted(name)) {
                return Ok(None);
            }
            // A name tells what calibrates only by convention: the class stands in the truth, so all are read first.
            let recordings = names
                .par_iter()
                .map(|name| read(&plan.directory, name, ohm))
                .collect::<Result<Vec<_>, _>>()?;
            let replayed = World::replay::<S>(world, &recordings, plan, &bar);
            Ok(Some(replayed.only(wanted)))
        })
        .collect::<Result<Vec<_>, String>>()?;
    bar.finish_and_clear();
    let worlds: Vec<World> = worlds.into_iter().flatten().collect();
    if worlds.is_empty() {
        return Err(format!(
            "no recording in {} has '{}' in its name",
            plan.directory.display(),
            plan.only.as_deref().unwrap_or_default()
        ));
    }
    Ok(worlds)
}
