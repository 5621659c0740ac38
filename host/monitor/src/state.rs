//! State of the monitor: everything shown is read from here, everything received is put in here.

use std::collections::VecDeque;

use crate::stream::{Event, Level, Message, Sample};

/// Log lines kept.
const LOG_LINES: usize = 5_000;
/// Samples kept: a closing at one kilohertz.
const SAMPLES: usize = 12_000;

/// Where a contact is, as the firmware told it last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Phalanx, 1 for the proximal one.
    pub phalanx: u32,
    /// Distance from the phalanx's joint, millimetre.
    pub k_mm: f64,
    /// Its standard deviation, millimetre.
    pub sigma_mm: f64,
    /// Share of the belief in this place, 0 to 1.
    pub weight: f64,
}

/// The contact that is being followed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// Angle of the input link at touch, radian from the opening stop.
    pub touch_rad: Option<f64>,
    /// Places that explain it, the likelier first; empty where it is not located.
    pub places: Vec<Place>,
    /// Contact force, newton.
    pub force_n: Option<f64>,
    /// Effective contact radius, millimetre.
    pub radius_mm: Option<f64>,
    /// Stiffness of the object in words, from firmware that tells it.
    pub object: Option<String>,
    /// No further torque will improve it.
    pub settled: bool,
    /// Why there is no place.
    pub why: Option<String>,
}

/// A log line as kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Seconds, where known.
    pub time_s: Option<f64>,
    /// Importance.
    pub level: Level,
    /// Text.
    pub text: String,
}

/// Everything that was received, as far as it is still of use.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The log, oldest first.
    pub log: VecDeque<Line>,
    /// Samples since the last closing began, oldest first.
    pub samples: VecDeque<Sample>,
    /// State of the motion sequence.
    pub sequence: String,
    /// Scene, as the firmware names it.
    pub scene: Option<String>,
    /// The contact of this closing.
    pub contact: Option<Contact>,
    /// What a simulation knows to be true: phalanx, millimetre, newton.
    pub truth: Option<(u32, f64, f64)>,
    /// The fault that is latched.
    pub fault: Option<String>,
    /// Winding, degree Celsius.
    pub winding_c: Option<f64>,
    /// Supply, volt.
    pub supply_v: Option<f64>,
    /// Mean friction torque while closing, newton metre at the input link.
    pub friction_nm: Option<f64>,
    /// What the friction record leaves unexplained, newton metre.
    pub friction_residual_nm: Option<f64>,
    /// Torque factor of the calibration with its deviation.
    pub torque_factor: Option<(f64, f64)>,
    /// Compliance of the cable, as calibrated, radian per newton metre.
    pub cable_rad_per_nm: Option<f64>,
    /// Latest time seen, second.
    pub time_s: f64,
    /// Log records that were lost.
    pub dropped: u64,
    /// The source has ended.
    pub ended: bool,
}

impl State {
    /// Takes a message.
    pub fn take(&mut self, message: Message) {
        match message {
            Message::Event(event) => self.event(event),
            Message::Sample(sample) => {
                self.time_s = sample.time_s;
                if sample.supply_v.is_some() {
                    self.supply_v = sample.supply_v;
                }
                // A recording has no states: a closing begins where the finger has opened before.
                let driven = self.samples.iter().rev().find(|last| last.duty != 0.0);
                let opened = driven.is_some_and(|last| last.duty < 0.0);
                if self.sequence.is_empty() && sample.duty > 0.0 && opened {
                    self.forget_closing();
                }
                push(&mut self.samples, sample, SAMPLES);
            }
            Message::Truth {
                phalanx,
                k_mm,
                force_n,
            } => self.truth = Some((phalanx, k_mm, force_n)),
            Message::Note(text) => self.line(None, Level::Info, text),
        }
    }

    /// Adds a line of the monitor's own to the log.
    pub fn note(&mut self, level: Level, text: impl Into<String>) {
        self.line(Some(self.time_s), level, text.into());
    }

    fn line(&mut self, time_s: Option<f64>, level: Level, text: String) {
        push(
            &mut self.log,
            Line {
                time_s,
                level,
                text,
            },
            LOG_LINES,
        );
    }

    fn forget_closing(&mut self) {
        self.samples.clear();
        self.contact = None;
        self.truth = None;
    }

    fn event(&mut self, event: Event) {
        if let Some(time_s) = event.time_s {
            self.time_s = time_s;
        }
        match event.name.as_str() {
            "boot" => {
                self.scene = event.field("scene").map(str::to_owned);
                self.fault = None;
            }
            "state" => {
                // Only clearing it leads out of a fault.
                if event.field("from") == Some("fault") {
                    self.fault = None;
                }
                event
                    .field("name")
                    .unwrap_or_default()
                    .clone_into(&mut self.sequence);
                if matches!(self.sequence.as_str(), "close" | "record-closing" | "home") {
                    self.forget_closing();
                }
            }
            "fault" => self.fault = event.field("name").map(str::to_owned),
            "status" => {
                self.winding_c = event.number("winding_c").or(self.winding_c);
                self.supply_v = event.number("supply_v").or(self.supply_v);
                if event.number("fault") == Some(0.0) {
                    self.fault = None;
                }
            }
            "friction-recorded" => {
                self.friction_nm = event.number("closing_mnm").map(|value| 1e-3 * value);
                self.friction_residual_nm = event.number("residual_mnm").map(|value| 1e-3 * value);
            }
            "calibrated" => {
                self.torque_factor = event
                    .number("torque_factor")
                    .zip(event.number("torque_factor_sigma"));
                self.cable_rad_per_nm = event.number("cable_mrad_per_nm").map(|value| 1e-3 * value);
            }
            "log" => {
                // The firmware tells the total since it started.
                let total = event.number("dropped").unwrap_or_default();
                self.dropped = total.max(0.0) as u64;
            }
            "touch" => {
                self.contact = Some(Contact {
                    touch_rad: event.number("theta_a_mrad").map(|value| 1e-3 * value),
                    ..Contact::default()
                });
            }
            "located" | "ambiguous" | "not-located" => self.judged(&event),
            "object" => {
                if let Some(contact) = &mut self.contact {
                    contact.object = object(&event);
                }
            }
            _ => {}
        }
        // For a recording, not for a reader.
        let level = if event.name.starts_with("answer kept") {
            Level::Debug
        } else {
            event.level
        };
        self.line(event.time_s, level, event.text());
    }

    /// A word on the contact.
    fn judged(&mut self, event: &Event) {
        let contact = self.contact.get_or_insert_default();
        let place = |prefix: &str, weight| {
            Some(Place {
                phalanx: event.number(&format!("{prefix}phalanx"))? as u32,
                k_mm: event.number(&format!("{prefix}k_mm"))?,
                sigma_mm: event.number(&format!("{prefix}sigma_mm"))?,
                weight,
            })
        };
        let first = match event.name.as_str() {
            "ambiguous" => 0.5,
            _ => event.number("p_phalanx").unwrap_or(1.0),
        };
        contact.places = [place("", first), place("other_", 0.5)]
            .into_iter()
            .flatten()
            .collect();
        contact.why = event.field("why").map(str::to_owned);
        contact.force_n = event.number("force_n").or(contact.force_n);
        contact.radius_mm = event.number("radius_mm").or(contact.radius_mm);
        contact.settled = event.field("settled") == Some("true") || event.name == "not-located";
    }
}

/// The stiffness of an object, or the least that it has.
fn object(event: &Event) -> Option<String> {
    match event.number("stiffness_n_per_mm") {
        Some(stiffness) => Some(format!("{stiffness:.2} N/mm")),
        None => {
            let least = event.number("least_n_per_mm")?;
            Some(format!("above {least:.1} N/mm"))
        }
    }
}

fn push<T>(queue: &mut VecDeque<T>, value: T, most: usize) {
    if queue.len() >= most {
        queue.pop_front();
    }
    queue.push_back(value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::parse;

    fn told(lines: &[&str]) -> State {
        let mut state = State::default();
        for line in lines {
            state.take(parse(line).expect("a line"));
        }
        state
    }

    #[test]
    fn a_contact_is_followed_from_touch_to_place() {
        let state = told(&[
            "1.0 [INFO ] state name=close from=idle",
            "2.0 [INFO ] touch time_us=2000000 theta_a_mrad=800.5 torque_mnm=3.1",
            "2.1 [INFO ] located phalanx=2 k_mm=30.5 sigma_mm=0.6 force_n=0.8 radius_mm=11 settled=false",
        ]);
        let contact = state.contact.expect("a contact");
        assert_eq!(contact.touch_rad, Some(0.8005));
        assert_eq!(contact.places.len(), 1);
        assert_eq!(contact.places[0].k_mm, 30.5);
        assert!(!contact.settled);
    }

    #[test]
    fn an_object_is_as_stiff_as_told_or_stiffer_than_something() {
        let of = |stiffness: &str| {
            let line = format!(
                "2.2 [INFO ] object relative=stiffer stiffness_n_per_mm={stiffness} least_n_per_mm=0.41"
            );
            let located =
                "2.1 [INFO ] located phalanx=2 k_mm=30.5 sigma_mm=0.6 force_n=0.8 settled=true";
            let state = told(&["2.0 [INFO ] touch time_us=2000000", located, &line]);
            state.contact.and_then(|contact| contact.object)
        };
        assert_eq!(of("0.528"), Some("0.53 N/mm".to_owned()));
        assert_eq!(of("NaN"), Some("above 0.4 N/mm".to_owned()));
    }

    #[test]
    fn another_closing_forgets_the_contact() {
        let state = told(&[
            "touch theta_a_mrad=800",
            "located phalanx=2 k_mm=30 sigma_mm=1 settled=true",
            "state name=close from=idle",
        ]);
        assert_eq!(state.contact, None);
        assert_eq!(state.sequence, "close");
    }

    #[test]
    fn a_fault_is_shown_until_it_is_cleared() {
        let latched = ["state name=fault from=close", "fault number=12 name=stall"];
        assert_eq!(told(&latched).fault.as_deref(), Some("stall"));
        let cleared = [latched[0], latched[1], "state name=idle from=fault"];
        assert_eq!(told(&cleared).fault, None);
    }

    #[test]
    fn both_places_of_an_ambiguous_contact_are_kept() {
        let state = told(&[
            "ambiguous phalanx=2 k_mm=20 sigma_mm=1 other_phalanx=3 other_k_mm=5 other_sigma_mm=2 settled=true",
        ]);
        let places = state.contact.expect("a contact").places;
        assert_eq!((places.len(), places[1].phalanx), (2, 3));
    }

    #[test]
    fn the_log_does_not_grow_for_ever() {
        let mut state = State::default();
        for _ in 0..LOG_LINES + 10 {
            state.note(Level::Info, "x");
        }
        assert_eq!(state.log.len(), LOG_LINES);
    }
}
