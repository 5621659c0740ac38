//! Radii of the object: in which order they are fitted, and which are worth a fit.
//!
//! Each fit starts from that of a neighbouring radius, first from small radii to large ones, then back where a fit has found far less than
//! its neighbour: it has ended in another minimum than the best one, with a place far from it
//! (docs/SENSING.md#large-objects).

use super::fit::Fitted;
use super::{Locator, Place, Prior};
use crate::finger::Mechanics;
use crate::joint_sensor::Told;
use crate::numeric::Bounded;
use crate::sensing::SeriesElement;

/// Radii of the object for which a location is fitted, metre: evenly spaced in the logarithm of the radius plus 3 mm, which
/// is the prior (chosen).
pub(super) const RADII_M: [f32; 6] = [0.001, 0.0045, 0.012, 0.025, 0.05, 0.1];
/// One of them.
pub(super) fn radius_m(index: usize) -> f32 {
    RADII_M.get(index).copied().unwrap_or_default()
}

/// Order in which they are fitted, each with the radius whose result is its starting point.
pub(super) const ORDER: [(usize, usize); 11] = [
    (1, 1),
    (0, 1),
    (2, 1),
    (3, 2),
    (4, 3),
    (5, 4),
    (4, 5),
    (3, 4),
    (2, 3),
    (1, 2),
    (0, 1),
];
/// Index from which the order leads back.
pub(super) const BACK: usize = 6;
/// On the way back fit a radius again only where its neighbour is likelier by this logarithm (chosen: neighbours in one minimum differ by
/// less, and each fit takes time).
const FALLEN: f32 = 4.0;
/// A radius less likely than the best by this logarithm is skipped, with those beyond it.
const HOPELESS: f32 = 10.0;
/// Fit no other radius of a hypothesis whose logarithm of the evidence is below that of the likeliest fit by more than this and that fit's
/// chi square, because a poor fit decides little (chosen). Most contacts on phalanx 1 have their last word earlier for it.
const LOST: f32 = 100.0;
/// Index of the largest radius. It is fitted only where the data demand it.
const LARGE: usize = 5;
/// They do where the next smaller radius is likelier than all others by this logarithm.
const DEMANDED: f32 = 2.0;

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// Keeps a result if it is better than those of earlier starts. Returns whether it was kept.
    pub(super) fn keep(&mut self, fitted: Option<Fitted>) -> bool {
        let track = self.tracks.get_mut(self.track);
        let Some(kept) = track
            .zip(ORDER.get(self.order))
            .and_then(|(track, (radius, _))| track.fits.get_mut(*radius))
        else {
            return false;
        };
        let is_first = self.start == 0 && self.order < BACK;
        let better = match (&fitted, &kept) {
            (Some(new), Some(old)) => is_first || new.ln_evidence > old.ln_evidence,
            (Some(_), None) => true,
            (None, _) => is_first,
        };
        if better {
            *kept = fitted;
        }
        better
    }

    /// Logarithm of the evidence below which a hypothesis is lost (`LOST`). If the likeliest contact slides off its phalanx, none is lost:
    /// beyond the end of its path it bears with any torque, and may win where others are spoiled.
    pub(super) fn lost(&self) -> f32 {
        let best = self.best_fit().filter(|best| !best.leaves);
        best.map_or(f32::NEG_INFINITY, |best| {
            best.ln_evidence - best.chi_square - LOST
        })
    }

    /// Moves on to the next start, radius or hypothesis.
    pub(super) fn go_on(&mut self, prior: &Prior<X>, joint: impl Told) {
        let starts = self.starts();
        let lost = self.lost();
        let Some(track) = self.tracks.get_mut(self.track) else {
            return;
        };
        let has_place = track.phalanx > 1;
        self.start += 1;
        if self.start < starts << u32::from(joint.change().is_some()) {
            return;
        }
        self.start = 0;
        loop {
            self.order += 1;
            let next = ORDER
                .get(self.order)
                .filter(|_| has_place && matches!(prior.place, Place::Anywhere));
            let Some(&(radius, from)) = next else {
                self.order = 0;
                self.track += 1;
                return;
            };
            let mut least = f32::NEG_INFINITY;
            for (index, fitted) in track.fits.iter().enumerate() {
                if index != from
                    && let Some(fitted) = fitted
                {
                    least = fitted.ln_evidence.at_least(least);
                }
            }
            let leads_back = self.order >= BACK;
            let demands = radius == LARGE;
            least += if demands { DEMANDED } else { -HOPELESS };
            least = least.at_least(lost);
            if leads_back && let Some(own) = track.fit(radius) {
                least = least.at_least(own.ln_evidence + FALLEN);
            }
            let hopeful = (track.fit(from)).is_some_and(|fitted| fitted.ln_evidence > least);
            if hopeful {
                return;
            }
            if !leads_back && let Some(fit) = track.fits.get_mut(radius) {
                *fit = None;
            }
        }
    }
}
