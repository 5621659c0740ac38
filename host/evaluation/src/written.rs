//! Writes the tables of the experiments into the documents.

use palpate_evaluation::experiments::{calibration, catalogue, document, fingerprint};
use palpate_plant::Engine;

use super::{Outcome, everything, plan, rows};

/// Worlds whose tables stand in the documents, those that the headline comes from first.
const WRITTEN: [&str; 3] = ["workshop", "workshop@mujoco", "ideal"];

/// Writes the tables, with the fingerprint of the code that made them.
///
/// # Errors
/// A world or document cannot be read or written; experiments lack closings, and nothing is written.
pub fn write(seed: u64, quick: bool) -> Outcome {
    let (mut all, mut calibrations) = (Vec::new(), Vec::new());
    let mut left_out = 0;
    for world in WRITTEN {
        let plan = plan(world, None, seed, quick || world == "ideal")?;
        // Ablation and sensitivity compare causes in one world; the other engine would tell the same at a higher price.
        let jobs = match plan.world.engine {
            Engine::Plant => everything(&plan),
            Engine::Mujoco => catalogue::all(&plan),
        };
        let (rows, failed) = rows(&plan, &jobs);
        for job in &failed {
            eprintln!("{world}, {}: {}", job.name, job.failure);
        }
        left_out += failed.iter().filter(|job| job.failure.leaves_out()).count();
        all.extend(rows);
        let (fingers, failed) = calibration::study(&plan);
        for (seed, failure) in &failed {
            eprintln!("{world}, calibration of finger {seed}: {failure}");
        }
        calibrations.push((plan.place, calibration::Summary::of(&fingers)));
    }
    if left_out > 0 {
        return Err(
            format!("nothing is written: {left_out} of the experiments lack closings").into(),
        );
    }
    let code = fingerprint::fingerprint()?;
    for (file, body) in document::bodies(&all, &calibrations) {
        document::write(&fingerprint::root().join(file), &code, &body)?;
    }
    Ok(())
}
