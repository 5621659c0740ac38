//! Places told with and without a sensor at joint 2, next to the truth: drawn fingers, calibrated on pins.

use crate::places::{PIN_SHARES, anew, calibrated, drawn, fitting};
use crate::{Error, Simulated, Verdict};
use palpate::sensing::NotLocated;
use palpate_plant::{Contact, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::ops::Range;

/// Angles of joint 1, degree: in the travel, and where the stiffest place of `tendon2` lies on its phalanx.
pub const POSTURES: [Range<f64>; 2] = [25.0..55.0, 92.0..98.0];

/// What the closings in one range of postures came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Closings on the last phalanx.
    pub closings: u32,
    /// Of these, told to be somewhere else.
    pub elsewhere: u32,
    /// Of these, told as two places.
    pub ambiguous: u32,
    /// Of these, told to be where the place cannot be observed.
    pub unobservable: u32,
    /// Places told on the right phalanx, as shares of it: told less true, with the deviation told.
    pub places: Vec<[f64; 2]>,
}

impl Score {
    /// Puts the scores of two fingers together.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.closings += other.closings;
        self.elsewhere += other.elsewhere;
        self.ambiguous += other.ambiguous;
        self.unobservable += other.unobservable;
        self.places.extend(&other.places);
        self
    }
}

/// A drawn finger of a world, calibrated, and `grasps` contacts in each of the [`POSTURES`]: the same for every scene of this geometry.
///
/// # Errors
/// The world does not suit the scene; the sequence refused.
pub fn finger<S: Simulated>(world: &World, seed: u64, grasps: usize) -> Result<Vec<Score>, Error> {
    let (simulation, _, length_m) = calibrated::<S>(world, seed, PIN_SHARES)?;
    let one = |posture_deg: &Range<f64>| -> Result<Score, Error> {
        let posture_rad = posture_deg.start.to_radians()..posture_deg.end.to_radians();
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut score = Score::default();
        for index in 0..grasps {
            let grasp = drawn::<S>(length_m, posture_rad.clone(), &mut random);
            let mut simulation = anew(&simulation, seed, index);
            if let Some(outcome) = fitting(simulation.close(&grasp))?
                && let Some(first) = outcome.first_contact
                && first.contact.phalanx == S::PHALANGES
            {
                score.take(outcome.verdict, &first.contact, length_m);
            }
        }
        Ok(score)
    };
    POSTURES.iter().map(one).collect()
}

impl Score {
    fn take(&mut self, verdict: Verdict, truth: &Contact, length_m: f64) {
        self.closings += 1;
        match verdict {
            Verdict::Located {
                phalanx,
                k_m,
                sigma_m,
                ..
            } if phalanx == truth.phalanx => {
                let place = [k_m - truth.k_m, sigma_m].map(|metre| metre / length_m);
                self.places.push(place);
            }
            Verdict::Ambiguous { .. } => self.ambiguous += 1,
            Verdict::NotLocated(NotLocated::Unobservable) => self.unobservable += 1,
            _ => self.elsewhere += 1,
        }
    }
}
