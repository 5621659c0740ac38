//! The back-EMF of a recording that has the duty of its bridge.

use palpate::sample::Sample;

use super::{PERIOD_US, Row};

/// What a duty of 1 means, and what the current takes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    /// Voltage at the motor at a duty of 1, volt.
    pub supply_v: f64,
    /// Resistance of the motor's circuit, ohm.
    pub ohm: f64,
}

/// Fills in the back-EMF of samples that were made of `rows`, wherever the rows have a duty and no back-EMF of their own: mean duty of
/// the sample's millisecond times supply, less the resistance times its current. A duty that is a mere direction, 1 or -1, tells
/// no voltage.
pub fn back_emf_from_duty(samples: &mut [Sample], rows: &[Row], supply: Supply) {
    let is_share = |row: &Row| {
        row.duty
            .is_some_and(|duty| duty.abs() > 0.0 && duty.abs() < 1.0)
    };
    let Some(origin_s) = rows.first().map(|row| row.time_s) else {
        return;
    };
    if !rows.iter().any(is_share) || rows.iter().any(|row| row.emf_v.is_some()) {
        return;
    }
    let mut next = 0;
    for sample in samples {
        let end_s = origin_s + sample.time_us as f64 * 1e-6;
        // The row that is in force when the sample begins counts where none comes within it.
        let begin_s = end_s - PERIOD_US as f64 * 1e-6;
        while next < rows.len() && rows[next].time_s <= begin_s + 1e-9 {
            next += 1;
        }
        let within = rows[next..]
            .iter()
            .take_while(|row| row.time_s <= end_s + 1e-9);
        let (sum, count) = within
            .filter_map(|row| row.duty)
            .fold((0.0, 0.0), |(sum, count), duty| (sum + duty, count + 1.0));
        let duty = if count > 0.0 {
            sum / count
        } else {
            (next.checked_sub(1))
                .and_then(|last| rows[last].duty)
                .unwrap_or(f64::NAN)
        };
        let emf_v = supply.supply_v * duty - supply.ohm * f64::from(sample.current_a);
        sample.emf_v = emf_v as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::resample;

    const SUPPLY: Supply = Supply {
        supply_v: 12.0,
        ohm: 35.0,
    };

    fn rows(interval_s: f64, duty: impl Fn(f64) -> Option<f64>) -> Vec<Row> {
        (0..200)
            .map(|index| f64::from(index) * interval_s)
            .map(|time_s| Row {
                time_s,
                encoder_counts: (60_000.0 * time_s) as i64,
                current_a: 0.02,
                duty: duty(time_s),
                emf_v: None,
            })
            .collect()
    }

    #[test]
    fn the_voltage_less_what_the_current_takes() {
        for interval_s in [0.000_25, 0.001, 0.004] {
            let rows = rows(interval_s, |time_s| Some(0.3 + 0.5 * time_s));
            let mut samples = resample(&rows, 0).samples;
            assert!(samples.iter().all(|sample| sample.emf_v.is_nan()));
            back_emf_from_duty(&mut samples, &rows, SUPPLY);
            for sample in &samples {
                let at_s = sample.time_us as f64 * 1e-6;
                let expected = 12.0 * (0.3 + 0.5 * at_s) - 0.7;
                let late_v = 12.0 * 0.5 * interval_s.max(0.001);
                let off_v = f64::from(sample.emf_v) - expected;
                assert!(off_v.abs() <= late_v + 1e-5, "{interval_s} {off_v}");
            }
        }
    }

    #[test]
    fn a_direction_is_no_voltage() {
        for duty in [None, Some(1.0), Some(-1.0), Some(0.0)] {
            let rows = rows(0.001, |_| duty);
            let mut samples = resample(&rows, 0).samples;
            back_emf_from_duty(&mut samples, &rows, SUPPLY);
            assert!(samples.iter().all(|sample| sample.emf_v.is_nan()));
        }
    }
}
