//! Result of a calibration next to the truth, and the location error before and after it.

use std::path::Path;

use crate::experiments::calibration::Finger;
use palpate_document::chart::{
    BLUE, Chart, DrawError, GREEN, GREY, Legend, Mark, ORANGE, Series, write,
};

/// Found against true, with two claimed deviations, on a square.
fn against(
    fingers: &[Finger],
    what: &str,
    unit: &str,
    point: impl Fn(&Finger) -> (f64, f64, f64),
) -> Chart {
    let points: Vec<_> = fingers.iter().map(point).collect();
    let values = || points.iter().flat_map(|&(x, y, _)| [x, y]);
    let low = 0.95 * values().fold(f64::INFINITY, f64::min);
    let high = 1.05 * values().fold(f64::NEG_INFINITY, f64::max);
    let mut found = Series::new(
        "found, two claimed deviations",
        BLUE,
        Mark::Dots,
        points.iter().map(|&(x, y, _)| (x, y)).collect(),
    );
    found.bars = points.iter().map(|&(_, _, bar)| bar).collect();
    Chart {
        title: format!("{what} of {} simulated fingers", fingers.len()),
        x_label: format!("true {what}{unit}"),
        y_label: format!("found{unit}"),
        x: (low, high),
        y: (low, high),
        log_y: false,
        legend: Legend::LowerRight,
        series: vec![
            Series::new("", GREY, Mark::Dashes, vec![(low, low), (high, high)]),
            found,
        ],
    }
}

/// Absolute error against the share of contacts that are better.
fn errors(fingers: &[Finger]) -> Chart {
    let curve = |after: usize| {
        let mut errors: Vec<f64> = fingers
            .iter()
            .flat_map(|finger| finger.errors_m(after))
            .collect();
        errors.sort_by(f64::total_cmp);
        let count = errors.len() as f64;
        let share = |rank: usize| 100.0 * (rank as f64 + 0.5) / count;
        errors
            .iter()
            .enumerate()
            .map(|(rank, error)| (share(rank), (1e3 * error).max(0.01)))
            .collect::<Vec<_>>()
    };
    Chart {
        title: "Location error before and after the calibration (simulated)".to_owned(),
        x_label: "share of the located contacts that are better, %".to_owned(),
        y_label: "absolute error, mm".to_owned(),
        x: (0.0, 100.0),
        y: (0.01, 100.0),
        log_y: true,
        legend: Legend::UpperLeft,
        series: vec![
            Series::new("before", ORANGE, Mark::Line, curve(0)),
            Series::new("after", GREEN, Mark::Line, curve(1)),
        ],
    }
}

/// Writes `calibration.svg`.
///
/// # Errors
/// Whatever keeps the files from being written.
pub fn calibration(directory: &Path, fingers: &[Finger]) -> Result<(), DrawError> {
    let factor = against(fingers, "torque factor", "", |finger| {
        let found = f64::from(finger.found.torque_factor);
        let sigma = found * f64::from(finger.found.torque_factor_sigma);
        (finger.truth.torque_factor, found, 2.0 * sigma)
    });
    let cable = against(fingers, "cable twist", ", rad/(N m)", |finger| {
        let sigma = f64::from(finger.found.cable_sigma_rad_per_nm);
        (
            finger.truth.cable_rad_per_nm,
            finger.found.cable_rad_per_nm.into(),
            2.0 * sigma,
        )
    });
    write(directory, "calibration", &[factor, cable, errors(fingers)])
}
