//! Figures from many trials.

use serde::Serialize;

use super::{Answer, Trial};

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

/// The value that a share of the values does not exceed, interpolated between neighbours; `None` without values.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + (high - low) * at.fract())
}

/// The middle value.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

fn percent(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| 100.0 * part as f64 / whole as f64)
}

/// Everything that is counted over a set of closings; `None` where there is nothing to count. Errors and deviations are
/// those of located contacts, in percent of the length of the phalanx in contact; a proximal contact has no location
/// error.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scores {
    /// Closings.
    pub closings: usize,
    /// Contacts beyond the proximal phalanx.
    pub distal: usize,
    /// Of them: place on the right phalanx as the last word, and no early touch.
    pub located: usize,
    /// Closings whose last word is two places.
    pub ambiguous: usize,
    /// Contacts whose last word names another phalanx.
    pub wrong_phalanx: usize,
    /// Of them: as the likelier of two places.
    pub wrong_ambiguous: usize,
    /// Of them: the phalanx that was named pressed harder than any other when it was named, because the object had passed on to it.
    pub wrong_passed_on: usize,
    /// Contacts that were never felt.
    pub missed: usize,
    /// Mean absolute error.
    pub err_mean_pct: Option<f64>,
    /// Standard deviation of the absolute error.
    pub err_sd_pct: Option<f64>,
    /// Absolute error that 95 % stay below.
    pub err_95_pct: Option<f64>,
    /// Largest absolute error.
    pub err_max_pct: Option<f64>,
    /// Mean absolute error, millimetre.
    pub err_mean_mm: Option<f64>,
    /// True places within one claimed deviation, percent.
    pub within1_pct: Option<f64>,
    /// True places within two claimed deviations, percent.
    pub within2_pct: Option<f64>,
    /// Mean of (error / claimed deviation)^2: 1 for honest deviations.
    pub z2_mean: Option<f64>,
    /// Contacts on the proximal phalanx.
    pub proximal: usize,
    /// Of them: named as proximal, and no early touch.
    pub proximal_named: usize,
    /// Closings without contact.
    pub free: usize,
    /// Of them: nothing was said of a contact or of softness.
    pub free_clean: usize,
    /// Touches in closings without contact.
    pub free_touched: usize,
    /// The same in a thousand.
    pub false_alarms_per_1000: Option<f64>,
    /// Contacts with a touch before the contact.
    pub early: usize,
    /// Closings said to be unusual.
    pub unusual: usize,
    /// Median time from first contact to its decision, of located contacts, millisecond.
    pub delay_ms: Option<f64>,
    /// The same, 90 %.
    pub delay_90_ms: Option<f64>,
    /// The same, largest.
    pub delay_max_ms: Option<f64>,
    /// Median time from first contact to its decision, of every contact that was felt and not early, millisecond.
    pub touch_delay_ms: Option<f64>,
    /// The same, 90 %.
    pub touch_delay_90_ms: Option<f64>,
    /// Median error of the contact force against the truth at the instant when it is told, percent of the truth.
    pub force_err_pct: Option<f64>,
    /// The same, mean.
    pub force_err_mean_pct: Option<f64>,
    /// The same, 95 %.
    pub force_err_95_pct: Option<f64>,
    /// True forces within two claimed deviations, percent.
    pub force_within2_pct: Option<f64>,
    /// Mean of (error / claimed deviation)^2 of the force.
    pub force_z2_mean: Option<f64>,
}

impl Scores {
    /// Counts trials.
    #[must_use]
    pub fn of<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> Self {
        let trials: Vec<&Trial> = trials.into_iter().collect();
        let is_ambiguous = |trial: &Trial| matches!(trial.answer, Answer::Ambiguous { .. });
        let is_wrong = |trial: &Trial| {
            trial
                .truth
                .zip(trial.answer.phalanx())
                .is_some_and(|(contact, said)| said != contact.phalanx)
        };
        let count = |what: &dyn Fn(&Trial) -> bool| trials.iter().filter(|t| what(t)).count();
        let on = |trial: &Trial| trial.truth.map_or(0, |contact| contact.phalanx);
        let located: Vec<&Trial> = trials.iter().copied().filter(|t| t.is_located()).collect();
        let all = |what: &dyn Fn(&Trial) -> Option<f64>| -> Vec<f64> {
            located
                .iter()
                .filter_map(|trial| what(trial))
                .filter(|value| value.is_finite())
                .collect()
        };
        let errors_pct = all(&|trial| Some(100.0 * trial.error_m()?.abs() / trial.truth?.length_m));
        let errors_mm = all(&|trial| Some(1e3 * trial.error_m()?.abs()));
        let z = all(&|trial| Some(trial.error_m()?.abs() / trial.answer.place()?.1));
        let delays = all(&|trial| Some(1e3 * (trial.touched_s? - trial.truth?.time_s)));
        let felt: Vec<f64> = trials
            .iter()
            .filter(|trial| !trial.is_early())
            .filter_map(|trial| Some(1e3 * (trial.touched_s? - trial.truth?.time_s)))
            .collect();
        let forces = all(&|trial| {
            let force = trial.force.filter(|force| force.true_n > 0.0)?;
            Some(100.0 * (force.told_n / force.true_n - 1.0).abs())
        });
        let force_z = all(&|trial| {
            let force = trial.force.filter(|force| force.true_n > 0.0)?;
            Some((force.told_n - force.true_n).abs() / force.sigma_n)
        });
        let inside = |z: &[f64], deviations: f64| {
            percent(z.iter().filter(|z| **z <= deviations).count(), z.len())
        };
        let free = count(&|t| t.truth.is_none());
        let free_touched = count(&|t| t.truth.is_none() && t.touched_s.is_some());
        let spread = mean_and_deviation(&errors_pct);
        let mean = |values: &[f64]| mean_and_deviation(values).map(|(mean, _)| mean);
        let mean_square = |z: &[f64]| mean(&z.iter().map(|z| z * z).collect::<Vec<_>>());
        Self {
            closings: trials.len(),
            distal: count(&|t| on(t) > 1),
            located: located.len(),
            ambiguous: count(&is_ambiguous),
            wrong_phalanx: count(&is_wrong),
            wrong_ambiguous: count(&|t| is_wrong(t) && is_ambiguous(t)),
            wrong_passed_on: count(&|t| {
                is_wrong(t) && t.force.is_some_and(|force| force.true_n > 0.0)
            }),
            missed: count(&|t| t.truth.is_some() && t.touched_s.is_none()),
            err_mean_pct: spread.map(|(mean, _)| mean),
            err_sd_pct: spread.map(|(_, deviation)| deviation),
            err_95_pct: quantile(&errors_pct, 0.95),
            err_max_pct: quantile(&errors_pct, 1.0),
            err_mean_mm: mean(&errors_mm),
            within1_pct: inside(&z, 1.0),
            within2_pct: inside(&z, 2.0),
            z2_mean: mean_square(&z),
            proximal: count(&|t| on(t) == 1),
            proximal_named: count(&|t| on(t) == 1 && t.answer == Answer::Proximal && !t.is_early()),
            free,
            free_clean: count(&|t| t.truth.is_none() && t.is_clean()),
            free_touched,
            false_alarms_per_1000: percent(free_touched, free).map(|share| 10.0 * share),
            early: count(&|t| t.truth.is_some() && t.is_early()),
            unusual: count(&|t| t.unusual),
            delay_ms: median(&delays),
            delay_90_ms: quantile(&delays, 0.9),
            delay_max_ms: quantile(&delays, 1.0),
            touch_delay_ms: median(&felt),
            touch_delay_90_ms: quantile(&felt, 0.9),
            force_err_pct: median(&forces),
            force_err_mean_pct: mean(&forces),
            force_err_95_pct: quantile(&forces, 0.95),
            force_within2_pct: inside(&force_z, 2.0),
            force_z2_mean: mean_square(&force_z),
        }
    }
}
