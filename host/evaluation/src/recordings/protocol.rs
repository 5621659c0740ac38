//! The product's own protocol, followed in a recording: rest, free closing, opening, closing again onto what is there.
//!
//! What the samples are good for is derived from the motion alone, as a firmware knows it: the first closing and the
//! opening after it record friction, the second closing is watched (or calibrates).

use palpate::finger::Mechanics;
use palpate::sample::{Drive, Sample};
use palpate::sensing::{Directive, Event, NoJointSensor, Sensor, SeriesElement, Settings};

use crate::trace::PERIOD_US;

/// Samples at rest after a motion, so that what was begun ends.
pub const FLUSH: u64 = 600;
/// The same after a recording, so that the last word is said. Where a second contact spoils the curve, the locator tries ever shorter parts
/// of it first, and may have its last word seconds later. The firmware goes on with that while it holds and opens the finger, for as long.
pub const LAST_WORD: u64 = 8000;
/// Least samples at rest before the first motion from which the offset of the current sense is taken.
const OFFSET_SAMPLES: usize = 50;
/// Window over which a steady speed is taken, samples.
const SPEED_WINDOW: usize = 100;

/// Where in the protocol a recording is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    #[default]
    Rest,
    FreeClosing,
    Opening,
    Closing,
}

/// Follows the motion and says what the samples are good for.
#[derive(Clone, Debug)]
pub struct Protocol {
    purpose: Directive,
    stage: Stage,
}

impl Protocol {
    /// `purpose`: what the second closing is for.
    #[must_use]
    pub fn new(purpose: Directive) -> Self {
        Self {
            purpose,
            stage: Stage::Rest,
        }
    }

    /// The directive that begins with this sample.
    pub fn directive(&mut self, drive: Drive) -> Option<Directive> {
        let (stage, directive) = match (self.stage, drive) {
            (Stage::Rest, Drive::Closing) => (Stage::FreeClosing, Some(Directive::RecordFriction)),
            (Stage::FreeClosing, Drive::Opening) => (Stage::Opening, None),
            (Stage::Opening, Drive::Closing) => (Stage::Closing, Some(self.purpose)),
            _ => return None,
        };
        self.stage = stage;
        directive
    }

    /// Whether the second closing has come.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.stage == Stage::Closing
    }
}

/// Takes the offset of the current sense off, as measured at rest before the first motion: the current carries the sign
/// of the drive, its offset too.
pub fn remove_offset(samples: &mut [Sample]) {
    let resting = samples
        .iter()
        .take_while(|sample| sample.drive == Drive::Idle)
        .count();
    if resting < OFFSET_SAMPLES {
        return;
    }
    // The last of them may already be driven, and the finger not yet turn.
    let rest = &samples[..resting - OFFSET_SAMPLES / 2];
    let sum: f64 = rest.iter().map(|sample| f64::from(sample.current_a)).sum();
    let offset_a = (sum / rest.len() as f64) as f32;
    for sample in samples {
        sample.current_a -= match sample.drive {
            Drive::Opening => -offset_a,
            Drive::Closing | Drive::Idle => offset_a,
        };
    }
}

/// Steady speed of the motion in one direction, counts per second without sign: the median over tenths of a second of its
/// first run, before anything can be touched.
#[must_use]
pub fn speed(samples: &[Sample], drive: Drive) -> Option<f64> {
    let other = match drive {
        Drive::Closing => Drive::Opening,
        _ => Drive::Closing,
    };
    let begin = samples.iter().position(|sample| sample.drive == drive)?;
    let end = samples[begin..]
        .iter()
        .position(|sample| sample.drive == other)
        .map_or(samples.len(), |length| begin + length);
    let mut speeds: Vec<f64> = samples[begin..end]
        .chunks_exact(SPEED_WINDOW)
        .filter(|chunk| chunk.iter().all(|sample| sample.drive == drive))
        .filter_map(|chunk| {
            let (first, last) = (chunk.first()?, chunk.last()?);
            let counts = last.position_counts.wrapping_sub(first.position_counts);
            let time_us = last.time_us.checked_sub(first.time_us)?;
            (time_us > 0).then(|| f64::from(counts).abs() / (time_us as f64 * 1e-6))
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds
        .get(speeds.len() / 2)
        .copied()
        .filter(|speed| *speed > 0.0)
}

/// Settings of the sensing with the speeds of a recording: an opening may have another one than the closings.
#[derive(Clone, Copy, Debug)]
pub struct Speeds {
    /// While closing.
    pub closing: Settings,
    /// While opening.
    pub opening: Settings,
}

impl Speeds {
    /// What the product would have been set to for these samples.
    #[must_use]
    pub fn of(samples: &[Sample], nominal: &Settings, rad_per_count: f32) -> Self {
        let at = |drive| {
            let mut settings = *nominal;
            if let Some(counts_per_s) = speed(samples, drive) {
                settings.speed_rad_per_s = (counts_per_s * f64::from(rad_per_count)) as f32;
            }
            settings
        };
        Self {
            closing: at(Drive::Closing),
            opening: at(Drive::Opening),
        }
    }

    /// Settings for a sample.
    #[must_use]
    pub fn at(&self, drive: Drive) -> Settings {
        match drive {
            Drive::Opening => self.opening,
            Drive::Closing | Drive::Idle => self.closing,
        }
    }
}

/// Some samples of a motor at rest after the last sample: the sensor ends with them what it has begun.
pub fn idle_after(samples: &[Sample], number: u64) -> impl Iterator<Item = Sample> {
    let last = samples.last().copied();
    last.into_iter().flat_map(move |last| {
        (1..=number).map(move |step| Sample {
            time_us: last.time_us + step * PERIOD_US,
            drive: Drive::Idle,
            current_a: 0.0,
            ..last
        })
    })
}

/// Replays samples by the protocol, and hands what the sensing says of them to `hear`, with its time. `false`: there was
/// no second closing.
pub fn follow<F: Mechanics, X: SeriesElement>(
    sensor: &mut Sensor<F, NoJointSensor, X>,
    samples: &[Sample],
    speeds: &Speeds,
    purpose: Directive,
    mut hear: impl FnMut(u64, &Event),
) -> bool {
    let mut protocol = Protocol::new(purpose);
    for sample in samples {
        if let Some(directive) = protocol.directive(sample.drive) {
            sensor.direct(directive);
        }
        sensor.set_settings(speeds.at(sample.drive));
        if let Some(event) = sensor.update(sample) {
            hear(sample.time_us, &event);
        }
    }
    for idle in idle_after(samples, LAST_WORD) {
        if let Some(event) = sensor.update(&idle) {
            hear(idle.time_us, &event);
        }
    }
    protocol.is_complete()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_ms: u64, counts: i32, current_a: f32, drive: Drive) -> Sample {
        Sample {
            time_us: 1000 * time_ms,
            position_counts: counts,
            current_a,
            emf_v: f32::NAN,
            drive,
            joint: (),
        }
    }

    #[test]
    fn the_second_closing_is_watched_and_the_first_records() {
        let mut protocol = Protocol::new(Directive::Watch);
        let drives = [
            (Drive::Idle, None),
            (Drive::Closing, Some(Directive::RecordFriction)),
            (Drive::Idle, None),
            (Drive::Closing, None),
            (Drive::Opening, None),
            (Drive::Idle, None),
            (Drive::Closing, Some(Directive::Watch)),
            (Drive::Idle, None),
            (Drive::Closing, None),
        ];
        for (drive, expected) in drives {
            assert_eq!(protocol.directive(drive), expected);
        }
        assert!(protocol.is_complete());
    }

    #[test]
    fn the_offset_is_taken_off_with_the_sign_of_the_drive() {
        let mut samples: Vec<Sample> = (0..200)
            .map(|ms| sample(ms, 0, 0.002, Drive::Idle))
            .collect();
        samples.push(sample(200, 40, 0.022, Drive::Closing));
        samples.push(sample(201, 0, -0.022, Drive::Opening));
        remove_offset(&mut samples);
        let current = |i: usize| samples[i].current_a;
        assert!(current(0).abs() < 1e-6);
        assert!((current(200) - 0.020).abs() < 1e-6);
        assert!((current(201) + 0.020).abs() < 1e-6);
    }

    #[test]
    fn the_speed_is_that_of_the_first_closing() {
        let mut samples: Vec<Sample> = (0..1000)
            .map(|ms| sample(ms, 60 * ms as i32, 0.0, Drive::Closing))
            .collect();
        samples.push(sample(1000, 59_000, 0.0, Drive::Opening));
        samples.extend((1001..4000).map(|ms| sample(ms, 10 * ms as i32, 0.0, Drive::Closing)));
        let speed = speed(&samples, Drive::Closing).expect("it closes");
        assert!((speed - 60_000.0).abs() < 1.0, "{speed}");
    }
}
