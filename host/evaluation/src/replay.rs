//! The sensing on a recording: what the firmware would have said.
//!
//! Passive: nothing is known of how the recording was made. Friction comes from a recording of a free motion, or from a
//! free closing that the recording itself contains.

use palpate::app::log;
use palpate::sample::{Drive, Sample};
use palpate::scene::Scene;
use palpate::sensing::{Directive, Event, Sensor};
use serde_json::{Map, Value, json};

use crate::trace::PERIOD_US;

/// A pause in a closing, microseconds, that does not yet end it.
const PAUSE_US: u64 = 100_000;
/// Share of the longest closing that a free one must have: one that stopped early may have touched something.
const FREE_SHARE: f64 = 0.9;
/// A closing shorter than this share of the scene's travel tells too little of its friction.
const LEAST_TRAVEL: f64 = 0.5;

/// A stretch of samples, by index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// First sample.
    pub from: usize,
    /// After the last sample.
    pub to: usize,
}

/// Where the recording of friction was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A recording of its own.
    Separate,
    /// A free closing (and what opening followed) in the recording itself.
    Within(Stretch),
    /// Nowhere: contacts cannot be told from friction.
    None,
}

/// An event with its time.
#[derive(Clone, Debug)]
pub struct Told {
    /// Microseconds from the recording's begin.
    pub time_us: u64,
    /// What was said.
    pub event: Event,
}

/// What a replay found.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Where friction was learned.
    pub friction: Source,
    /// What the sensing said.
    pub told: Vec<Told>,
}

/// Stretches driven in one direction.
fn stretches(samples: &[Sample], drive: Drive) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for (index, sample) in samples.iter().enumerate() {
        if sample.drive != drive {
            continue;
        }
        match found.last_mut() {
            Some(last)
                if sample.time_us.saturating_sub(samples[last.to - 1].time_us) <= PAUSE_US
                    && samples[last.to..index]
                        .iter()
                        .all(|s| s.drive == Drive::Idle) =>
            {
                last.to = index + 1;
            }
            _ => found.push(Stretch {
                from: index,
                to: index + 1,
            }),
        }
    }
    found
}

fn travel(samples: &[Sample], stretch: &Stretch) -> f64 {
    let (first, last) = (&samples[stretch.from], &samples[stretch.to - 1]);
    f64::from(last.position_counts.wrapping_sub(first.position_counts))
}

/// Mean current over the last quarter of a stretch, over that of its second quarter: a contact makes it rise.
fn rise(samples: &[Sample], stretch: &Stretch) -> f64 {
    let length = stretch.to - stretch.from;
    let mean = |from: usize, to: usize| {
        let part = &samples[stretch.from + from..stretch.from + to];
        part.iter().map(|s| f64::from(s.current_a)).sum::<f64>() / part.len().max(1) as f64
    };
    mean(3 * length / 4, length) / mean(length / 4, length / 2)
}

/// A free closing: among those as long as the longest, the one whose current rises least.
fn free_closing(samples: &[Sample], least_counts: f64) -> Option<Stretch> {
    let closings = stretches(samples, Drive::Closing);
    let longest = closings
        .iter()
        .map(|stretch| travel(samples, stretch))
        .fold(0.0, f64::max);
    if longest < least_counts {
        return None;
    }
    closings
        .into_iter()
        .filter(|stretch| {
            travel(samples, stretch) >= FREE_SHARE * longest && stretch.to - stretch.from > 100
        })
        .min_by(|a, b| rise(samples, a).total_cmp(&rise(samples, b)))
        // A closing that ends in a contact is no free one, however long.
        .filter(|stretch| (0.5..1.5).contains(&rise(samples, stretch)))
}

/// With the opening that follows, so that friction is known both ways.
fn with_opening(samples: &[Sample], closing: &Stretch) -> Stretch {
    let opening = stretches(samples, Drive::Opening)
        .into_iter()
        .find(|stretch| stretch.from >= closing.to);
    let next = stretches(samples, Drive::Closing)
        .into_iter()
        .find(|stretch| stretch.from >= closing.to);
    let to = match (opening, next) {
        (Some(opening), Some(next)) if opening.from > next.from => closing.to,
        (Some(opening), _) => opening.to,
        (None, _) => closing.to,
    };
    Stretch {
        from: closing.from,
        to,
    }
}

/// Replays `samples`, with the friction of `record` where there is one.
#[must_use]
pub fn replay<S: Scene>(samples: &[Sample], record: Option<&[Sample]>) -> Replay {
    let mut sensor = sensor::<S>(record.unwrap_or(samples));
    let drivetrain = S::drivetrain(sensor.finger());
    let least = LEAST_TRAVEL * f64::from(S::TRAVEL_RAD / drivetrain.rad_per_count);
    let mut told = Vec::new();
    let friction = match record {
        Some(record) => {
            learn(&mut sensor, record);
            Source::Separate
        }
        None => match free_closing(samples, least) {
            Some(closing) => {
                let stretch = with_opening(samples, &closing);
                learn(&mut sensor, &samples[stretch.from..stretch.to]);
                Source::Within(stretch)
            }
            None => Source::None,
        },
    };
    sensor.direct(Directive::Watch);
    let mut last_us = None;
    for sample in samples {
        // The sensing judges what it has when the drive stops; across a gap nothing is known.
        let gap = last_us.is_some_and(|last: u64| sample.time_us > last + PERIOD_US);
        if gap {
            let idle = Sample {
                drive: Drive::Idle,
                ..*sample
            };
            take(&mut sensor, &idle, &mut told);
        } else {
            take(&mut sensor, sample, &mut told);
        }
        last_us = Some(sample.time_us);
    }
    flush(&mut sensor, samples, &mut told);
    Replay { friction, told }
}

fn take<F: palpate::finger::Mechanics>(
    sensor: &mut Sensor<F>,
    sample: &Sample,
    told: &mut Vec<Told>,
) {
    if let Some(event) = sensor.update(sample) {
        told.push(Told {
            time_us: sample.time_us,
            event,
        });
    }
}

/// Samples at rest after the end, so that the last word is said.
const FLUSH: u64 = 200;

fn flush<F: palpate::finger::Mechanics>(
    sensor: &mut Sensor<F>,
    samples: &[Sample],
    told: &mut Vec<Told>,
) {
    let Some(last) = samples.last() else { return };
    for step in 1..=FLUSH {
        let idle = Sample {
            time_us: last.time_us + step * PERIOD_US,
            drive: Drive::Idle,
            current_a: 0.0,
            ..*last
        };
        take(sensor, &idle, told);
    }
}

/// Lets the sensor record friction. What it says of that, it says again where it is asked for the record.
fn learn<F: palpate::finger::Mechanics>(sensor: &mut Sensor<F>, samples: &[Sample]) {
    sensor.direct(Directive::RecordFriction);
    let mut ignored = Vec::new();
    for sample in samples {
        take(sensor, sample, &mut ignored);
    }
    flush(sensor, samples, &mut ignored);
}

/// The scene's sensor, set to the speed of the recording.
fn sensor<S: Scene>(samples: &[Sample]) -> Sensor<S::Finger> {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let mut settings = S::settings();
    if let Some(counts_per_s) = steady_speed(samples) {
        settings.speed_rad_per_s = (counts_per_s * f64::from(drivetrain.rad_per_count)) as f32;
    }
    Sensor::new(finger, drivetrain, settings, S::UNCALIBRATED)
}

/// Most frequent closing speed, counts per second: the median over tenths of a second of closing.
fn steady_speed(samples: &[Sample]) -> Option<f64> {
    const WINDOW: usize = 100;
    let mut speeds: Vec<f64> = samples
        .chunks_exact(WINDOW)
        .filter(|chunk| chunk.iter().all(|sample| sample.drive == Drive::Closing))
        .filter_map(|chunk| {
            let (first, last) = (chunk.first()?, chunk.last()?);
            let counts = last.position_counts.wrapping_sub(first.position_counts);
            let time_us = last.time_us.checked_sub(first.time_us)?;
            (time_us > 0).then(|| f64::from(counts) / (time_us as f64 * 1e-6))
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds
        .get(speeds.len() / 2)
        .copied()
        .filter(|speed| *speed > 0.0)
}

/// An event as name and fields, as the firmware's log has them; null what is not known.
#[must_use]
pub fn fields(event: &Event) -> (&'static str, Map<String, Value>) {
    let mut name = "";
    let mut map = Map::new();
    let write = |line: &'static log::Line, values: &[log::Value<'_>]| {
        name = line.name();
        let values = values.iter().map(|value| match *value {
            log::Value::Number(number) if number.is_finite() => {
                json!((f64::from(number) * 1e4).round() / 1e4)
            }
            log::Value::Number(_) => Value::Null,
            log::Value::Count(count) => json!(count),
            log::Value::Flag(flag) => json!(flag),
            log::Value::Text(text) => json!(text),
        });
        map.extend(line.keys.iter().map(ToString::to_string).zip(values));
    };
    log::event(&mut log::Fields(write), event);
    (name, map)
}

/// An event as a log line: `name key=value key=value`.
#[must_use]
pub fn line(event: &Event) -> String {
    let (name, fields) = fields(event);
    let mut out = name.to_owned();
    for (key, value) in fields.iter().filter(|(_, value)| !value.is_null()) {
        match value {
            Value::String(text) => out.push_str(&format!(" {key}={text}")),
            value => out.push_str(&format!(" {key}={value}")),
        }
    }
    out
}
