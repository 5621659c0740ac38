//! The pieces of work that experiments are made of: one finger and its closings.

use palpate_plant::{Engine, Parameters, World};
use palpate_simulation::Simulated;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::live::{Failure, Setup};
use super::objects::Object;
use super::result::{Method, Place};
use super::session::{Case, Session};
use crate::score::{Contact, Trial};

/// One trial with the row it belongs to.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the experiment.
    pub experiment: String,
    /// Algorithm.
    pub method: Method,
    /// After the guided calibration.
    pub calibrated: bool,
    /// What was said.
    pub trial: Trial,
}

/// A piece of work that one worker does: one finger and its closings.
pub struct Job {
    /// What it belongs to.
    pub name: String,
    /// Closings in it.
    pub closings: usize,
    /// The work: appends its entries, so that what was done before a failure counts.
    pub run: Box<Work>,
}

/// See [`Job::run`].
pub type Work = dyn Fn(&mut Vec<Entry>) -> Result<(), Failure> + Send + Sync;

/// What to run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The world, or the middle of the worlds that are drawn.
    pub world: World,
    /// Its name and the engine, for the tables.
    pub place: Place,
    /// The default scene in it.
    pub parameters: Parameters,
    /// Seed of everything that is drawn at random.
    pub seed: u64,
    /// A tenth of the free closings, a quarter of the random ones.
    pub quick: bool,
}

impl Plan {
    /// A scene in the world.
    ///
    /// # Errors
    /// A value of the world that does not go with the scene.
    pub fn of(&self, scene: &str) -> Result<Parameters, palpate_plant::Error> {
        self.world.of(scene)
    }

    /// How many fingers an experiment takes: `full`, half of them where MuJoCo takes its time, or `quick`.
    #[must_use]
    pub fn fingers(&self, quick: u64, full: u64) -> u64 {
        match (self.quick, self.world.engine) {
            (true, _) => quick,
            (false, Engine::Plant) => full,
            (false, Engine::Mujoco) => full / 2,
        }
    }
}

/// Tries to find a place for an object.
const TRIES: usize = 20;

pub(super) fn entries<S: Simulated>(
    experiment: &'static str,
    session: &Session<S>,
    case: &Case,
) -> Result<Vec<Entry>, Failure> {
    Ok(session
        .all(case)?
        .into_iter()
        .map(|(method, calibrated, trial)| Entry {
            experiment: experiment.to_owned(),
            method,
            calibrated,
            trial,
        })
        .collect())
}

/// A job whose closings each come from `next`, tried again where the object cannot be there.
pub(super) fn job<S: Simulated + 'static>(
    experiment: &'static str,
    parameters: Result<Parameters, palpate_plant::Error>,
    seed: u64,
    closings: usize,
    next: impl Fn(usize, &mut Pcg64Mcg) -> Wanted + Send + Sync + 'static,
) -> Job {
    let run = move |found: &mut Vec<Entry>| {
        let parameters = parameters
            .clone()
            .map_err(palpate_simulation::Error::Plant)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x005e_ed0f_91ac_e500);
        let mut session = match Session::<S>::new(&parameters, &Setup::default(), seed) {
            Ok(session) => session,
            Err(failure) => {
                // A finger that does not get through its preparation feels nothing.
                for index in 0..closings {
                    found.extend(unfelt(experiment, next(index, &mut random).phalanx));
                }
                return Err(Failure::Unfelt(Box::new(failure)));
            }
        };
        let mut ended = Ok(());
        for index in 0..closings {
            match closing(&mut session, || next(index, &mut random)) {
                Ok(case) => found.extend(entries(experiment, &session, &case)?),
                // What the firmware could not end counts as a contact that was not felt.
                Err(Failure::Fault(fault)) => {
                    found.extend(unfelt(experiment, next(index, &mut random).phalanx));
                    ended = Err(Failure::Unfelt(Box::new(Failure::Fault(fault))));
                }
                Err(failure) => return Err(failure),
            }
        }
        ended
    };
    Job {
        name: experiment.to_owned(),
        closings,
        run: Box::new(run),
    }
}

/// A contact of which no method said anything.
fn unfelt(experiment: &'static str, phalanx: u8) -> impl Iterator<Item = Entry> {
    let trial = Trial {
        truth: Some(Contact {
            phalanx,
            k_m: f64::NAN,
            length_m: f64::NAN,
            time_s: f64::INFINITY,
        }),
        ..Trial::default()
    };
    [Method::Ours]
        .into_iter()
        .chain(Method::papers().map(|(method, _)| method))
        .flat_map(|method| [(method, true), (method, false)])
        .map(move |(method, calibrated)| Entry {
            experiment: experiment.to_owned(),
            method,
            calibrated,
            trial,
        })
}

/// A contact that is wanted.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The object.
    pub object: Object,
    /// Phalanx.
    pub phalanx: u8,
    /// Place, metre.
    pub k_m: f64,
    /// Posture, radian.
    pub theta_1_rad: f64,
    /// Whether another phalanx may meet the object first; an experiment about one phalanx puts the object elsewhere then.
    pub any_first: bool,
}

/// Closes on the first wanted contact that can be made.
///
/// # Errors
/// [`Failure`].
pub fn closing<S: Simulated>(
    session: &mut Session<S>,
    mut next: impl FnMut() -> Wanted,
) -> Result<Case, Failure> {
    for _ in 0..TRIES {
        let wanted = next();
        let case = session.grasp(
            &wanted.object,
            wanted.phalanx,
            wanted.k_m,
            wanted.theta_1_rad,
        )?;
        let other = |case: &Case| {
            case.truth
                .is_some_and(|truth| truth.phalanx != wanted.phalanx)
        };
        match case {
            Some(case) if wanted.any_first || !other(&case) => return Ok(case),
            _ => {}
        }
    }
    Err(Failure::Missing("place for the object"))
}
