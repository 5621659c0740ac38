//! Which phalanx, which of several places: hypotheses that compete for one curve.
//!
//! A running slope and the finger's inverse (bisection) give the places to start from; each becomes a fit of the whole
//! curve, refined a step at a time, and so does a contact on the proximal phalanx, which has no place. They are compared
//! by their evidence: what explains the curve as well with less freedom wins, two that explain it about equally well are
//! reported as ambiguous.

use crate::finger::{Class, Mechanics};
use crate::numeric::ln;
use crate::sensing::NotLocated;
use crate::sensing::curve::{self, BINS, Point, Slope};
use crate::sensing::fit::{
    Data, Estimate, Hypothesis, LEAST_POINTS, Place, Prior, free_behind_cable,
};

/// Most hypotheses at a time: two places on each of two phalanges, and the proximal one.
const MOST: usize = 5;
/// Logarithm of the odds below which two explanations stand beside each other: 20 to 1.
const LN_ODDS: f32 = 3.0;
/// Mean square residual, in variances, beyond which a curve is not that of the hypothesis at all.
const MISFIT: f32 = 25.0;
/// Torque at which hypotheses are first made, in standard deviations of the offset and of a point.
const FIRST_SIGMAS: f32 = 8.0;
/// Growth of the torque after which the slope is asked again for places not thought of.
const ASK_AGAIN: f32 = 1.8;
/// Two places closer than this share of the phalanx are one.
const SAME_PLACE: f32 = 0.12;

/// What the hypotheses say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Too early.
    Undecided,
    /// One place.
    At {
        /// Phalanx.
        phalanx: u8,
        /// The fit.
        estimate: Estimate,
        /// By how much the residuals exceed what was expected, as a variance ratio, at least 1.
        spread: f32,
    },
    /// Two places; the likelier first.
    Either {
        /// Phalanges.
        phalanx: [u8; 2],
        /// Fits.
        estimate: [Estimate; 2],
        /// As in `At`.
        spread: f32,
    },
    /// A contact without a place.
    Nowhere(NotLocated),
}

/// The competition. It goes in rounds: within one, every hypothesis is fitted to the same points, or their evidence could
/// not be compared.
#[derive(Clone, Debug)]
pub struct Locator {
    hypotheses: heapless::Vec<Hypothesis, MOST>,
    /// Points of this round.
    points: heapless::Vec<Point, BINS>,
    /// The hypothesis whose turn it is.
    turn: usize,
    asked_at_nm: f32,
    /// What the slope said last, for a contact that no hypothesis explains.
    class: Class,
    slope: Option<Slope>,
}

impl Default for Locator {
    fn default() -> Self {
        Self {
            hypotheses: heapless::Vec::new(),
            points: heapless::Vec::new(),
            turn: 0,
            asked_at_nm: 0.0,
            class: Class::Invalid,
            slope: None,
        }
    }
}

impl Locator {
    /// The slope that the places were last asked for with.
    pub fn slope(&self) -> Option<&Slope> {
        self.slope.as_ref()
    }

    /// Fits in hand.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.hypotheses
    }

    /// Whether every fit has reached its minimum.
    pub fn has_converged(&self) -> bool {
        self.hypotheses.iter().all(Hypothesis::has_converged)
    }

    /// One step: begins a round if it is time to, and refines the next hypothesis. True when that ends a round: then there
    /// is a verdict. `near` is a posture near the onset.
    pub fn refine<F: Mechanics>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        near: &F::Configuration,
    ) -> bool {
        if self.turn == 0 {
            self.points.clear();
            // As many as there are bins.
            let _ = self
                .points
                .extend_from_slice(data.points.get(..BINS).unwrap_or(data.points));
            if self.is_time_to_ask(prior) {
                self.ask(finger, data, prior, near);
                return false;
            }
        }
        let round = Data {
            points: &self.points,
            ..*data
        };
        if let Some(hypothesis) = self.hypotheses.get_mut(self.turn) {
            hypothesis.refine(finger, &round, prior, near);
        }
        self.turn += 1;
        if self.turn < self.hypotheses.len() {
            return false;
        }
        self.turn = 0;
        !self.hypotheses.is_empty()
    }

    /// Whether the torque has grown enough for places not thought of.
    fn is_time_to_ask(&mut self, prior: &Prior) -> bool {
        let Some(last) = self.points.last() else {
            return false;
        };
        let rise = last.torque_nm;
        let variance = last.variance_nm2 + prior.offset_sigma_nm * prior.offset_sigma_nm;
        let due = self.points.len() >= LEAST_POINTS
            && rise > ASK_AGAIN * self.asked_at_nm
            && rise * rise > FIRST_SIGMAS * FIRST_SIGMAS * variance;
        if due {
            self.asked_at_nm = rise;
        }
        due
    }

    /// Starts the count of settled steps anew: no more points will come.
    pub fn refresh(&mut self) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.refresh();
        }
    }

    /// Asks the finger's inverse where a contact of the measured slope may be.
    fn ask<F: Mechanics>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        near: &F::Configuration,
    ) {
        let Some(slope) = curve::slope(
            data.points.iter(),
            f32::NEG_INFINITY,
            data.drivetrain.creep[0],
        ) else {
            return;
        };
        self.slope = Some(slope);
        if let Place::Known { phalanx, k_m, .. } = prior.place {
            // Calibration: the place is told, and only that.
            if self.hypotheses.is_empty() {
                self.add(finger, phalanx, k_m, prior);
            }
            return;
        }
        let rad_per_nm = slope.counts_per_nm * data.drivetrain.rad_per_count;
        let calibration = &prior.calibration;
        let compliance = (rad_per_nm - calibration.cable_rad_per_nm) / calibration.torque_factor;
        let onset_rad = data.origin_rad + slope.onset_counts * data.drivetrain.rad_per_count;
        let Some(free) = free_behind_cable(finger, onset_rad, calibration, prior.creep[0], near)
        else {
            return;
        };
        let inverse = finger.locate(&free.configuration, free.torque_nm, compliance.max(1e-6));
        self.class = if compliance > 0.0 {
            inverse.class()
        } else {
            Class::TooStiff
        };
        if self.hypotheses.is_empty() {
            self.add(finger, 1, 0.0, prior);
        }
        for candidate in inverse.candidates() {
            if candidate.phalanx > 1 {
                self.add(finger, candidate.phalanx, candidate.k_m, prior);
            }
        }
        // No place is as soft or as stiff as the slope: the nearest one there is, on each phalanx that has none.
        let share = match self.class {
            Class::TooStiff => 0.85,
            Class::Proximal | Class::Gap | Class::TooSoft => 0.1,
            _ => return,
        };
        for phalanx in 2..=F::PHALANGES as u8 {
            if !self.hypotheses.iter().any(|h| h.phalanx() == phalanx) {
                let length = finger.phalanx_length_m(phalanx).unwrap_or(0.0);
                self.add(finger, phalanx, share * length, prior);
            }
        }
    }

    /// Adds a hypothesis unless there is one like it; the worst one makes room.
    fn add<F: Mechanics>(&mut self, finger: &F, phalanx: u8, k_m: f32, prior: &Prior) {
        let Some(length) = finger.phalanx_length_m(phalanx) else {
            return;
        };
        let known = self.hypotheses.iter().any(|h| {
            h.phalanx() == phalanx
                && (phalanx == 1
                    || h.steps() == 0
                    || h.estimate()
                        .is_some_and(|e| (e.k_m - k_m).abs() < SAME_PLACE * length))
        });
        if known {
            return;
        }
        if self.hypotheses.is_full() {
            let worst = (0..self.hypotheses.len()).min_by(|&a, &b| {
                let evidence = |i: usize| {
                    self.hypotheses.get(i).map_or(f32::NEG_INFINITY, |h| {
                        if h.phalanx() == 1 {
                            f32::INFINITY
                        } else {
                            h.ln_evidence(1.0)
                        }
                    })
                };
                evidence(a).total_cmp(&evidence(b))
            });
            if let Some(worst) = worst {
                self.hypotheses.swap_remove(worst);
            }
        }
        // There is room: one was just made.
        let _ = self
            .hypotheses
            .push(Hypothesis::new(phalanx, k_m, length, prior));
    }

    /// Mean square residual of the best hypothesis, in variances; infinite if none explains the curve.
    pub fn misfit(&self) -> f32 {
        self.hypotheses
            .iter()
            .filter_map(|h| h.estimate())
            .map(|e| e.chi_square / (e.reached as f32 - 2.0).max(1.0))
            .fold(f32::INFINITY, f32::min)
    }

    /// What the hypotheses say at the end of a round. `bonus` is what else is known of each (a joint's sensor), as a
    /// logarithm of odds.
    pub fn verdict(&self, bonus: impl Fn(&Estimate) -> f32) -> Verdict {
        // One that was just added has not found its place yet; it will be heard with the next rounds.
        let seasoned = || self.hypotheses.iter().filter(|h| h.steps() >= 2);
        if seasoned().next().is_none() {
            return Verdict::Undecided;
        }
        let spread = self.misfit();
        if !spread.is_finite() || spread > MISFIT {
            return Verdict::Nowhere(self.unexplained());
        }
        let spread = spread.max(1.0);
        let mut first: Option<(&Hypothesis, &Estimate, f32)> = None;
        let mut second: Option<(&Hypothesis, &Estimate, f32)> = None;
        for hypothesis in seasoned() {
            let Some(estimate) = hypothesis.estimate() else {
                continue;
            };
            let evidence = hypothesis.ln_evidence(spread) + bonus(estimate);
            let entry = (hypothesis, estimate, evidence);
            match first {
                Some((best, at, best_evidence)) => {
                    // Two starts that met in one minimum are one explanation.
                    let same = best.phalanx() == hypothesis.phalanx()
                        && (at.k_m - estimate.k_m).abs() < at.k_sigma_m + estimate.k_sigma_m;
                    if evidence > best_evidence {
                        if !same {
                            second = first;
                        }
                        first = Some(entry);
                    } else if !same && second.is_none_or(|(_, _, e)| evidence > e) {
                        second = Some(entry);
                    }
                }
                None => first = Some(entry),
            }
        }
        let Some((hypothesis, estimate, evidence)) = first else {
            return Verdict::Nowhere(self.unexplained());
        };
        if hypothesis.phalanx() == 1 || hypothesis.is_on_first_joint() {
            return Verdict::Nowhere(NotLocated::Proximal);
        }
        if let Some((rival, other, rival_evidence)) = second
            && rival.phalanx() != 1
            && evidence - rival_evidence < LN_ODDS
        {
            return Verdict::Either {
                phalanx: [hypothesis.phalanx(), rival.phalanx()],
                estimate: [*estimate, *other],
                spread,
            };
        }
        Verdict::At {
            phalanx: hypothesis.phalanx(),
            estimate: *estimate,
            spread,
        }
    }

    /// Why nothing explains the curve.
    fn unexplained(&self) -> NotLocated {
        match self.class {
            Class::Proximal => NotLocated::Proximal,
            Class::TooSoft => NotLocated::TooSoft,
            Class::Gap => NotLocated::Gap,
            Class::TooStiff => NotLocated::TooStiff,
            _ => NotLocated::Unexplained,
        }
    }
}

/// Logarithm of the likelihood of a joint's measured change, given what a hypothesis says, up to a constant.
pub fn ln_likelihood(measured_rad: f32, expected_rad: f32, sigma_rad: f32) -> f32 {
    let deviation = (measured_rad - expected_rad) / sigma_rad.max(f32::MIN_POSITIVE);
    // A sensor that is broken must not decide alone.
    -ln(1.0 + 0.5 * deviation * deviation) * 4.0
}
