//! What becomes of held contacts, next to the truth: contacts that roll, slip, are lost or pushed, while the torque rises and while the
//! object is held; and contacts that nothing happens to.

use crate::disturbance::{Disturbance, Happened, What, When};
use crate::places::{calibrated, fitting};
use crate::{Error, Outcome, Simulated, Verdict};
use palpate::sensing::{Change, Followed};
use palpate_plant::{Grasp, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Grasps of one finger.
pub const GRASPS: usize = 10;
/// A change is told in time within this, second.
const IN_TIME_S: f64 = 0.05;
/// A change counts as large while the torque rises from this torque on, newton metre, and in the hold where more than this share is
/// gone.
const LARGE_NM: f64 = 0.02;
const LARGE_SHARE: f64 = 0.5;
/// Pins of the calibration on the last phalanx, as shares of its length.
const PINS: [f64; 2] = [0.29, 0.71];

/// Kinds of things that happen, with what of them counts as told right.
pub const KINDS: [(&str, &[Change]); 8] = [
    ("quiet", &[]),
    ("gives way, rising", &[Change::Slipped, Change::Lost]),
    ("gone, rising", &[Change::Lost]),
    ("pushed, rising", &[Change::Pushed]),
    ("gives way, held", &[Change::Slipped, Change::Lost]),
    ("gone, held", &[Change::Lost]),
    ("pushed, held", &[Change::Pushed]),
    ("gives way far, held", &[Change::Slipped, Change::Lost]),
];

/// An object, and what happens to it in each of [`KINDS`].
#[derive(Clone, Debug)]
pub struct Case {
    /// The object, before the last phalanx.
    pub grasp: Grasp,
    /// One of each kind.
    pub events: [(When, What); KINDS.len()],
}

impl Case {
    /// Draws a cylinder of 6 to 40 mm before a phalanx of this number and length.
    pub fn drawn(phalanx: u8, length_m: f64, random: &mut Pcg64Mcg) -> Self {
        let shape = Shape::Cylinder {
            diameter_m: random.random_range(0.006..0.04),
        };
        let k_m = length_m * random.random_range(0.2..0.85);
        let grasp = Grasp::touching(phalanx, k_m, random.random_range(0.55..1.0), shape);
        let rising = When::Rising(random.random_range(0.08..0.25));
        let holding = When::Holding(random.random_range(0.1..0.4));
        let by_m = random.random_range(1e-3..8e-3);
        let (slips, pushes) = (What::Gives(by_m), What::Gives(-1.5 * by_m));
        Self {
            grasp,
            events: [
                (When::Never, What::Nothing),
                (rising, slips),
                (rising, What::Goes),
                (rising, pushes),
                (holding, slips),
                (holding, What::Goes),
                (holding, pushes),
                (holding, What::Gives(6.0 * by_m)),
            ],
        }
    }
}

/// What a kind came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Grasps in which it happened; of quiet ones all.
    pub happened: u32,
    /// Of these the large ones.
    pub large: u32,
    /// Told anything afterwards.
    pub told: u32,
    /// Of these after large ones.
    pub large_told: u32,
    /// Told within 50 ms.
    pub in_time: u32,
    /// Told as what it was, at any time.
    pub right: u32,
    /// Told right, and within 50 ms.
    pub right_in_time: u32,
    /// Told before anything happened; of a quiet grasp anything told.
    pub early: u32,
    /// From the beginning until the first word, second.
    pub delays_s: Vec<f64>,
}

fn changes(outcome: &Outcome) -> impl Iterator<Item = (f64, Change)> {
    let told = outcome.followed.iter();
    told.filter_map(|(us, event)| match event {
        #[expect(clippy::cast_precision_loss, reason = "microseconds of a simulation")]
        Followed::Changed { change, .. } => Some((*us as f64 * 1e-6, *change)),
        _ => None,
    })
}

impl Score {
    fn add(&mut self, outcome: &Outcome, happened: Option<Happened>, wanted: &[Change]) {
        self.happened += 1;
        let Some(happened) = happened else {
            self.early += u32::from(changes(outcome).next().is_some());
            return;
        };
        self.early += u32::from(changes(outcome).any(|(at_s, _)| at_s < happened.time_s));
        let is_large = if happened.is_held {
            happened.to_nm < LARGE_SHARE * happened.from_nm
        } else {
            (happened.from_nm - happened.to_nm).abs() > LARGE_NM
        };
        self.large += u32::from(is_large);
        let since = || changes(outcome).filter(|(at_s, _)| *at_s >= happened.time_s);
        if let Some((at_s, _)) = since().next() {
            let delay_s = at_s - happened.time_s;
            self.told += 1;
            self.large_told += u32::from(is_large);
            self.in_time += u32::from(delay_s <= IN_TIME_S);
            self.delays_s.push(delay_s);
        }
        let right = since().find(|(_, change)| wanted.contains(change));
        self.right += u32::from(right.is_some());
        let in_time = right.is_some_and(|(at_s, _)| at_s - happened.time_s <= IN_TIME_S);
        self.right_in_time += u32::from(in_time);
    }

    /// Puts the scores of two fingers together.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.happened += other.happened;
        self.large += other.large;
        self.told += other.told;
        self.large_told += other.large_told;
        self.in_time += other.in_time;
        self.right += other.right;
        self.right_in_time += other.right_in_time;
        self.early += other.early;
        self.delays_s.extend(&other.delays_s);
        self.delays_s.sort_by(f64::total_cmp);
        self
    }

    /// Delay that this share of those told had at most, millisecond; NaN of none.
    #[must_use]
    pub fn delay_ms(&self, share: f64) -> f64 {
        let last = self.delays_s.len().saturating_sub(1);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "an index"
        )]
        let at = (share * last as f64).round() as usize;
        self.delays_s.get(at).map_or(f64::NAN, |s| 1e3 * s)
    }
}

/// A place after rolling, metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Error and claimed deviation of the place that was told.
    pub error_m: f64,
    /// See `error_m`.
    pub sigma_m: f64,
    /// How far the contact had rolled.
    pub way_m: f64,
    /// Error of the place where it began, taken for where it is.
    pub began_error_m: f64,
}

impl Moved {
    /// Of a grasp whose contact is the only one, located, and told where it has come to.
    #[must_use]
    pub fn of(outcome: &Outcome) -> Option<Self> {
        let first = outcome.first_contact?.contact;
        let [now] = outcome.truth.contacts[..] else {
            return None;
        };
        let Verdict::Located { k_m: began_m, .. } = outcome.verdict else {
            return None;
        };
        outcome.followed.iter().find_map(|(_, event)| match *event {
            Followed::Moved {
                phalanx,
                k_m,
                sigma_m,
                ..
            } if phalanx == now.phalanx => Some(Self {
                error_m: (f64::from(k_m) - now.k_m).abs(),
                sigma_m: f64::from(sigma_m),
                way_m: (now.k_m - first.k_m).abs(),
                began_error_m: (began_m - now.k_m).abs(),
            }),
            _ => None,
        })
    }
}

/// What all grasps of a finger, or of several, came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scores {
    /// In the order of [`KINDS`].
    pub kinds: [Score; KINDS.len()],
    /// Quiet grasps whose contact was told to have moved.
    pub moved: Vec<Moved>,
    /// Quiet grasps of which nothing told where the contact had come to.
    pub unmoved: u32,
}

impl Scores {
    /// Puts those of two fingers together.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        let mut others = other.kinds.iter();
        let mut moved = self.moved;
        moved.extend(&other.moved);
        Self {
            kinds: self.kinds.map(|score| match others.next() {
                Some(other) => score.with(other),
                None => score,
            }),
            moved,
            unmoved: self.unmoved + other.unmoved,
        }
    }

    /// Mean of something over the contacts that moved.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    pub fn mean(&self, of: impl Fn(&Moved) -> f64) -> f64 {
        self.moved.iter().map(of).sum::<f64>() / self.moved.len() as f64
    }

    /// Share of the contacts that moved whose place was told within two deviations, percent.
    #[must_use]
    pub fn within2_pct(&self) -> f64 {
        self.mean(|moved| 100.0 * f64::from(moved.error_m <= 2.0 * moved.sigma_m))
    }
}

/// A drawn finger of a world: prepared, calibrated on the stop and two pins, then `grasps` grasps with one closing of each kind.
/// `tell` hears of every closing.
///
/// # Errors
/// The world does not suit the scene, or an object cannot be where it is wanted.
pub fn finger<S: Simulated>(
    world: &World,
    seed: u64,
    grasps: usize,
    mut tell: impl FnMut(usize, &str, Option<Happened>, &Outcome),
) -> Result<Scores, Error> {
    let (simulation, _, length_m) = calibrated::<S>(world, seed, PINS)?;
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x00c4_a26e);
    let mut scores = Scores::default();
    for grasp in 0..grasps {
        let case = Case::drawn(S::PHALANGES, length_m, &mut random);
        for (index, ((name, wanted), (when, what))) in KINDS.iter().zip(case.events).enumerate() {
            let mut simulation = simulation.clone();
            simulation.reseed(seed.wrapping_mul(1_000_003) + (1000 * grasp + index) as u64);
            let mut disturbance = Disturbance::new(when, what);
            let mut refused = None;
            let outcome = simulation.close_while(&case.grasp, |plant, state| {
                refused = disturbance.advance(plant, state).err().or(refused.take());
            });
            if let Some(error) = refused {
                return Err(error.into());
            }
            let Some(outcome) = fitting(outcome)? else {
                continue;
            };
            let happened = disturbance.happened();
            tell(grasp, name, happened, &outcome);
            if when == When::Never {
                match Moved::of(&outcome) {
                    Some(moved) => scores.moved.push(moved),
                    None => scores.unmoved += 1,
                }
            }
            if happened.is_some() || when == When::Never {
                scores.kinds[index].add(&outcome, happened, wanted);
            }
        }
    }
    Ok(scores)
}
