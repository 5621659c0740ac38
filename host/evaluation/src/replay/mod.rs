//! The sensing on a recording: what the firmware would have said.
//!
//! A recording that the firmware streamed tells what each sample was for, and the same events come out of it (`again`). Any
//! other is watched passively: nothing is known of how the recording was made. Friction comes from a recording of a free motion, or from a
//! free closing that the recording itself contains; torque factor and cable from recordings of a press and of pins.
//!
//! | module | what it does |
//! |---|---|
//! | `again` | the same events from what the firmware streamed |
//! | `find` | free motion in a recording |
//! | `kept` | what the firmware had in flash |
//! | `event` | events as text and JSON |

mod again;
mod event;
mod find;

use again::again;

pub use again::Comparison;
pub use event::{Fields, fields, followed_fields, line, object_fields};
pub use find::{MotionSegment, NoFreeClosing};

use palpate::app::log::object_with;
use palpate::finger::Mechanics;
use palpate::sample::{Drive, Sample};
use palpate::scene::Scene;
use palpate::sensing::{
    AfterContact, Calibration, Directive, Event, Followed, NoJointSensor, Object, Sensor,
    SeriesElement, Settings, Suspicion,
};

use crate::recordings::protocol::{FLUSH, LAST_WORD, Speeds, idle_after};
use crate::trace::{PERIOD_US, Streamed};

/// Where the recording of friction was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// What the firmware itself knew or recorded.
    Live,
    /// A recording of its own.
    Separate,
    /// A free closing (and what opening followed) in the recording itself.
    Within(MotionSegment),
    /// Nowhere: contacts cannot be told from friction.
    None(NoFriction),
}

/// Why friction is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoFriction {
    /// No free motion was found.
    NoFreeClosing(NoFreeClosing),
    /// A free closing, but no opening after it.
    NoOpening {
        /// When the closing ends, second.
        closed_s: f64,
    },
    /// Too little of the free motion could be used.
    Coverage {
        /// Share of the travel that was covered both ways.
        coverage: f32,
    },
}

impl std::fmt::Display for NoFriction {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoFreeClosing(why) => write!(out, "no free closing: {why}"),
            Self::NoOpening { closed_s } => write!(
                out,
                "no opening follows the free closing that ends at {closed_s:.3} s: friction is recorded both ways"
            ),
            Self::Coverage { coverage } => write!(
                out,
                "no friction was learnt from the free motion, of which {:.0} % of the travel were used (60 % are needed, both ways, at \
                 a steady speed, from the opening stop on): is the zero right (--zero-counts), is the speed even?",
                100.0 * coverage
            ),
        }
    }
}

/// An event with its time.
#[derive(Clone, Debug)]
pub struct TimedEvent {
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
    pub told: Vec<TimedEvent>,
    /// What it said after the first contact, in scenes with that option, with the time from the recording's begin.
    pub followed: Vec<(u64, Followed)>,
    /// How stiff the objects of its places are, in scenes with that option; times in microseconds.
    pub objects: Vec<(u64, Object)>,
    /// How near the search for a contact was to a decision, with the time from the recording's begin, wherever it changed.
    pub evidence: Vec<(u64, Suspicion)>,
    /// The settings in force.
    pub settings: Settings,
    /// The calibration in force after it.
    pub calibration: Calibration,
}

/// Keeps what the search makes of a sample, if it is something else than of the sample before.
fn note(evidence: &mut Vec<(u64, Suspicion)>, time_us: u64, found: Option<Suspicion>) {
    if let Some(found) = found
        && evidence.last().is_none_or(|last| last.1 != found)
    {
        evidence.push((time_us, found));
    }
}

impl Replay {
    /// Everything that was said in the order of time: microseconds from the recording's begin, name and fields.
    #[must_use]
    pub fn lines(&self) -> Vec<(u64, Fields)> {
        let told = (self.told.iter()).map(|told| (told.time_us, fields(&told.event)));
        let followed =
            (self.followed.iter()).map(|(time_us, event)| (*time_us, followed_fields(event)));
        let objects =
            (self.objects.iter()).map(|(time_us, object)| (*time_us, object_fields(object)));
        let mut lines: Vec<_> = told.chain(objects).chain(followed).collect();
        lines.sort_by_key(|(time_us, _)| *time_us);
        lines
    }
}

/// What is known before a recording is replayed.
#[derive(Clone, Debug)]
pub struct Preparation<'a> {
    /// Recording of a free closing and opening, instead of one searched in the recording.
    pub friction: Option<&'a [Sample]>,
    /// Torque factor and cable.
    pub calibration: Calibration,
}

/// Replays recordings with the sensing of a scene that is known by its name. Function pointers, so that the sensing of each scene is
/// compiled once, in this crate, and not again in every program and test that replays.
#[derive(Clone, Copy, Debug)]
pub struct Replayer {
    /// [`Scene::UNCALIBRATED`].
    pub uncalibrated: Calibration,
    /// [`Mechanics::PHALANGES`] of its finger.
    pub phalanges: u8,
    /// Resistance of its motor, ohm.
    pub motor_ohm: f32,
    /// Replays samples of any origin; the directive says what their closings are for: [`Directive::Watch`] but for calibrations.
    pub replay: fn(&[Sample], &Preparation, Directive) -> Replay,
    /// Replays what the firmware streamed, and compares the events with those that it told.
    pub again: fn(&[Streamed]) -> (Replay, Comparison),
}

impl Replayer {
    /// That of a scene, where there is one of this name.
    #[must_use]
    pub fn of(scene: &str) -> Option<Self> {
        palpate_scenes::for_scene!(scene, |S| Self::new::<S>())
    }

    fn new<S: Scene>() -> Self {
        Self {
            uncalibrated: S::UNCALIBRATED,
            phalanges: S::PHALANGES,
            motor_ohm: S::DRIVE.motor.resistance_ohm,
            replay: replay::<S>,
            again: again::<S>,
        }
    }
}

/// Replays `samples`; `purpose` is what its closings are for, [`Directive::Watch`] but for calibrations.
#[must_use]
fn replay<S: Scene>(samples: &[Sample], before: &Preparation, purpose: Directive) -> Replay {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let source = before.friction.unwrap_or(samples);
    let speeds = Speeds::of(source, &S::settings(), drivetrain.rad_per_count);
    let mut sensor: Sensor<S::Finger, NoJointSensor, S::Series> =
        Sensor::new(finger, drivetrain, speeds.closing, before.calibration);
    let travel = f64::from(S::TRAVEL_RAD / drivetrain.rad_per_count);
    let found = match before.friction {
        Some(record) => learn(&mut sensor, record, &speeds).map(|()| Source::Separate),
        None => within(&mut sensor, samples, &speeds, travel),
    };
    let friction = found.unwrap_or_else(Source::None);
    // What calibrates comes after the free motion; a watch does not mind it.
    let from = match (&friction, purpose) {
        (_, Directive::Watch) => 0,
        (Source::Within(stretch), _) => stretch.to,
        _ => 0,
    };
    sensor.direct(purpose);
    let mut after = S::After::default();
    after.direct(purpose);
    let (mut told, mut followed, mut evidence) = (Vec::new(), Vec::new(), Vec::new());
    let mut objects = Vec::new();
    let mut last_us = None;
    let mut take_after =
        |sensor: &mut Sensor<_, _, _>, sample: &Sample, before: usize, told: &[TimedEvent]| {
            let told = told.get(before).map(|told| &told.event);
            if let Some(event) = after.sample(sensor, sample, told) {
                followed.push((sample.time_us, event));
            }
        };
    let mut take_object =
        |sensor: &Sensor<_, _, _>, sample: &Sample, before: usize, told: &[TimedEvent]| {
            let object = told
                .get(before)
                .and_then(|told| object_with(&told.event, sensor.object()));
            objects.extend(object.map(|object| (sample.time_us, object)));
        };
    for sample in &samples[from..] {
        // The sensing judges what it has when the drive stops; across a gap nothing is known.
        let gap = last_us.is_some_and(|last: u64| sample.time_us > last + PERIOD_US);
        let idle = Sample {
            drive: Drive::Idle,
            ..*sample
        };
        let (sample, before) = (if gap { &idle } else { sample }, told.len());
        take(&mut sensor, sample, &mut told);
        take_object(&sensor, sample, before, &told);
        take_after(&mut sensor, sample, before, &told);
        note(&mut evidence, sample.time_us, sensor.suspicion());
        last_us = Some(sample.time_us);
    }
    for idle in idle_after(samples, LAST_WORD) {
        let before = told.len();
        take(&mut sensor, &idle, &mut told);
        take_object(&sensor, &idle, before, &told);
        take_after(&mut sensor, &idle, before, &told);
    }
    Replay {
        friction,
        told,
        followed,
        objects,
        evidence,
        settings: *sensor.settings(),
        calibration: *sensor.calibration(),
    }
}

/// Learns friction from a free closing in the recording itself.
fn within<F: Mechanics, X: SeriesElement>(
    sensor: &mut Sensor<F, NoJointSensor, X>,
    samples: &[Sample],
    speeds: &Speeds,
    travel_counts: f64,
) -> Result<Source, NoFriction> {
    let closing = find::free_closing(samples, travel_counts).map_err(NoFriction::NoFreeClosing)?;
    let stretch = find::with_opening(samples, &closing);
    if stretch.to == closing.to {
        return Err(NoFriction::NoOpening {
            closed_s: samples[closing.to - 1].time_us as f64 * 1e-6,
        });
    }
    learn(sensor, &samples[stretch.from..stretch.to], speeds)?;
    Ok(Source::Within(stretch))
}

fn take<F: Mechanics, X: SeriesElement>(
    sensor: &mut Sensor<F, NoJointSensor, X>,
    sample: &Sample,
    told: &mut Vec<TimedEvent>,
) {
    if let Some(event) = sensor.update(sample) {
        told.push(TimedEvent {
            time_us: sample.time_us,
            event,
        });
    }
}

fn flush<F: Mechanics, X: SeriesElement>(
    sensor: &mut Sensor<F, NoJointSensor, X>,
    samples: &[Sample],
    told: &mut Vec<TimedEvent>,
) {
    for idle in idle_after(samples, FLUSH) {
        take(sensor, &idle, told);
    }
}

/// Lets the sensor record friction. An opening may have another speed than the closings: the sensing is told that speed while
/// it lasts.
fn learn<F: Mechanics, X: SeriesElement>(
    sensor: &mut Sensor<F, NoJointSensor, X>,
    samples: &[Sample],
    speeds: &Speeds,
) -> Result<(), NoFriction> {
    sensor.direct(Directive::RecordFriction);
    let mut told = Vec::new();
    for sample in samples {
        sensor.set_settings(speeds.at(sample.drive));
        take(sensor, sample, &mut told);
    }
    sensor.set_settings(speeds.closing);
    sensor.direct(Directive::Rest);
    flush(sensor, samples, &mut told);
    for told in told {
        if let Event::FrictionNotRecorded { coverage } = told.event {
            return Err(NoFriction::Coverage { coverage });
        }
    }
    Ok(())
}
