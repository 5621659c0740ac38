//! What the data hold of the place of a second contact on three phalanges
//! (docs/SECOND_CONTACTS.md#what-the-data-hold-of-a-second-contact): derivatives of the whole torque curve of an independent finger
//! ([`HeldTwice`](crate::reference::HeldTwice)), from before the first contact to the end of the probing, by everything that the firmware
//! does not know ([`second_bound`]), and the exact posterior of such curves by sampling ([`second_posterior`]), which needs no curve that
//! is linear.
//!
//! **Not known** are the torque factor, the cable's twist and stiffening, as a press on the stop and two pins leave them; friction of the
//! joints; what pulleys take, and what each stage of the transmission is off by, as the scene states both, whatever the pins told; contact
//! friction as a world's user states it, the same at both contacts; place, radius and onset of the first contact; place, radius and angle
//! of the second. A roundish object has both places as far from the joint between them, and radii that follow from that, to 15 %, where the
//! phalanges are side by side. An object of any shape has a second place and radius of its own.
//!
//! **Noise** is that of the bound for first contacts, with the wander of the world and the wave of its worm.
//!
//! **Taken as exact**: which phalanges touch, all lengths but for the levers, springs but for the torque factor, the noise's size. **Left
//! out**: weight, creep of the cable, objects that yield, a third contact (a curve ends where one begins). Who knows less than that is off
//! by more. Only pairs of phalanges whose second place changes the stiffness count, and of those the grasps whose place is told with a
//! deviation below a quarter of the phalanx, as the firmware has it.
//!
//! Fisher's information takes the curve as linear in the unknowns over their deviations. Where friction holds the finger it is not; the
//! posterior is exact there too, but for the samples' number.

mod fisher;
mod grasp;
mod sampled;

use nalgebra::DMatrix;
use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::chain::Told;
use super::each::{DRAWS, each};
use super::information::MEAN_SHARE;
use crate::reference::Noise;
use fisher::{LEVELS, noise};
use grasp::{Asked, Grasp};

/// Deviation of a place from which on it is not told, as a share of the phalanx.
const TOLD: f64 = 0.25;

/// Mean errors without sign that the data allow of the place of a second contact, percent of the phalanx.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SecondBound {
    /// The scene.
    pub scene: &'static str,
    /// The whole curve, object of any shape.
    pub whole_pct: f64,
    /// The whole curve, roundish object.
    pub round_pct: f64,
    /// What lies after the second contact, with what was told of the first one before; object of any shape.
    pub after_pct: f64,
    /// The same, roundish object.
    pub after_round_pct: f64,
    /// The whole curve, roundish object, contact friction exact.
    pub smooth_pct: f64,
    /// The whole curve, roundish object, levers and losses exact.
    pub even_pct: f64,
    /// The whole curve, a cylinder.
    pub cylinder_pct: f64,
    /// The same, and contact friction and everything about the finger exact: what noise leaves, and what is not known of the contacts.
    pub noise_pct: f64,
    /// Nothing of what lies after the second contact but that there is one, roundish object.
    pub alone_pct: f64,
    /// Grasps whose place is told, of which the means are, and all.
    pub told: usize,
    /// See `told`.
    pub grasps: usize,
}

/// What a calibration leaves unknown of a finger, in units of the deviations, and the noise of its curves.
struct Calibrated {
    known: DMatrix<f64>,
    noise: Noise,
}

/// Draws grasps on a scene's calibrated finger and asks for something of each; those that do not tell it are drawn again.
fn each_drawn<S: Scene, const N: usize>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
    of: impl Fn(&Asked, &Calibrated, &Grasp, &mut Pcg64Mcg) -> Option<[f64; N]> + Sync,
) -> Option<Vec<[f64; N]>> {
    let asked = Asked::of::<S>(parameters);
    let noise = noise(parameters);
    let known = asked.calibrated(&noise)?;
    let calibrated = Calibrated { known, noise };
    Some(each(contacts, seed, DRAWS * DRAWS, |random| {
        let grasp = asked.drawn(asked.finger(&calibrated.known, random)?, random)?;
        of(&asked, &calibrated, &grasp, random)
    }))
}

/// What the data hold of second contacts on a scene's finger in a world. `None` where the finger cannot make them.
#[must_use]
pub fn second_bound<S: Scene>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
) -> Option<SecondBound> {
    let sigmas =
        each_drawn::<S, LEVELS>(parameters, contacts, seed, |asked, calibrated, grasp, _| {
            asked.sigmas(grasp, &calibrated.known, &calibrated.noise)
        })?;
    let told: Vec<&[f64; LEVELS]> = sigmas.iter().filter(|sigma| sigma[3] < TOLD).collect();
    let mean_pct = |level: usize| {
        let sum: f64 = told.iter().map(|sigma| sigma[level]).sum();
        100.0 * MEAN_SHARE * sum / told.len() as f64
    };
    (!told.is_empty()).then(|| SecondBound {
        scene: S::NAME,
        whole_pct: mean_pct(0),
        round_pct: mean_pct(1),
        after_pct: mean_pct(2),
        after_round_pct: mean_pct(3),
        smooth_pct: mean_pct(4),
        even_pct: mean_pct(5),
        cylinder_pct: mean_pct(6),
        noise_pct: mean_pct(7),
        alone_pct: mean_pct(8),
        told: told.len(),
        grasps: sigmas.len(),
    })
}

/// A table for docs/SECOND_CONTACTS.md: bounds with the names of their worlds.
#[must_use]
pub fn markdown(bounds: &[(&str, SecondBound)]) -> String {
    let mut out = head(
        "world | scene | told | shape alone | after it, any shape | after it, roundish | whole, any shape | whole, roundish | and friction exact \
         | and levers exact | a cylinder | and the finger exact",
    );
    for (world, bound) in bounds {
        out.push_str(&format!(
            "| `{world}` | {} | {}/{} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |\n",
            bound.scene,
            bound.told,
            bound.grasps,
            bound.alone_pct,
            bound.after_pct,
            bound.after_round_pct,
            bound.whole_pct,
            bound.round_pct,
            bound.smooth_pct,
            bound.even_pct,
            bound.cylinder_pct,
            bound.noise_pct,
        ));
    }
    out
}

/// What an exact posterior makes of drawn grasps, percent of the phalanx.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SecondPosterior {
    /// The scene.
    pub scene: &'static str,
    /// Mean error without sign of the posterior's mean.
    pub error_pct: f64,
    /// Mean error without sign that its deviations stand for.
    pub claimed_pct: f64,
    /// Errors within two deviations.
    pub within2_pct: f64,
    /// Grasps whose place is told, and all.
    pub told: usize,
    /// See `told`.
    pub grasps: usize,
}

/// Grasps drawn as in [`second_bound`], with noise, given to the exact posterior of a roundish object.
#[must_use]
pub fn second_posterior<S: Scene>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
) -> Option<SecondPosterior> {
    let all = each_drawn::<S, 2>(
        parameters,
        contacts,
        seed,
        |asked, calibrated, grasp, random| {
            asked.sampled(grasp, &calibrated.known, &calibrated.noise, random)
        },
    )?;
    let told: Vec<[f64; 2]> = all
        .iter()
        .copied()
        .filter(|[_, sigma]| *sigma < TOLD)
        .collect();
    let Told {
        error_pct,
        claimed_pct,
        within2_pct,
    } = Told::of(&told);
    (!told.is_empty()).then_some(SecondPosterior {
        scene: S::NAME,
        error_pct,
        claimed_pct,
        within2_pct,
        told: told.len(),
        grasps: all.len(),
    })
}

/// A table for docs/SECOND_CONTACTS.md: posteriors with the names of their worlds.
#[must_use]
pub fn posterior_markdown(posteriors: &[(&str, SecondPosterior)]) -> String {
    let mut out =
        head("world | scene | told | exact posterior: error, % | claimed, % | within 2σ, %");
    for (world, posterior) in posteriors {
        out.push_str(&format!(
            "| `{world}` | {} | {}/{} | {:.1} | {:.1} | {:.0} |\n",
            posterior.scene,
            posterior.told,
            posterior.grasps,
            posterior.error_pct,
            posterior.claimed_pct,
            posterior.within2_pct,
        ));
    }
    out
}
