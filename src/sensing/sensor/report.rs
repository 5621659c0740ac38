//! Reports a contact: a location, an ambiguity or a reason why not, if it differs from the last report.

use super::contact::Contact;
use super::state::SensorState;
use crate::finger::{Mechanics, VAGUE};
use crate::joint_sensor::JointSensor;
use crate::numeric::Bounded;
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::{Estimate, LocatorResult, Prior};
use crate::sensing::{Event, NotLocated, Object, Refusal};

/// A location is reported again when its deviation has shrunk by this factor.
const SHARPER: f32 = 0.75;
/// Share of the torque limit above which a proximal contact is reported: below, it may be a contact near the joint.
const SURE_PROXIMAL: f32 = 0.5;

/// Probability of a phalanx from which on a place on it that is too uncertain is known to be on it (chosen).
const SURE_PHALANX: f32 = 0.9;
/// Deviations from joint 2 within which a place may be a contact on phalanx 1: of a first place whose curve began like one there, and of
/// one that a second contact follows.
pub(in crate::sensing) const NEAR_SIGMAS: f32 = 2.0;

/// The last report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reported {
    Nothing,
    Located(Spot),
    Ambiguous,
    /// Nothing was told so far, and an earlier round found that the contact may be on phalanx 1.
    MaybeProximal,
    /// Unobservable, but likely to be on a phalanx.
    Vague(Spot),
}

/// Where a contact is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub(super) phalanx: u8,
    pub(super) k_m: f32,
    pub(super) sigma_m: f32,
}

/// Whether a place that a verdict has is too uncertain to be one. Of two places as well: "here, or anywhere" is no choice.
fn is_vague(verdict: &LocatorResult) -> bool {
    let vague = |of: &Estimate| of.k_sigma_m >= VAGUE * of.length_m;
    match verdict {
        LocatorResult::At(estimate) => vague(estimate),
        LocatorResult::Either(estimates) => estimates.iter().any(vague),
        _ => false,
    }
}

/// Where a contact may be whose place is too uncertain to be one, with the larger deviation of two; nothing where its phalanx is not known
/// either.
fn vague_place(verdict: &LocatorResult) -> Reported {
    let (estimate, sigma_m) = match verdict {
        LocatorResult::At(estimate) => (estimate, estimate.k_sigma_m),
        LocatorResult::Either([estimate, other]) => {
            (estimate, estimate.k_sigma_m.at_least(other.k_sigma_m))
        }
        _ => return Reported::Nothing,
    };
    if estimate.p_phalanx > SURE_PHALANX {
        Reported::Vague(Spot {
            phalanx: estimate.phalanx,
            k_m: estimate.k_m,
            sigma_m,
        })
    } else {
        Reported::Nothing
    }
}

/// Whether a place is so near to joint 2 that the contact may be one on phalanx 1.
fn is_near_joint(verdict: &LocatorResult) -> bool {
    matches!(verdict, LocatorResult::At(of) if of.phalanx == 2 && of.k_m < NEAR_SIGMAS * of.k_sigma_m)
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Reports the verdict at the end of a round if it is new; `last` makes it final.
    pub(super) fn report(&mut self, contact: &mut Contact<F, H, X>, last: bool) {
        let prior = self.prior(&contact.collector);
        self.joint_change = H::change(contact.collector.reading, contact.collector.waiting.reading);
        let verdict = contact.locator.verdict(&prior);
        match verdict {
            verdict
                if is_vague(&verdict)
                    || contact.reported == Reported::MaybeProximal && is_near_joint(&verdict) =>
            {
                if last {
                    self.emit_nowhere(contact, NotLocated::Unobservable);
                    // Keep the place for the search for a second contact.
                    if F::MOVES_ON {
                        contact.reported = vague_place(&verdict);
                    }
                }
            }
            LocatorResult::At(estimate) => {
                let sigma_m = estimate.k_sigma_m;
                let news = match contact.reported {
                    Reported::Located(before) => {
                        before.phalanx != estimate.phalanx
                            || sigma_m < SHARPER * before.sigma_m
                            || (estimate.k_m - before.k_m).abs() > 2.0 * before.sigma_m
                    }
                    _ => true,
                };
                if sigma_m <= self.settings.wanted_sigma_m && !last {
                    contact.end();
                } else if news || last {
                    self.emit_located(contact, &prior, &estimate, last);
                }
            }
            LocatorResult::Either(estimates) => {
                if last || !matches!(contact.reported, Reported::Ambiguous) {
                    self.emit_ambiguous(contact, &estimates, last);
                }
            }
            LocatorResult::Nowhere(why) => {
                let sure =
                    contact.collector.torque_nm >= SURE_PROXIMAL * self.settings.torque_limit_nm;
                if last {
                    self.emit_nowhere(contact, why);
                } else if let NotLocated::Proximal | NotLocated::Unobservable = why {
                    if contact.reported == Reported::Nothing && contact.locator.may_be_proximal() {
                        contact.reported = Reported::MaybeProximal;
                    }
                    if why == NotLocated::Proximal && sure {
                        contact.end();
                    }
                }
            }
            LocatorResult::Undecided if last => self.give_up(contact),
            LocatorResult::Undecided => {}
        }
    }

    /// Reports that there were too few samples.
    pub(super) fn give_up(&mut self, contact: &Contact<F, H, X>) {
        if self.is_calibrating() {
            self.emit_calibration(Err(Refusal::TooFewSamples));
        } else {
            self.emit_nowhere(contact, NotLocated::TooFewSamples);
        }
    }

    fn emit_nowhere(&mut self, contact: &Contact<F, H, X>, why: NotLocated) {
        self.emit(Event::NotLocated {
            why,
            torque_nm: contact.collector.torque_nm,
        });
    }

    fn emit_located(
        &mut self,
        contact: &mut Contact<F, H, X>,
        prior: &Prior<X>,
        estimate: &Estimate,
        settled: bool,
    ) {
        let &Estimate {
            phalanx,
            k_m,
            k_sigma_m: sigma_m,
            p_phalanx,
            ..
        } = estimate;
        let data = self.data(&contact.collector.curve, contact.collector.curve.points());
        let state = contact.locator.state(
            estimate,
            &self.finger,
            &data,
            prior,
            &self.posture,
            self.drivetrain.closing_rad(self.position_counts),
        );
        let (mut k_c, mut force_n, mut force_sigma_n) = (f32::INFINITY, f32::NAN, f32::NAN);
        let [mut onset_rad, _] = prior.onset_rad;
        let mut share_by_give = f32::NAN;
        if let Some(state) = state {
            share_by_give = state.share_by_give_n_per_m;
            let shared = contact.shared || contact.locator.may_be_shared();
            let known = !contact.collector.is_lost() && !shared;
            if known {
                (force_n, force_sigma_n) = (state.force.force_n, state.force.sigma_n);
            }
            onset_rad = state.onset_rad;
            let free = &state.onset;
            k_c = self
                .finger
                .contact_compliance(&free.configuration, free.torque_nm, phalanx, k_m)
                .map_or(f32::INFINITY, |compliance| 1.0 / compliance);
        }
        self.onset_rad = onset_rad;
        if X::OBJECT_GIVES {
            let compliance_m_per_n = estimate.give_m_per_n;
            self.object = Some(Object {
                compliance_m_per_n,
                share: compliance_m_per_n.map(|give| share_by_give * give),
            });
        }
        contact.reported = Reported::Located(Spot {
            phalanx,
            k_m,
            sigma_m,
        });
        // With a deviation of half of itself or more the curve does not determine the radius.
        let (radius_m, radius_sigma_m) = if estimate.radius_sigma_m < 0.5 * estimate.radius_m {
            (estimate.radius_m, estimate.radius_sigma_m)
        } else {
            (f32::NAN, f32::NAN)
        };
        self.emit(Event::Located {
            phalanx,
            p_phalanx,
            k_m,
            sigma_m,
            k_c_nm_per_rad: k_c,
            force_n,
            force_sigma_n,
            radius_m,
            radius_sigma_m,
            settled,
        });
    }

    fn emit_ambiguous(
        &mut self,
        contact: &mut Contact<F, H, X>,
        estimates: &[Estimate; 2],
        settled: bool,
    ) {
        contact.reported = Reported::Ambiguous;
        let [likelier, other] = estimates;
        self.emit(Event::Ambiguous {
            phalanx: [likelier.phalanx, other.phalanx],
            p_phalanx: [likelier.p_phalanx, other.p_phalanx],
            k_m: [likelier.k_m, other.k_m],
            sigma_m: [likelier.k_sigma_m, other.k_sigma_m],
            settled,
        });
    }
}
