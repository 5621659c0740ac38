//! Fisher's bound of a place, as a mean over drawn contacts, and its table.

use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use serde::Serialize;

use super::each::{DRAWS, each};
use super::information::MEAN_SHARE;
use super::known::Known;

/// Mean errors without sign that the data allow, percent of the phalanx.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// The scene.
    pub scene: &'static str,
    /// With pins and a press on the stop.
    pub calibrated_pct: f64,
    /// The same if nothing were known of the joints' friction and preload but what the scene says.
    pub joints_forgotten_pct: f64,
    /// With pins, if the leverage at a place differs from that at the pins by what they leave of the doubt that the scene states.
    pub leverage_pct: f64,
    /// With pins, if pulleys of tendon and return cable are off one by one.
    pub pulleys_pct: f64,
    /// With a press on the stop alone.
    pub pressed_pct: f64,
    /// The same if the leverage at a place is as doubtful as the scene states.
    pub pressed_leverage_pct: f64,
    /// The same if pulleys of tendon and return cable are off one by one.
    pub pressed_pulleys_pct: f64,
    /// By the data sheets.
    pub sheet_pct: f64,
    /// Contacts.
    pub contacts: usize,
}

/// What the data hold of places on a scene's finger. `None` where the finger cannot make the contacts.
#[must_use]
pub fn bound<S: Scene>(parameters: &Parameters, contacts: u64, seed: u64) -> Option<Bound> {
    Known::of::<S>(parameters).bound(S::NAME, contacts, seed)
}

impl Known {
    /// What the data hold of places with this much known.
    pub(super) fn bound(&self, scene: &'static str, contacts: u64, seed: u64) -> Option<Bound> {
        let sigmas = each(contacts, seed, DRAWS, |random| {
            self.sigmas_pct(&self.drawn(random)?)
        });
        let mean = |level: usize| {
            let sum: f64 = sigmas.iter().map(|sigma| sigma[level]).sum();
            MEAN_SHARE * sum / sigmas.len() as f64
        };
        (!sigmas.is_empty()).then(|| Bound {
            scene,
            calibrated_pct: mean(0),
            joints_forgotten_pct: mean(1),
            leverage_pct: mean(2),
            pulleys_pct: mean(3),
            pressed_pct: mean(4),
            pressed_leverage_pct: mean(5),
            pressed_pulleys_pct: mean(6),
            sheet_pct: mean(7),
            contacts: sigmas.len(),
        })
    }
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(bounds: &[Bound]) -> String {
    let mut out = head(
        "scene | pins, % | pins, joints forgotten, % | pins, leverage in doubt, % | pins, pulleys off, % \
         | a press, % | a press, leverage in doubt, % | a press, pulleys off, % | data sheets, %",
    );
    for bound in bounds {
        out.push_str(&format!(
            "| {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |\n",
            bound.scene,
            bound.calibrated_pct,
            bound.joints_forgotten_pct,
            bound.leverage_pct,
            bound.pulleys_pct,
            bound.pressed_pct,
            bound.pressed_leverage_pct,
            bound.pressed_pulleys_pct,
            bound.sheet_pct,
        ));
    }
    out
}
