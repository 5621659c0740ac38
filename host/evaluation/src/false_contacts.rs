//! False contacts against delay: what each choice of the setting `sensitivity` costs in a world.
//!
//! Fingers drawn from the spreads close on nothing and on something; every closing is simulated once and judged with every
//! choice.

use palpate::drive::fault::Fault;
use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_simulation::Simulated;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::experiments::catalogue::random_cylinder;
use crate::experiments::fingers;
use crate::experiments::job::{Plan, Wanted, closing};
use crate::experiments::judge::length_m;
use crate::experiments::live::{Failure, Setup};
use crate::experiments::result::Place;
use crate::experiments::session::{Case, Session};
use crate::score::{Contact, Scores, Trial};

/// Choices of the setting, false contacts per thousand closings.
pub const CHOICES: [f32; 6] = [100.0, 10.0, 1.0, 0.1, 0.01, 0.001];
/// Seeds of the fingers, from the plan's on.
const SEEDS: u64 = 7000;
/// Free closings of one finger.
const CLOSINGS: usize = 25;
/// Default number of contacts of one finger on each of two phalanges: the first that can touch, where a contact is softest, and the last.
pub const CONTACTS: usize = 5;
/// Postures of the contacts, `theta_1`, radian: a finger without a spring at joint 1 meets objects anywhere on its travel, the others
/// past the rest angle of their springs, with way left for the probing.
const POSTURES_RAD: [std::ops::Range<f64>; 2] = [0.25..1.1, 0.65..0.95];

/// What one choice costs.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// The finger.
    pub scene: String,
    /// The setting, false contacts per thousand closings.
    pub sensitivity: f32,
    /// Free closings.
    pub free: usize,
    /// Touches in them.
    pub false_contacts: usize,
    /// Those said to be softer than a free finger.
    pub unusual: usize,
    /// Contacts.
    pub contacts: usize,
    /// Of them: felt before they were there.
    pub early: usize,
    /// Of them: never felt.
    pub missed: usize,
    /// Delay of the contacts on the first phalanx that can touch, median and 90 %, millisecond.
    pub proximal_ms: [Option<f64>; 2],
    /// The same, distal phalanx.
    pub distal_ms: [Option<f64>; 2],
}

/// The trials of one finger by choice.
type Trials = Vec<[Trial; CHOICES.len()]>;

fn judged<S: Simulated>(
    session: &mut Session<S>,
    case: &Case,
) -> Result<[Trial; CHOICES.len()], Failure> {
    let calibration = session.calibrated;
    let mut trials = [Trial::default(); CHOICES.len()];
    for (trial, choice) in trials.iter_mut().zip(CHOICES) {
        session.settings.false_contacts_per_thousand = choice;
        *trial = session.ours(case, &calibration)?;
    }
    Ok(trials)
}

/// What each finger of a study does.
#[derive(Clone, Copy, Debug)]
struct Each {
    closings: usize,
    contacts: usize,
}

/// A closing that the firmware did not end: felt where there was nothing, not felt where there was something.
fn unended(phalanx: Option<u8>) -> [Trial; CHOICES.len()] {
    let truth = phalanx.map(|phalanx| Contact {
        phalanx,
        k_m: f64::NAN,
        length_m: f64::NAN,
        time_s: f64::INFINITY,
    });
    let touched_s = truth.is_none().then_some(0.0);
    [Trial {
        truth,
        touched_s,
        ..Trial::default()
    }; CHOICES.len()]
}

/// The trials of a finger, and the last fault, which is one of the trials.
fn finger<S: Simulated>(
    plan: &Plan,
    seed: u64,
    each: Each,
) -> Result<(Trials, Option<Fault>), Failure> {
    let parameters = plan.of(S::NAME).map_err(palpate_simulation::Error::Plant)?;
    let mut session = Session::<S>::new(&parameters.randomised(seed), &Setup::default(), seed)?;
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x00fa_15e0);
    let mut trials = Trials::new();
    let mut switched_off = None;
    let mut take = |session: &mut Session<S>, closed: Result<Case, Failure>, phalanx| {
        trials.push(match closed {
            Ok(case) => judged(session, &case)?,
            Err(Failure::Fault(fault)) => {
                switched_off = Some(fault);
                unended(phalanx)
            }
            Err(failure) => return Err(failure),
        });
        Ok(())
    };
    for _ in 0..each.closings {
        let closed = session.free_closing();
        take(&mut session, closed, None)?;
    }
    let [unsprung, sprung] = POSTURES_RAD;
    let postures = if parameters.finger.spring_nm_per_rad[0] > 0.0 {
        sprung
    } else {
        unsprung
    };
    for phalanx in [first_touching::<S>(), S::PHALANGES] {
        let length_m = length_m::<S>(phalanx)?;
        for _ in 0..each.contacts {
            let closed = closing(&mut session, || Wanted {
                object: random_cylinder(&mut random),
                phalanx,
                k_m: length_m * random.random_range(0.05..0.95),
                theta_1_rad: random.random_range(postures.clone()),
                any_first: false,
            });
            take(&mut session, closed, Some(phalanx))?;
        }
    }
    Ok((trials, switched_off))
}

/// The first phalanx that can touch anything.
fn first_touching<S: Scene>() -> u8 {
    <S::Finger as Mechanics>::FIRST_TOUCHING
}

/// Rows, and seeds of the fingers that did not get through, with the reason.
pub type Study = (Vec<Row>, Vec<(u64, Failure)>);

/// `closings` free closings on as many fingers of a scene as they need, and `contacts` of each finger on either phalanx. `None` where
/// there is no such scene.
#[must_use]
pub fn study(plan: &Plan, scene: &str, closings: usize, contacts: usize) -> Option<Study> {
    palpate_scenes::for_scene!(scene, |S| study_of::<S>(plan, closings, contacts))
}

fn study_of<S: Simulated>(plan: &Plan, closings: usize, contacts: usize) -> Study {
    let fingers = closings.div_ceil(CLOSINGS) as u64;
    let each = Each {
        closings: closings.div_ceil(fingers.max(1) as usize),
        contacts,
    };
    let first = plan.seed + SEEDS;
    let label = format!("{} {}", S::NAME, world(&plan.place));
    let (found, mut failed) = fingers::each(&label, first..first + fingers, |seed| {
        Ok((seed, finger::<S>(plan, seed, each)?))
    });
    let mut all = Trials::new();
    for (seed, (trials, switched_off)) in found {
        all.extend(trials);
        let unfelt = |fault| (seed, Failure::Unfelt(Box::new(Failure::Fault(fault))));
        failed.extend(switched_off.map(unfelt));
    }
    let row = |index: usize| {
        let trials: Vec<Trial> = all.iter().map(|trials| trials[index]).collect();
        let on = |phalanx: u8| {
            let of = trials.iter().filter(|trial| {
                trial
                    .truth
                    .is_some_and(|contact| contact.phalanx == phalanx)
            });
            Scores::of(of)
        };
        let free = Scores::of(trials.iter().filter(|trial| trial.truth.is_none()));
        let [proximal, distal] = [on(first_touching::<S>()), on(S::PHALANGES)];
        let delays = |scores: &Scores| [scores.touch_delay_ms, scores.touch_delay_90_ms];
        Row {
            place: plan.place.clone(),
            scene: S::NAME.to_owned(),
            sensitivity: CHOICES[index],
            free: free.free,
            false_contacts: free.free_touched,
            unusual: free.unusual,
            contacts: proximal.closings + distal.closings,
            early: proximal.early + distal.early,
            missed: proximal.missed + distal.missed,
            proximal_ms: delays(&proximal),
            distal_ms: delays(&distal),
        }
    };
    ((0..CHOICES.len()).map(row).collect(), failed)
}

/// A world's name, with its engine where it is not the plant.
fn world(place: &Place) -> String {
    match place.engine.as_str() {
        "plant" => place.world.clone(),
        engine => format!("{}@{engine}", place.world),
    }
}

/// The table of the manual.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut out = head(
        "world | scene | `sensitivity` | false contacts | false `unusual` | contacts early, missed | proximal, ms: median, 90 % \
         | distal, ms: median, 90 %",
    );
    let whole = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.0}"));
    let pair = |[a, b]: [Option<f64>; 2]| format!("{}, {}", whole(a), whole(b));
    for row in rows {
        let line = format!(
            "| {} | {} | {} | {} of {} | {} | {}, {} of {} | {} | {} |\n",
            world(&row.place),
            row.scene,
            row.sensitivity,
            row.false_contacts,
            row.free,
            row.unusual,
            row.early,
            row.missed,
            row.contacts,
            pair(row.proximal_ms),
            pair(row.distal_ms),
        );
        out.push_str(&line);
    }
    out
}
