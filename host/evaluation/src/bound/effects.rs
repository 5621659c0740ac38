//! What the data hold of a place where a single effect of the experiments is there: large objects, and weight that the scene states
//! (docs/BOUNDS.md#large-objects-and-weight).

use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use palpate_scenes::{P70, P70Grasp, Tendon2};

use super::known::{GRAVITY_M_PER_S2, Known};
use super::mean::Bound;
use super::objects::Objects;
use crate::experiments::effects::HEAVY_KG_PER_M;
use crate::reference::Weight;

/// As [`super::mean::bound`], with a change.
fn changed<S: Scene>(
    name: &'static str,
    change: impl Fn(&mut Known),
    contacts: u64,
    seed: u64,
) -> Option<Bound> {
    let mut known = Known::of::<S>(&Parameters::of(S::NAME).ok()?);
    change(&mut known);
    known.bound(name, contacts, seed)
}

fn enlarge(known: &mut Known) {
    known.objects = Objects::Large;
}

/// Mounts the heavy finger so that gravity points along phalanx 1, turned by this angle.
fn weigh(known: &mut Known, mounting_deg: f64) {
    known.opened.weight = Some(Weight {
        phalanx_n: (known.lengths_m.iter())
            .map(|length_m| GRAVITY_M_PER_S2 * HEAVY_KG_PER_M * length_m)
            .collect(),
        down_rad: mounting_deg.to_radians(),
    });
}

/// Bounds of the effects that are rows of the experiments; `None` where a finger cannot make the contacts.
#[must_use]
pub fn effects(contacts: u64, seed: u64) -> Option<Vec<Bound>> {
    let heavy = |name, mounting_deg: f64| {
        changed::<Tendon2>(name, |known| weigh(known, mounting_deg), contacts, seed)
    };
    Some(vec![
        changed::<P70>("p70", |_| {}, contacts, seed)?,
        changed::<P70>("p70, cylinder of 120 mm", enlarge, contacts, seed)?,
        changed::<P70Grasp>("p70-grasp", |_| {}, contacts, seed)?,
        changed::<P70Grasp>("p70-grasp, cylinder of 120 mm", enlarge, contacts, seed)?,
        changed::<Tendon2>("tendon2", |_| {}, contacts, seed)?,
        heavy("tendon2, 65 g that opens it", -90.0)?,
        heavy("tendon2, 65 g along phalanx 1", 0.0)?,
        heavy("tendon2, 65 g that closes it", 90.0)?,
    ])
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(bounds: &[Bound]) -> String {
    let mut out = head("finger and effect | pins, % | pins, leverage in doubt, %");
    for bound in bounds {
        out.push_str(&format!(
            "| {} | {:.2} | {:.2} |\n",
            bound.scene, bound.calibrated_pct, bound.leverage_pct
        ));
    }
    out
}
