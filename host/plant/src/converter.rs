//! What a converter's sample-and-hold does to a pin, and the pin of the current sense over time.

use crate::switching::{Circuit, INSTANTS, Period, Winding};
use std::sync::Arc;

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

/// Number of precomputed powers of [`Settling::left`].
const KEPT: usize = 16;

/// A converter with its hold capacitor, which brings the last channel's voltage along.
#[derive(Clone, Copy, Debug, Default)]
pub struct Converter {
    held_v: f64,
    /// Of the last two channels, which take turns.
    settlings: [Settling; 2],
}

/// Effect of the hold capacitor's charge on successive conversions of a source with this timing.
#[derive(Clone, Copy, Debug, Default)]
struct Settling {
    source: Source,
    timing_s: [f64; 2],
    /// Error of the first conversion, as a share of the difference between hold capacitor and pin before it.
    brought: f64,
    /// Error of a conversion, as a share of the error of the one before, and its powers from the zeroth.
    left: f64,
    powers: [f64; KEPT],
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
            // Connecting the hold capacitor shares its charge with the pin's within nanoseconds; the source then makes up for it.
            let share = source.hold_f / both_f;
            let settling_s = source.ohm * both_f + source.switch_ohm * source.hold_f;
            let sampled = (-sample_s / settling_s).exp();
            // The hold capacitor is away; without one at the pin nothing keeps a deviation.
            let between = (-(every_s - sample_s) / (source.ohm * source.pin_f).max(1e-15)).exp();
            new.brought = share * sampled;
            new.left = sampled * (between * (1.0 - share) + share);
        }
        let mut power = 1.0;
        for kept in &mut new.powers {
            *kept = power;
            power *= new.left;
        }
        new
    }
}

impl Converter {
    fn settling(&mut self, source: &Source, timing_s: [f64; 2]) -> &Settling {
        let is_known = |known: &Settling| (known.source, known.timing_s) == (*source, timing_s);
        if let Some(known) = self.settlings.iter().position(is_known) {
            return &self.settlings[known];
        }
        self.settlings.swap(0, 1);
        self.settlings[0] = Settling::of(source, timing_s);
        &self.settlings[0]
    }

    /// Converts: takes the undisturbed pin's voltages at the end of each sampling, and replaces them by what the converter holds then.
    /// `timing_s` is the duration of a sampling, and the time from the beginning of one to that of the next.
    pub fn sample(&mut self, source: &Source, timing_s: [f64; 2], volts: &mut [f64]) {
        let &Settling { brought, left, .. } = self.settling(source, timing_s);
        let (mut before_v, mut away_v) = (self.held_v, 0.0);
        for volt in &mut *volts {
            let pin_v = *volt;
            away_v = left * away_v + brought * (before_v - pin_v);
            *volt = pin_v + away_v;
            before_v = pin_v;
        }
        self.held_v = volts.last().copied().unwrap_or(self.held_v);
    }

    /// The same for a pin whose undisturbed voltage is constant.
    pub fn sample_steady(
        &mut self,
        source: &Source,
        timing_s: [f64; 2],
        pin_v: f64,
        volts: &mut [f64],
    ) {
        let held_v = self.held_v;
        let settling = self.settling(source, timing_s);
        let mut away_v = settling.brought * (held_v - pin_v);
        for some in volts.chunks_mut(KEPT) {
            for (volt, power) in some.iter_mut().zip(settling.powers) {
                *volt = pin_v + away_v * power;
            }
            away_v *= settling.powers[KEPT - 1] * settling.left;
        }
        self.held_v = volts.last().copied().unwrap_or(self.held_v);
    }
}

/// The pin of the current sense after the last step of the plant.
#[derive(Clone, Debug)]
pub struct Probe(pub(crate) Pin);

/// Where its voltage comes from.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack for a reading; a box would be allocated for each"
)]
pub(crate) enum Pin {
    /// It stays the same.
    Constant(f64),
    /// The bridge switches.
    Switching(Switching),
}

/// A bridge that goes on as it is.
#[derive(Clone, Debug)]
pub(crate) struct Switching {
    pub winding: Winding,
    pub circuit: Circuit,
    pub period: Arc<Period>,
    pub reached_s: f64,
    /// Noise in the first half of the period and in what follows, volt.
    pub noise_v: [f64; 2],
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
                pin.shown_v(pin.winding.pin_v, at_s)
            }
        }
    }

    /// Fills in the voltages at equally distant times. `at_s` is the first time after the plant's step and the distance. Times do not
    /// go back from one call to the next.
    pub fn fill(&mut self, at_s: [f64; 2], volts: &mut [f64]) {
        let [first_s, every_s] = at_s;
        match &self.0 {
            Pin::Constant(volt) => volts.fill(*volt),
            Pin::Switching(_) => {
                for (n, some) in volts.chunks_mut(INSTANTS).enumerate() {
                    self.fill_some([first_s + every_s * (n * INSTANTS) as f64, every_s], some);
                }
            }
        }
    }

    fn fill_some(&mut self, at_s: [f64; 2], volts: &mut [f64]) {
        let [first_s, every_s] = at_s;
        if matches!(&self.0, Pin::Switching(pin) if pin.try_fill(at_s, volts)) {
            return;
        }
        for (n, volt) in volts.iter_mut().enumerate() {
            *volt = self.volts(first_s + every_s * n as f64);
        }
    }
}

impl Switching {
    /// What the pin shows, where an exact mirror would show `pin_v`.
    fn shown_v(&self, pin_v: f64, at_s: f64) -> f64 {
        let noise_v = self.noise_v[usize::from(self.period.is_late(at_s))];
        (pin_v * (1.0 + self.bent_per_v * pin_v) + noise_v).clamp(0.0, self.full_scale_v)
    }

    /// Does what [`Probe::fill`] does without integrating from one time to the next; `false` where that is not possible.
    fn try_fill(&self, at_s: [f64; 2], volts: &mut [f64]) -> bool {
        let Ok(volts) = <&mut [f64; INSTANTS]>::try_from(volts) else {
            return false;
        };
        if self.reached_s != 0.0
            || !self
                .period
                .try_fill(&self.circuit, &self.winding, at_s, volts)
        {
            return false;
        }
        for volt in volts {
            *volt = self.shown_v(*volt, at_s[0]);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMING: [f64; 2] = [294e-9, 588e-9];

    fn found(source: Source, held_v: f64) -> Vec<f64> {
        let holding = || Converter {
            held_v,
            ..Converter::default()
        };
        let mut steady = vec![0.0; 16];
        holding().sample_steady(&source, TIMING, 1.0, &mut steady);
        let mut all = vec![1.0; 16];
        holding().sample(&source, TIMING, &mut all);
        assert!(all.iter().zip(&steady).all(|(a, b)| (a - b).abs() < 1e-12));
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
