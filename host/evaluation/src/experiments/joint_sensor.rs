//! The sensor of joint 2: the same contacts felt with it and without.

use palpate_document::table::head;
use palpate_scenes::{Tendon2, Tendon2Hall};
use palpate_simulation::joint_sensor::{POSTURES, Score, finger};
use palpate_simulation::places::summary;
use serde_json::{Value, json};

use super::fingers;
use super::following::Failed;
use super::job::Plan;

/// Name, as `--only` takes it.
pub const NAME: &str = "joint sensor";

/// Contacts of one finger in each range of postures.
const CONTACTS: usize = 10;

/// Scenes without and with the sensor.
const SCENES: [&str; 2] = ["tendon2", "tendon2-hall"];

/// The same contacts without the sensor and with it.
#[must_use]
pub fn study(plan: &Plan) -> ([Vec<Score>; 2], Failed) {
    let seeds = || plan.seed + 7000..plan.seed + 7000 + plan.fingers(1, 10);
    let (without, mut failed) = fingers::each("fingers without the sensor", seeds(), |seed| {
        finger::<Tendon2>(&plan.world, seed, CONTACTS)
    });
    let (with, more) = fingers::each("fingers with the sensor", seeds(), |seed| {
        finger::<Tendon2Hall>(&plan.world, seed, CONTACTS)
    });
    failed.extend(more);
    let total = [without, with].map(|all| fingers::total(&all, POSTURES.len(), Score::with));
    (total, failed)
}

/// A row for each range of postures and each scene: its name, the range, the score, and the mean deviation told, as a share.
fn rows(scores: &[Vec<Score>; 2]) -> impl Iterator<Item = (&'static str, usize, &Score, f64)> {
    (0..POSTURES.len()).flat_map(move |range| {
        (SCENES.iter().zip(scores)).filter_map(move |(scene, scores)| {
            let score = scores.get(range)?;
            let told: f64 = score.places.iter().map(|[_, sigma]| sigma).sum();
            Some((*scene, range, score, told / score.places.len() as f64))
        })
    })
}

/// The study as a table.
#[must_use]
pub fn table(scores: &[Vec<Score>; 2]) -> String {
    let mut text = head(
        "theta_1, degree | scene | n | located | error, mean, % | deviation told, mean, % | within 2σ, % | ambiguous | unobservable | \
         elsewhere",
    );
    for (scene, range, score, told) in rows(scores) {
        let [error, within] = summary(&score.places);
        let shown = |value: f64| {
            if value.is_nan() {
                "–".to_owned()
            } else {
                format!("{value:.2}")
            }
        };
        text += &format!(
            "| {:.0} to {:.0} | {scene} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
            POSTURES[range].start,
            POSTURES[range].end,
            score.closings,
            score.places.len(),
            shown(100.0 * error),
            shown(100.0 * told),
            shown(within),
            score.ambiguous,
            score.unobservable,
            score.elsewhere,
        );
    }
    text
}

/// The study as lines of JSON.
#[must_use]
pub fn lines(plan: &Plan, scores: &[Vec<Score>; 2]) -> Vec<Value> {
    let line = |(scene, range, score, told): (&str, usize, &Score, f64)| {
        let [error, within] = summary(&score.places);
        json!({
            "type": "joint-sensor", "world": plan.place.world, "engine": plan.place.engine, "scene": scene,
            "theta_1_deg": [POSTURES[range].start, POSTURES[range].end], "n": score.closings, "located": score.places.len(),
            "ambiguous": score.ambiguous, "unobservable": score.unobservable, "elsewhere": score.elsewhere,
            "mean_abs_err_pct": 100.0 * error, "mean_sigma_pct": 100.0 * told, "within_2sigma_pct": within,
        })
    };
    rows(scores).map(line).collect()
}
