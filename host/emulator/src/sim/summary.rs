// SPDX-License-Identifier: GPL-2.0-only
//! Result of a run next to the simulated truth.

use palpate_plant::ObjectMount;
use serde_json::{Map, Value, json};

use super::session::Session;
use crate::log::Line;

/// What the firmware said about the contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Told {
    /// A place on a phalanx beyond the first.
    Located,
    /// A contact on the first phalanx.
    Proximal,
    /// No contact.
    #[default]
    None,
    /// Softer than the free finger should be.
    Unusual,
    /// A contact that fits no place, or more than one.
    Ambiguous,
    /// The run ended in a fault, which nobody cleared.
    Fault,
}

impl Told {
    /// As in the summary.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Located => "located",
            Self::Proximal => "proximal",
            Self::None => "none",
            Self::Unusual => "unusual",
            Self::Ambiguous => "ambiguous",
            Self::Fault => "fault",
        }
    }
}

/// A stiffness as it was told, newton per millimetre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stiffness {
    /// This.
    Told(f64),
    /// Not less.
    Above(f64),
}

/// Estimate and truth of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// What the firmware said.
    pub told: Told,
    /// Why it has no place, in the firmware's word, as `unobservable`.
    pub why: Option<String>,
    /// Phalanx of the estimate.
    pub phalanx: Option<u32>,
    /// Estimated place.
    pub k_mm: Option<f64>,
    /// Claimed standard deviation.
    pub sigma_mm: Option<f64>,
    /// Where the finger first touched the object.
    pub true_phalanx: Option<u32>,
    /// The place there.
    pub true_k_mm: Option<f64>,
    /// Estimated contact force.
    pub force_n: Option<f64>,
    /// Force of that contact when the estimate was made.
    pub true_force_n: Option<f64>,
    /// Stiffness of the object by firmware that tells it, newton per millimetre: of one that cannot be told from a rigid one the least.
    pub object: Option<Stiffness>,
    /// Stiffness of the springs that hold it; `None` of a fixed one.
    pub true_object_n_per_mm: Option<f64>,
    /// Name of the first fault.
    pub fault: Option<String>,
    /// Executed instructions.
    pub instructions: u64,
    /// Simulated seconds.
    pub emulated_s: f64,
}

impl Summary {
    /// Reads a session's lines.
    #[must_use]
    pub fn of(session: &Session<'_>) -> Self {
        let mut summary = Self {
            fault: session.faults.first().map(|fault| fault.1.clone()),
            instructions: session.machine.account().total().instructions,
            emulated_s: session.machine.time_s(),
            ..Self::default()
        };
        for line in &session.lines {
            summary.hear(line);
        }
        if session.faulted() {
            summary.told = Told::Fault;
        }
        if let Some(plant) = session.machine.plant()
            && let Some(first) = plant.truth().first_contact
        {
            summary.true_phalanx = Some(first.contact.phalanx.into());
            summary.true_k_mm = Some(1e3 * first.contact.k_m);
        }
        let held = session
            .machine
            .plant()
            .map(|plant| plant.parameters().object);
        summary.true_object_n_per_mm = held
            .filter(|object| object.mount == ObjectMount::Spring)
            .map(|object| 1e-3 * object.stiffness_n_per_m);
        let truth = session.truth_at_estimate.as_ref();
        summary.true_force_n = truth
            .and_then(|truth| truth.strongest())
            .map(|contact| contact.force_n);
        summary
    }

    fn hear(&mut self, line: &Line) {
        let event = line.event();
        let mut place = |told| {
            self.told = told;
            self.why = event.field("why").map(str::to_owned);
            self.phalanx = event.number("phalanx").map(|n| n as u32);
            self.k_mm = event.number("k_mm");
            self.sigma_mm = event.number("sigma_mm");
            self.force_n = event.number("force_n");
            self.object = None;
        };
        match event.name {
            "located" if event.field("phalanx") == Some("1") => place(Told::Proximal),
            "located" => place(Told::Located),
            "ambiguous" => place(Told::Ambiguous),
            "unusual" => place(Told::Unusual),
            "not-located" => match event.field("why") {
                Some("proximal") => {
                    place(Told::Proximal);
                    (self.phalanx, self.why) = (Some(1), None);
                }
                Some("too-soft") => place(Told::Unusual),
                _ => place(Told::Ambiguous),
            },
            "object" => {
                let number = |key: &str| event.number(key).filter(|value| value.is_finite());
                self.object = number("stiffness_n_per_mm")
                    .map(Stiffness::Told)
                    .or_else(|| number("least_n_per_mm").map(Stiffness::Above));
            }
            // A new grasp begins.
            "state" if event.field("name") == Some("close") => place(Told::None),
            _ => {}
        }
    }

    /// As an object of a line of its own.
    #[must_use]
    pub fn json(&self, wall_s: f64) -> Value {
        let (object, least) = match self.object {
            Some(Stiffness::Told(stiffness)) => (Some(stiffness), None),
            Some(Stiffness::Above(least)) => (None, Some(least)),
            None => (None, None),
        };
        json!({
            "type": "summary",
            "verdict": self.told.name(),
            "why": self.why,
            "phalanx": self.phalanx,
            "k_mm": self.k_mm,
            "sigma_mm": self.sigma_mm,
            "true_phalanx": self.true_phalanx,
            "true_k_mm": self.true_k_mm,
            "force_n": self.force_n,
            "true_force_n": self.true_force_n,
            "object_n_per_mm": object,
            "object_least_n_per_mm": least,
            "true_object_n_per_mm": self.true_object_n_per_mm,
            "fault": self.fault,
            "instructions": self.instructions,
            "emulated_s": self.emulated_s,
            "wall_s": wall_s,
        })
    }

    /// For people.
    #[must_use]
    pub fn text(&self, wall_s: f64) -> String {
        let number = |value: Option<f64>, unit: &str| {
            value.map_or("-".to_owned(), |v| format!("{v:.2} {unit}"))
        };
        let phalanx = |value: Option<u32>| value.map_or("-".to_owned(), |n| n.to_string());
        let sigma = self
            .sigma_mm
            .map_or(String::new(), |s| format!(" +- {s:.2}"));
        let fault = self.fault.as_ref().filter(|_| self.told == Told::Fault);
        let reason = fault
            .or(self.why.as_ref())
            .map_or(String::new(), |name| format!(" ({name})"));
        let object = self.object.map_or(String::new(), |stiffness| {
            let told = match stiffness {
                Stiffness::Told(stiffness) => format!("{stiffness:.2} N/mm"),
                Stiffness::Above(least) => format!("above {least:.2} N/mm"),
            };
            let truth = self
                .true_object_n_per_mm
                .map_or("fixed".to_owned(), |stiffness| {
                    format!("{stiffness:.2} N/mm")
                });
            format!("object    {told:<20} {truth}\n")
        });
        let faster = self.emulated_s / wall_s.max(1e-9);
        format!(
            "verdict   {}{reason}\n\
             \x20         estimate             simulated truth\n\
             phalanx   {:<20} {}\n\
             k         {:<20} {}\n\
             force     {:<20} {}\n\
             {object}{} instructions, {:.2} s simulated in {wall_s:.2} s: {faster:.1} times real time\n",
            self.told.name(),
            phalanx(self.phalanx),
            phalanx(self.true_phalanx),
            number(self.k_mm, "mm") + &sigma,
            number(self.true_k_mm, "mm"),
            number(self.force_n, "N"),
            number(self.true_force_n, "N"),
            self.instructions,
            self.emulated_s,
        )
    }
}

/// A log line as an object: name, time since power-on, level and fields, numbers as numbers.
#[must_use]
pub fn event_json(line: &Line) -> Value {
    let event = line.event();
    let mut object = Map::new();
    object.insert("type".into(), "event".into());
    object.insert("name".into(), event.name.into());
    object.insert("t_s".into(), json!(line.time_s()));
    if !line.level.is_empty() {
        object.insert("level".into(), line.level.as_str().into());
    }
    for (key, text) in event.fields() {
        // A field must not hide what every event has.
        let key = if object.contains_key(key) {
            format!("field_{key}")
        } else {
            key.to_owned()
        };
        object.insert(key, value(text));
    }
    Value::Object(object)
}

fn value(text: &str) -> Value {
    match text {
        "true" => return true.into(),
        "false" => return false.into(),
        "NaN" | "inf" | "-inf" => return Value::Null,
        _ => {}
    }
    if let Ok(whole) = text.parse::<i64>() {
        return whole.into();
    }
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => json!(number),
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(message: &str) -> Line {
        Line {
            fetched_s: 2.0,
            timestamp: "1.500000".into(),
            level: "info".into(),
            message: message.into(),
            location: String::new(),
        }
    }

    #[test]
    fn what_has_no_place_says_why_until_the_next_word() {
        let mut summary = Summary::default();
        summary.hear(&line("not-located why=unobservable torque_nm=0.2"));
        assert_eq!(summary.json(1.0)["verdict"], "ambiguous");
        assert_eq!(summary.json(1.0)["why"], "unobservable");
        assert!(
            summary
                .text(1.0)
                .starts_with("verdict   ambiguous (unobservable)\n")
        );
        summary.hear(&line("not-located why=proximal torque_nm=0.2"));
        assert!(summary.text(1.0).starts_with("verdict   proximal\n"));
        summary.hear(&line(
            "located phalanx=2 k_mm=30.0 sigma_mm=1.0 force_n=2.0",
        ));
        assert_eq!(summary.json(1.0)["why"], Value::Null);
    }

    #[test]
    fn an_event_becomes_an_object_with_numbers() {
        let object = event_json(&line("state name=close n=3 k_mm=1.5 x=NaN ok=true"));
        let expected = r#"{"type":"event","name":"state","t_s":1.5,"level":"info","field_name":"close","n":3,"k_mm":1.5,"x":null,"ok":true}"#;
        assert_eq!(object.to_string(), expected);
    }
}
