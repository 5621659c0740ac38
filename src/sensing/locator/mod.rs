//! Locates the contact and estimates its radius: the whole torque-angle curve against the finger's exact path
//! (docs/MECHANICS.md#finite-torque-step, docs/BOUNDS.md#estimation-from-recordings).
//!
//! A hypothesis is a phalanx, on one side of its stiffest place. For each of several contact radii, unless another hypothesis is far
//! likelier, the location is fitted together with the other unknowns of contact and drivetrain, each with a prior: the onset, contact
//! friction, torque factor, friction or preload of the joints, the cable's twist and stiffening, losses or the object's compliance.
//! Residuals are correlated by friction and efficiency ([`Noise`]). The fits at all radii together, weighted by their evidence, are the
//! posterior: its mean and deviation are the location's, and its integral over a phalanx is that phalanx's probability. A contact on the
//! proximal phalanx, which has no place, competes with them.
//!
//! | module | responsible for |
//! |---|---|
//! | `prior` | unknowns and their priors |
//! | `model` | the torque predicted at the measured angles, with its derivatives |
//! | `noise` | the part of a residual that earlier points predict |
//! | `onset` | the free finger where a contact begins |
//! | `fit` | one fit: passes over the curve, a few points at a time |
//! | `starts` | hypotheses and where their fits begin: the finger's inverse, and beside it |
//! | `radii` | radii of the object, and the order in which they are fitted |
//! | `shares` | how much of the curve one contact explains |
//! | `posterior` | verdict: fits weighted by their evidence |
//! | `force` | posture and force of an estimate |

mod fit;
mod force;
mod model;
mod noise;
mod onset;
mod posterior;
mod prior;
mod radii;
mod shares;
mod starts;
#[cfg(all(test, feature = "firmware"))]
mod tests;

pub(super) use force::springs;
pub use noise::Noise;
pub(super) use noise::{WAVE_SHARE, waves_nm};
pub use onset::free_behind_cable;
pub use posterior::{Estimate, LocatorResult};
pub use prior::{Place, Prior};

use crate::finger::{Class, Free, Mechanics};
use crate::joint_sensor::Told;
use crate::sensing::curve::Point;
use crate::sensing::{Calibration, Drivetrain, SeriesElement};
use fit::{Fit, Fitted, Progress};
use model::{Hold, Model};
use radii::{RADII_M, radius_m};
use shares::Longer;
use starts::{HELD_START, last_start};

/// Smallest number of points for a fit.
pub const LEAST_POINTS: usize = 5;
/// Largest number of hypotheses: two places on each of two phalanges, and a proximal contact.
const MOST: usize = 5;

/// Calibration from a contact at a known place or from the closing stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    /// Torque factor, cable and torque of the joints with their deviations, as far as the model and the priors hold.
    pub calibration: Calibration,
    /// Mean square residual, in variances.
    pub misfit: f32,
    /// How far the rest of what is known had to give way for it, as a variance ratio, at least 1.
    pub strain: f32,
}

/// The curve in the form that the model needs.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// Points, by rising angle.
    pub points: &'a [Point],
    /// Measured angle theta_a at the curve's origin, radian.
    pub origin_rad: f32,
    /// The drivetrain.
    pub drivetrain: &'a Drivetrain,
}

impl Data<'_> {
    /// Measured angle of a point.
    fn rad(&self, point: &Point) -> f32 {
        self.origin_rad + point.counts * self.drivetrain.rad_per_count
    }

    /// Measured angle at the end of a point.
    fn end_rad(&self, point: &Point) -> f32 {
        self.rad(point) + 0.5 * point.width_counts * self.drivetrain.rad_per_count
    }
}

/// A hypothesis with the results of its fits.
#[derive(Clone, Debug)]
struct Track {
    phalanx: u8,
    length_m: f32,
    /// Location by the finger's inverse, in lengths of the phalanx.
    candidate: f32,
    /// Its side of the stiffest place, in lengths of the phalanx.
    side: [f32; 2],
    fits: [Option<Fitted>; RADII_M.len()],
}

/// All hypotheses.
type Tracks = heapless::Vec<Track, MOST>;

/// Fits all hypotheses in rounds. Within a round every hypothesis is fitted to the same points, otherwise their evidence could
/// not be compared.
#[derive(Clone, Debug)]
pub struct Locator<F: Mechanics, X: SeriesElement> {
    tracks: Tracks,
    /// Number of points of this round.
    number: usize,
    fit: Option<Fit<F, X>>,
    /// Current hypothesis, index into [`ORDER`](radii::ORDER), and start.
    track: usize,
    order: usize,
    start: usize,
    /// Whether this round starts each fit at several places.
    thorough: bool,
    /// How much of the curve is believed, index into the shares of `shares`.
    share: usize,
    /// A longer part of the curve, with which this one is compared.
    longer: Option<Longer>,
    /// That comparison is over: the next round's verdict stands.
    compared: bool,
    under_way: bool,
    /// Reason from the slope alone, for a contact that no hypothesis explains.
    class: Class,
}

impl<F: Mechanics, X: SeriesElement> Default for Locator<F, X> {
    fn default() -> Self {
        Self {
            tracks: heapless::Vec::new(),
            number: 0,
            fit: None,
            track: 0,
            order: 0,
            start: 0,
            thorough: false,
            share: 0,
            longer: None,
            compared: false,
            under_way: false,
            class: Class::Invalid,
        }
    }
}

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// Whether a round is under way.
    pub fn is_under_way(&self) -> bool {
        self.under_way
    }

    /// Begins a round on the points so far; false if there are too few. The last round is thorough.
    /// Until the round is over its points must not change; new ones may be added.
    pub fn begin(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        last: bool,
    ) -> bool {
        self.fit = None;
        (self.track, self.order, self.start) = (0, 0, 0);
        let (number, enough) = shares::points(data, self.share);
        self.number = number;
        self.under_way = enough;
        if !self.under_way {
            return false;
        }
        self.thorough = last || self.tracks.is_empty();
        if self.thorough {
            let data = self.of_round(data);
            self.class = starts::find(&mut self.tracks, finger, &data, prior, near);
        }
        self.under_way = !self.tracks.is_empty();
        self.under_way
    }

    fn of_round<'a>(&self, data: &Data<'a>) -> Data<'a> {
        Data {
            points: data.points.get(..self.number).unwrap_or(data.points),
            ..*data
        }
    }

    /// Evaluates the next points of a pass over the curve (cost: docs/RESULTS.md#speed-and-size). `joint` is what the sensor of joint 2
    /// told when the round began, `()` without one. True at the end of the round: then there is a verdict.
    pub fn step(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        joint: impl Told,
    ) -> bool {
        if !self.under_way {
            return false;
        }
        let data = self.of_round(data);
        // Read at the end of the whole curve, where a second contact may act. It checks places and does not calibrate.
        let joint = if self.share == 0 && matches!(prior.place, Place::Anywhere) {
            joint
        } else {
            Default::default()
        };
        if self.fit.is_none() {
            self.fit = self.next_fit(prior, joint);
        }
        let joint = if self.distrusts(joint) {
            joint.distrusted()
        } else {
            joint
        };
        let Some(fit) = &mut self.fit else {
            self.under_way = false;
            return true;
        };
        let progress = fit.step(finger, &data, prior, near, joint);
        if progress == Progress::UnderWay {
            return false;
        }
        let fitted = match progress {
            Progress::Converged => fit.fitted(prior),
            _ => None,
        };
        // The calibration needs the best fit itself at a known place. Repeat that fit if the last start was not the best.
        if !matches!(prior.place, Place::Anywhere) {
            let best = self.keep(fitted);
            self.start = match (prior.place, self.start) {
                (Place::Known { .. }, 0) => HELD_START,
                (Place::Known { .. }, HELD_START) if !best => const { 1 + last_start::<F>() },
                _ => {
                    self.under_way = false;
                    return true;
                }
            };
            self.fit = None;
            return false;
        }
        self.fit = None;
        self.keep(fitted);
        self.go_on(prior, joint);
        if self.track >= self.tracks.len() {
            self.under_way = false;
        }
        !self.under_way
    }

    /// What a fit at a known place or at the stop teaches, with its mean square residual.
    pub fn learned(&mut self, prior: &Prior<X>) -> Option<Learned> {
        let mut learned = self.fit.as_mut()?.learned(prior)?;
        learned.misfit /= self.number as f32;
        Some(learned)
    }

    /// Whether a pass over the curve has begun and is not complete.
    pub fn is_within_pass(&self) -> bool {
        self.fit.as_ref().is_some_and(Fit::is_within_pass)
    }

    /// Abandons the current round.
    pub fn stop(&mut self) {
        self.under_way = false;
        self.fit = None;
    }

    /// Whether a contact without a place may be on phalanx 1: not where that is hidden, nor where the place is lost at joint 3.
    pub fn may_be_proximal(&self) -> bool {
        let is_beyond = |(track, _): (&Track, _)| track.phalanx > 2;
        F::FIRST_TOUCHING == 1 && !(F::PHALANGES > 2 && self.likeliest().is_some_and(is_beyond))
    }
}

impl Track {
    fn hold<X: SeriesElement>(&self, radius: usize, prior: &Prior<X>) -> Hold {
        match (prior.place, self.phalanx) {
            (Place::Stop, _) => Hold::Stop,
            (Place::Known { radius_m, .. }, phalanx) => Hold::Contact { phalanx, radius_m },
            (Place::Anywhere, 0 | 1) => Hold::Proximal,
            (Place::Anywhere, phalanx) => Hold::Contact {
                phalanx,
                radius_m: radius_m(radius) + prior.half_thickness_m,
            },
        }
    }

    /// The fit with a radius, where there is one.
    fn fit(&self, radius: usize) -> Option<&Fitted> {
        self.fits.get(radius)?.as_ref()
    }
}
