//! A recording at any times, as the samples that the sensing is given once a millisecond.

use palpate::sample::{Drive, Sample};

use super::Row;

/// Period of the samples, microseconds.
pub const PERIOD_US: u64 = 1_000;
/// A pause this long, or this many typical intervals, is a gap: what happened in it is not known.
const GAP_S: f64 = 0.02;
const GAP_INTERVALS: f64 = 5.0;
/// Rows further apart than this tell nothing about friction or stiffness, however regular they are.
const LONGEST_INTERVAL_S: f64 = 0.2;
/// Four hours, fourteen million samples: a longer recording is cut, and most likely in another unit.
const LONGEST_S: f64 = 1.44e4;
/// Speed over which the direction is taken, second, where there is no duty.
const SPEED_WINDOW_S: f64 = 0.02;
/// Counts over that window below which the motor stands.
const STANDING_COUNTS: f64 = 3.0;

/// A stretch without data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Begin, second.
    pub from_s: f64,
    /// End, second.
    pub to_s: f64,
}

/// The samples, and what is missing between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resampled {
    /// One a millisecond, none within a gap.
    pub samples: Vec<Sample>,
    /// Stretches without data.
    pub gaps: Vec<Gap>,
    /// Typical interval between the rows, second.
    pub interval_s: f64,
    /// The rows come slower than the samples: the samples between are interpolated.
    pub interpolated: bool,
    /// Rows beyond the longest recording that is taken; left out.
    pub cut_at_s: Option<f64>,
}

/// Where the motor drives during a row, by the duty or, without one, by the motion.
fn drive(rows: &[Row], index: usize) -> Drive {
    let Some(row) = rows.get(index) else {
        return Drive::Idle;
    };
    let near = |step: isize| {
        let mut at = index;
        while let Some(next) = at
            .checked_add_signed(step)
            .and_then(|i| rows.get(i).map(|_| i))
        {
            at = next;
            if (rows[at].time_s - row.time_s).abs() >= 0.5 * SPEED_WINDOW_S {
                break;
            }
        }
        rows[at].encoder_counts
    };
    #[expect(clippy::cast_precision_loss, reason = "small differences")]
    let moved = near(1).saturating_sub(near(-1)) as f64;
    let closing = row.duty.is_none_or(|duty| duty > 0.0) && moved > STANDING_COUNTS;
    let opening = row.duty.is_none_or(|duty| duty < 0.0) && moved < -STANDING_COUNTS;
    match (closing, opening) {
        (true, _) => Drive::Closing,
        (_, true) => Drive::Opening,
        _ => Drive::Idle,
    }
}

fn median_interval(rows: &[Row]) -> f64 {
    let mut intervals: Vec<f64> = rows
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

/// Samples from `rows`, whose times must rise; positions count from `zero_counts`.
///
/// A sample's current is the mean over its millisecond (the current between two rows is a straight line), its
/// position the one at the end. Nothing is invented across a gap: the samples stop and start again.
#[must_use]
pub fn resample(rows: &[Row], zero_counts: i64) -> Resampled {
    let interval_s = median_interval(rows);
    let gap_s = GAP_S
        .max(GAP_INTERVALS * interval_s)
        .min(LONGEST_INTERVAL_S);
    #[expect(clippy::cast_precision_loss, reason = "a constant")]
    let period_s = PERIOD_US as f64 * 1e-6;
    let mut out = Resampled {
        interval_s,
        interpolated: interval_s > 1.5 * period_s,
        ..Resampled::default()
    };
    let Some(origin) = rows.first().map(|row| row.time_s) else {
        return out;
    };
    let mut from = 0;
    while from < rows.len() {
        let mut to = from + 1;
        while to < rows.len() && rows[to].time_s - rows[to - 1].time_s <= gap_s {
            to += 1;
        }
        let piece = &rows[from..to];
        let (begin, end) = (
            piece[0].time_s - origin,
            piece[piece.len() - 1].time_s - origin,
        );
        if begin > LONGEST_S {
            out.cut_at_s = Some(origin + LONGEST_S);
            return out;
        }
        if from > 0 {
            out.gaps.push(Gap {
                from_s: rows[from - 1].time_s,
                to_s: piece[0].time_s,
            });
        }
        piece_samples(
            piece,
            origin,
            (begin, end.min(LONGEST_S)),
            zero_counts,
            &mut out.samples,
        );
        from = to;
    }
    out
}

/// Appends the samples of one gapless piece.
fn piece_samples(
    piece: &[Row],
    origin: f64,
    (begin, end): (f64, f64),
    zero_counts: i64,
    samples: &mut Vec<Sample>,
) {
    let mut tick = (begin * 1e6 / PERIOD_US as f64).floor() as u64 + 1;
    let mut index = 0;
    let at = |index: usize, time: f64| {
        let (a, b) = (&piece[index], &piece[(index + 1).min(piece.len() - 1)]);
        let span = b.time_s - a.time_s;
        let share = if span > 0.0 {
            ((time - (a.time_s - origin)) / span).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let counts = b.encoder_counts.saturating_sub(a.encoder_counts) as f64 * share;
        (
            (counts.round() as i64).saturating_add(a.encoder_counts.saturating_sub(zero_counts)),
            a.current_a + share * (b.current_a - a.current_a),
        )
    };
    let mut last_time = begin;
    loop {
        let time = (tick * PERIOD_US) as f64 * 1e-6;
        if time > end {
            return;
        }
        // Mean of the piecewise straight current from the last sample to this one.
        let mut area = 0.0;
        let (mut t0, mut i0) = (last_time, at(index, last_time).1);
        while index + 1 < piece.len() && piece[index + 1].time_s - origin <= time {
            index += 1;
            let t1 = piece[index].time_s - origin;
            area += 0.5 * (i0 + piece[index].current_a) * (t1 - t0);
            (t0, i0) = (t1, piece[index].current_a);
        }
        let (counts, current) = at(index, time);
        area += 0.5 * (i0 + current) * (time - t0);
        let mean = if time > last_time {
            area / (time - last_time)
        } else {
            current
        };
        samples.push(Sample {
            time_us: tick * PERIOD_US,
            // The sensing takes differences of counts that wrap.
            position_counts: counts as i32,
            current_a: mean as f32,
            emf_v: piece[index].emf_v.unwrap_or(f64::NAN) as f32,
            drive: drive(piece, index),
            joint: (),
        });
        last_time = time;
        tick += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ramp(times: impl Iterator<Item = f64>) -> Vec<Row> {
        times
            .map(|time_s| Row {
                time_s,
                encoder_counts: (time_s * 30_000.0).round() as i64,
                current_a: 0.01 + 0.1 * time_s,
                duty: None,
                emf_v: None,
            })
            .collect()
    }

    #[test]
    fn uneven_rows_give_even_samples() {
        let rows = ramp((0..4000).map(|i| f64::from(i) * 0.25e-3 + f64::from(i % 3) * 0.05e-3));
        let out = resample(&rows, 0);
        assert!(out.gaps.is_empty());
        assert!(out.samples.len() > 990);
        for pair in out.samples.windows(2) {
            assert_eq!(pair[1].time_us - pair[0].time_us, PERIOD_US);
        }
        for sample in &out.samples {
            let time = sample.time_us as f64 * 1e-6;
            assert!((f64::from(sample.position_counts) - time * 30_000.0).abs() <= 1.5);
            let middle = 0.01 + 0.1 * (time - 0.5e-3);
            assert!(
                (f64::from(sample.current_a) - middle).abs() < 2e-5,
                "mean over the period"
            );
            assert_eq!(sample.drive, Drive::Closing);
        }
    }

    #[test]
    fn slow_rows_are_interpolated() {
        let out = resample(&ramp((0..100).map(|i| f64::from(i) * 0.01)), 0);
        assert!(out.interpolated && out.gaps.is_empty());
        assert_eq!(out.samples.len(), 990);
    }

    #[test]
    fn gaps_are_left_open() {
        let rows = ramp((0..100).map(|i| f64::from(i) * 1e-3 + if i < 50 { 0.0 } else { 0.5 }));
        let out = resample(&rows, 0);
        assert_eq!(out.gaps.len(), 1);
        assert!((out.gaps[0].to_s - out.gaps[0].from_s - 0.501).abs() < 1e-9);
        assert!(
            out.samples
                .iter()
                .all(|s| !(50_000..550_000).contains(&s.time_us))
        );
    }

    #[test]
    fn standing_is_idle() {
        let rows: Vec<Row> = ramp((0..100).map(|i| f64::from(i) * 1e-3))
            .into_iter()
            .map(|row| Row {
                encoder_counts: 5,
                ..row
            })
            .collect();
        assert!(
            resample(&rows, 0)
                .samples
                .iter()
                .all(|s| s.drive == Drive::Idle)
        );
    }

    proptest! {
        #[test]
        fn any_rows_give_finite_samples(
            steps in proptest::collection::vec((1e-7_f64..3.0, any::<i64>(), -1e3_f64..1e3), 0..40),
            zero in any::<i64>(),
        ) {
            let mut time_s = -5.0;
            let rows: Vec<Row> = steps
                .into_iter()
                .map(|(step, encoder_counts, current_a)| {
                    time_s += step;
                    Row { time_s, encoder_counts, current_a, duty: None, emf_v: None }
                })
                .collect();
            let out = resample(&rows, zero);
            prop_assert!(out.samples.iter().all(|s| s.current_a.is_finite()));
            prop_assert!(out.samples.windows(2).all(|p| p[0].time_us < p[1].time_us));
        }
    }
}
