// SPDX-License-Identifier: GPL-2.0-only
//! What the chip's pins are wired to: the plant, stepped in virtual time, and what may go wrong between the two.

use palpate_plant::{Pins, Plant};

use crate::time::{self, Ticks};

/// A failure between the plant's voltages and the chip's readings; wires of the encoder fail in the plant itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wires {
    /// The converter gives this voltage for the motor current, whatever flows.
    pub current_v: Option<f64>,
    /// nFAULT pulled low.
    pub fault_low: bool,
}

/// Supply sense of a board without a plant: half the converter's range.
const SUPPLY_SENSE_V: f64 = 1.65;

/// The world at the pins.
#[derive(Debug)]
pub struct World {
    plant: Option<Plant>,
    pub(crate) pins: Pins,
    synced: Ticks,
    pub(crate) wires: Wires,
    /// When the bridge last stopped driving the motor, and when it last began.
    pub(crate) drive_ended: Option<Ticks>,
    pub(crate) drive_began: Option<Ticks>,
}

/// The bridge pushes current through the motor.
pub(crate) fn driving(pins: &Pins) -> bool {
    pins.awake && pins.outputs_enabled && pins.duty > 0.0
}

impl World {
    pub(crate) fn new(plant: Option<Plant>) -> Self {
        Self {
            plant,
            pins: Pins::default(),
            synced: 0,
            wires: Wires::default(),
            drive_ended: None,
            drive_began: None,
        }
    }

    /// Brings the world up to now with the pins as they were.
    pub(crate) fn sync(&mut self, now: Ticks) {
        if now > self.synced {
            if let Some(plant) = &mut self.plant {
                plant.step(&self.pins, time::seconds(now - self.synced));
            }
            self.synced = now;
        }
    }

    /// New pins from now on.
    pub(crate) fn set_pins(&mut self, pins: Pins, now: Ticks) {
        if pins == self.pins {
            return;
        }
        self.sync(now);
        match (driving(&self.pins), driving(&pins)) {
            (true, false) => self.drive_ended = Some(now),
            (false, true) => self.drive_began = Some(now),
            _ => {}
        }
        self.pins = pins;
    }

    /// Edges that reached the timer's quadrature decoder.
    pub(crate) fn edges(&self) -> i64 {
        self.plant.as_ref().map_or(0, Plant::encoder_count)
    }

    pub(crate) fn current_v(&self) -> f64 {
        let sensed = self.plant.as_ref().map_or(0.0, Plant::current_sense_v);
        self.wires.current_v.unwrap_or(sensed)
    }

    pub(crate) fn supply_v(&self) -> f64 {
        self.plant.as_ref().map_or(SUPPLY_SENSE_V, Plant::supply_sense_v)
    }

    pub(crate) fn hall_v(&self) -> f64 {
        self.plant.as_ref().map_or(0.0, Plant::hall_v)
    }

    pub(crate) fn fault_low(&self) -> bool {
        self.wires.fault_low || self.plant.as_ref().is_some_and(Plant::fault_pin_low)
    }

    pub(crate) fn plant(&self) -> Option<&Plant> {
        self.plant.as_ref()
    }

    pub(crate) fn plant_mut(&mut self) -> Option<&mut Plant> {
        self.plant.as_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_when_the_bridge_stops_driving() {
        let mut world = World::new(None);
        let on = Pins { outputs_enabled: true, awake: true, duty: 0.3, closing: true };
        world.set_pins(on, 10);
        world.set_pins(Pins { duty: 0.0, ..on }, 20);
        world.set_pins(Pins { awake: false, ..on }, 30);
        assert_eq!((world.drive_began, world.drive_ended), (Some(10), Some(20)));
    }
}
