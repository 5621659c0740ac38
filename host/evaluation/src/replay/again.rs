//! The sensing once more on what the firmware streamed: the same samples, the same directives, so the same events.
//!
//! Nothing is guessed here: which stage a sample served, what was kept from before and which pin was pressed on stand in the
//! log lines between the samples. What the firmware said live stands there too, and is compared with every digit.

use palpate::app::grasp::ContactSensing;
use palpate::app::grasp::coordinator::directive;
use palpate::app::grasp::sensing::SensingRequest;
use palpate::app::log::{self, Parsed, Value};
use palpate::drive::Fault;
use palpate::drive::sequence::State;
use palpate::scene::Scene;
use palpate::sensing::{Directive, Event, Followed, JointSensor, Object};
use palpate_scenes::kept;

use super::{Fields, Replay, Source, TimedEvent, fields, followed_fields, note, object_fields};
use crate::trace::Streamed;

/// Lines that say what the sensing found.
const EVENTS: [&str; 16] = [
    "friction-recorded",
    "friction-not-recorded",
    "friction-stale",
    "unusual",
    "stiffness",
    "touch",
    "located",
    "object",
    "ambiguous",
    "not-located",
    "calibrated",
    "calibration-refused",
    "second-contact",
    "grasp",
    "moved",
    "contact-change",
];

/// What the firmware said live against what was said again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Events in the recording.
    pub live: usize,
    /// Where the two differ: in text, in a digit or in the sample that an event came with.
    pub differences: Vec<String>,
}

/// Runs the sensing of scene `S` on a stream.
#[must_use]
pub fn again<S: Scene>(stream: &[Streamed]) -> (Replay, Comparison) {
    let mut following = Following::<S> {
        sensing: ContactSensing::new(),
        purpose: Directive::Watch,
        kept: Vec::new(),
    };
    let (mut told, mut followed, mut evidence) = (Vec::new(), Vec::new(), Vec::new());
    let mut objects = Vec::new();
    let mut live = Vec::new();
    let mut said = Vec::new();
    for (index, row) in stream.iter().enumerate() {
        for line in &row.log {
            let parsed = log::parse(line);
            following.line(line, &parsed);
            if EVENTS.contains(&parsed.name) {
                // Logged after the sample before this one had been taken.
                live.push((index, line.as_str()));
            }
        }
        let joint = <S::Joint as JointSensor>::recorded(row.sample.joint);
        let sample = row.sample.with_joint(joint);
        let event = following.sensing.sample(&sample);
        let after = following.sensing.follow(&sample, event.as_ref());
        let time_us = sample.time_us;
        note(
            &mut evidence,
            time_us,
            following.sensing.sensor().suspicion(),
        );
        if let Some(event) = event {
            said.push((index + 1, Said::Event(event)));
            told.push(TimedEvent { time_us, event });
            if let Some(object) = log::object_with(&event, following.sensing.object()) {
                said.push((index + 1, Said::Object(object)));
                objects.push((time_us, object));
            }
        }
        if let Some(event) = after {
            said.push((index + 1, Said::After(event)));
            followed.push((time_us, event));
        }
    }
    let replay = Replay {
        friction: Source::Live,
        told,
        followed,
        objects,
        evidence,
        settings: *following.sensing.sensor().settings(),
        calibration: *following.sensing.calibration(),
    };
    (replay, compare(&live, &said, stream.len()))
}

/// What was said again.
#[derive(Clone, Copy, Debug)]
enum Said {
    Event(Event),
    After(Followed),
    Object(Object),
}

impl Said {
    fn write(&self, log: &mut impl log::Log) {
        match self {
            Self::Event(event) => log::event(log, event),
            Self::After(event) => log::followed(log, event),
            Self::Object(object) => log::object(log, object),
        }
    }

    fn fields(&self) -> Fields {
        match self {
            Self::Event(event) => fields(event),
            Self::After(event) => followed_fields(event),
            Self::Object(object) => object_fields(object),
        }
    }
}

/// The sensing, led as the firmware led it.
struct Following<S: Scene> {
    sensing: ContactSensing<S>,
    purpose: Directive,
    /// What was kept in flash, as far as it was told.
    kept: Vec<u8>,
}

impl<S: Scene> Following<S> {
    fn line(&mut self, line: &str, parsed: &Parsed<'_>) {
        match parsed.name {
            "state" => {
                let name = parsed.field("name");
                let entered = State::ALL
                    .into_iter()
                    .find(|state| Some(state.name()) == name);
                if let Some(entered) = entered
                    && let Some(directive) = directive(entered, self.purpose)
                {
                    self.sensing.request(SensingRequest::Direct(directive));
                    if entered == State::Close {
                        self.purpose = Directive::Watch;
                    }
                }
            }
            // What the next closing is for.
            "calibrating" => {
                let k_m = parsed.field("pin_m").and_then(|text| text.parse().ok());
                self.purpose = match k_m.filter(|k_m: &f32| k_m.is_finite()) {
                    Some(k_m) => Directive::Calibrate {
                        phalanx: S::PHALANGES,
                        k_m,
                    },
                    None => Directive::CalibrateCable,
                };
            }
            "fault" => {
                let name = parsed.field("name").unwrap_or_default();
                if Fault::ALL
                    .iter()
                    .any(|fault| fault.name() == name && fault.loses_counts())
                {
                    self.sensing.request(SensingRequest::Realign);
                }
            }
            _ => {
                if let Some(piece) = line.strip_prefix("answer kept ") {
                    self.keep(piece);
                }
            }
        }
    }

    /// A piece of what was kept: its number from 0, and bytes.
    fn keep(&mut self, piece: &str) {
        let mut words = piece.split_whitespace();
        if words.next() == Some("0") {
            self.kept.clear();
        }
        self.kept
            .extend(words.filter_map(|word| word.parse::<u8>().ok()));
        // As long as pieces are missing it is refused; what was identified may follow a whole record.
        let sensing = &mut self.sensing;
        let _ = kept::<S, _>(&self.kept, |record| {
            sensing.restore(record);
        });
    }
}

/// Compares in order; what the last sample led to is no longer in the recording.
fn compare(live: &[(usize, &str)], said: &[(usize, Said)], rows: usize) -> Comparison {
    let said: Vec<_> = said.iter().filter(|(row, _)| *row < rows).collect();
    let mut differences = Vec::new();
    for index in 0..live.len().max(said.len()) {
        let difference = match (live.get(index), said.get(index)) {
            (Some((at, line)), Some((row, event))) => {
                if at == row && same(line, event) {
                    continue;
                }
                format!(
                    "live '{line}' at row {at}, again '{}' at row {row}",
                    super::line(&event.fields())
                )
            }
            (Some((at, line)), None) => format!("live '{line}' at row {at}, not said again"),
            (None, Some((row, event))) => {
                format!(
                    "not live, again '{}' at row {row}",
                    super::line(&event.fields())
                )
            }
            (None, None) => continue,
        };
        differences.push(difference);
    }
    Comparison {
        live: live.len(),
        differences,
    }
}

/// Whether a line is what an event would be logged as, to the last digit.
fn same(line: &str, said: &Said) -> bool {
    let live = log::parse(line);
    let mut equal = false;
    let compare = |form: &'static log::Line, values: &[Value<'_>]| {
        equal = form.name() == live.name
            && form.keys.iter().zip(values).all(|(key, value)| {
                let text = live.field(key).unwrap_or_default();
                match *value {
                    Value::Text(value) => text == value,
                    Value::Number(value) if value.is_nan() => text == "NaN",
                    Value::Number(value) => text.parse() == Ok(value),
                    Value::Count(value) => text.parse() == Ok(value),
                    Value::Flag(value) => text.parse() == Ok(value),
                }
            });
    };
    said.write(&mut log::Fields(compare));
    equal
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOUCH: Said = Said::Event(Event::Touch {
        time_us: 7,
        theta_a_rad: 0.5,
        torque_nm: 0.25,
    });

    #[test]
    fn every_event_is_a_line_of_the_log() {
        for name in EVENTS {
            assert!(log::LINES.iter().any(|line| line.name() == name), "{name}");
        }
    }

    #[test]
    fn equal_is_to_the_last_digit_and_with_the_same_sample() {
        let line = "touch time_us=7 theta_a_mrad=500.0 torque_mnm=250";
        assert!(same(line, &TOUCH));
        assert!(!same(
            "touch time_us=7 theta_a_mrad=500.00003 torque_mnm=250",
            &TOUCH
        ));
        let compared = |row, said: &[_]| compare(&[(row, line)], said, 10);
        assert_eq!(compared(3, &[(3, TOUCH)]).differences.len(), 0);
        assert_eq!(compared(3, &[(4, TOUCH)]).differences.len(), 1);
        assert_eq!(compared(3, &[]).differences.len(), 1);
        assert_eq!(compared(3, &[(3, TOUCH), (9, TOUCH)]).differences.len(), 1);
        // The recording ends before the firmware can have said it.
        assert_eq!(compared(3, &[(3, TOUCH), (10, TOUCH)]).differences.len(), 0);
    }
}
