//! What follows the first contact: second contacts, and what becomes of a contact that is held.

use std::f64::consts::FRAC_2_PI;

use palpate::finger::HoldsTwice;
use palpate_document::table::head;
use palpate_scenes::{Linkage3, P70Grasp, P70Hold, Tendon3};
use palpate_simulation::changes::{self, KINDS, Scores};
use palpate_simulation::places::summary;
use palpate_simulation::second_contacts::{self, Score};
use palpate_simulation::{Error, Simulated};
use serde_json::{Value, json};

use super::fingers;
use super::job::Plan;

/// Names, as `--only` takes them.
pub const NAMES: [&str; 2] = ["changes", "second contacts"];

/// Grasps of one finger in which a second contact is looked for.
const GRASPS: usize = 20;

/// What could not be done: the finger's seed, and why.
pub type Failed = Vec<(u64, Error)>;

/// Changes of held contacts of `p70-hold`, calibrated: ten grasps with one closing of every kind on each drawn finger.
#[must_use]
pub fn changes(plan: &Plan) -> (Scores, Failed) {
    let first = plan.seed + 4000;
    let seeds = first..first + plan.fingers(1, 10);
    let (all, failed) = fingers::each("fingers held", seeds, |seed| {
        changes::finger::<P70Hold>(&plan.world, seed, changes::GRASPS, |_, _, _, _| {})
    });
    (all.iter().fold(Scores::default(), Scores::with), failed)
}

/// Changes as a table.
#[must_use]
pub fn changes_table(scores: &Scores) -> String {
    let mut text = head(
        "what happens | n | told | right | within 50 ms | right, within 50 ms | large: n, told | delay median, 90 %, ms | told before",
    );
    for ((name, _), score) in KINDS.iter().zip(&scores.kinds) {
        text += &format!("| {name} | {} | ", score.happened);
        text += &if name == &KINDS[0].0 {
            format!("{} | – | – | – | – | – | – |\n", score.early)
        } else {
            let delays = if score.told == 0 {
                "–".to_owned()
            } else {
                format!("{:.0}, {:.0}", score.delay_ms(0.5), score.delay_ms(0.9))
            };
            format!(
                "{} | {} | {} | {} | {}, {} | {delays} | {} |\n",
                score.told,
                score.right,
                score.in_time,
                score.right_in_time,
                score.large,
                score.large_told,
                score.early
            )
        };
    }
    text + &format!(
        "\n{} quiet contacts rolled by {:.1} mm (mean) and were told with an error of {:.2} mm (mean), {:.0} % within two deviations; \
         {} were told without a place.\n",
        scores.moved.len(),
        1e3 * scores.mean(|moved| moved.way_m),
        1e3 * scores.mean(|moved| moved.error_m),
        scores.within2_pct(),
        scores.unmoved
    )
}

/// Changes as lines of JSON.
pub fn changes_json(plan: &Plan, scores: &Scores) -> impl Iterator<Item = Value> {
    let place = plan.place.clone();
    KINDS.iter().zip(&scores.kinds).map(move |((name, _), score)| {
        json!({
            "type": "change", "world": place.world, "engine": place.engine, "what": name, "n": score.happened,
            "told": score.told, "right": score.right, "in_time": score.in_time, "right_in_time": score.right_in_time,
            "large": score.large, "large_told": score.large_told, "told_before": score.early,
            "delay_median_ms": score.delay_ms(0.5), "delay_90_ms": score.delay_ms(0.9),
        })
    })
}

fn second_of<S: Simulated<Finger: HoldsTwice>>(plan: &Plan, failed: &mut Failed) -> Score {
    let first = plan.seed + 5000;
    let seeds = first..first + plan.fingers(1, 10);
    let (all, not_done) = fingers::each("fingers that grasp", seeds, |seed| {
        second_contacts::finger::<S>(&plan.world, seed, GRASPS, true, |_, _, _| {})
    });
    failed.extend(not_done);
    all.iter().fold(Score::default(), Score::with)
}

/// Second contacts of the default finger and of those with three phalanges, calibrated.
#[must_use]
pub fn second_contacts(plan: &Plan) -> (Vec<(&'static str, Score)>, Failed) {
    let mut failed = Vec::new();
    let scores = vec![
        ("p70", second_of::<P70Grasp>(plan, &mut failed)),
        ("tendon3", second_of::<Tendon3>(plan, &mut failed)),
        ("linkage3", second_of::<Linkage3>(plan, &mut failed)),
    ];
    (scores, failed)
}

/// Second contacts as a table.
#[must_use]
pub fn second_contacts_table(scores: &[(&'static str, Score)]) -> String {
    let mut text = head(
        "finger | power grasps | told | right phalanx, wrong | enveloped | single contacts | told as two | in passing or as the motion ended: n, told | places | \
         error, mean, % | claimed, % | within 2σ, % | faults",
    );
    for (name, score) in scores {
        let places = if score.places.is_empty() {
            "– | – | –".to_owned()
        } else {
            let [error, within] = summary(&score.places);
            let claimed = claimed_pct(&score.places);
            format!("{:.1} | {claimed:.1} | {within:.0}", 100.0 * error)
        };
        text += &format!(
            "| {name} | {} | {} | {}, {} | {} | {} | {} | {}, {} | {} | {places} | {} |\n",
            score.power,
            score.told,
            score.phalanx_right,
            score.phalanx_wrong,
            score.enveloped,
            score.single,
            score.false_ones,
            score.late,
            score.late_told,
            score.places.len(),
            score.faults
        );
    }
    text
}

/// Second contacts as lines of JSON.
pub fn second_contacts_json(
    plan: &Plan,
    scores: &[(&'static str, Score)],
) -> impl Iterator<Item = Value> {
    let place = plan.place.clone();
    scores.iter().map(move |(name, score)| {
        let [error, within] = summary(&score.places);
        json!({
            "type": "second-contacts", "world": place.world, "engine": place.engine, "scene": name, "power": score.power,
            "told": score.told, "phalanx_right": score.phalanx_right,
            "phalanx_wrong": score.phalanx_wrong, "enveloped": score.enveloped, "single": score.single,
            "false": score.false_ones, "late": score.late, "late_told": score.late_told, "faults": score.faults,
            "places": score.places.len(), "mean_abs_err_pct": 100.0 * error, "within_2sigma_pct": within,
            "claimed_abs_err_pct": claimed_pct(&score.places),
        })
    })
}

/// Mean absolute error that normal errors with the told deviations would have, percent; NaN without places. Each place is its error and
/// the told deviation, as shares of the phalanx.
#[expect(clippy::cast_precision_loss, reason = "a count")]
fn claimed_pct(places: &[[f64; 2]]) -> f64 {
    let sigmas: f64 = places.iter().map(|[_, sigma]| sigma).sum();
    100.0 * FRAC_2_PI.sqrt() * sigmas / places.len() as f64
}
