// SPDX-License-Identifier: GPL-2.0-only
//! Sequences, sums, and when each conversion sees its pin.

use super::*;

const CLOCK: Ticks = 96;

/// Constant voltages.
struct Wired<F>(F);

impl<F: Fn(u32) -> f64> Voltages for Wired<F> {
    fn source(&self, _: u32) -> Source {
        Source::default()
    }

    fn find(&mut self, channel: u32, _: Ticks, _: [f64; 2], _: &mut [f64]) -> Option<f64> {
        Some(self.0(channel))
    }
}

fn at(now: Ticks) -> Clocks {
    Clocks { now, bus: 24 }
}

fn enabled() -> Adc {
    let mut adc = Adc::new("ADC1");
    assert!(
        adc.write(CR, ADEN, at(0), CLOCK).is_err(),
        "in deep power-down"
    );
    adc.write(CR, 0, at(0), CLOCK).unwrap();
    adc.write(CR, ADVREGEN, at(0), CLOCK).unwrap();
    adc.write(CR, ADVREGEN | ADCAL, at(0), CLOCK).unwrap();
    assert_eq!(adc.read(CR).unwrap() & ADCAL, 0);
    adc.write(CR, ADVREGEN | ADEN, at(0), CLOCK).unwrap();
    adc
}

#[test]
fn sums_sixteen_conversions_of_two_channels() {
    let mut adc = enabled();
    adc.write(CFGR2, 2 | 3 << 2, at(0), CLOCK).unwrap();
    adc.write(SMPR1, 3 << 6 | 3 << 18, at(0), CLOCK).unwrap();
    adc.write(JSQR, 1 | 8 << 2 | 1 << 7 | 2 << 9 | 6 << 15, at(0), CLOCK)
        .unwrap();
    adc.write(CR, ADVREGEN | JADSTART, at(0), CLOCK).unwrap();
    assert_eq!(adc.next_event(), None, "armed, not started");
    adc.trigger(1000, CLOCK);
    // 24.5 + 12.5 cycles, 16 times
    let one = 37 * 16 * CLOCK;
    let mut volts = Wired(|channel| if channel == 2 { 1.65 } else { 9.0 });
    assert_eq!(adc.next_event(), Some(1000 + one));
    adc.finish(1000 + one, CLOCK, &mut volts);
    assert_eq!(adc.read(ISR).unwrap() & (JEOC | JEOS), JEOC);
    adc.finish(1000 + 2 * one, CLOCK, &mut volts);
    assert_eq!(adc.read(ISR).unwrap() & (JEOC | JEOS), JEOC | JEOS);
    assert_eq!(adc.read(JDR1), Ok(16 * 2048));
    assert_eq!(adc.read(JDR1 + 4), Ok(16 * 4095));
    adc.write(IER, JEOS, at(0), CLOCK).unwrap();
    assert!(adc.interrupt());
    adc.write(ISR, JEOC | JEOS, at(0), CLOCK).unwrap();
    assert!(!adc.interrupt());
}

/// A pin that rises by 1 V in 100 us.
struct Rising;

impl Voltages for Rising {
    fn source(&self, _: u32) -> Source {
        Source::default()
    }

    fn find(&mut self, _: u32, from: Ticks, at_s: [f64; 2], volts: &mut [f64]) -> Option<f64> {
        for (n, volt) in volts.iter_mut().enumerate() {
            *volt = 1e4 * (time::seconds(from) + at_s[0] + at_s[1] * n as f64);
        }
        None
    }
}

#[test]
fn each_conversion_sees_the_pin_when_its_sampling_ends() {
    let mut adc = enabled();
    adc.write(CFGR2, 2, at(0), CLOCK).unwrap();
    adc.write(SMPR1, 2 << 6, at(0), CLOCK).unwrap();
    adc.write(JSQR, 8 << 2 | 1 << 7 | 2 << 9, at(0), CLOCK)
        .unwrap();
    adc.write(CR, ADVREGEN | JADSTART, at(0), CLOCK).unwrap();
    let begun = 100 * time::TICKS_PER_US;
    adc.trigger(begun, CLOCK);
    adc.finish(adc.next_event().unwrap(), CLOCK, &mut Rising);
    // 1 V and what it rises by in 12.5, and 37.5 cycles of 42.5 MHz.
    let volts = |cycles: f64| 1.0 + 1e4 * cycles / 42.5e6;
    let expected = code(volts(12.5)) + code(volts(37.5));
    assert_eq!(adc.read(JDR1), Ok(expected));
}

#[test]
fn a_regular_conversion_ends_its_start_bit() {
    let mut adc = enabled();
    adc.write(SQR1, 7 << 6, at(0), CLOCK).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, at(0), CLOCK).unwrap();
    let done = adc.next_event().unwrap();
    let mut volts = Wired(|channel| if channel == 7 { 0.825 } else { 0.0 });
    adc.finish(done, CLOCK, &mut volts);
    assert_eq!(adc.read(DR), Ok(1024));
    assert_eq!(adc.read(CR).unwrap() & ADSTART, 0);
}
