//! Which phalanx, which of several places: hypotheses that compete for one curve.
//!
//! A running slope and the finger's inverse (bisection) give the places to start from; each becomes a fit of the whole
//! curve, refined a step at a time, and so does a contact on the proximal phalanx, which has no place. They are compared
//! by their evidence: what explains the curve as well with less freedom wins, two that explain it about equally well are
//! reported as ambiguous.

mod ask;
mod judge;

pub use judge::{Verdict, ln_likelihood};

use crate::finger::{Class, Mechanics};
use crate::sensing::Drivetrain;
use crate::sensing::curve::{BINS, Point};
use crate::sensing::fit::{Data, Hypothesis, Prior};
use crate::sensing::location::Series;

/// Most hypotheses at a time: two places on each of two phalanges, and the proximal one.
const MOST: usize = 5;

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
}

impl Default for Locator {
    fn default() -> Self {
        Self {
            hypotheses: heapless::Vec::new(),
            points: heapless::Vec::new(),
            turn: 0,
            asked_at_nm: 0.0,
            class: Class::Invalid,
        }
    }
}

impl Locator {
    /// Fits in hand.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.hypotheses
    }

    /// Whether every fit has reached its minimum.
    pub fn has_converged(&self) -> bool {
        self.hypotheses.iter().all(Hypothesis::has_converged)
    }

    /// One step: begins a round if it is time to, and refines the next hypothesis. True when that ends a round: then there
    /// is a verdict. `points` are by rising angle from `origin_rad` on; only a round's beginning looks at them. `near` is a
    /// posture near the onset.
    pub fn refine<'a, F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        points: impl Iterator<Item = &'a Point>,
        (origin_rad, drivetrain): (f32, &Drivetrain),
        prior: &Prior<X>,
        near: &F::Configuration,
    ) -> bool {
        let begins = self.turn == 0;
        if begins {
            self.points.clear();
            for point in points {
                // As many as there are bins.
                let _ = self.points.push(*point);
            }
        }
        if begins && self.is_time_to_ask(prior) {
            self.ask(finger, (origin_rad, drivetrain), prior, near);
            return false;
        }
        let data = Data {
            points: &self.points,
            origin_rad,
            drivetrain,
        };
        if let Some(hypothesis) = self.hypotheses.get_mut(self.turn) {
            hypothesis.refine(finger, &data, prior, near);
        }
        self.turn += 1;
        if self.turn < self.hypotheses.len() {
            return false;
        }
        self.turn = 0;
        !self.hypotheses.is_empty()
    }

    /// Starts the count of settled steps anew: no more points will come.
    pub fn refresh(&mut self) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.refresh();
        }
    }
}
