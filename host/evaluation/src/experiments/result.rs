//! What an experiment found, as JSON lines and as a table.

use serde::Serialize;

/// Which algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// This firmware's sensing.
    Ours,
    /// The paper's algorithm.
    Paper,
}

/// What one method said of one closing, beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Phalanx that was touched first and where it is felt, metre; `None` for a free closing.
    pub truth: Option<(u8, f64)>,
    /// Length of that phalanx, metre.
    pub length_m: f64,
    /// True time of first contact, second on the samples' clock.
    pub contact_s: f64,
    /// When a contact was decided, second on the samples' clock.
    pub touched_s: Option<f64>,
    /// Phalanx that was named: 1 for a contact that cannot be located.
    pub phalanx: Option<u8>,
    /// Place and claimed deviation, metre; the paper's algorithm claims none.
    pub place: Option<(f64, Option<f64>)>,
    /// Two places were given; the likelier is in `place`.
    pub ambiguous: bool,
}

impl Trial {
    /// Error of the place, metre, where the right phalanx was located.
    #[must_use]
    pub fn error_m(&self) -> Option<f64> {
        let (phalanx, k) = self.truth?;
        let (found, _) = self.place?;
        (self.phalanx == Some(phalanx)).then_some(found - k)
    }
}

/// One row of the table; `None` where a figure makes no sense for the experiment.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Always `result`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Which experiment.
    pub experiment: String,
    /// Which algorithm.
    pub method: Method,
    /// After the guided calibration at known contacts.
    pub calibrated: bool,
    /// Closings.
    pub n: usize,
    /// Closings in which the phalanx in contact was named, percent.
    pub detected_pct: Option<f64>,
    /// Closings in which a contact was felt at all, percent.
    pub touched_pct: Option<f64>,
    /// Mean absolute error in percent of the phalanx's length.
    pub mean_abs_err_pct: Option<f64>,
    /// Standard deviation of the absolute error, percent of the phalanx's length.
    pub std_abs_err_pct: Option<f64>,
    /// Mean absolute error, millimetre.
    pub mean_abs_err_mm: Option<f64>,
    /// Largest absolute error, percent of the phalanx's length.
    pub max_abs_err_pct: Option<f64>,
    /// Closings with a touch before there was a contact.
    pub false_alarms: usize,
    /// True places within two claimed deviations, percent.
    pub within_2sigma_pct: Option<f64>,
    /// Median time from first contact to its decision, millisecond.
    pub delay_median_ms: Option<f64>,
    /// Closings with two candidate places.
    pub ambiguous: usize,
}

/// So much before the true contact a touch may be decided and still be one: a sample's period.
const EARLY_S: f64 = 1.5e-3;

fn percent(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| 100.0 * part as f64 / whole as f64)
}

/// Mean and standard deviation (over n - 1), or `None` without values.
#[must_use]
pub fn mean_and_deviation(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((mean, (squares / (count - 1.0).max(1.0)).sqrt()))
}

/// The middle value.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Puts trials together.
#[must_use]
pub fn summarise(experiment: &str, method: Method, calibrated: bool, trials: &[Trial]) -> Row {
    let touching: Vec<&Trial> = trials
        .iter()
        .filter(|trial| trial.truth.is_some())
        .collect();
    let early = |trial: &Trial| {
        trial
            .touched_s
            .is_some_and(|time| trial.truth.is_none() || time < trial.contact_s - EARLY_S)
    };
    let named = touching
        .iter()
        .filter(|trial| trial.truth.map(|(phalanx, _)| phalanx) == trial.phalanx)
        .count();
    let located: Vec<&&Trial> = touching.iter().filter(|t| t.error_m().is_some()).collect();
    let share = |trial: &Trial| {
        trial
            .error_m()
            .map(|error| 100.0 * error.abs() / trial.length_m)
    };
    let errors_pct: Vec<f64> = located.iter().filter_map(|trial| share(trial)).collect();
    let errors_mm: Vec<f64> = located
        .iter()
        .filter_map(|trial| Some(1e3 * trial.error_m()?.abs()))
        .collect();
    let judged: Vec<bool> = located
        .iter()
        .filter_map(|trial| Some(trial.error_m()?.abs() <= 2.0 * trial.place?.1?))
        .collect();
    let delays: Vec<f64> = touching
        .iter()
        .filter(|trial| !early(trial))
        .filter_map(|trial| Some(1e3 * (trial.touched_s? - trial.contact_s)))
        .collect();
    let spread = mean_and_deviation(&errors_pct);
    Row {
        kind: "result",
        experiment: experiment.to_owned(),
        method,
        calibrated,
        n: trials.len(),
        detected_pct: percent(named, touching.len()),
        touched_pct: percent(
            touching
                .iter()
                .filter(|trial| trial.touched_s.is_some())
                .count(),
            touching.len(),
        ),
        mean_abs_err_pct: spread.map(|(mean, _)| mean),
        std_abs_err_pct: spread.map(|(_, deviation)| deviation),
        mean_abs_err_mm: mean_and_deviation(&errors_mm).map(|(mean, _)| mean),
        max_abs_err_pct: errors_pct.iter().copied().reduce(f64::max),
        false_alarms: trials.iter().filter(|trial| early(trial)).count(),
        within_2sigma_pct: percent(
            judged.iter().filter(|inside| **inside).count(),
            judged.len(),
        ),
        delay_median_ms: median(&delays),
        ambiguous: trials.iter().filter(|trial| trial.ambiguous).count(),
    }
}

/// The rows as a Markdown table.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut out = String::from(
        "| experiment | method | calibrated | n | phalanx named | error, mean ± sd, % of length | mm | largest, % \
         | within 2σ | false alarms | delay, median |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let or_dash = |value: Option<f64>, digits: usize, unit: &str| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}{unit}"))
    };
    for row in rows {
        let method = match row.method {
            Method::Ours => "ours",
            Method::Paper => "paper's",
        };
        let error = match (row.mean_abs_err_pct, row.std_abs_err_pct) {
            (Some(mean), Some(deviation)) => format!("{mean:.2} ± {deviation:.2}"),
            _ => "–".to_owned(),
        };
        out.push_str(&format!(
            "| {} | {method} | {} | {} | {} | {error} | {} | {} | {} | {} | {} |\n",
            row.experiment,
            if row.calibrated { "yes" } else { "no" },
            row.n,
            or_dash(row.detected_pct, 0, " %"),
            or_dash(row.mean_abs_err_mm, 2, ""),
            or_dash(row.max_abs_err_pct, 1, ""),
            or_dash(row.within_2sigma_pct, 1, " %"),
            row.false_alarms,
            or_dash(row.delay_median_ms, 0, " ms"),
        ));
    }
    out
}

/// A row for each calibrated experiment on the distal phalanx or on nothing, the paper's algorithm beside ours.
#[must_use]
pub fn headline(rows: &[Row]) -> String {
    let mut out = String::from(
        "| experiment | closings | false alarms | error, mean ± sd, % of length | within 2σ | delay, median \
         | paper's algorithm, same samples |\n|---|---|---|---|---|---|---|\n",
    );
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let error = |row: &Row| {
        let (mean, deviation) = (row.mean_abs_err_pct?, row.std_abs_err_pct?);
        Some(format!("{mean:.2} ± {deviation:.2}"))
    };
    // A contact on phalanx 1 has no place that could be in error.
    let shown = |row: &&Row| row.calibrated && row.experiment != "proximal";
    for row in rows.iter().filter(shown) {
        if row.method != Method::Ours {
            continue;
        }
        let paper = rows
            .iter()
            .filter(shown)
            .find(|other| other.method == Method::Paper && other.experiment == row.experiment);
        out.push_str(&format!(
            "| {} | {} | {} | {} | {} | {} | {} |\n",
            row.experiment,
            row.n,
            row.false_alarms,
            or_dash(error(row)),
            or_dash(row.within_2sigma_pct.map(|value| format!("{value:.1} %"))),
            or_dash(row.delay_median_ms.map(|value| format!("{value:.0} ms"))),
            or_dash(paper.and_then(error)),
        ));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(found: Option<f64>, touched_s: Option<f64>) -> Trial {
        Trial {
            truth: Some((2, 0.030)),
            length_m: 0.070,
            contact_s: 1.0,
            touched_s,
            phalanx: found.map(|_| 2),
            place: found.map(|k| (k, Some(0.0004))),
            ambiguous: false,
        }
    }

    #[test]
    fn a_row_counts_what_it_says() {
        let trials = [
            trial(Some(0.0307), Some(1.040)),
            trial(Some(0.0293), Some(1.060)),
            trial(Some(0.0302), Some(0.9)),
            trial(None, None),
        ];
        let row = summarise("distal", Method::Ours, true, &trials);
        assert_eq!((row.n, row.false_alarms), (4, 1));
        assert!((row.detected_pct.unwrap() - 75.0).abs() < 1e-9);
        assert!((row.mean_abs_err_pct.unwrap() - (1.0 + 1.0 + 2.0 / 7.0) / 3.0).abs() < 1e-9);
        assert!((row.within_2sigma_pct.unwrap() - 100.0).abs() < 1e-9);
        assert!((row.delay_median_ms.unwrap() - 60.0).abs() < 1e-6);
        let json = serde_json::to_value(&row).unwrap();
        assert_eq!(json["type"], "result");
        assert_eq!(json["method"], "ours");
    }

    #[test]
    fn the_headline_puts_the_paper_s_error_beside_ours() {
        let distal = [trial(Some(0.0307), Some(1.040))];
        let rows = [
            summarise("distal", Method::Ours, true, &distal),
            summarise(
                "distal",
                Method::Paper,
                true,
                &[trial(Some(0.0370), Some(1.1))],
            ),
            summarise("distal", Method::Ours, false, &distal),
            summarise("proximal", Method::Ours, true, &distal),
        ];
        let table = headline(&rows);
        assert_eq!(table.lines().count(), 3);
        assert!(
            table.ends_with("| distal | 1 | 0 | 1.00 ± 0.00 | 0.0 % | 40 ms | 10.00 ± 0.00 |\n"),
            "{table}"
        );
    }

    #[test]
    fn the_wrong_phalanx_is_no_location() {
        let wrong = Trial {
            phalanx: Some(3),
            ..trial(Some(0.03), Some(1.1))
        };
        let row = summarise("x", Method::Paper, false, &[wrong]);
        assert_eq!(row.detected_pct, Some(0.0));
        assert_eq!(row.mean_abs_err_pct, None);
    }

    #[test]
    fn a_touch_of_nothing_is_a_false_alarm() {
        let free = |touched_s| Trial {
            truth: None,
            phalanx: None,
            place: None,
            ..trial(None, touched_s)
        };
        let row = summarise("free", Method::Ours, true, &[free(None), free(Some(2.0))]);
        assert_eq!(
            (row.false_alarms, row.detected_pct, row.delay_median_ms),
            (1, None, None)
        );
        assert!(markdown(&[row]).contains("| free | ours | yes | 2 | – | – | – | – | – | 1 | – |"));
    }
}
