//! One fit: a hypothesis with a fixed contact radius; the other unknowns by Levenberg-Marquardt.
//!
//! Each trial is one pass over the curve ([`pass`]). If a pass is better, the next
//! step starts from its unknowns; if not, the step is shortened. The fit has converged when the predicted gain of a step is at
//! most [`ENOUGH`], or when no shortened step is better.

mod joint;
mod learned;
mod pass;
mod soft;

use super::Data;
use super::model::Hold;
use super::posterior::JOINT_SHARE;
use super::prior::{FACTOR, GIVE, JOINT, K, Of, Place, Prior, Scaling, UNKNOWNS};
use crate::finger::Mechanics;
use crate::joint_sensor::Told;
use crate::numeric::{Bounded, ln, sqrt};
use crate::sensing::SeriesElement;
use crate::sensing::normal::Normal;
use pass::Pass;

/// Smallest gain worth a step, in units of the cost (minus twice the logarithm of the likelihood).
const ENOUGH: f32 = 0.02;
/// Largest number of passes.
const MOST_PASSES: u8 = 24;
/// Passes after which the place is fitted too, where a cable that is not known decides: at the joint the stiffness hardly changes with
/// the place, and a fit that the wrong cable sends there stays.
const PLACE_AFTER: u8 = 2;
/// Damping of the first shortened step, and damping at which the fit gives up.
const FIRST_DAMPING: f32 = 0.02;
const MOST_DAMPING: f32 = 30.0;

/// One over the variance of a place that may be anywhere on the phalanx, in lengths of it: between those about its middle and about
/// one of its ends (chosen).
const UNIFORM: f32 = 4.0;

/// What kind of contact a fit assumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hypothesis {
    pub(super) hold: Hold,
    pub(super) length_m: f32,
}

impl Hypothesis {
    pub(super) fn has_place(&self) -> bool {
        matches!(self.hold, Hold::Contact { .. })
    }
}

/// Result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    /// Unknowns in units of their prior.
    pub(super) x: [f32; UNKNOWNS],
    /// Standard deviation of the location, metre; 0 if it has none.
    pub(super) k_sigma_m: f32,
    /// Compliance of the object that the curve asks for, in units of its prior, and its standard deviation, even where the fit is that
    /// of a rigid object; 0 without the unknown.
    pub(super) give: [f32; 2],
    /// Logarithm of the evidence, integrated over the unknowns (Laplace's approximation).
    pub(super) ln_evidence: f32,
    /// Sum of the squared whitened residuals and of what the priors gave way.
    pub(super) chi_square: f32,
    /// The contact slides off its phalanx before the curve ends.
    pub(super) leaves: bool,
}

/// A fit under way.
#[derive(Clone, Debug)]
pub(super) struct Fit<F: Mechanics, X: SeriesElement> {
    pub(super) hypothesis: Hypothesis,
    x: [f32; UNKNOWNS],
    trial: [f32; UNKNOWNS],
    cost: f32,
    chi_square: f32,
    leaves: bool,
    /// See [`Calibration::worm_rad`](crate::sensing::Calibration::worm_rad).
    worm_rad: [f32; 2],
    normal: Normal<UNKNOWNS, Of<F, X>>,
    damping: f32,
    passes: u8,
    /// Whether the object's compliance is fitted: the curve demands it.
    gives: bool,
    /// The pass at the trial's unknowns, once it has begun.
    pass: Option<Pass<F, X>>,
}

/// State of a fit after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Progress {
    UnderWay,
    Converged,
    /// No contact of this kind explains the curve.
    Failed,
}

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// A fit that starts from given unknowns: those of another fit (`fitted`), whose cable is right enough to fit the place at once, or of
    /// the prior at some place. It starts with a rigid object.
    pub(super) fn new(hypothesis: Hypothesis, mut x: [f32; UNKNOWNS], fitted: bool) -> Self {
        if X::OBJECT_GIVES {
            x[GIVE] = 0.0;
        }
        Self {
            hypothesis,
            x,
            trial: x,
            cost: f32::INFINITY,
            chi_square: f32::INFINITY,
            leaves: false,
            worm_rad: [0.0; 2],
            normal: Normal::EMPTY,
            damping: 0.0,
            gives: false,
            passes: if F::CABLE_DECIDES && fitted {
                PLACE_AFTER
            } else {
                0
            },
            pass: None,
        }
    }

    /// Whether a pass has begun and is not complete.
    pub(super) fn is_within_pass(&self) -> bool {
        self.pass.is_some()
    }

    /// Evaluates some more points of a pass over the curve; after the last one, computes the next trial.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub(super) fn step(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        joint: impl Told,
    ) -> Progress {
        let scaling = Scaling::of::<F, X>(prior, self.hypothesis.length_m);
        if self.pass.is_none() {
            self.begin(finger, data, prior, near, &scaling);
        }
        let progress = self.go_on(finger, data, &scaling);
        if progress == Progress::UnderWay {
            return progress;
        }
        if let Some(change) = joint.change()
            && progress == Progress::Converged
        {
            self.weigh_joint(finger, data, prior, near, &change, &scaling);
        }
        let progress = self.judge(progress == Progress::Converged, prior, &scaling);
        self.pass = None;
        progress
    }

    /// Evaluates a finished pass (`complete`: it reached the end of the curve).
    fn judge(&mut self, complete: bool, prior: &Prior<X>, scaling: &Scaling) -> Progress {
        self.passes = self.passes.saturating_add(1);
        let mut gained = f32::INFINITY;
        // Small gain of a shortened step does not mean convergence: the full step may gain more.
        let whole = self.damping == 0.0;
        let penalty = Self::penalty(&self.trial, prior);
        match &self.pass {
            Some(pass) if complete && pass.squares + pass.logarithms + penalty < self.cost => {
                let cost = pass.squares + pass.logarithms + penalty;
                gained = self.cost - cost;
                self.cost = cost;
                self.x = self.trial;
                self.chi_square = pass.squares;
                self.leaves = pass.model.has_ended();
                self.normal = pass.normal;
                self.worm_rad = pass.whitening.worm_rad();
                self.damping *= 0.2;
                if self.damping < 1e-3 {
                    self.damping = 0.0;
                }
            }
            _ if self.cost == f32::INFINITY => return self.retreat(),
            _ => self.damping = (6.0 * self.damping).at_least(FIRST_DAMPING),
        }
        let placed = !F::CABLE_DECIDES || self.passes > PLACE_AFTER;
        let settled = (whole && placed && gained < ENOUGH)
            || self.damping > MOST_DAMPING
            || self.passes >= MOST_PASSES;
        if (settled || !self.advance(scaling)) && !self.release(scaling) {
            return Progress::Converged;
        }
        Progress::UnderWay
    }

    /// No contact path at the starting place: nearer to the middle of the phalanx there may be one, and of a pin a little beyond the place
    /// that is told.
    fn retreat(&mut self) -> Progress {
        if !self.hypothesis.has_place() || self.passes >= MOST_PASSES / 2 {
            return Progress::Failed;
        }
        self.trial[K] += 0.25 * (0.5 - self.trial[K]);
        Progress::UnderWay
    }

    /// Contribution of the priors to the cost at some unknowns.
    fn penalty(x: &[f32; UNKNOWNS], prior: &Prior<X>) -> f32 {
        let mut penalty = 0.0;
        for (unknown, x) in x.iter().enumerate() {
            if unknown != K || matches!(prior.place, Place::Known { .. }) {
                penalty += x * x;
            }
        }
        penalty + prior.beside_normal::<F>(x[JOINT])[0]
    }

    /// Moves the trial by the best step; false if its predicted gain is too small.
    fn advance(&mut self, scaling: &Scaling) -> bool {
        let mut held = [false; UNKNOWNS];
        let first = F::CABLE_DECIDES && self.passes < PLACE_AFTER;
        held[K] = first;
        held[GIVE] = X::OBJECT_GIVES && !self.gives;
        // An unknown that meets its bound is fixed there; the others are solved again.
        for _ in 0..=2 {
            let mut normal = self.normal;
            for unknown in (0..UNKNOWNS).filter(|unknown| held[*unknown]) {
                normal.hold(unknown);
            }
            let Some(factor) = normal.factor(self.damping) else {
                return false;
            };
            let step = factor.step();
            let promised = self.normal.promise(&step);
            if promised < ENOUGH && self.damping == 0.0 && !first {
                return false;
            }
            self.trial = self.x;
            let mut met = false;
            for unknown in 0..UNKNOWNS {
                self.trial[unknown] += step[unknown];
                let at_bound = scaling.hold(&mut self.trial, unknown);
                if at_bound && !held[unknown] && self.trial[unknown] == self.x[unknown] {
                    held[unknown] = true;
                    met = true;
                }
            }
            if !met {
                break;
            }
        }
        true
    }

    /// The fit's result so far.
    pub(super) fn fitted(&self, prior: &Prior<X>) -> Option<Fitted> {
        let (has_place, length_m) = (self.hypothesis.has_place(), self.hypothesis.length_m);
        let by_factor = self.normal.ratio(FACTOR, K);
        let give = self.asked()?;
        let mut normal = self.rigid();
        let factor = normal.factor(0.0)?;
        let determinant = factor.ln_determinant();
        let mut k_sigma_m = 0.0;
        let mut flat = 0.0;
        if has_place {
            // Keep a place that the curve hardly tells on its phalanx, and one on the joint, which the verdict does not tell, near it. On
            // phalanx 2 behind a hidden one the verdict does tell it, so it has its own deviation.
            let second = matches!(self.hypothesis.hold, Hold::Contact { phalanx: 2, .. });
            let is_untold_at_joint = F::FIRST_TOUCHING == 1 || !second;
            // A pin's place is in deviations from where it is told to be, not a share of the phalanx.
            let is_share = matches!(prior.place, Place::Anywhere);
            let precision = if is_untold_at_joint && is_share && self.x[K] < JOINT_SHARE {
                1.0 / (JOINT_SHARE * JOINT_SHARE)
            } else {
                UNIFORM
            };
            let mut variance = factor.variance(K);
            flat = 0.5 * ln(core::f32::consts::TAU / (1.0 + precision * variance));
            if F::UNEVEN {
                // As much of the torque factor as the curve itself has told holds for the leverage along the curve, not at the place.
                let told = 1.0 - factor.variance(FACTOR);
                let sigma = prior.calibration.torque_factor_sigma;
                let shift = by_factor * prior.leverage_sigma / sigma;
                variance += told.at_least(0.0) * (shift * shift);
            }
            k_sigma_m = length_m * sqrt(variance / (1.0 + precision * variance));
        }
        let ln_evidence = -0.5 * self.cost - 0.5 * determinant + flat - self.ln_odds_against();
        (ln_evidence.is_finite() && k_sigma_m.is_finite()).then_some(Fitted {
            x: self.x,
            k_sigma_m,
            give,
            ln_evidence,
            chi_square: self.chi_square + Self::penalty(&self.x, prior),
            leaves: self.leaves,
        })
    }
}
