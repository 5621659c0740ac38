//! The posterior: all fits, each weighted by its evidence.

use super::fit::Fitted;
use super::prior::{K, Scaling, UNKNOWNS};
use super::radii::{RADII_M, radius_m};
use super::{Locator, Prior, Track};
use crate::finger::{Class, Mechanics};
use crate::numeric::{Bounded, exp, ln, not_negative, sqrt};
use crate::sensing::{NotLocated, SeriesElement};

/// Ignore a second phalanx, or a second place on the same, with lower odds than this against the likeliest one.
const UNLIKELY: f32 = 0.05;
/// Nearer to the joint than this share of the phalanx, a contact counts as one on the joint.
pub(super) const JOINT_SHARE: f32 = 0.02;
/// Deviations of chi square above which a hypothesis does not explain the curve.
const MISFIT_SIGMAS: f32 = 3.0;

/// Largest chi square of a number of squares that counts as explained.
pub(super) fn allowed(squares: f32) -> f32 {
    squares + MISFIT_SIGMAS * sqrt(2.0 * squares)
}

/// Result of all fits of one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Phalanx.
    pub phalanx: u8,
    /// Its length, metre.
    pub length_m: f32,
    /// Probability that the contact is on this phalanx, 0 to 1.
    pub p_phalanx: f32,
    /// Location at first contact, metre. On the distal half of the phalanx the mean of the distribution cut off at the tip.
    pub k_m: f32,
    /// Its standard deviation, metre, before the distribution is cut off.
    pub k_sigma_m: f32,
    /// Effective contact radius, metre.
    pub radius_m: f32,
    /// Its standard deviation, metre.
    pub radius_sigma_m: f32,
    /// Compliance of the object and its standard deviation, metre per newton; 0 where every object is taken to be rigid.
    pub give_m_per_n: [f32; 2],
    /// Unknowns of the likeliest fit.
    pub(super) best: [f32; UNKNOWNS],
    pub(super) best_radius_m: f32,
}

/// Result of all hypotheses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocatorResult {
    /// Too few points so far.
    Undecided,
    /// One place.
    At(Estimate),
    /// Two places, the likelier first.
    Either([Estimate; 2]),
    /// A contact that cannot be located.
    Nowhere(NotLocated),
}

/// A hypothesis with its weight in the verdict.
#[derive(Clone, Copy)]
struct Weighed {
    estimate: Estimate,
    ln_evidence: f32,
}

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// The verdict at the end of a round.
    // Not inlined: the result is written directly to its place.
    #[inline(never)]
    pub fn verdict(&self, prior: &Prior<X>) -> LocatorResult {
        if self.under_way || self.number == 0 {
            return LocatorResult::Undecided;
        }
        let spread = self.spread();
        let mut weighed: heapless::Vec<Weighed, { super::MOST }> = heapless::Vec::new();
        for track in &self.tracks {
            let Some(mut new) = track.weigh::<F, X>(prior, spread) else {
                continue;
            };
            if X::FLEXIBLE && F::CABLE_DECIDES {
                new.ln_evidence += prior.ln_cable(&new.estimate.best) / spread;
            }
            // Two starts that ended in one minimum are one hypothesis.
            let same = weighed
                .iter_mut()
                .find(|old| old.estimate.is_as(&new.estimate));
            match same {
                Some(old) if old.ln_evidence < new.ln_evidence => *old = new,
                Some(_) => {}
                None => {
                    let _ = weighed.push(new);
                }
            }
        }
        // The likeliest of all, or beside one of those beyond phalanx 1.
        let likeliest = |but: Option<&Weighed>| {
            (weighed.iter())
                .filter(|of| {
                    but.is_none_or(|but| !core::ptr::eq(but, *of) && of.estimate.phalanx > 1)
                })
                .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))
        };
        let Some(first) = likeliest(None).filter(|_| self.explains()) else {
            return LocatorResult::Nowhere(self.unexplained());
        };
        let odds = |of: &Weighed| exp(of.ln_evidence - first.ln_evidence);
        let rival = likeliest(Some(first)).filter(|rival| odds(rival) > UNLIKELY);
        if first.estimate.is_without_place::<F>() {
            // Perhaps beyond joint 2, near to it.
            let why = if rival.is_some() {
                NotLocated::Unobservable
            } else {
                NotLocated::Proximal
            };
            return LocatorResult::Nowhere(why);
        }
        // There it may as well be at the end of the phalanx before, whose normal is another: no fit of either holds.
        if F::PHALANGES > 2 && first.estimate.phalanx > 2 && first.estimate.is_on_joint() {
            return LocatorResult::Nowhere(NotLocated::Unobservable);
        }
        match rival {
            Some(rival) => LocatorResult::Either([told(first, &weighed), told(rival, &weighed)]),
            None => LocatorResult::At(told(first, &weighed)),
        }
    }

    /// Whether any hypothesis explains the curve.
    pub fn explains(&self) -> bool {
        self.chi_square() <= allowed(self.terms())
    }

    /// Whether the likeliest contact slides off its phalanx before the curve ends, while one on another phalanx would not:
    /// beyond the end of its path a hypothesis bears with any torque, and wins where a second contact or a last bad block
    /// spoils the others. The beginning of the curve decides then.
    pub fn leans_on_its_end(&self) -> bool {
        self.likeliest().is_some_and(|(likeliest, fitted)| {
            let stays = |track: &Track| track.fits.iter().flatten().any(|other| !other.leaves);
            let others = |track: &&Track| track.phalanx > 1 && track.phalanx != likeliest.phalanx;
            fitted.leaves && self.tracks.iter().filter(others).any(stays)
        })
    }

    /// What [chi square](Fitted::chi_square) is expected to be at most: one for every point, and some for the radius, which is the nearest of
    /// a grid (chosen: as many as there are unknowns; 27 points of a pin half way between two radii have 52).
    fn terms(&self) -> f32 {
        (self.number + UNKNOWNS) as f32
    }

    /// [Chi square](Fitted::chi_square) of the likeliest hypothesis over the number of its squares; at least 1.
    fn spread(&self) -> f32 {
        (self.chi_square() / self.terms())
            .at_least(1.0)
            .at_most(1e6)
    }

    /// [The same](Fitted::chi_square) of the likeliest fit; infinite if there is none.
    pub(super) fn chi_square(&self) -> f32 {
        self.best_fit().map_or(f32::INFINITY, |fit| fit.chi_square)
    }

    /// The likeliest fit of all.
    pub(super) fn best_fit(&self) -> Option<&Fitted> {
        self.likeliest().map(|(_, fit)| fit)
    }

    /// The same with its hypothesis.
    pub(super) fn likeliest(&self) -> Option<(&Track, &Fitted)> {
        let mut best: Option<(&Track, &Fitted)> = None;
        for track in &self.tracks {
            for fit in track.fits.iter().flatten() {
                if best.is_none_or(|(_, old)| fit.ln_evidence > old.ln_evidence) {
                    best = Some((track, fit));
                }
            }
        }
        best
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

/// A hypothesis with the probability of its phalanx among all.
#[inline(never)]
fn told(of: &Weighed, all: &[Weighed]) -> Estimate {
    let (mut mine, mut total) = (0.0, 0.0);
    for other in all {
        let odds = exp(other.ln_evidence - of.ln_evidence);
        total += odds;
        if other.estimate.phalanx == of.estimate.phalanx {
            mine += odds;
        }
    }
    Estimate {
        p_phalanx: mine / total,
        ..of.estimate
    }
}

impl Track {
    /// Combines all radii; `spread` is the ratio of the residuals' variance to the expected one.
    fn weigh<F: Mechanics, X: SeriesElement>(
        &self,
        prior: &Prior<X>,
        spread: f32,
    ) -> Option<Weighed> {
        let mut best: Option<(&Fitted, usize)> = None;
        for (index, fitted) in self.fits.iter().enumerate() {
            let Some(fitted) = fitted else { continue };
            if best.is_none_or(|(old, _)| fitted.ln_evidence > old.ln_evidence) {
                best = Some((fitted, index));
            }
        }
        let (best, best_index) = best?;
        let scaling = Scaling::of::<F, X>(prior, self.length_m);
        let has_place = self.phalanx > 1;
        let (mut total, mut k, mut kk, mut r, mut rr) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut give, mut give_squares) = (0.0, 0.0);
        for (index, fitted) in self.fits.iter().enumerate() {
            let Some(fitted) = fitted else { continue };
            let weight = exp((fitted.ln_evidence - best.ln_evidence) / spread);
            // Relative to the best, so that nothing cancels.
            let place_m = self.length_m * (fitted.x[K] - best.x[K]);
            let beside_m = radius_m(index) - radius_m(best_index);
            total += weight;
            k += weight * place_m;
            let sigma_m = fitted.k_sigma_m;
            let within_m = CELL * self.length_m * self.step(index);
            kk += weight * (place_m * place_m + spread * sigma_m * sigma_m + within_m * within_m);
            r += weight * beside_m;
            let half_m = CELL * RATIO * (radius_m(index) + 0.003);
            rr += weight * (beside_m * beside_m + half_m * half_m);
            if X::OBJECT_GIVES {
                let [mean, sigma] = fitted.give;
                let beside = mean - best.give[0];
                give += weight * beside;
                give_squares += weight * (beside * beside + spread * sigma * sigma);
            }
        }
        let (k, r) = (k / total, r / total);
        let variance = |squares: f32, mean: f32| (squares / total - mean * mean).at_least(0.0);
        let mut give_m_per_n = [0.0; 2];
        if X::OBJECT_GIVES {
            give /= total;
            let sigma = sqrt(variance(give_squares, give));
            give_m_per_n = [best.give[0] + give, sigma].map(|x| x * prior.give_m_per_n);
        }
        let k_sigma_m = sqrt(variance(kk, k));
        let mut k_m = 0.0;
        if has_place {
            k_m = scaling.values(&best.x)[K] + k;
            let left_m = (self.length_m - k_m).at_least(0.0);
            if left_m < k_m {
                // Cut the distribution off at the tip and take its mean. The fit ends at the tip, so an optimum beyond counts as there.
                let [left_m, _] = not_negative([left_m, k_sigma_m]);
                k_m = self.length_m - left_m;
            }
        }
        let estimate = Estimate {
            phalanx: self.phalanx,
            length_m: self.length_m,
            p_phalanx: 0.0,
            k_m,
            k_sigma_m,
            radius_m: radius_m(best_index) + r + prior.half_thickness_m,
            radius_sigma_m: sqrt(variance(rr, r)),
            give_m_per_n,
            best: best.x,
            best_radius_m: radius_m(best_index) + prior.half_thickness_m,
        };
        let radii = if has_place { RADII_M.len() as f32 } else { 1.0 };
        Some(Weighed {
            estimate,
            ln_evidence: best.ln_evidence / spread + ln(total / radii),
        })
    }

    /// Change of the place from one radius to the next around this one, in lengths of the phalanx.
    fn step(&self, index: usize) -> f32 {
        let fitted = |index: usize| self.fit(index);
        let place = |other: Option<&Fitted>| other.or(fitted(index)).map_or(0.0, |f| f.x[K]);
        let below = fitted(index.wrapping_sub(1));
        let above = fitted(index + 1);
        let way = (place(above) - place(below)).abs();
        if below.is_some() && above.is_some() {
            0.5 * way
        } else {
            way
        }
    }
}

/// A fit represents the radii half way to its neighbours: their standard deviation, as a share of a step.
const CELL: f32 = 0.289;
/// Logarithm of the ratio of one radius to the next, each plus 3 mm.
const RATIO: f32 = 0.646;

impl Estimate {
    /// Whether it is on the proximal phalanx or on the very joint of phalanx 2: as compliant as a contact anywhere on
    /// phalanx 1 (docs/MECHANICS.md#contact-stiffness), and nearer to the joint than either phalanx is thick.
    fn is_without_place<F: Mechanics>(&self) -> bool {
        let on_joint = self.phalanx == 2 && self.is_on_joint();
        F::FIRST_TOUCHING == 1 && (self.phalanx <= 1 || on_joint)
    }

    /// Whether it is as near to the joint before its phalanx as makes no place of its own.
    fn is_on_joint(&self) -> bool {
        self.k_m < JOINT_SHARE * self.length_m
    }

    /// Whether both are the same place within their deviations.
    fn is_as(&self, other: &Self) -> bool {
        self.phalanx == other.phalanx
            && (self.k_m - other.k_m).abs() < self.k_sigma_m + other.k_sigma_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, Tendon3};
    use crate::sensing::Cable;
    use crate::sensing::locator::tests::{prior, track};

    /// Place and deviation, in lengths of the phalanx, that a likeliest place and its deviation are told as.
    fn told(place: f32, sigma: f32) -> [f32; 2] {
        const LENGTH_M: f32 = 0.05;
        let track = track(3, LENGTH_M, [place, sigma], 0.0);
        let prior = prior();
        let weighed = track.weigh::<<Tendon3 as Scene>::Finger, Cable>(&prior, 1.0);
        let Estimate { k_m, k_sigma_m, .. } = weighed.expect("a fit").estimate;
        [k_m / LENGTH_M, k_sigma_m / LENGTH_M]
    }

    #[test]
    fn a_place_is_the_mean_of_what_lies_on_the_phalanx() {
        for (place, sigma) in [
            (1.0f32, 0.1f32),
            (0.9, 0.1),
            (0.95, 0.02),
            (0.8, 0.25),
            (0.3, 0.05),
        ] {
            let [k, claimed] = told(place, sigma);
            let (mut weights, mut sum) = (0.0f64, 0.0f64);
            for step in 0..10_000u16 {
                let at = 1.0 - (f64::from(step) + 0.5) * 1e-4;
                let off = (at - f64::from(place)) / f64::from(sigma);
                let weight = (-0.5 * off * off).exp();
                weights += weight;
                sum += weight * at;
            }
            let mean = (sum / weights) as f32;
            assert!(
                (k - mean).abs() < 0.03 * sigma,
                "{place} {sigma}: {k} {mean}"
            );
            assert!(
                (claimed / sigma - 1.0).abs() < 1e-3,
                "{place} {sigma}: {claimed}"
            );
        }
    }

    #[test]
    fn a_place_stays_on_the_phalanx_however_little_is_known() {
        for place in [0.0, 1e-3, 0.5, 1.0, 1.2] {
            for sigma in [0.0, 1e-20, 0.1, 0.5] {
                let [k, _] = told(place, sigma);
                assert!((0.0..=1.0).contains(&k), "{place} {sigma}: {k}");
            }
        }
    }
}
