//! Soft objects: felt by the default scene, and by one whose firmware takes them to be rigid.

use palpate_document::table::head;
use palpate_scenes::{P70, P70Grasp};
use palpate_simulation::places::summary;
use palpate_simulation::soft_objects::{LEVELS, Score, finger};
use serde_json::{Value, json};

use super::fingers;
use super::following::Failed;
use super::job::Plan;

/// Name, as `--only` takes it.
pub const NAME: &str = "soft objects";

/// Objects of one finger at each stiffness.
const OBJECTS: usize = 10;

/// Soft objects felt by the default scene, and by one whose firmware takes them to be rigid, calibrated.
#[must_use]
pub fn study(plan: &Plan) -> ([Vec<Score>; 2], Failed) {
    let seeds = || plan.seed + 6000..plan.seed + 6000 + plan.fingers(1, 10);
    let (soft, mut failed) = fingers::each("fingers on soft objects", seeds(), |seed| {
        finger::<P70>(&plan.world, seed, OBJECTS)
    });
    let (rigid, more) = fingers::each("fingers that take them to be rigid", seeds(), |seed| {
        finger::<P70Grasp>(&plan.world, seed, OBJECTS)
    });
    failed.extend(more);
    let total = [soft, rigid].map(|all| fingers::total(&all, LEVELS.len(), Score::with));
    (total, failed)
}

fn stiffness(level: Option<f64>) -> String {
    level.map_or_else(
        || "fixed".to_owned(),
        |level| format!("{:.2}", 1e-3 * level),
    )
}

/// Soft objects as a table.
#[must_use]
pub fn table([soft, rigid]: &[Vec<Score>; 2]) -> String {
    let mut text = head(
        "object, N/mm | n | located | error, mean, % | within 2σ, % | compliance off by, mean, mm/N | within 2σ, % | stiffness told | \
         taken to be rigid: located | error, mean, % | within 2σ, %",
    );
    for ((level, soft), rigid) in LEVELS.iter().zip(soft).zip(rigid) {
        let [error, within] = summary(&soft.places);
        let [off, honest] = summary(&soft.compliances);
        let [other, other_within] = summary(&rigid.places);
        text += &format!(
            "| {} | {} | {} | {:.2} | {within:.0} | {:.2} | {honest:.0} | {} | {} | {:.2} | {other_within:.0} |\n",
            stiffness(*level),
            soft.closings,
            soft.places.len(),
            100.0 * error,
            1e3 * off,
            soft.clear,
            rigid.places.len(),
            100.0 * other,
        );
    }
    text
}

/// Soft objects as lines of JSON.
#[must_use]
pub fn lines(plan: &Plan, [soft, rigid]: &[Vec<Score>; 2]) -> Vec<Value> {
    let line = |scene: &str, level: Option<f64>, score: &Score| {
        let [error, within] = summary(&score.places);
        let [off, honest] = summary(&score.compliances);
        json!({
            "type": "soft-objects", "world": plan.place.world, "engine": plan.place.engine, "scene": scene,
            "stiffness_n_per_m": level, "n": score.closings, "located": score.places.len(), "elsewhere": score.elsewhere,
            "mean_abs_err_pct": 100.0 * error, "within_2sigma_pct": within,
            "compliance_mean_abs_err_mm_per_n": 1e3 * off, "compliance_within_2sigma_pct": honest, "stiffness_told": score.clear,
        })
    };
    let mut all = Vec::new();
    for (scene, scores) in [("p70", soft), ("p70-grasp", rigid)] {
        let levels = LEVELS.iter().zip(scores);
        all.extend(levels.map(|(level, score)| line(scene, *level, score)));
    }
    all
}
