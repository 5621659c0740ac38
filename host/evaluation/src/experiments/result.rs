//! Results of an experiment, as JSON lines and as a table.

use palpate_document::table::head;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::paper::{Rule, STEPS_NM};
use crate::score::{Scores, Trial};

/// Which algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// This firmware's sensing.
    Ours,
    /// The paper's algorithm with one of its [`STEPS_NM`].
    Paper(usize),
    /// The paper's stiffness from two levels of torque.
    PaperTwoLevels,
}

impl Method {
    /// The baselines.
    pub fn papers() -> impl Iterator<Item = (Self, Rule)> {
        STEPS_NM
            .iter()
            .enumerate()
            .map(|(index, step_nm)| (Self::Paper(index), Rule::Rise(*step_nm)))
            .chain([(Self::PaperTwoLevels, Rule::TwoLevels)])
    }

    /// Name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Paper(_) => "paper",
            Self::PaperTwoLevels => "paper-two-levels",
        }
    }

    /// Name in tables.
    fn title(self) -> String {
        match self {
            Self::Ours => "ours".to_owned(),
            Self::Paper(index) => format!(
                "paper's, {:.0} mN m",
                1e3 * STEPS_NM.get(index).copied().unwrap_or(f64::NAN)
            ),
            Self::PaperTwoLevels => "paper's, two levels".to_owned(),
        }
    }
}

/// Where an experiment took place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Place {
    /// World, by name or file.
    pub world: String,
    /// Engine that computed finger and object.
    pub engine: String,
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Where.
    pub place: Place,
    /// Which experiment.
    pub experiment: String,
    /// Which algorithm.
    pub method: Method,
    /// After the guided calibration at known contacts.
    pub calibrated: bool,
    /// What came of it.
    pub scores: Scores,
}

/// Steps with fewer located contacts than this share of the best are not compared by their error.
const COMPARABLE: f64 = 0.9;

impl Row {
    /// Puts trials together.
    #[must_use]
    pub fn of(
        place: &Place,
        experiment: &str,
        method: Method,
        calibrated: bool,
        trials: &[Trial],
    ) -> Self {
        Self {
            place: place.clone(),
            experiment: experiment.to_owned(),
            method,
            calibrated,
            scores: Scores::of(trials),
        }
    }

    /// The best of the paper's steps, in hindsight: the least mean error among those that locate about as many contacts as
    /// any; without errors, the one that names most.
    #[must_use]
    pub fn best(rows: Vec<Self>) -> Option<Self> {
        let named = |row: &Self| row.scores.located + row.scores.proximal_named;
        let most = rows.iter().map(named).max()? as f64;
        rows.into_iter()
            .filter(|row| named(row) as f64 >= COMPARABLE * most)
            .min_by(|a, b| {
                let error = |row: &Self| row.scores.err_mean_pct.unwrap_or(f64::INFINITY);
                error(a).total_cmp(&error(b)).then(named(b).cmp(&named(a)))
            })
    }

    /// Share of the contacts whose phalanx was named, percent.
    fn named_pct(&self) -> Option<f64> {
        let scores = &self.scores;
        let contacts = scores.distal + scores.proximal;
        let named = scores.located + scores.proximal_named;
        (contacts > 0).then(|| 100.0 * named as f64 / contacts as f64)
    }

    /// One line of JSON: every score, and the keys that were there before them.
    #[must_use]
    pub fn json(&self) -> Value {
        let scores = &self.scores;
        let contacts = scores.distal + scores.proximal;
        let touched =
            (contacts > 0).then(|| 100.0 * (contacts - scores.missed) as f64 / contacts as f64);
        let alarms = scores.false_alarms_per_1000.unwrap_or(0.0) * scores.free as f64 * 1e-3;
        let mut line = json!({
            "type": "result", "world": self.place.world, "engine": self.place.engine,
            "experiment": self.experiment, "method": self.method.name(), "calibrated": self.calibrated,
            "n": scores.closings, "detected_pct": self.named_pct(), "touched_pct": touched,
            "mean_abs_err_pct": scores.err_mean_pct, "std_abs_err_pct": scores.err_sd_pct,
            "mean_abs_err_mm": scores.err_mean_mm, "max_abs_err_pct": scores.err_max_pct,
            "false_alarms": scores.early + alarms.round() as usize,
            "within_2sigma_pct": scores.within2_pct, "delay_median_ms": scores.touch_delay_ms,
        });
        if let Value::Object(fields) = &mut line {
            if let Method::Paper(index) = self.method {
                fields.insert("torque_step_nm".into(), json!(STEPS_NM.get(index)));
            }
            let all = serde_json::to_value(scores).unwrap_or_default();
            let all: Map<String, Value> = all.as_object().cloned().unwrap_or_default();
            fields.extend(all);
        }
        line
    }
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
}

fn pair(first: Option<f64>, second: Option<f64>, digits: usize, between: &str) -> String {
    match (first, second) {
        (None, None) => "–".to_owned(),
        _ => format!(
            "{}{between}{}",
            or_dash(first, digits),
            or_dash(second, digits)
        ),
    }
}

/// Headings of [`cells`].
const SCORES: &str = "named, % | wrong phalanx (of two, passed on) | error, mean ± sd, % | 95 %, max | within 1σ, 2σ, % | mean z² | \
                      force error, mean, 95 %, % | early | false alarms / 1000 | unusual | delay, ms";

/// Every score of a row, in the order of [`SCORES`].
fn cells(row: &Row) -> String {
    let scores = &row.scores;
    format!(
        "{} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {}",
        or_dash(row.named_pct(), 0),
        match (scores.wrong_ambiguous, scores.wrong_passed_on) {
            (0, 0) => scores.wrong_phalanx.to_string(),
            (of_two, passed_on) => format!("{} ({of_two}, {passed_on})", scores.wrong_phalanx),
        },
        pair(scores.err_mean_pct, scores.err_sd_pct, 2, " ± "),
        pair(scores.err_95_pct, scores.err_max_pct, 1, ", "),
        pair(scores.within1_pct, scores.within2_pct, 0, ", "),
        or_dash(scores.z2_mean, 1),
        pair(scores.force_err_mean_pct, scores.force_err_95_pct, 1, ", "),
        scores.early,
        or_dash(scores.false_alarms_per_1000, 1),
        scores.unusual,
        or_dash(scores.touch_delay_ms, 0),
    )
}

/// The rows as a Markdown table. A proximal contact has no place that could be in error.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut out = head(&format!("experiment | method | cal. | n | {SCORES}"));
    for row in rows {
        out.push_str(&format!(
            "| {} | {} | {} | {} | {} |\n",
            row.experiment,
            row.method.title(),
            if row.calibrated { "yes" } else { "no" },
            row.scores.closings,
            cells(row),
        ));
    }
    out
}

/// A row for each calibrated experiment with every score, the paper's algorithm next to ours.
#[must_use]
pub fn headline(rows: &[Row]) -> String {
    let mut out = head(&format!(
        "world | experiment | n | {SCORES} | paper's algorithm at its best: named, %; error, %"
    ));
    let shown = |row: &&Row| row.calibrated;
    for row in rows.iter().filter(shown) {
        if row.method != Method::Ours {
            continue;
        }
        let paper = rows.iter().filter(shown).find(|other| {
            matches!(other.method, Method::Paper(_))
                && other.experiment == row.experiment
                && other.place == row.place
        });
        out.push_str(&format!(
            "| {}{} | {} | {} | {} | {} |\n",
            row.place.world,
            if row.place.engine == "mujoco" {
                ", MuJoCo"
            } else {
                ""
            },
            row.experiment,
            row.scores.closings,
            cells(row),
            paper.map_or_else(
                || "–".to_owned(),
                |row| {
                    let Scores {
                        err_mean_pct,
                        err_sd_pct,
                        ..
                    } = row.scores;
                    let error = pair(err_mean_pct, err_sd_pct, 2, " ± ");
                    format!("{}; {error}", or_dash(row.named_pct(), 0))
                }
            ),
        ));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::{Answer, Contact, Force};

    fn place() -> Place {
        Place {
            world: "ideal".into(),
            engine: "plant".into(),
        }
    }

    fn trial(found: Option<f64>, touched_s: Option<f64>) -> Trial {
        Trial {
            truth: Some(Contact {
                phalanx: 2,
                k_m: 0.030,
                length_m: 0.070,
                time_s: 1.0,
            }),
            touched_s,
            answer: found.map_or(Answer::Nothing, |k_m| Answer::Located {
                phalanx: 2,
                k_m,
                sigma_m: 0.0004,
            }),
            ..Trial::default()
        }
    }

    fn row(experiment: &str, method: Method, calibrated: bool, trials: &[Trial]) -> Row {
        Row::of(&place(), experiment, method, calibrated, trials)
    }

    #[test]
    fn a_row_counts_what_it_says() {
        let trials = [
            trial(Some(0.0307), Some(1.040)),
            trial(Some(0.0293), Some(1.060)),
            trial(Some(0.0302), Some(0.9)),
            trial(None, None),
        ];
        let json = row("distal", Method::Ours, true, &trials).json();
        assert_eq!(
            (json["n"].as_u64(), json["false_alarms"].as_u64()),
            (Some(4), Some(1))
        );
        // The early one is not located.
        assert_eq!(json["detected_pct"].as_f64(), Some(50.0));
        assert!((json["mean_abs_err_pct"].as_f64().unwrap() - 1.0).abs() < 1e-9);
        assert!((json["within1_pct"].as_f64().unwrap()).abs() < 1e-9);
        assert_eq!(json["within_2sigma_pct"].as_f64(), Some(100.0));
        assert!((json["z2_mean"].as_f64().unwrap() - 3.0625).abs() < 1e-6);
        assert!((json["delay_median_ms"].as_f64().unwrap() - 50.0).abs() < 1e-6);
        assert_eq!(
            (json["missed"].as_u64(), json["early"].as_u64()),
            (Some(1), Some(1))
        );
        assert_eq!(
            (json["type"].as_str(), json["method"].as_str()),
            (Some("result"), Some("ours"))
        );
    }

    #[test]
    fn the_headline_puts_the_paper_s_error_beside_ours() {
        let distal = [trial(Some(0.0307), Some(1.040))];
        let rows = [
            row("distal", Method::Ours, true, &distal),
            row(
                "distal",
                Method::Paper(3),
                true,
                &[trial(Some(0.0370), Some(1.1))],
            ),
            row("distal", Method::Ours, false, &distal),
            row("proximal", Method::Ours, true, &distal),
        ];
        let table = headline(&rows);
        assert_eq!(table.lines().count(), 4);
        let distal = "| ideal | distal | 1 | 100 | 0 | 1.00 ± 0.00 | 1.0, 1.0 | 0, 100 | 3.1 | – | 0 | – | 0 | 40 | 100; 10.00 ± 0.00 |\n";
        assert!(table.contains(distal), "{table}");
        assert!(!table.contains("| no |") && table.contains("| proximal | 1 |"));
    }

    #[test]
    fn the_best_step_must_locate_what_others_locate() {
        let good = trial(Some(0.0301), Some(1.04));
        let worse = trial(Some(0.0320), Some(1.04));
        let none = trial(None, Some(1.04));
        let rows = vec![
            row("x", Method::Paper(0), true, &[good, none]),
            row("x", Method::Paper(1), true, &[worse, worse]),
            row("x", Method::Paper(2), true, &[good, worse]),
        ];
        assert_eq!(Row::best(rows).unwrap().method, Method::Paper(2));
    }

    #[test]
    fn the_wrong_phalanx_and_a_proximal_place_are_no_location() {
        let mut wrong = trial(None, Some(1.1));
        wrong.answer = Answer::Proximal;
        let mut proximal = trial(None, Some(1.1));
        proximal.truth = proximal.truth.map(|on| Contact { phalanx: 1, ..on });
        proximal.answer = Answer::Proximal;
        // One of two places may be right, but the likelier is not.
        let mut of_two = proximal;
        of_two.answer = Answer::Ambiguous {
            phalanx: 2,
            k_m: 0.02,
            sigma_m: 0.001,
        };
        // The object had passed on to the phalanx that was named.
        let mut passed_on = trial(Some(0.02), Some(1.1));
        passed_on.truth = proximal.truth;
        passed_on.force = Some(Force {
            time_s: 1.3,
            told_n: 1.0,
            sigma_n: 0.1,
            true_n: 0.9,
        });
        let trials = [wrong, proximal, of_two, passed_on];
        let row = row("x", Method::PaperTwoLevels, false, &trials);
        assert_eq!(row.scores.err_mean_pct, None);
        let scores = &row.scores;
        let wrong = [scores.wrong_ambiguous, scores.wrong_passed_on];
        assert_eq!((scores.wrong_phalanx, wrong), (3, [1, 1]));
        assert_eq!((scores.proximal_named, scores.ambiguous), (1, 1));
        assert!(markdown(&[row]).contains("| 3 (1, 1) |"));
    }

    #[test]
    fn a_touch_of_nothing_is_a_false_alarm() {
        let free = |touched_s| Trial {
            touched_s,
            ..Trial::default()
        };
        let row = row("free", Method::Ours, true, &[free(None), free(Some(2.0))]);
        assert_eq!(row.scores.false_alarms_per_1000, Some(500.0));
        assert_eq!((row.scores.free_clean, row.scores.early), (1, 0));
        assert!(
            markdown(&[row]).contains(
                "| free | ours | yes | 2 | – | 0 | – | – | – | – | – | 0 | 500.0 | 0 | – |"
            )
        );
    }
}
