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
    /// One place. Where the residuals exceed what was expected, its deviations are as much larger.
    At(Estimate),
    /// Two places, the likelier first; deviations as in `At`.
    Either([Estimate; 2]),
    /// A contact without a place.
    Nowhere(NotLocated),
}

impl Locator {
    /// Mean square residual of the best hypothesis, in variances; infinite if none explains the curve.
    pub fn misfit(&self) -> f32 {
        let mut least = f32::INFINITY;
        for estimate in self.hypotheses.iter().filter_map(Hypothesis::estimate) {
            least = estimate.misfit().at_most(least);
        }
        least
    }

    /// What the hypotheses say at the end of a round; `misfit` as above. `bonus` is what else is known of each (a joint's
    /// sensor), as a logarithm of odds.
    // Not inlined: what it says is written where it stays.
    #[inline(never)]
    pub fn verdict(&self, misfit: f32, bonus: impl Fn(&Estimate) -> f32) -> Verdict {
        let spread = misfit.at_least(1.0);
        let mut undecided = true;
        let mut first: Option<(&Estimate, f32)> = None;
        let mut second: Option<(&Estimate, f32)> = None;
        for hypothesis in &self.hypotheses {
            // One that was just added has not found its place yet; it will be heard with the next rounds.
            if hypothesis.steps() < 2 {
                continue;
            }
            undecided = false;
            let Some(estimate) = hypothesis.estimate() else {
                continue;
            };
            let evidence = hypothesis.ln_evidence(spread) + bonus(estimate);
            let entry = Some((estimate, evidence));
            // Two starts that met in one minimum are one explanation.
            let same = first.is_some_and(|(at, _)| at.is_as(estimate));
            if first.is_none_or(|(_, best)| evidence > best) {
                if !same {
                    second = first;
                }
                first = entry;
            } else if !same && second.is_none_or(|(_, best)| evidence > best) {
                second = entry;
            }
        }
        if undecided {
            return Verdict::Undecided;
        }
        let Some((estimate, evidence)) = first.filter(|_| misfit <= MISFIT) else {
            return Verdict::Nowhere(self.unexplained());
        };
        if estimate.is_without_place() {
            return Verdict::Nowhere(NotLocated::Proximal);
        }
        if let Some((rival, rival_evidence)) = second
            && rival.phalanx > 1
            && evidence - rival_evidence < LN_ODDS
        {
            return Verdict::Either([estimate.swollen(spread), rival.swollen(spread)]);
        }
        Verdict::At(estimate.swollen(spread))
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
