//! Second contacts told next to the truth, on drawn grasps: power grasps, in which another phalanx presses too, and single
//! contacts.

use crate::places::{PIN_RAD, PIN_SHARES, fitting};
use crate::{Error, Outcome, Row, Simulated, Simulation};
use palpate::drive::config::Config;
use palpate::drive::sequence::Motion;
use palpate::finger::HoldsTwice;
use palpate::joint_sensor::AngleSensor;
use palpate::scene::Scene;
use palpate::sensing::{
    AfterContact, Calibration, Drivetrain, Event, Follow, Followed, Grip, Settings,
};
use palpate_plant::{Contact, Grasp, Shape, Truth, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::marker::PhantomData;

/// A phalanx presses on the object, newton: less is a graze.
const PRESSES_N: f64 = 0.2;
/// Samples most of which show two phalanges in contact.
const PRESSES_MS: usize = 20;
/// Turns that the motor makes at least while two phalanges press and it closes: with fewer they met as the motion ended, or in
/// passing.
const LEAST_TURNS: f64 = 4.0;

/// A scene with something else after the first contact, whatever its file says.
#[derive(Clone, Copy, Debug)]
pub struct With<S, A>(PhantomData<(S, A)>);

/// A scene with the option `second_contact`, whether its file has it or not.
pub type Grasping<S> = With<S, Follow<<S as Scene>::Finger>>;

impl<S: Scene, A: AfterContact<S::Finger>> Scene for With<S, A> {
    const NAME: &'static str = S::NAME;
    const DIMENSIONS: &'static str = S::DIMENSIONS;
    type Finger = S::Finger;
    type Joint = S::Joint;
    type Series = S::Series;
    type After = A;
    const MECHANISM: Self::Finger = S::MECHANISM;
    const DRIVE: Config = S::DRIVE;
    const MOTION: Motion = S::MOTION;
    const UNCALIBRATED: Calibration = S::UNCALIBRATED;
    const DRIVETRAIN: Drivetrain = S::DRIVETRAIN;
    const FRICTION_NM: f32 = S::FRICTION_NM;
    const IDENTIFIES: bool = S::IDENTIFIES;
    const HOLD_FORCE_N: f32 = S::HOLD_FORCE_N;
    const MOUNTING_RAD: f32 = S::MOUNTING_RAD;
    const ANGLE_SENSOR: AngleSensor = S::ANGLE_SENSOR;

    fn settings() -> Settings {
        S::settings()
    }
}

/// What a run of grasps came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Grasps in which two phalanges pressed for some turns of the motor, and the second at the end.
    pub power: u32,
    /// Of these told.
    pub told: u32,
    /// Of these with the right phalanx.
    pub phalanx_right: u32,
    /// Of those told with a wrong phalanx; of the others the phalanx was not told.
    pub phalanx_wrong: u32,
    /// Of these told as enveloped.
    pub enveloped: u32,
    /// Two pressed for fewer turns: as the motion ended, or while the object passed from one to the other; and of these told.
    pub late: u32,
    /// See `late`.
    pub late_told: u32,
    /// A second phalanx touched and hardly pressed.
    pub grazed: u32,
    /// One phalanx pressed, and of these told as two.
    pub single: u32,
    /// See `single`.
    pub false_ones: u32,
    /// Closings that ended in a fault.
    pub faults: u32,
    /// Places on the right phalanx, as shares of it: told less true, with the deviation told.
    pub places: Vec<[f64; 2]>,
}

impl Score {
    /// Puts the scores of two fingers together.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.power += other.power;
        self.told += other.told;
        self.phalanx_right += other.phalanx_right;
        self.phalanx_wrong += other.phalanx_wrong;
        self.enveloped += other.enveloped;
        self.late += other.late;
        self.late_told += other.late_told;
        self.grazed += other.grazed;
        self.single += other.single;
        self.false_ones += other.false_ones;
        self.faults += other.faults;
        self.places.extend(&other.places);
        self
    }

    /// Adds a closing on an object that phalanx `first` touched first, with the second contact as it began and so many turns of
    /// the motor with two.
    fn add(
        &mut self,
        outcome: &Outcome,
        first: u8,
        began: Option<&Contact>,
        turns: f64,
        lengths_m: &[f64],
    ) {
        let others = || outcome.truth.contacts.iter().filter(|c| c.phalanx != first);
        let second: Option<&Contact> = others()
            .filter(|c| c.force_n > PRESSES_N)
            .max_by(|a, b| a.force_n.total_cmp(&b.force_n));
        let told = outcome.second_contact();
        if second.is_none() {
            if others().next().is_some() {
                self.grazed += 1;
            } else {
                self.single += 1;
                self.false_ones += u32::from(told.is_some());
            }
            return;
        }
        if turns < LEAST_TURNS {
            self.late += 1;
            self.late_told += u32::from(told.is_some());
            return;
        }
        self.power += 1;
        self.enveloped += u32::from(outcome.grip() == Some(Grip::Enveloped));
        if let Some(Followed::SecondContact {
            phalanx,
            k_m,
            sigma_m,
            ..
        }) = told
        {
            self.told += 1;
            let truth = began.filter(|truth| truth.phalanx == phalanx);
            self.phalanx_right += u32::from(truth.is_some());
            self.phalanx_wrong += u32::from(truth.is_none() && phalanx != 0);
            if let Some(truth) = truth.filter(|_| k_m.is_finite()) {
                let length_m = lengths_m[usize::from(phalanx) - 1];
                let error_m = f64::from(k_m) - truth.k_m;
                self.places
                    .push([error_m, f64::from(sigma_m)].map(|m| m / length_m));
            }
        }
    }
}

/// Follows the contacts of a closing: where the second one was when it began. It rolls afterwards, as the first does.
#[derive(Debug, Default)]
struct Second {
    began: Option<Contact>,
    /// Samples in a row without it.
    gone: usize,
}

impl Second {
    fn advance(&mut self, truth: &Truth) {
        let first = truth.first_contact.map(|first| first.contact.phalanx);
        let others = truth.contacts.iter();
        let other = others.filter(|contact| first.is_some_and(|first| contact.phalanx != first));
        match other.max_by(|a, b| a.force_n.total_cmp(&b.force_n)) {
            Some(contact) => {
                self.began.get_or_insert(*contact);
                self.gone = 0;
            }
            None => {
                self.gone += 1;
                if self.gone > PRESSES_MS {
                    self.began = None;
                }
            }
        }
    }
}

fn drawn(lengths_m: &[f64], random: &mut Pcg64Mcg) -> Grasp {
    let phalanges = lengths_m.len();
    // Large objects against the inner phalanges meet another phalanx, small ones out there do not.
    let is_large = random.random_bool(0.6);
    let phalanx = if is_large {
        random.random_range(1..phalanges)
    } else {
        random.random_range(1..=phalanges)
    };
    let share = if is_large { 0.5..0.95 } else { 0.2..0.9 };
    let diameter_m = if is_large { 0.04..0.10 } else { 0.006..0.03 };
    let shape = Shape::Cylinder {
        diameter_m: random.random_range(diameter_m),
    };
    let k_m = random.random_range(share) * lengths_m[phalanx - 1];
    let theta_1_rad = random.random_range(0.55..1.0);
    #[expect(clippy::cast_possible_truncation, reason = "a phalanx of three")]
    Grasp::touching(phalanx as u8, k_m, theta_1_rad, shape)
}

/// Turns that the motor made while two phalanges pressed, bounces left out, as far as closing and probing go. Beyond that the
/// motor holds with a current of its own and shows no torque.
fn turns_with_two(
    outcome: &Outcome,
    counts_per_turn: f64,
    travel_counts: f64,
    probing_counts: f64,
) -> f64 {
    let touched_s = outcome.events.iter().find_map(|(time_us, event)| {
        #[expect(clippy::cast_precision_loss, reason = "microseconds of a simulation")]
        matches!(event, Event::Touch { .. }).then_some(*time_us as f64 * 1e-6)
    });
    let touched = (outcome.trace.iter()).find(|row| touched_s.is_some_and(|s| row.time_s >= s));
    let probed = touched.map_or(travel_counts, |row| {
        f64::from(row.encoder_counts) + probing_counts
    });
    let end_counts = travel_counts.min(probed);
    let pressing = |row: &&Row| row.true_pressing.count_ones() > 1;
    let began = (outcome.trace.windows(PRESSES_MS))
        .position(|rows| rows.iter().filter(pressing).count() > PRESSES_MS / 2);
    let since = began.and_then(|first| outcome.trace.get(first..));
    let way = since.and_then(|rows| {
        let last = rows.iter().filter(pressing).map(|row| row.encoder_counts);
        let last_counts = f64::from(last.max()?).min(end_counts);
        Some(last_counts - f64::from(rows.first()?.encoder_counts))
    });
    way.unwrap_or(0.0) / counts_per_turn
}

/// A drawn finger of a world, prepared and, if wanted, calibrated, and its grasps. `tell` hears of every closing, with the second
/// contact as it began and the turns of the motor with two.
///
/// # Errors
/// The world does not suit the scene; the sequence refused.
pub fn finger<S>(
    world: &World,
    seed: u64,
    grasps: usize,
    calibrated: bool,
    tell: impl FnMut(&Outcome, Option<&Contact>, f64),
) -> Result<Score, Error>
where
    S: Simulated<Finger: HoldsTwice>,
{
    finger_of::<Grasping<S>>(world, seed, grasps, calibrated, tell)
}

/// The same of a scene that looks for second contacts by itself: its own, or [`With`] what follows.
///
/// # Errors
/// As [`finger`].
pub fn finger_of<S: Simulated>(
    world: &World,
    seed: u64,
    grasps: usize,
    calibrated: bool,
    mut tell: impl FnMut(&Outcome, Option<&Contact>, f64),
) -> Result<Score, Error> {
    let parameters = world.of(S::NAME)?.randomised(seed);
    let lengths_m = &parameters.finger.length_m;
    let drivetrain = S::drivetrain(&S::MECHANISM);
    let [travel_counts, probing_counts] =
        [S::TRAVEL_RAD, S::MOTION.probing_rad].map(|rad| f64::from(rad / drivetrain.rad_per_count));
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut simulation = Simulation::<S>::new(&parameters, seed)?;
    simulation.prepare()?;
    if calibrated {
        let length_m = lengths_m[usize::from(S::PHALANGES) - 1];
        simulation.calibrate_on_pins(length_m, PIN_SHARES, PIN_RAD)?;
    }
    simulation.traced = true;
    let mut score = Score::default();
    for index in 0..grasps {
        let grasp = drawn(lengths_m, &mut random);
        let mut simulation = simulation.clone();
        simulation.reseed(seed.wrapping_mul(1_000_003) + index as u64);
        let mut second = Second::default();
        let closed = simulation.close_while(&grasp, |plant, _| second.advance(&plant.truth()));
        let Some(outcome) = fitting(closed)? else {
            continue;
        };
        let Some(first) = outcome.first_contact.map(|first| first.contact.phalanx) else {
            continue;
        };
        let counts_per_turn = parameters.encoder.counts_per_rev;
        let turns = turns_with_two(&outcome, counts_per_turn, travel_counts, probing_counts);
        tell(&outcome, second.began.as_ref(), turns);
        if outcome.fault.is_some() {
            score.faults += 1;
        } else {
            score.add(&outcome, first, second.began.as_ref(), turns, lengths_m);
        }
    }
    Ok(score)
}
