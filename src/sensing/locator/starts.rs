//! Hypotheses, and where their fits begin: the tangent stiffness K_c of the curve's beginning, inverted by bisection
//! (docs/MECHANICS.md#contact-stiffness), gives the first guess on each phalanx.

use super::fit::{Fit, Hypothesis};
use super::prior::{FRICTION, JOINT, K, LEAST_SHARE, LOSS, Scaling, UNKNOWNS, fits_loss};
use super::radii::{BACK, ORDER};
use super::{Data, Locator, Place, Prior, Track, Tracks, onset};
use crate::finger::{Class, Mechanics};
use crate::joint_sensor::Told;
use crate::numeric::{Bounded, clamp};
use crate::sensing::{SeriesElement, curve};

/// Share of the rise over which the slope is taken: further on the curve is no longer close to its tangent.
const FIRST_SHARE: f32 = 0.4;
/// Smallest distance of a start from the end of a side, in lengths of the phalanx.
const MARGIN: f32 = 0.03;
/// If the stiffest place is nearer than this to the end of the phalanx, there is only one side.
const LEAST_SIDE: f32 = 0.04;

/// Starting places of a thorough search, as shares of one side of a phalanx's stiffest place.
const STARTS: [f32; 2] = [0.2, 0.75];
/// Index of the start at the place of the best fit so far, with joints that take [`HELD`].
pub(super) const HELD_START: usize = 1 + STARTS.len();
/// Torque of the joints at that start, in deviations from its mean. A break-away torque puts a kink into the curve: a fit that starts
/// below it stops there, one that starts above it passes. The other unknowns start from the prior: those of a fit that stopped there,
/// first of all its onset, lead back (compared in `locator::tests`).
const HELD: f32 = 6.0;
/// Contact friction at the start after it, from the best fit so far, in deviations from its mean. Where something holds joint 2 at its
/// stop, contact friction decides with the place how long: a fit that has come to the kink with too little of it stays there, and torque
/// of the joints alone does not lead away (compared in `starts::tests`).
const STUCK: f32 = 5.0;
/// Contact friction at which further starts begin where a sensor tells of joint 2, in deviations from its mean: below its bound, which
/// makes it zero. A fit that begins with enough friction to hold the finger near its stiffest place finds no slope towards the place of a
/// contact that slides.
const SLIPPERY: f32 = -6.0;

/// Index of the last start.
pub(super) const fn last_start<F: Mechanics>() -> usize {
    if F::HOLDS { HELD_START + 1 } else { HELD_START }
}

// Not inlined: called from several places, with a large stack frame.
#[inline(never)]
fn add(tracks: &mut Tracks, phalanx: u8, length_m: f32, side: [f32; 2], candidate: f32) {
    let [low, high] = side;
    let margin = MARGIN.at_most(0.4 * (high - low));
    // The capacity is the largest number that a finger of three phalanges has.
    let _ = tracks.push(Track {
        phalanx,
        length_m,
        candidate: clamp(candidate, low + margin, high - margin),
        side,
        fits: [const { None }; _],
    });
}

/// Sets the hypotheses for a curve; returns the verdict of its slope alone.
#[inline(never)]
pub(super) fn find<F: Mechanics, X: SeriesElement>(
    tracks: &mut Tracks,
    finger: &F,
    data: &Data,
    prior: &Prior<X>,
    near: &F::Configuration,
) -> Class {
    tracks.clear();
    let whole = [0.0, 1.0];
    match prior.place {
        Place::Stop => {
            add(tracks, 0, 1.0, whole, 0.5);
            return Class::Invalid;
        }
        Place::Known { phalanx, k_m, .. } => {
            if let Some(length_m) = finger.phalanx_length_m(phalanx) {
                add(tracks, phalanx, length_m, whole, k_m / length_m);
            }
            return Class::Invalid;
        }
        Place::Anywhere => {}
    }
    if F::FIRST_TOUCHING == 1 {
        let length_m = finger.phalanx_length_m(1).unwrap_or(1.0);
        add(tracks, 1, length_m, whole, 0.5);
    }
    let Some(free) = onset::at::<F, X>(finger, prior.onset_rad[0], prior, near) else {
        return Class::Invalid;
    };
    let at = &free.configuration;
    let compliance = contact_compliance(data, prior);
    let inverse = compliance.map(|own| finger.locate(at, free.torque_nm, own.at_least(1e-6)));
    for phalanx in 2..=F::PHALANGES as u8 {
        let Some(length_m) = finger.phalanx_length_m(phalanx) else {
            continue;
        };
        let place = |beyond: bool| {
            let candidates = inverse
                .as_ref()
                .map_or(&[][..], |inverse| inverse.candidates());
            (candidates.iter())
                .find(|c| c.phalanx == phalanx && c.beyond_stiffest == beyond)
                .map(|c| c.k_m / length_m)
        };
        let stiffest = finger
            .stiffest_m(at, free.torque_nm, phalanx)
            .map_or(1.0, |k_m| k_m / length_m);
        if stiffest > LEAST_SIDE && stiffest < 1.0 - LEAST_SIDE {
            for (side, beyond) in [([0.0, stiffest], false), ([stiffest, 1.0], true)] {
                let middle = 0.5 * (side[0] + side[1]);
                add(
                    tracks,
                    phalanx,
                    length_m,
                    side,
                    place(beyond).unwrap_or(middle),
                );
            }
        } else {
            let candidate = place(false).or(place(true)).unwrap_or(0.5);
            add(tracks, phalanx, length_m, whole, candidate);
        }
    }
    match (&inverse, compliance) {
        (Some(inverse), Some(own)) if own > 0.0 => inverse.class(),
        (Some(_), _) => Class::TooStiff,
        (None, _) => Class::Invalid,
    }
}

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// Returns how many starts the current fit has. With a reading of joint 2 it takes each of them twice, first believing the reading,
    /// then taking it for wrong: a fit that only starts where a wrong reading has led may end in another minimum than one without a
    /// reading.
    pub(super) fn starts(&self) -> usize {
        let has_place = (self.tracks.get(self.track)).is_some_and(|track| track.phalanx > 1);
        if self.thorough && has_place && self.order == 0 {
            1 + const { last_start::<F>() }
        } else {
            1
        }
    }

    /// Whether the current start takes the reading of joint 2 for wrong.
    pub(super) fn distrusts(&self, joint: impl Told) -> bool {
        joint.change().is_some() && self.start >= self.starts()
    }

    /// Begins the current fit.
    pub(super) fn next_fit(&self, prior: &Prior<X>, joint: impl Told) -> Option<Fit<F, X>> {
        let track = self.tracks.get(self.track)?;
        let &(radius, from) = ORDER.get(self.order)?;
        let hold = track.hold(radius, prior);
        let length_m = track.length_m;
        let distrusts = self.distrusts(joint);
        let start = if distrusts {
            self.start - self.starts()
        } else {
            self.start
        };
        let before = match (start, self.order, self.thorough) {
            // Start from the neighbouring radius on the way back, else from the result of the last round, of the fit that believes the
            // reading, or of the neighbouring radius.
            (_, BACK.., _) => None,
            (0, 0, _) | (0, _, false) | (HELD_START.., ..) => track.fit(radius),
            _ => None,
        };
        let neighbour = track.fit(from).filter(|_| self.order > 0);
        let (mut x, mut fitted) = match before.or(neighbour) {
            Some(fitted) => (fitted.x, true),
            None => {
                let place = match start.checked_sub(1).and_then(|i| STARTS.get(i)) {
                    Some(share) => track.side[0] + share * (track.side[1] - track.side[0]),
                    None => track.candidate,
                };
                (values(place, prior), false)
            }
        };
        if fits_loss::<F, X>() && joint.change().is_some() {
            // Start from the expected loss: a fit with a reading of joint 2 does not move it.
            x[LOSS] = 0.0;
        }
        if joint.change().is_some() && !distrusts && !fitted && start > 0 {
            x[FRICTION] = SLIPPERY;
            Scaling::of::<F, X>(prior, length_m).hold(&mut x, FRICTION);
        }
        if start == HELD_START {
            // With three phalanges a fit that starts from the prior's cable strays (docs/SENSING.md#torque-that-holds-the-joints).
            if !F::MOVES_ON {
                (x, fitted) = (values(x[K], prior), false);
            }
            x[JOINT] = HELD;
        }
        if F::HOLDS && start == const { last_start::<F>() } {
            x[FRICTION] = STUCK;
        }
        Some(Fit::new(Hypothesis { hold, length_m }, x, fitted))
    }
}

/// Values from which a fit starts: those of the prior, at a place in lengths of the phalanx.
pub(super) fn values<X: SeriesElement>(place: f32, prior: &Prior<X>) -> [f32; UNKNOWNS] {
    let mut x = [0.0; UNKNOWNS];
    if matches!(prior.place, Place::Anywhere) {
        x[K] = place.at_least(LEAST_SHARE).at_most(1.0);
    }
    x
}

/// Compliance of the finger at the contact by the slope of the curve's beginning, without the cable's, radian per newton
/// metre.
pub(super) fn contact_compliance<X: SeriesElement>(data: &Data, prior: &Prior<X>) -> Option<f32> {
    let slope = curve::slope(data.points, FIRST_SHARE, data.drivetrain.creep)?;
    let rad_per_nm = slope.counts_per_nm * data.drivetrain.rad_per_count;
    let cable = if X::FLEXIBLE {
        prior.calibration.cable_rad_per_nm
    } else {
        0.0
    };
    Some((rad_per_nm - cable) / prior.calibration.torque_factor)
}

#[cfg(all(test, feature = "firmware"))]
mod tests;
