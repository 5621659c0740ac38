//! Places and stiffnesses told of objects on springs, next to the truth: drawn fingers, calibrated on pins that are fixed.

use crate::places::{PIN_SHARES, anew, calibrated, drawn, fitting};
use crate::{Error, Simulated, Verdict};
use palpate_plant::{Object, ObjectMount, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// Angles of joint 1, radian.
const POSTURES_RAD: std::ops::Range<f64> = 0.45..1.0;

/// Stiffness of the springs that hold the objects, newton per metre; `None` of fixed ones.
pub const LEVELS: [Option<f64>; 5] = [None, Some(3000.0), Some(1000.0), Some(500.0), Some(250.0)];

/// What the closings on objects of one stiffness came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Closings on the last phalanx.
    pub closings: u32,
    /// Of these, told to be somewhere else.
    pub elsewhere: u32,
    /// Places told on the right phalanx, as shares of it: told less true, with the deviation told.
    pub places: Vec<[f64; 2]>,
    /// Compliance of the object, metre per newton: told less true, with the deviation told.
    pub compliances: Vec<[f64; 2]>,
    /// A stiffness was told and not only a least one.
    pub clear: u32,
}

impl Score {
    /// Puts the scores of two fingers together.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.closings += other.closings;
        self.elsewhere += other.elsewhere;
        self.clear += other.clear;
        self.places.extend(&other.places);
        self.compliances.extend(&other.compliances);
        self
    }
}

/// A drawn finger of a world, calibrated, and `grasps` objects of each of the [`LEVELS`]: the same places and sizes at every level.
///
/// # Errors
/// The world does not suit the scene; the sequence refused.
pub fn finger<S: Simulated>(world: &World, seed: u64, grasps: usize) -> Result<Vec<Score>, Error> {
    let (simulation, parameters, length_m) = calibrated::<S>(world, seed, PIN_SHARES)?;
    let one = |level: &Option<f64>| -> Result<Score, Error> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut score = Score::default();
        for index in 0..grasps {
            let grasp = drawn::<S>(length_m, POSTURES_RAD, &mut random);
            let mut simulation = anew(&simulation, seed, index);
            simulation.plant().mount(&Object {
                mount: level.map_or(ObjectMount::Fixed, |_| ObjectMount::Spring),
                stiffness_n_per_m: level.unwrap_or(parameters.object.stiffness_n_per_m),
                ..parameters.object
            })?;
            let Some(outcome) = fitting(simulation.close(&grasp))? else {
                continue;
            };
            let first = outcome.first_contact.map(|first| first.contact);
            let Some(truth) = first.filter(|contact| contact.phalanx == S::PHALANGES) else {
                continue;
            };
            score.closings += 1;
            let Verdict::Located {
                phalanx,
                k_m,
                sigma_m,
                ..
            } = outcome.verdict
            else {
                continue;
            };
            if phalanx != truth.phalanx {
                score.elsewhere += 1;
                continue;
            }
            let place = [(k_m - truth.k_m), sigma_m].map(|metre| metre / length_m);
            score.places.push(place);
            if let Some(object) = simulation.slow().sensing.object() {
                let [told, sigma] = object.compliance_m_per_n.map(f64::from);
                let given = level.map_or(0.0, |stiffness| 1.0 / stiffness);
                score.compliances.push([told - given, sigma]);
                score.clear += u32::from(object.stiffness_n_per_m().is_some());
            }
        }
        Ok(score)
    };
    LEVELS.iter().map(one).collect()
}
