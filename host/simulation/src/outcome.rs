//! Result of a motion.

use crate::Row;
use palpate::drive::fault::Fault;
use palpate::sample::Sample;
use palpate::sensing::{Directive, Event, Followed, Grip, NotLocated};
use palpate_plant::{FirstContact, Truth};

/// The last word on a grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Nothing was felt.
    Free,
    /// Located.
    Located {
        /// Phalanx, from 1.
        phalanx: u8,
        /// Place from its joint, metre.
        k_m: f64,
        /// Standard deviation, metre.
        sigma_m: f64,
        /// Contact force then, newton.
        force_n: f64,
        /// No more torque was needed.
        settled: bool,
    },
    /// Two places explain it.
    Ambiguous {
        /// Phalanges, the likelier first.
        phalanx: [u8; 2],
        /// Places, metre.
        k_m: [f64; 2],
        /// Standard deviations, metre.
        sigma_m: [f64; 2],
    },
    /// A contact without a place.
    NotLocated(NotLocated),
    /// Softer than the free finger.
    Unusual,
    /// A contact was felt, and no more said.
    Touched,
    /// The bridge was switched off.
    Fault(Fault),
}

/// Everything a motion showed.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Events with the time they were told, microseconds since reset.
    pub events: Vec<(u64, Event)>,
    /// What followed the first contact, as `events`, in scenes with that option.
    pub followed: Vec<(u64, Followed)>,
    /// What they amount to.
    pub verdict: Verdict,
    /// The true first contact since the object was placed.
    pub first_contact: Option<FirstContact>,
    /// The truth at the end.
    pub truth: Truth,
    /// The fault, if there was one.
    pub fault: Option<Fault>,
    /// What the sensing was given, with what each sample was good for.
    pub samples: Vec<(Directive, Sample)>,
    /// Samples next to the truth, if they were asked for.
    pub trace: Vec<Row>,
}

impl Outcome {
    /// Time from the true first contact to the first `Touch`, second.
    #[must_use]
    pub fn delay_s(&self) -> Option<f64> {
        let touched = self.events.iter().find_map(|(_, event)| match event {
            #[expect(clippy::cast_precision_loss, reason = "microseconds of a simulation")]
            Event::Touch { time_us, .. } => Some(*time_us as f64 * 1e-6),
            _ => None,
        });
        Some(touched? - self.first_contact?.time_s)
    }

    /// How the object was held at the end of the closing, in scenes that tell it.
    #[must_use]
    pub fn grip(&self) -> Option<Grip> {
        self.followed.iter().find_map(|(_, event)| match event {
            Followed::Grasp { grip, .. } => Some(*grip),
            _ => None,
        })
    }

    /// The second contact, in scenes that look for one.
    #[must_use]
    pub fn second_contact(&self) -> Option<Followed> {
        let mut events = self.followed.iter().map(|(_, event)| *event);
        events.find(|event| matches!(event, Followed::SecondContact { .. }))
    }

    /// Located minus true place, metre, if both are on the same phalanx.
    #[must_use]
    pub fn error_m(&self) -> Option<f64> {
        let truth = self.first_contact?.contact;
        match self.verdict {
            Verdict::Located { phalanx, k_m, .. } if phalanx == truth.phalanx => {
                Some(k_m - truth.k_m)
            }
            _ => None,
        }
    }
}

/// The last word among events.
pub(crate) fn verdict(events: &[(u64, Event)], fault: Option<Fault>) -> Verdict {
    if let Some(fault) = fault {
        return Verdict::Fault(fault);
    }
    let mut verdict = Verdict::Free;
    for (_, event) in events {
        match *event {
            Event::Touch { .. } => verdict = Verdict::Touched,
            Event::Unusual { .. } => verdict = Verdict::Unusual,
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                force_n,
                settled,
                ..
            } => {
                verdict = Verdict::Located {
                    phalanx,
                    k_m: k_m.into(),
                    sigma_m: sigma_m.into(),
                    force_n: force_n.into(),
                    settled,
                };
            }
            Event::Ambiguous {
                phalanx,
                k_m,
                sigma_m,
                ..
            } => {
                verdict = Verdict::Ambiguous {
                    phalanx,
                    k_m: k_m.map(f64::from),
                    sigma_m: sigma_m.map(f64::from),
                };
            }
            Event::NotLocated { why, .. } => verdict = Verdict::NotLocated(why),
            _ => {}
        }
    }
    verdict
}
