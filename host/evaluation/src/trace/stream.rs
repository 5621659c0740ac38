//! Recordings that the firmware streamed itself: samples as the sensing was given them, with the log lines between them.
//!
//! `cargo xtask record` writes them: a column `log` holds the lines that came before a sample. Nothing is resampled here.

use std::io::Read;

use palpate::app::log::BETWEEN_LINES;
use palpate::sample::{Drive, Sample};

use super::PERIOD_US;
use super::read::{ReadError, back_emf, columns, field, malformed, reader};

/// Microseconds are whole up to here (some hundred years).
const LARGEST_TIME_S: f64 = 3.2e9;

/// A sample, and what was logged before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Streamed {
    /// The sample; the angle of joint 2 where it was measured.
    pub sample: Sample<Option<f32>>,
    /// Lines since the sample before.
    pub log: Vec<String>,
}

/// Reads a recording with a column `log`; `None` for one without, or one that lacks samples (a divider, records dropped): what
/// the sensing made of those is not known.
///
/// # Errors
/// [`ReadError`], with line and column where there is one.
pub fn stream(input: impl Read) -> Result<Option<Vec<Streamed>>, ReadError> {
    let mut reader = reader(input);
    let header = reader.headers().map_err(malformed)?.clone();
    let columns = columns(&header)?;
    let at = |name: &str| header.iter().position(|field| field.trim() == name);
    let (Some(duty), Some(log)) = (columns.duty, at("log")) else {
        return Ok(None);
    };
    let joint = at("joint_rad");
    let mut rows: Vec<Streamed> = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(malformed)? {
        let time_s = field(&record, columns.time, "time_s", LARGEST_TIME_S, "a time")?;
        let expected = "a number of counts";
        let largest = f64::from(i32::MAX);
        let counts = field(&record, columns.counts, "encoder_counts", largest, expected)?;
        let expected = "a current in ampere below 1000";
        let current_a = field(&record, columns.current, "current_a", 1.0e3, expected)?;
        let duty = field(&record, duty, "duty", f64::MAX, "a number")?;
        let emf_v = back_emf(&record, &columns)?;
        let text = |at: usize| record.get(at).unwrap_or("").trim();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bounded above; before the origin there is no time"
        )]
        let sample = Sample {
            time_us: (1e6 * time_s).round() as u64,
            position_counts: counts as i32,
            current_a: current_a as f32,
            emf_v: emf_v.map_or(f32::NAN, |volt| volt as f32),
            drive: if duty > 0.0 {
                Drive::Closing
            } else if duty < 0.0 {
                Drive::Opening
            } else {
                Drive::Idle
            },
            joint: joint.and_then(|at| text(at).parse().ok()),
        };
        let complete = rows
            .last()
            .is_none_or(|last| sample.time_us == last.sample.time_us + PERIOD_US);
        if !complete {
            return Ok(None);
        }
        let log = text(log)
            .split(BETWEEN_LINES)
            .filter(|line| !line.is_empty());
        let log = log.map(str::to_owned).collect();
        rows.push(Streamed { sample, log });
    }
    // Too few are told by the other reader.
    Ok((rows.len() > 1).then_some(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    use palpate_monitor::recording::HEADER;

    #[test]
    fn samples_come_with_the_lines_before_them() {
        let file = format!(
            "{HEADER}\n1.000000,-3,0.0151,,1,,\"boot version=1 | state name=close from=idle\"\n1.001000,4,0.1,-3.4,-1,0.25,\n"
        );
        let rows = stream(file.as_bytes())
            .expect("well formed")
            .expect("whole");
        assert_eq!(
            rows[0].log,
            ["boot version=1", "state name=close from=idle"]
        );
        assert_eq!(rows[0].sample.time_us, 1_000_000);
        assert_eq!(rows[0].sample.joint, None);
        assert!(rows[0].sample.emf_v.is_nan());
        assert_eq!(
            rows[1].sample,
            Sample {
                time_us: 1_001_000,
                position_counts: 4,
                current_a: 0.1,
                emf_v: -3.4,
                drive: Drive::Opening,
                joint: Some(0.25),
            }
        );
        assert!(rows[1].log.is_empty());
    }

    #[test]
    fn what_lacks_samples_or_lines_is_no_stream() {
        let gap = format!("{HEADER}\n1.000,0,0,,1,,\n1.002,0,0,,1,,\n");
        assert_eq!(stream(gap.as_bytes()), Ok(None));
        assert_eq!(stream(format!("{HEADER}\n").as_bytes()), Ok(None));
        let other = "time_s,encoder_counts,current_a,duty\n1.000,0,0,1\n";
        assert_eq!(stream(other.as_bytes()), Ok(None));
        let wrong = format!("{HEADER}\n1.000,zero,0,,1,,\n");
        let error = stream(wrong.as_bytes()).expect_err("refused");
        assert!(error.to_string().contains("line 2, column encoder_counts"));
    }
}
