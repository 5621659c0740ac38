//! The guided calibration: what to do next, after each of its steps.

use core::fmt;

use crate::app::console::text::Whole;
use crate::drive::sequence::State;
use crate::finger::Mechanics;
use crate::scene::Scene;
use crate::sensing::location::SeriesElement;
use crate::sensing::{Calibration, Event, Refusal};

/// Places of the two pins as shares of the distal phalanx: where the finger is soft, for the torque factor, and where it is
/// stiff, so that the cable shows.
const PIN_SHARES: [f32; 2] = [0.3, 0.75];

/// What the user should do next; displayed as a sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hint {
    /// Put a pin at a place and calibrate there.
    Pin {
        /// From the joint of the distal phalanx, whole millimetres, as a pin is placed.
        k_mm: u16,
    },
    /// All steps are done: keep it.
    Save,
    /// Friction has to be recorded first, or again.
    RecordFriction,
    /// A step was refused: what to look at before it is repeated.
    Again(Refusal),
}

impl Hint {
    /// What follows from an event, given what is known after it; `None` for those outside the guided sequence.
    pub fn after<S: Scene>(event: &Event, known: &Calibration, finger: &S::Finger) -> Option<Self> {
        match event {
            // Where there is a cable, a press on the closing stop follows by itself, and its result leads on.
            Event::FrictionRecorded { .. } if !S::Series::FLEXIBLE && known.contacts == 0 => {
                Some(Self::next::<S>(known, finger))
            }
            Event::FrictionStale { .. } | Event::FrictionNotRecorded { .. } => {
                Some(Self::RecordFriction)
            }
            Event::Calibrated { calibration } => Some(Self::next::<S>(calibration, finger)),
            // It is known as well as this step can determine it: continue.
            Event::CalibrationRefused {
                why: Refusal::Uninformative,
            } => Some(Self::next::<S>(known, finger)),
            Event::CalibrationRefused { why } => Some(Self::Again(*why)),
            _ => None,
        }
    }

    /// Whether to tell it in this state of the motion. After a `stop` or a fault, which leave the motion at rest, a hint to repeat the
    /// calibration would blame the pin; a calibration that is refused for itself is told while the finger still moves.
    pub fn helps(&self, state: State) -> bool {
        !matches!((self, state), (Self::Again(_), State::Idle | State::Fault))
    }

    /// The step after those that have been taken: one pin, then the other. A press on the closing stop came by itself.
    fn next<S: Scene>(known: &Calibration, finger: &S::Finger) -> Self {
        let share = PIN_SHARES.get(usize::from(known.contacts));
        let length_m = finger.phalanx_length_m(S::PHALANGES);
        match (share, length_m) {
            (Some(share), Some(length_m)) => Self::Pin {
                k_mm: (share * length_m * 1e3 + 0.5) as u16,
            },
            _ => Self::Save,
        }
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pin { k_mm } => {
                let k_mm = Whole((*k_mm).into());
                return write!(
                    f,
                    "put a pin at {k_mm} mm from the last joint and enter: calibrate {k_mm}"
                );
            }
            Self::Save => "calibrated; remove any pin and enter: save",
            Self::RecordFriction => "free the finger and enter: record-friction",
            Self::Again(Refusal::NoContact) => {
                "no contact: put the pin in the finger's way; repeat"
            }
            Self::Again(Refusal::TooFewSamples) => {
                "short press: is current-limit or probe-torque low? repeat"
            }
            Self::Again(Refusal::NoSuchPlace) => {
                "no such place on the last phalanx: give a distance"
            }
            Self::Again(Refusal::Misfit) => {
                "not one fixed pin or stop: let nothing else touch; repeat"
            }
            Self::Again(Refusal::Implausible) => {
                "far from what is known: check the place, or enter: calibrate forget"
            }
            Self::Again(Refusal::Uninformative) => "nothing new learned: choose another place",
        })
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::scene::P70;

    fn known(presses: u16, contacts: u16) -> Calibration {
        Calibration {
            presses,
            contacts,
            ..P70::UNCALIBRATED
        }
    }

    fn after(event: Event, known: &Calibration) -> Option<Hint> {
        Hint::after::<P70>(&event, known, &P70::MECHANISM)
    }

    fn calibrated(presses: u16, contacts: u16) -> Option<Hint> {
        let calibration = known(presses, contacts);
        after(Event::Calibrated { calibration }, &calibration)
    }

    const RECORDED: Event = Event::FrictionRecorded {
        closing_nm: 0.1,
        opening_nm: -0.1,
        residual_nm: 1e-3,
        coverage: 1.0,
        wander_nm: 1e-3,
        wander_s: 2.0,
    };

    #[test]
    fn the_sequence_leads_from_friction_to_save() {
        let said = [
            // A press on the closing stop follows by itself.
            after(RECORDED, &known(0, 0)),
            calibrated(1, 0),
            calibrated(1, 1),
            calibrated(1, 2),
        ];
        assert_eq!(
            said,
            [
                None,
                Some(Hint::Pin { k_mm: 21 }),
                Some(Hint::Pin { k_mm: 53 }),
                Some(Hint::Save),
            ]
        );
    }

    #[test]
    fn whoever_begins_with_a_pin_is_led_to_the_rest() {
        assert_eq!(calibrated(0, 1), Some(Hint::Pin { k_mm: 53 }));
        assert_eq!(calibrated(1, 7), Some(Hint::Save));
    }

    #[test]
    fn a_calibrated_finger_that_records_friction_anew_is_not_led_on() {
        assert_eq!(after(RECORDED, &known(1, 2)), None);
        for event in [
            Event::FrictionStale { misfit_nm: 0.01 },
            Event::FrictionNotRecorded { coverage: 0.5 },
        ] {
            assert_eq!(after(event, &known(1, 2)), Some(Hint::RecordFriction));
        }
    }

    #[test]
    fn every_refusal_says_what_to_look_at_and_one_leads_on() {
        for why in [
            Refusal::NoContact,
            Refusal::TooFewSamples,
            Refusal::NoSuchPlace,
            Refusal::Misfit,
            Refusal::Implausible,
        ] {
            let said = after(Event::CalibrationRefused { why }, &known(1, 0));
            assert_eq!(said, Some(Hint::Again(why)));
        }
        let why = Refusal::Uninformative;
        let said = after(Event::CalibrationRefused { why }, &known(1, 1));
        assert_eq!(said, Some(Hint::Pin { k_mm: 53 }));
    }

    #[test]
    fn what_was_stopped_is_not_to_be_repeated() {
        let again = Hint::Again(Refusal::NoContact);
        for (state, told) in [
            (State::Probe, true),
            (State::Open, true),
            (State::Idle, false),
            (State::Fault, false),
        ] {
            assert_eq!(again.helps(state), told, "{state:?}");
            // Of a recording, which ends at rest.
            assert!(Hint::RecordFriction.helps(state));
        }
    }

    #[test]
    fn a_contact_needs_no_hint() {
        let touch = Event::Touch {
            time_us: 1,
            theta_a_rad: 0.1,
            torque_nm: 0.01,
        };
        assert_eq!(after(touch, &known(0, 0)), None);
    }
}
