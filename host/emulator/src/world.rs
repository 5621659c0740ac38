// SPDX-License-Identifier: GPL-2.0-only
//! Wires the chip's pins to the world, steps it in virtual time, and injects wiring faults.

use palpate_plant::{Pins, Plant, Probe, Source};

use crate::chip::Voltages;
use crate::time::{self, Ticks};

/// Faults between the plant's voltages and the chip's pins; faults of the encoder's wires are in the plant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WiringFaults {
    /// The motor current reads as this voltage, independent of the current.
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
    pub(crate) wires: WiringFaults,
    /// Time for which nFAULT is low after the bridge was woken.
    wake_fault: Ticks,
    awake_since: Option<Ticks>,
    /// Times at which the bridge was last switched off and on.
    off_since: Option<Ticks>,
    on_since: Option<Ticks>,
}

/// Whether the bridge is awake and driven, which includes braking.
fn powered(pins: &Pins) -> bool {
    pins.awake && pins.outputs_enabled
}

impl World {
    pub(crate) fn new(plant: Option<Plant>, wake_fault_s: f64) -> Self {
        Self {
            plant,
            pins: Pins::default(),
            synced: 0,
            wires: WiringFaults::default(),
            wake_fault: time::ticks(wake_fault_s),
            awake_since: None,
            off_since: None,
            on_since: None,
        }
    }

    /// Steps the world up to now with the previous pins.
    pub(crate) fn sync(&mut self, now: Ticks) {
        if now > self.synced {
            if let Some(plant) = &mut self.plant {
                plant.step(&self.pins, time::seconds(now - self.synced));
            }
            self.synced = now;
        }
    }

    /// Sets the pins from now on.
    pub(crate) fn set_pins(&mut self, pins: Pins, now: Ticks) {
        if pins == self.pins {
            return;
        }
        self.sync(now);
        match (powered(&self.pins), powered(&pins)) {
            (true, false) => self.off_since = Some(now),
            (false, true) => self.on_since = Some(now),
            _ => {}
        }
        self.awake_since = match (pins.awake, self.awake_since) {
            (false, _) => None,
            (true, since) => since.or(Some(now)),
        };
        self.pins = pins;
    }

    /// The chip's outputs to the bridge.
    #[must_use]
    pub fn pins(&self) -> &Pins {
        &self.pins
    }

    /// Whether the bridge is awake and driven.
    #[must_use]
    pub fn bridge_on(&self) -> bool {
        powered(&self.pins)
    }

    /// Time at which the bridge was last switched off; later than the time of switching on if it is off now.
    #[must_use]
    pub fn bridge_off_since(&self) -> Option<Ticks> {
        self.off_since
    }

    /// Time at which the bridge was last switched on.
    #[must_use]
    pub fn bridge_on_since(&self) -> Option<Ticks> {
        self.on_since
    }

    /// Edges that reached the timer's quadrature decoder.
    pub(crate) fn edges(&self) -> i64 {
        self.plant.as_ref().map_or(0, Plant::encoder_count)
    }

    /// The timer of the PWM counts zero.
    pub(crate) fn align_pwm(&mut self) {
        if let Some(plant) = &mut self.plant {
            plant.align_pwm();
        }
    }

    /// What the converters see.
    pub(crate) fn channels(&self) -> Channels<'_> {
        Channels {
            world: self,
            probe: None,
        }
    }

    pub(crate) fn fault_low(&self) -> bool {
        let waking = self
            .awake_since
            .is_some_and(|since| self.synced < since + self.wake_fault);
        waking || self.wires.fault_low || self.plant.as_ref().is_some_and(Plant::fault_pin_low)
    }

    pub(crate) fn plant(&self) -> Option<&Plant> {
        self.plant.as_ref()
    }

    pub(crate) fn plant_mut(&mut self) -> Option<&mut Plant> {
        self.plant.as_mut()
    }
}

/// The converters' pins at and after the last step of the world.
pub(crate) struct Channels<'a> {
    world: &'a World,
    probe: Option<Probe>,
}

impl Channels<'_> {
    /// The current sense.
    fn current(&mut self) -> Option<&mut Probe> {
        let plant = self.world.plant.as_ref()?;
        let pins = &self.world.pins;
        Some(self.probe.get_or_insert_with(|| plant.current_probe(pins)))
    }
}

impl Voltages for Channels<'_> {
    fn source(&self, channel: u32) -> Source {
        match (channel, &self.world.plant) {
            (2, Some(plant)) if self.world.wires.current_v.is_none() => plant.current_source(),
            (6, Some(plant)) => plant.supply_source(),
            _ => Source::default(),
        }
    }

    /// A conversion that began before the world's last step is answered from there.
    fn find(
        &mut self,
        channel: u32,
        from: Ticks,
        [first_s, every_s]: [f64; 2],
        volts: &mut [f64],
    ) -> Option<f64> {
        let plant = self.world.plant.as_ref();
        let since_s = time::seconds(from.saturating_sub(self.world.synced));
        Some(match channel {
            2 => match (self.world.wires.current_v, self.current()) {
                (Some(volts), _) => volts,
                (None, Some(probe)) => {
                    if let Some(steady_v) = probe.constant_v() {
                        return Some(steady_v);
                    }
                    probe.fill([since_s + first_s, every_s], volts);
                    return None;
                }
                (None, None) => 0.0,
            },
            6 => plant.map_or(SUPPLY_SENSE_V, Plant::supply_sense_v),
            7 => plant.map_or(0.0, Plant::hall_v),
            // Internal reference, 1.212 V.
            18 => 1.212,
            _ => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_when_the_bridge_is_switched() {
        let mut world = World::new(None, 0.0);
        let on = Pins {
            outputs_enabled: true,
            awake: true,
            duty: 0.3,
            closing: true,
        };
        world.set_pins(on, 10);
        assert!(world.bridge_on());
        world.set_pins(Pins { duty: 0.0, ..on }, 20);
        assert_eq!(world.bridge_off_since(), None, "braking is not off");
        world.set_pins(Pins { awake: false, ..on }, 30);
        assert_eq!(
            (world.bridge_on_since(), world.bridge_off_since()),
            (Some(10), Some(30))
        );
    }
}
