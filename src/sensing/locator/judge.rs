//! Who wins: the hypotheses compared by their evidence.

use super::Locator;
use crate::finger::Class;
use crate::numeric::{Bounded, ln};
use crate::sensing::NotLocated;
use crate::sensing::fit::{Estimate, Hypothesis};

/// Logarithm of the odds below which two explanations stand beside each other: 20 to 1.
const LN_ODDS: f32 = 3.0;
/// Mean square residual, in variances, beyond which a curve is not that of the hypothesis at all.
const MISFIT: f32 = 25.0;

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

impl Locator {
    /// Mean square residual of the best hypothesis, in variances; infinite if none explains the curve.
    pub fn misfit(&self) -> f32 {
        self.hypotheses
            .iter()
            .filter_map(|h| h.estimate())
            .map(|e| e.chi_square / (e.reached as f32 - 2.0).at_least(1.0))
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
        let spread = spread.at_least(1.0);
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
    let deviation = (measured_rad - expected_rad) / sigma_rad.at_least(f32::MIN_POSITIVE);
    // A sensor that is broken must not decide alone.
    -ln(1.0 + 0.5 * deviation * deviation) * 4.0
}
