//! What a converter's sample-and-hold does to a pin, and the pin of the current sense over time.

use crate::switching::{Circuit, Period, Winding};

/// What drives a pin, and what the converter puts on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Source {
    /// Impedance of the source, ohm.
    pub ohm: f64,
    /// Capacitor at the pin, farad.
    pub pin_f: f64,
    /// Switch of the converter, ohm.
    pub switch_ohm: f64,
    /// Capacitor that holds the sample, farad; 0: an ideal converter.
    pub hold_f: f64,
}

/// A converter with its hold capacitor, which brings the last channel's voltage along.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Converter {
    held_v: f64,
    last: Settling,
}

/// What of a deviation stays at a source with such a timing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Settling {
    source: Source,
    timing_s: [f64; 2],
    /// Share of the hold capacitor's voltage that comes to the pin, and what is left of a deviation after sampling and between.
    share: f64,
    sampled: f64,
    between: f64,
}

impl Settling {
    fn of(source: &Source, timing_s: [f64; 2]) -> Self {
        let [sample_s, every_s] = timing_s;
        let mut new = Self {
            source: *source,
            timing_s,
            ..Self::default()
        };
        if source.hold_f > 0.0 {
            let both_f = source.pin_f + source.hold_f;
            new.share = source.hold_f / both_f;
            let settling_s = source.ohm * both_f + source.switch_ohm * source.hold_f;
            new.sampled = (-sample_s / settling_s).exp();
            // The hold capacitor is away; without one at the pin nothing keeps a deviation.
            new.between = (-(every_s - sample_s) / (source.ohm * source.pin_f).max(1e-15)).exp();
        }
        new
    }
}

impl Converter {
    /// A converter that last sampled this voltage.
    #[must_use]
    pub fn holding(held_v: f64) -> Self {
        Self {
            held_v,
            ..Self::default()
        }
    }

    /// The voltages that successive samples of one channel find: `volts` gives the undisturbed pin at a time after the first
    /// sampling began, second, in order. Sampling takes `sample_s`, the next begins `every_s` later.
    ///
    /// Connecting the hold capacitor shares its charge with the pin's within nanoseconds; the source then makes up for it.
    pub fn sample(
        &mut self,
        source: &Source,
        [sample_s, every_s]: [f64; 2],
        count: u32,
        mut volts: impl FnMut(f64) -> f64,
        mut found: impl FnMut(f64),
    ) {
        if (self.last.source, self.last.timing_s) != (*source, [sample_s, every_s]) {
            self.last = Settling::of(source, [sample_s, every_s]);
        }
        let Settling {
            share,
            sampled,
            between,
            ..
        } = self.last;
        let mut away_v = 0.0;
        let mut begun_s = 0.0;
        for _ in 0..count {
            let pin_v = volts(begun_s + sample_s);
            away_v += share * (self.held_v - pin_v - away_v);
            away_v *= sampled;
            self.held_v = pin_v + away_v;
            found(self.held_v);
            away_v *= between;
            begun_s += every_s;
        }
    }
}

/// The pin of the current sense after the last step of the plant.
#[derive(Clone, Debug)]
pub struct Probe(pub(crate) Pin);

/// Where its voltage comes from.
#[derive(Clone, Debug)]
pub(crate) enum Pin {
    /// It stays the same.
    Constant(f64),
    /// The bridge switches.
    Switching(Box<Switching>),
}

/// A bridge that goes on as it is.
#[derive(Clone, Debug)]
pub(crate) struct Switching {
    pub winding: Winding,
    pub circuit: Circuit,
    pub period: Period,
    pub reached_s: f64,
    /// Noise of this instant, volt.
    pub noise_v: f64,
    /// Change of the gain per volt.
    pub bent_per_v: f64,
    pub full_scale_v: f64,
}

impl Probe {
    /// The voltage, if it stays the same whenever it is looked at.
    #[must_use]
    pub fn constant_v(&self) -> Option<f64> {
        match &self.0 {
            Pin::Constant(volts) => Some(*volts),
            Pin::Switching(_) => None,
        }
    }

    /// Voltage so many seconds after the step, at times that do not go back.
    pub fn volts(&mut self, at_s: f64) -> f64 {
        match &mut self.0 {
            Pin::Constant(volts) => *volts,
            Pin::Switching(pin) => {
                // Whole tens of attoseconds: equal distances then take equal decays.
                let dt = ((at_s - pin.reached_s) * 1e17).round() * 1e-17;
                if dt > 0.0 {
                    pin.winding.wait(&pin.circuit, &pin.period, dt);
                    pin.reached_s += dt;
                }
                let volts = pin.winding.pin_v;
                (volts * (1.0 + pin.bent_per_v * volts) + pin.noise_v).clamp(0.0, pin.full_scale_v)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMING: [f64; 2] = [294e-9, 588e-9];

    fn found(source: Source, held_v: f64) -> Vec<f64> {
        let mut all = Vec::new();
        Converter::holding(held_v).sample(&source, TIMING, 16, |_| 1.0, |v| all.push(v));
        all
    }

    /// Hold capacitor, switch, pin's capacitor and source, by steps of 20 ps.
    fn stepped(source: Source, held_v: f64) -> Vec<f64> {
        let dt = 2e-11;
        let (mut pin_v, mut hold_v) = (1.0, held_v);
        let mut all = Vec::new();
        for _ in 0..16 {
            for _ in 0..(TIMING[0] / dt) as u32 {
                let through_a = (hold_v - pin_v) / source.switch_ohm;
                hold_v -= dt * through_a / source.hold_f;
                pin_v += dt * (through_a + (1.0 - pin_v) / source.ohm) / source.pin_f;
            }
            all.push(hold_v);
            for _ in 0..((TIMING[1] - TIMING[0]) / dt) as u32 {
                pin_v += dt * (1.0 - pin_v) / source.ohm / source.pin_f;
            }
        }
        all
    }

    #[test]
    fn the_last_channel_leaves_what_its_charge_does() {
        let source = |pin_f| Source {
            ohm: 6800.0,
            pin_f,
            switch_ohm: 1000.0,
            hold_f: 5e-12,
        };
        for (pin_f, allowed) in [(1e-9, 2e-4), (100e-12, 2e-3)] {
            let (formula, small) = (found(source(pin_f), 2.2), stepped(source(pin_f), 2.2));
            for (one, other) in formula.iter().zip(&small) {
                assert!(
                    (one - other).abs() < allowed,
                    "{pin_f}: {formula:?} {small:?}"
                );
            }
            // 5 pF of 1.2 V in 1 nF: 6 mV, less what has flowed off.
            assert!((formula[0] - 1.0) / (1.2 * 5e-12 / pin_f) > 0.5);
        }
        // Nothing at the pin: 0.05 % of 1.2 V after 7.5 time constants.
        let bare = found(source(0.0), 2.2);
        assert!((bare[0] - 1.0 - 1.2 * 5.3e-4).abs() < 1e-4, "{bare:?}");
        assert_eq!(found(Source::default(), 2.2), [1.0; 16]);
    }
}
