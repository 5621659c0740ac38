//! Lines of a source: log lines, samples, and the summary of a simulation.
//!
//! Two forms are understood. The emulator prints one JSON object a line; probe-rs, defmt-print and the serial port print
//! `TIME [LEVEL] name key=value ... (FILE:LINE)`, where all but the text may be missing.

use palpate::app::log;
use serde_json::Value;

/// How important a log line is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For developers.
    Debug,
    /// What happens.
    #[default]
    Info,
    /// Something to look at.
    Warn,
    /// The motor is off, or was about to be.
    Error,
}

impl Level {
    /// Reads the word that defmt prints.
    #[must_use]
    pub fn parse(word: &str) -> Option<Self> {
        Some(match word.trim().to_ascii_lowercase().as_str() {
            "trace" | "debug" => Self::Debug,
            "info" => Self::Info,
            "warn" => Self::Warn,
            "error" => Self::Error,
            _ => return None,
        })
    }

    /// Four letters, for a column.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Debug => "DEBG",
            Self::Info => "INFO",
            Self::Warn => "WARN",
            Self::Error => "ERR ",
        }
    }
}

/// A log line: its words and fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Event {
    /// Seconds since the chip started, if the line tells.
    pub time_s: Option<f64>,
    /// Importance.
    pub level: Level,
    /// Words before the first field.
    pub name: String,
    /// Fields in the order of the line.
    pub fields: Vec<(String, String)>,
}

impl Event {
    /// A field's text.
    #[must_use]
    pub fn field(&self, key: &str) -> Option<&str> {
        self.fields
            .iter()
            .find(|field| field.0 == key)
            .map(|field| field.1.as_str())
    }

    /// A field as a finite number.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.field(key)?
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    }

    /// The line as the firmware wrote it.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.name.clone();
        for (key, value) in &self.fields {
            text.push(' ');
            text.push_str(key);
            text.push('=');
            text.push_str(value);
        }
        text
    }
}

/// One sample of the drivetrain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Second.
    pub time_s: f64,
    /// Encoder position, counts from the opening stop once homed.
    pub counts: f64,
    /// Motor current, ampere, closing positive.
    pub current_a: f64,
    /// Back-EMF, volt, where it is known.
    pub emf_v: Option<f64>,
    /// Duty of the bridge, or 1 where it closes, -1 where it opens, 0 where it is idle.
    pub duty: f64,
    /// Supply, volt, where it is known.
    pub supply_v: Option<f64>,
    /// Angle of joint 2, radian, where it is measured.
    pub joint_rad: Option<f64>,
    /// Torque that friction leaves unexplained, newton metre, while a contact is searched.
    pub residual_nm: Option<f64>,
    /// Evidence of a contact (logarithm of its likelihood ratio), and what it must exceed.
    pub evidence: Option<(f64, f64)>,
}

/// What one line means.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// The firmware said something.
    Event(Event),
    /// A sample.
    Sample(Sample),
    /// What is true, told by a simulation alone: contact location in millimetre with its phalanx.
    Truth {
        /// Phalanx that touches.
        phalanx: u32,
        /// Distance from its joint, millimetre.
        k_mm: f64,
        /// Contact force, newton.
        force_n: f64,
    },
    /// The source itself has something to say (an answer, an error).
    Note(String),
}

/// Reads one line; `None` for an empty one.
#[must_use]
pub fn parse(line: &str) -> Option<Message> {
    Some(match parse_line(line)? {
        Message::Event(event) if event.name == "sample" => Message::Sample(sample_of(&event)),
        other => other,
    })
}

/// The samples that `trace on` streams are log lines like all others.
fn sample_of(event: &Event) -> Sample {
    let number = |key: &str| event.number(key);
    Sample {
        time_s: number("time_us").map_or(event.time_s.unwrap_or_default(), |us| 1e-6 * us),
        counts: number("counts").unwrap_or_default(),
        current_a: number("current_a").unwrap_or_default(),
        emf_v: number("emf_v"),
        duty: number("drive").unwrap_or_default(),
        supply_v: number("supply_v"),
        joint_rad: number("joint_rad"),
        residual_nm: number("residual_mnm").map(|mnm| 1e-3 * mnm),
        evidence: number("evidence").zip(number("threshold")),
    }
}

fn parse_line(line: &str) -> Option<Message> {
    let line = line.trim_end_matches(['\r', '\n']);
    if line.trim().is_empty() {
        return None;
    }
    if line.starts_with('{')
        && let Ok(Value::Object(object)) = serde_json::from_str(line)
    {
        return Some(parse_object(object));
    }
    Some(parse_text(line))
}

fn parse_object(object: serde_json::Map<String, Value>) -> Message {
    let number = |key: &str| object.get(key).and_then(Value::as_f64);
    match object.get("type").and_then(Value::as_str) {
        Some("truth") => Message::Truth {
            phalanx: number("phalanx").unwrap_or_default() as u32,
            k_mm: number("k_mm").unwrap_or_default(),
            force_n: number("force_n").unwrap_or_default(),
        },
        Some("event") => {
            let mut event = Event {
                time_s: number("t_s"),
                ..Event::default()
            };
            for (key, value) in &object {
                let text = match value {
                    Value::String(text) => text.clone(),
                    Value::Null => "NaN".to_owned(),
                    other => other.to_string(),
                };
                match key.as_str() {
                    "type" | "t_s" => {}
                    "name" => event.name = text,
                    "level" => event.level = Level::parse(&text).unwrap_or_default(),
                    key => {
                        // The emulator renames a field that would hide the event's own name.
                        let key = key.strip_prefix("field_").unwrap_or(key);
                        event.fields.push((key.to_owned(), text));
                    }
                }
            }
            Message::Event(event)
        }
        _ => Message::Note(Value::Object(object).to_string()),
    }
}

fn parse_text(line: &str) -> Message {
    let mut event = Event::default();
    let mut rest = line.trim();
    if let Some((first, others)) = rest.split_once(' ')
        && let Ok(time_s) = first.parse()
    {
        event.time_s = Some(time_s);
        rest = others.trim_start();
    }
    if let Some(bracketed) = rest.strip_prefix('[')
        && let Some((word, others)) = bracketed.split_once(']')
        && let Some(level) = Level::parse(word)
    {
        event.level = level;
        rest = others.trim_start();
    } else if let Some((word, others)) = rest.split_once(' ')
        && let Some(level) = Level::parse(word)
    {
        event.level = level;
        rest = others.trim_start();
    }
    // The place in the source, which defmt printers add.
    if rest.ends_with(')')
        && let Some(at) = rest.rfind(" (")
        && rest[at..].contains(".rs:")
    {
        rest = &rest[..at];
    }
    let parsed = log::parse(rest);
    parsed.name.clone_into(&mut event.name);
    event.fields = parsed
        .fields()
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect();
    Message::Event(event)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(line: &str) -> Event {
        match parse(line) {
            Some(Message::Event(event)) => event,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn a_defmt_line_is_taken_apart() {
        let read = event(
            "14.9 [WARN ] friction-stale misfit_mnm=1.5 why=too far from it (src/board/telemetry.rs:145)",
        );
        assert_eq!(read.time_s, Some(14.9));
        assert_eq!(read.level, Level::Warn);
        assert_eq!(read.name, "friction-stale");
        assert_eq!(read.number("misfit_mnm"), Some(1.5));
        assert_eq!(read.field("why"), Some("too far from it"));
        assert_eq!(
            read.text(),
            "friction-stale misfit_mnm=1.5 why=too far from it"
        );
    }

    #[test]
    fn a_bare_line_is_a_name() {
        let read = event("calibrate forget");
        assert_eq!(
            (read.time_s, read.name.as_str()),
            (None, "calibrate forget")
        );
    }

    #[test]
    fn an_object_is_the_same_as_a_line() {
        let read = event(
            r#"{"type":"event","name":"state","t_s":1.5,"level":"info","field_name":"close","k_mm":null}"#,
        );
        assert_eq!(read.name, "state");
        assert_eq!(read.field("name"), Some("close"));
        assert_eq!(read.number("k_mm"), None);
    }

    #[test]
    fn a_sample_keeps_what_is_not_known_apart() {
        let read = parse("sample time_us=1000000 counts=12 current_a=0.01 drive=1 joint_rad=NaN");
        let Some(Message::Sample(sample)) = read else {
            panic!("{read:?}");
        };
        assert_eq!(
            (sample.time_s, sample.counts, sample.supply_v),
            (1.0, 12.0, None)
        );
    }

    #[test]
    fn nothing_that_comes_over_a_wire_panics() {
        for line in [
            "{",
            "}",
            "[",
            "= =",
            "1.0",
            "(",
            "[INFO",
            "a=(b.rs:",
            "{\"type\":3}",
            "\u{7f}\u{0}",
        ] {
            let _ = parse(line);
        }
        assert_eq!(parse("  "), None);
    }
}
