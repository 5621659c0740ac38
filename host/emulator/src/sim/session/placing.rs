// SPDX-License-Identifier: GPL-2.0-only
//! What is put in the finger's way when it closes. The firmware tells what a closing is for, whoever asked for it: the script, the
//! button, or a client of a port.

use palpate_plant::{Grasp, Object as Held, ObjectMount};

use super::Session;
use crate::Error;
use crate::sim::grasp::Object;

/// What the closing that comes is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Closing {
    /// To grasp the object of this run.
    Grasp,
    /// To press on the closing stop.
    Press,
    /// To press on a pin at this distance from the joint of the last phalanx, metre.
    Pin { k_m: f64 },
}

impl Session<'_> {
    /// Puts there what the finger is to meet, unless something lies there already.
    pub(super) fn place(&mut self, closing: Closing) -> Result<(), Error> {
        let held = self.settings.parameters.object;
        let (object, mount) = match closing {
            // Nothing may lie in its way.
            Closing::Press => return Ok(()),
            Closing::Grasp => (self.settings.object, held.mount),
            Closing::Pin { k_m } => {
                let phalanges = self.settings.parameters.finger.length_m.len();
                let last = u8::try_from(phalanges).unwrap_or(u8::MAX);
                let pin = Object::pin(last, k_m, self.settings.object);
                // A pin stands firmly.
                (Some(pin), ObjectMount::Fixed)
            }
        };
        let Some(plant) = self.machine.plant_mut().filter(|_| !self.placed) else {
            return Ok(());
        };
        plant.mount(&Held { mount, ..held })?;
        let grasp = object.map_or(Grasp::Free, |object| object.grasp());
        match (plant.place(&grasp), object) {
            // The firmware takes any place that some finger could have: that this one has not ends no run.
            (Err(palpate_plant::Error::Contact(why)), Some(object)) => {
                let (at, phalanx) = (object.contact_mm, object.phalanx);
                self.notes.push(format!(
                    "nothing can stand at {at} mm of phalanx {phalanx}, so the finger closes freely: {why}"
                ));
                plant.place(&Grasp::Free)?;
            }
            (placed, _) => placed?,
        }
        self.placed = true;
        Ok(())
    }
}
