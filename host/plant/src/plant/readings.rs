//! What the converters of a chip find at the current sense and the supply.

use super::Plant;
use crate::Pins;
use crate::converter::{Pin, Probe, Source};

impl Plant {
    /// The converter's pin of the current sense from now on, with these levels on the bridge's pins: where the current has edges it
    /// depends on when in the period of the PWM it is looked at.
    #[must_use]
    pub fn current_probe(&self, pins: &Pins) -> Probe {
        let switching = self.bridge.pin(pins, self.sense_noise_v);
        Probe(switching.unwrap_or(Pin::Constant(self.sense_v)))
    }

    /// What drives the converter's pin of the current sense.
    #[must_use]
    pub fn current_source(&self) -> Source {
        let sense = &self.parameters.sense;
        self.source(sense.pin_ohm(), sense.pin_f)
    }

    /// What drives the converter's pin of the supply.
    #[must_use]
    pub fn supply_source(&self) -> Source {
        let supply = &self.parameters.supply;
        self.source(supply.pin_ohm, supply.pin_f)
    }

    fn source(&self, ohm: f64, pin_f: f64) -> Source {
        let converter = &self.parameters.converter;
        Source {
            ohm,
            pin_f,
            switch_ohm: converter.switch_ohm,
            hold_f: converter.hold_f,
        }
    }

    /// Voltage of the current sense at the end of the last step, with edges the mean of the period of the PWM that follows:
    /// unsigned, zero while asleep.
    #[must_use]
    pub fn current_sense_v(&self) -> f64 {
        const PARTS: i32 = 16;
        let mut probe = self.current_probe(&self.pins);
        let part_s = 1.0 / (self.parameters.bridge.pwm_hz * f64::from(PARTS));
        let volts = (1..=PARTS).map(|part| probe.volts(f64::from(part) * part_s));
        volts.sum::<f64>() / f64::from(PARTS)
    }

    /// Measured current, ampere: with the sign of the drive, or with its own sign if a shunt measures it.
    #[must_use]
    pub fn sensed_a(&self) -> f64 {
        let sense = &self.parameters.sense;
        let shown_a = (self.current_sense_v() - sense.zero_v()) / sense.volt_per_a();
        if sense.is_shunt() || self.pins.closing {
            shown_a
        } else {
            -shown_a
        }
    }
}
