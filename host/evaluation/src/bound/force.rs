//! What the data hold of a contact's force (docs/BOUNDS.md#the-force).
//!
//! A force is in proportion to the springs' stiffness, of which a pin tells only the ratio to the gears' efficiency. With everything else
//! linear about the truth, as in [`super::information`], errors of the force are drawn for fingers, each with some contacts: all of a
//! finger share its springs and what its calibration has wrong.

use nalgebra::{DMatrix, DVector};
use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::SPRING;
use super::each::{DRAWS, each};
use super::information::{DIFFERENCE, Pulleys, forget, told};
use super::known::{Chosen, FACTOR, FRICTION, GIVE, K, Known, ONSET, RADIUS, UNKNOWNS};
use crate::reference::{Held, State};
use crate::score::{median, quantile};

/// Fingers and contacts of a set, as in the recordings of another engine (docs/RESULTS.md#recordings-of-another-engine).
const FINGERS: usize = 6;
const CONTACTS: usize = 8;
/// Sets that are drawn.
const SETS: usize = 2000;
/// Springs are within this share of the scene's, evenly.
const SPRINGS: f64 = 0.10;

/// How much is known beside what a press on the stop tells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    name: &'static str,
    pins: bool,
    springs: bool,
    friction: bool,
}

const LEVELS: [Level; 4] = [
    level("a press", false, false, false),
    level("pins", true, false, false),
    level("pins, and the contact's friction", true, false, true),
    level("pins, and the springs", true, true, false),
];

const fn level(name: &'static str, pins: bool, springs: bool, friction: bool) -> Level {
    Level {
        name,
        pins,
        springs,
        friction,
    }
}

/// Errors of a force without sign, percent of it, of whoever knows so much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceBound {
    /// What is known.
    pub known: &'static str,
    /// Median over all contacts.
    pub median_pct: f64,
    /// What one in twenty sets of contacts has less than, and one in twenty more, as its median.
    pub sets_pct: [f64; 2],
    /// Share of the sets whose median is at most 5 %, percent.
    pub within_pct: f64,
}

/// A contact: how its force's error, as a share, follows from the errors of what is known before it, and the deviation of what its curve's
/// noise adds.
#[derive(Clone, Debug)]
struct Linear {
    by_error: DVector<f64>,
    noise: f64,
}

/// What the errors of a level's contacts follow from.
struct Study {
    contacts: Vec<Linear>,
    /// Root of the covariance of what is known before it, in units of the unknowns' deviations.
    before: DMatrix<f64>,
}

/// Whether an unknown is the finger's, the same at all of its contacts.
fn is_of_finger(unknown: usize) -> bool {
    !matches!(unknown, FRICTION | K | RADIUS | ONSET | GIVE)
}

impl Known {
    /// Share of what the torque factor differs from the scene's that is the springs', with the sign of their stiffness.
    fn springs_by_factor(&self) -> f64 {
        -(SPRING / f64::from(self.sheet.torque_factor_sigma)).powi(2)
    }

    /// Force of a contact at a measured angle, reached in steps, with the scene's springs.
    fn force_n(&self, phalanx: usize, values: &[f64; UNKNOWNS], angles: &[f64]) -> Option<f64> {
        let (press, drive) = self.press(phalanx, values);
        let opened = self.with_pulleys(values);
        let held = Held::new(&opened, press, values[ONSET], &drive)?;
        let mut near: State = held.start().clone();
        for &angle_rad in angles {
            if angle_rad > values[ONSET] {
                near = held.at(angle_rad, &drive, &near)?;
            }
        }
        Some(near.force_n)
    }

    /// Derivatives of the force's logarithm at a curve's end, by all unknowns in units of their deviations.
    fn force_slopes(
        &self,
        chosen: &Chosen,
        angles: &[f64],
        deviations: &[f64; UNKNOWNS],
    ) -> Option<DVector<f64>> {
        let mut slopes = DVector::zeros(UNKNOWNS);
        for unknown in (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0) {
            let beside = |steps: f64| {
                let mut values = self.means(chosen);
                values[unknown] += steps * DIFFERENCE * deviations[unknown];
                self.force_n(chosen.phalanx, &values, angles)
            };
            slopes[unknown] = (beside(1.0)? / beside(-1.0)?).ln() / (2.0 * DIFFERENCE);
        }
        Some(slopes)
    }

    /// A contact at each level.
    fn forces(&self, chosen: &Chosen, before: &[DMatrix<f64>]) -> Option<Vec<Linear>> {
        let deviations = self.deviations(self.lengths_m[chosen.phalanx - 1]);
        let observed = self.observed(chosen.phalanx, self.means(chosen))?;
        let slopes = self.slopes(&observed, &deviations)?;
        let information = slopes.tr_mul(&slopes);
        let force = self.force_slopes(chosen, &observed.angles, &deviations)?;
        let of_level = |(level, before): (&Level, &DMatrix<f64>)| {
            let mut force = force.clone();
            if !level.springs {
                let share = deviations[FACTOR] / f64::from(self.sheet.torque_factor);
                force[FACTOR] += share * self.springs_by_factor();
            }
            let after = told(before, &information)?;
            let by_noise = &after * &force;
            let left = DMatrix::identity(UNKNOWNS, UNKNOWNS) + before * &information;
            Some(Linear {
                by_error: left.try_inverse()?.tr_mul(&force),
                noise: by_noise.dot(&(&information * &by_noise)).max(0.0).sqrt(),
            })
        };
        LEVELS.iter().zip(before).map(of_level).collect()
    }

    /// What is known before a contact at each level.
    fn known_before(&self, deviations: &[f64; UNKNOWNS]) -> Option<Vec<DMatrix<f64>>> {
        let of_level = |level: &Level| {
            let mut known = if level.pins {
                self.calibrated(deviations, Pulleys::Exact)?
            } else {
                self.pressed(deviations, Pulleys::Exact)
            };
            if level.friction {
                forget(&mut known, FRICTION, 0.0);
            }
            Some(known)
        };
        LEVELS.iter().map(of_level).collect()
    }

    /// Errors of the forces of one finger, as shares.
    fn errors(&self, level: &Level, study: &Study, random: &mut Pcg64Mcg) -> Vec<f64> {
        let mut normal = |sigma: f64| {
            let x: f64 = StandardNormal.sample(random);
            sigma * x
        };
        let factor_sigma = f64::from(self.sheet.torque_factor_sigma);
        let rest = normal((factor_sigma * factor_sigma - SPRING * SPRING).sqrt());
        let mut drawn = || DVector::from_fn(UNKNOWNS, |_, _| normal(1.0));
        let of_finger = drawn();
        let of_contacts: Vec<_> = (0..CONTACTS).map(|_| (drawn(), drawn()[0])).collect();
        let springs = random.random_range(-SPRINGS..SPRINGS);
        let share = self.springs_by_factor();
        let springs_error = if level.springs {
            0.0
        } else {
            (1.0 + share) * springs - share * rest
        };
        let one = |(of_contact, noise): (DVector<f64>, f64)| {
            let linear = study.contacts.choose(random)?;
            let x = DVector::from_fn(UNKNOWNS, |unknown, _| {
                if is_of_finger(unknown) {
                    of_finger[unknown]
                } else {
                    of_contact[unknown]
                }
            });
            let mut error = &study.before * x;
            if !level.pins {
                // Nothing has told the factor: it is off by what springs and gears are.
                error[FACTOR] = (rest - springs) / factor_sigma;
            }
            Some(springs_error + linear.by_error.dot(&error) + linear.noise * noise)
        };
        of_contacts.into_iter().filter_map(one).collect()
    }
}

/// Symmetric root of a covariance, which may be singular.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.clone().symmetric_eigen();
    let sizes = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    &eigen.eigenvectors * DMatrix::from_diagonal(&sizes) * eigen.eigenvectors.transpose()
}

/// What the data hold of forces on a scene's finger. `None` where the finger cannot make the contacts.
#[must_use]
pub fn forces<S: Scene>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
) -> Option<Vec<ForceBound>> {
    let known = Known::of::<S>(parameters);
    let length_m = known.lengths_m[known.first.max(2) - 1];
    let before = known.known_before(&known.deviations(length_m))?;
    let all = each(contacts, seed, DRAWS, |random| {
        known.forces(&known.drawn(random)?, &before)
    });
    let of_level = |(index, level): (usize, &Level)| {
        let study = Study {
            contacts: all.iter().map(|levels| levels[index].clone()).collect(),
            before: root(&before[index]),
        };
        let mut random = Pcg64Mcg::seed_from_u64((seed << 32) + index as u64);
        let mut medians = Vec::new();
        let mut errors = Vec::new();
        for _ in 0..SETS {
            let set: Vec<f64> = (0..FINGERS)
                .flat_map(|_| known.errors(level, &study, &mut random))
                .map(|error| 100.0 * error.abs())
                .collect();
            medians.push(median(&set)?);
            errors.extend(set);
        }
        let within = medians.iter().filter(|median| **median <= 5.0).count();
        Some(ForceBound {
            known: level.name,
            median_pct: median(&errors)?,
            sets_pct: [quantile(&medians, 0.05)?, quantile(&medians, 0.95)?],
            within_pct: 100.0 * within as f64 / SETS as f64,
        })
    };
    LEVELS.iter().enumerate().map(of_level).collect()
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(bounds: &[ForceBound]) -> String {
    let mut out = head(
        "known | median error, % | of a set: one in twenty below, above, % | sets with at most 5 %, %",
    );
    for bound in bounds {
        let [low, high] = bound.sets_pct;
        out.push_str(&format!(
            "| {} | {:.1} | {low:.1}, {high:.1} | {:.0} |\n",
            bound.known, bound.median_pct, bound.within_pct,
        ));
    }
    out
}
