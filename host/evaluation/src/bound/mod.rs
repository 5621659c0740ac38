//! What the data hold: contacts drawn from everything that the locator assumes, given to the locator and to the exact
//! posterior ([`crate::reference::Posterior`]). No estimator that knows as little does better than the posterior. For other fingers than
//! the prototype there is Fisher's information ([`information`]) and a posterior by sampling ([`sampled`]), and both for the place of a
//! second contact ([`second`]).
//!
//! An uncalibrated finger does not know its torque factor, efficiency over spring stiffness. Pressing on the closing stop and
//! releasing would tell the worm's share of it, back-EMF the torque constant's; the springs and the gearhead remain.

#[cfg(test)]
mod agreement;
mod chain;
pub mod drawn;
mod each;
pub mod effects;
mod felt;
pub mod force;
pub mod information;
mod known;
pub mod mean;
mod objects;
mod ours;
pub mod sampled;
pub mod second;
pub mod worm;

pub use chain::Told;
pub use known::opened;
pub use objects::Objects;

use palpate::scene::Scene;
use palpate::sensing::locator::{Data, LocatorResult};
use palpate::sensing::{Cable, Calibration};
use palpate_document::table::head;
use palpate_scenes::P70;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::Serialize;

use crate::reference::{Posterior, Rolling};
use crate::score::{Answer, Contact, Scores, Trial};
use drawn::{Drawn, REFERENCE_NOISE, Truths, contact, drivetrain, rolling};

/// Standard deviations of what makes up the torque factor, as shares: uniform spreads of 10 % of torque constant, spring and
/// gearhead, 9 % of the worm, 5 % of the current sense (scenes/common/defaults.toml).
const UNIFORM: f64 = 0.577;
const CONSTANT: f64 = 0.10 * UNIFORM;
const SPRING: f64 = 0.10 * UNIFORM;
const GEARHEAD: f64 = 0.10 * UNIFORM;
const WORM: f64 = 0.09 * UNIFORM;
const SENSE: f64 = 0.05 * UNIFORM;

/// How much of a finger is known.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// In words.
    pub name: &'static str,
    /// In numbers.
    pub calibration: Calibration,
    /// Where the truths come from.
    pub truths: Truths,
    /// What is touched.
    pub objects: Objects,
}

/// From nothing but the data sheets to the guided calibration.
#[must_use]
pub fn levels() -> Vec<Knowledge> {
    let sheet = P70::UNCALIBRATED;
    let pressed = Calibration {
        // As a press on the stop leaves it (src/sensing/sensor/calibrate.rs).
        cable_sigma_rad_per_nm: 0.02 * sheet.cable_rad_per_nm + 4e-3,
        stiffening_sigma_per_nm: 0.1,
        joint_nm: 0.0,
        joint_sigma_nm: 0.0,
        joint_correlation: 0.0,
        worm_rad: [0.0; 2],
        correlation: 0.0,
        ..sheet
    };
    let of = |shares: &[f64]| Calibration {
        torque_factor_sigma: shares.iter().map(|s| s * s).sum::<f64>().sqrt() as f32,
        ..pressed
    };
    let all = [CONSTANT, SPRING, GEARHEAD, WORM, SENSE];
    let level = |name, calibration| Knowledge {
        name,
        calibration,
        truths: Truths::Assumed,
        objects: Objects::Usual,
    };
    vec![
        level("data sheets", sheet),
        level("and the cable, by a press on the stop", of(&all)),
        level(
            "and the worm's efficiency",
            of(&[CONSTANT, SPRING, GEARHEAD, SENSE]),
        ),
        level(
            "and torque constant and current sense",
            of(&[SPRING, GEARHEAD]),
        ),
        level(
            "and the gearhead's efficiency: all but the spring",
            of(&[SPRING]),
        ),
        level("torque factor to 1.5 %, by pins", of(&[0.015])),
    ]
}

/// A finger in which nothing rubs, nothing is off and nothing is noisy, as in the world `ideal`, and its locator, calibrated by pins,
/// does not know.
///
/// # Panics
/// Never: there are levels.
#[must_use]
pub fn ideal() -> Knowledge {
    let calibrated = levels().pop().expect("levels");
    Knowledge {
        name: "the same, and nothing rubs or is noisy",
        truths: Truths::Ideal,
        ..calibrated
    }
}

/// A calibrated finger on cylinders of 120 mm, and one on which nothing rubs and nothing is noisy, as in the effects' rows.
#[must_use]
pub fn on_large() -> [Knowledge; 2] {
    [
        ("pins, cylinders of 120 mm", levels().pop().expect("levels")),
        ("the same, and nothing rubs or is noisy", ideal()),
    ]
    .map(|(name, known)| Knowledge {
        name,
        objects: Objects::Large,
        ..known
    })
}

/// What the library says of a drawn contact.
#[must_use]
pub fn located(drawn: &Drawn) -> LocatorResult {
    let finger = P70::MECHANISM;
    let drivetrain = drivetrain();
    let data = Data {
        points: drawn.bins.points(),
        origin_rad: drivetrain.closing_rad(drawn.bins.origin_counts()),
        drivetrain: &drivetrain,
    };
    ours::fitted::<_, Cable>(&finger, &data, &drawn.prior).verdict(&drawn.prior)
}

/// What the exact posterior says of it.
#[must_use]
pub fn exact(rolling: &Rolling, drawn: &Drawn) -> Option<Posterior> {
    Posterior::of(rolling, &drawn.curve, &REFERENCE_NOISE, &drawn.priors)
}

/// One contact with what was said of it: locator and exact posterior.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The contact.
    pub drawn: Drawn,
    /// The library.
    pub located: LocatorResult,
    /// The reference.
    pub exact: Option<Posterior>,
}

impl Judged {
    fn contact(&self) -> Contact {
        Contact {
            phalanx: 2,
            k_m: self.drawn.truth.k_m,
            length_m: rolling().distal_m,
            time_s: 0.0,
        }
    }

    fn trial(&self, answer: Answer) -> Trial {
        Trial {
            truth: Some(self.contact()),
            touched_s: Some(0.0),
            answer,
            ..Trial::default()
        }
    }

    /// Scores' form of what the library tells.
    #[must_use]
    pub fn ours(&self) -> Trial {
        let located = |estimate: &palpate::sensing::locator::Estimate| Answer::Located {
            phalanx: estimate.phalanx,
            k_m: estimate.k_m.into(),
            sigma_m: estimate.k_sigma_m.into(),
        };
        self.trial(match &self.located {
            LocatorResult::At(estimate) | LocatorResult::Either([estimate, _]) => located(estimate),
            LocatorResult::Undecided | LocatorResult::Nowhere(_) => Answer::NotLocated,
        })
    }

    /// Scores' form of the exact posterior.
    #[must_use]
    pub fn theirs(&self) -> Trial {
        self.trial(
            self.exact
                .map_or(Answer::NotLocated, |found| Answer::Located {
                    phalanx: 2,
                    k_m: found.k_m,
                    sigma_m: found.sigma_m,
                }),
        )
    }
}

/// Contacts drawn with this much known, judged by both.
#[must_use]
pub fn judged(known: &Knowledge, contacts: u64, seed: u64) -> Vec<Judged> {
    let rolling = rolling();
    (0..contacts)
        .into_par_iter()
        .map(|index| {
            let mut random = Pcg64Mcg::seed_from_u64((seed << 32) + index);
            let drawn = loop {
                if let Some(drawn) = contact(&rolling, known, &mut random) {
                    break drawn;
                }
            };
            Judged {
                located: located(&drawn),
                exact: exact(&rolling, &drawn),
                drawn,
            }
        })
        .collect()
}

/// A level of knowledge with the figures of both.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What is known.
    pub known: &'static str,
    /// Standard deviation of the torque factor, percent.
    pub factor_pct: f64,
    /// Mean claimed deviation of the exact posterior, percent of the phalanx.
    pub exact_sigma_pct: f64,
    /// The exact posterior.
    pub exact: Scores,
    /// The library.
    pub ours: Scores,
}

/// These levels of knowledge.
#[must_use]
pub fn study(levels: &[Knowledge], contacts: u64, seed: u64) -> Vec<Row> {
    levels
        .iter()
        .map(|level| {
            let all = judged(level, contacts, seed);
            let ours: Vec<Trial> = all.iter().map(Judged::ours).collect();
            let theirs: Vec<Trial> = all.iter().map(Judged::theirs).collect();
            let sigmas: Vec<f64> = all
                .iter()
                .filter_map(|one| Some(one.exact?.sigma_m))
                .collect();
            let mean_m = sigmas.iter().sum::<f64>() / sigmas.len().max(1) as f64;
            Row {
                known: level.name,
                factor_pct: 100.0 * f64::from(level.calibration.torque_factor_sigma),
                exact_sigma_pct: 100.0 * mean_m / rolling().distal_m,
                exact: Scores::of(&theirs),
                ours: Scores::of(&ours),
            }
        })
        .collect()
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut out = head(
        "known | torque factor, % | bound: error, % | claimed, % | within 2σ, % | ours: located | error, mean ± sd, % \
         | within 2σ, %",
    );
    let figure = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
    let whole = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.0}"));
    for row in rows {
        let line = format!(
            "| {} | {:.1} | {} | {:.2} | {} | {}/{} | {} ± {} | {} |\n",
            row.known,
            row.factor_pct,
            figure(row.exact.err_mean_pct),
            row.exact_sigma_pct,
            whole(row.exact.within2_pct),
            row.ours.located,
            row.ours.distal,
            figure(row.ours.err_mean_pct),
            figure(row.ours.err_sd_pct),
            whole(row.ours.within2_pct),
        );
        out.push_str(&line);
    }
    out
}
