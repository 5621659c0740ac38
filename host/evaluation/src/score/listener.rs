//! From the events of a closing to what was said in the end.

use palpate::sensing::{Event, NotLocated};

use super::{Answer, Contact, Force, Trial};

/// Hears the events of one closing; the last word counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Listener {
    trial: Trial,
}

impl Listener {
    /// Hears an event at a time of the samples' clock, microseconds. `true_force_n` is asked for the force that acts then
    /// on a phalanx, newton.
    pub fn hear(&mut self, time_us: u64, event: &Event, true_force_n: impl Fn(f64, u8) -> f64) {
        let time_s = time_us as f64 * 1e-6;
        match *event {
            Event::Touch { .. } => {
                self.trial.touched_s.get_or_insert(time_s);
            }
            Event::Unusual { .. } => self.trial.unusual = true,
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                force_n,
                force_sigma_n,
                ..
            } => {
                self.trial.answer = Answer::Located {
                    phalanx,
                    k_m: f64::from(k_m),
                    sigma_m: f64::from(sigma_m),
                };
                self.trial.force = Some(Force {
                    time_s,
                    told_n: f64::from(force_n),
                    sigma_n: f64::from(force_sigma_n),
                    true_n: true_force_n(time_s, phalanx),
                });
            }
            Event::Ambiguous {
                phalanx: [phalanx, _],
                k_m: [k_m, _],
                sigma_m: [sigma_m, _],
                ..
            } => {
                self.trial.answer = Answer::Ambiguous {
                    phalanx,
                    k_m: f64::from(k_m),
                    sigma_m: f64::from(sigma_m),
                };
                self.trial.force = None;
            }
            Event::NotLocated { why, .. } => {
                self.trial.answer = match why {
                    NotLocated::Proximal => Answer::Proximal,
                    _ => Answer::NotLocated,
                };
                self.trial.force = None;
            }
            _ => {}
        }
    }

    /// What was said, next to the truth. A touch without any further word is a contact that was not located.
    #[must_use]
    pub fn trial(&self, truth: Option<Contact>) -> Trial {
        let mut trial = self.trial;
        trial.truth = truth;
        if trial.answer == Answer::Nothing && trial.touched_s.is_some() {
            trial.answer = Answer::NotLocated;
        }
        trial
    }
}
