// SPDX-License-Identifier: GPL-2.0-only
//! One ADC: injected sequences triggered by TIM1's update event, regular sequences started by software, oversampling.

use palpate_plant::{Converter, Source};

use super::bank::{Bank, Clocks, Misuse, Register};
use crate::time::{self, Ticks};

const ISR: u32 = 0x00;
const IER: u32 = 0x04;
const CR: u32 = 0x08;
const CFGR: u32 = 0x0C;
const CFGR2: u32 = 0x10;
const SMPR1: u32 = 0x14;
const SQR1: u32 = 0x30;
const DR: u32 = 0x40;
const JSQR: u32 = 0x4C;
const JDR1: u32 = 0x80;

/// Largest number of conversions of a sum for which no memory is allocated.
const FEW: usize = 16;

const REGISTERS: &[Register] = &[
    (ISR, "ISR", 0),
    (IER, "IER", 0),
    (CR, "CR", 0x2000_0000),
    (CFGR, "CFGR", 0x8000_0000),
    (CFGR2, "CFGR2", 0),
    (SMPR1, "SMPR1", 0),
    (0x18, "SMPR2", 0),
    (0x20, "TR1", 0x0FFF_0000),
    (0x24, "TR2", 0x00FF_0000),
    (0x28, "TR3", 0x00FF_0000),
    (SQR1, "SQR1", 0),
    (0x34, "SQR2", 0),
    (0x38, "SQR3", 0),
    (0x3C, "SQR4", 0),
    (DR, "DR", 0),
    (JSQR, "JSQR", 0),
    (0x60, "OFR1", 0),
    (0x64, "OFR2", 0),
    (0x68, "OFR3", 0),
    (0x6C, "OFR4", 0),
    (JDR1, "JDR1", 0),
    (0x84, "JDR2", 0),
    (0x88, "JDR3", 0),
    (0x8C, "JDR4", 0),
    (0xA0, "AWD2CR", 0),
    (0xA4, "AWD3CR", 0),
    (0xB0, "DIFSEL", 0),
    (0xB4, "CALFACT", 0),
    (0xC0, "GCOMP", 0x1000),
];

const ADEN: u32 = 1;
const ADDIS: u32 = 1 << 1;
const ADSTART: u32 = 1 << 2;
const JADSTART: u32 = 1 << 3;
const ADSTP: u32 = 1 << 4;
const JADSTP: u32 = 1 << 5;
const ADVREGEN: u32 = 1 << 28;
const DEEPPWD: u32 = 1 << 29;
const ADCAL: u32 = 1 << 31;

const ADRDY: u32 = 1;
const EOC: u32 = 1 << 2;
const EOS: u32 = 1 << 3;
const OVR: u32 = 1 << 4;
const JEOC: u32 = 1 << 5;
const JEOS: u32 = 1 << 6;

/// Sampling times in half ADC clock cycles.
const SAMPLING: [u64; 8] = [5, 13, 25, 49, 95, 185, 495, 1281];
/// Successive approximation of 12 bits, in half cycles.
const CONVERSION: u64 = 25;
/// Reference voltage: the analogue supply.
pub(crate) const VREF_V: f64 = 3.3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Regular,
    Injected,
}

#[derive(Clone, Copy, Debug)]
struct Running {
    group: Group,
    rank: u32,
    done: Ticks,
}

/// What is wired to the channels.
pub(crate) trait Voltages {
    /// What drives a channel's pin.
    fn source(&self, channel: u32) -> Source;

    /// Fills in a pin's voltages, undisturbed by the converter, at equally distant times. `at_s` is the first time after `from` and the
    /// distance. Times do not go back until the world's next step. For a voltage that is constant until then it returns that one and
    /// leaves `volts` as it is.
    fn find(&mut self, channel: u32, from: Ticks, at_s: [f64; 2], volts: &mut [f64])
    -> Option<f64>;
}

/// One converter.
#[derive(Debug)]
pub(crate) struct Adc {
    bank: Bank,
    running: Option<Running>,
    /// The sample-and-hold.
    input: Converter,
    /// A conversion result was never read before the next one replaced it.
    pub(crate) missed_triggers: u64,
}

impl Adc {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            bank: Bank::new(name, REGISTERS),
            running: None,
            input: Converter::default(),
            missed_triggers: 0,
        }
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.bank.name);
    }

    pub(crate) fn read(&mut self, offset: u32) -> Result<u32, Misuse> {
        let value = self.bank.read(offset)?;
        if offset == DR {
            self.bank[ISR] &= !EOC;
        }
        Ok(value)
    }

    pub(crate) fn write(
        &mut self,
        offset: u32,
        value: u32,
        clocks: Clocks,
        adc_clock: Ticks,
    ) -> Result<(), Misuse> {
        match offset {
            ISR => self.bank[ISR] &= !value,
            CR => self.control(value, clocks, adc_clock)?,
            CFGR if value & 3 != 0 => {
                return Err(self
                    .bank
                    .unsupported(CFGR, value, "ADC DMA is not modelled"));
            }
            CFGR if value & 0xC00 != 0 || value >> 13 & 1 != 0 || value & (1 << 25) != 0 => {
                let what = "of the regular group only single software starts are modelled";
                return Err(self.bank.unsupported(CFGR, value, what));
            }
            JSQR if value >> 7 & 3 != 0 && value >> 2 & 0x1F != 8 => {
                return Err(self.bank.unsupported(
                    JSQR,
                    value,
                    "of the injected triggers only TIM1_TRGO2 is modelled",
                ));
            }
            _ => self.bank.write(offset, value)?,
        }
        Ok(())
    }

    fn control(&mut self, value: u32, clocks: Clocks, adc_clock: Ticks) -> Result<(), Misuse> {
        let old = self.bank[CR];
        let level = value & (ADVREGEN | DEEPPWD | 1 << 30);
        let mut new = old & !(ADVREGEN | DEEPPWD | 1 << 30) | level;
        if value & (ADEN | ADCAL) != 0 && (new & ADVREGEN == 0 || new & DEEPPWD != 0) {
            return Err(self.bank.unsupported(
                CR,
                value,
                "the voltage regulator is off or the ADC in deep power-down",
            ));
        }
        // Calibration completes immediately: its duration is not modelled.
        if value & ADEN != 0 && old & ADEN == 0 {
            new |= ADEN;
            self.bank[ISR] |= ADRDY;
        }
        if value & ADDIS != 0 {
            new &= !(ADEN | ADSTART | JADSTART);
            self.running = None;
        }
        if value & ADSTP != 0 {
            new &= !ADSTART;
            self.running = self.running.filter(|r| r.group == Group::Injected);
        }
        if value & JADSTP != 0 {
            new &= !JADSTART;
            self.running = self.running.filter(|r| r.group == Group::Regular);
        }
        for (start, group) in [(ADSTART, Group::Regular), (JADSTART, Group::Injected)] {
            if value & start != 0 && old & start == 0 {
                if new & ADEN == 0 {
                    return Err(self.bank.unsupported(CR, value, "started while disabled"));
                }
                new |= start;
                self.bank[CR] = new;
                let software = group == Group::Regular || self.bank[JSQR] >> 7 & 3 == 0;
                if software {
                    self.start(group, clocks.now, adc_clock);
                }
            }
        }
        self.bank[CR] = new;
        Ok(())
    }

    /// TIM1_TRGO2.
    pub(crate) fn trigger(&mut self, now: Ticks, adc_clock: Ticks) {
        if self.bank[CR] & JADSTART != 0 && self.bank[JSQR] >> 7 & 3 != 0 {
            match self.running {
                Some(Running {
                    group: Group::Injected,
                    ..
                }) => self.missed_triggers += 1,
                _ => self.start(Group::Injected, now, adc_clock),
            }
        }
    }

    fn start(&mut self, group: Group, now: Ticks, adc_clock: Ticks) {
        let done = now + self.duration(group, 0, adc_clock);
        self.running = Some(Running {
            group,
            rank: 0,
            done,
        });
    }

    fn channel(&self, group: Group, rank: u32) -> u32 {
        match group {
            Group::Injected => self.bank[JSQR] >> (9 + 6 * rank) & 0x1F,
            Group::Regular => {
                let position = rank + 1;
                self.bank[SQR1 + 4 * (position / 5)] >> (6 * (position % 5)) & 0x1F
            }
        }
    }

    /// Conversions summed for one result.
    fn ratio(&self, group: Group) -> u32 {
        let enable = match group {
            Group::Regular => 1,
            Group::Injected => 2,
        };
        if self.bank[CFGR2] & enable != 0 {
            2 << (self.bank[CFGR2] >> 2 & 7)
        } else {
            1
        }
    }

    /// Sampling of a channel, in half cycles.
    fn sampling(&self, channel: u32) -> u64 {
        let code = self.bank[SMPR1 + 4 * (channel / 10)] >> (3 * (channel % 10)) & 7;
        SAMPLING[code as usize]
    }

    fn duration(&self, group: Group, rank: u32, adc_clock: Ticks) -> Ticks {
        let sampling = self.sampling(self.channel(group, rank));
        (sampling + CONVERSION) * adc_clock / 2 * u64::from(self.ratio(group))
    }

    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.running.map(|running| running.done)
    }

    /// Completes the due conversions; `pins` are the voltages at the channels.
    pub(crate) fn finish(&mut self, now: Ticks, adc_clock: Ticks, pins: &mut impl Voltages) {
        let Some(Running { group, rank, done }) = self.running.filter(|r| r.done <= now) else {
            return;
        };
        let channel = self.channel(group, rank);
        let ratio = self.ratio(group);
        let begun = done.saturating_sub(self.duration(group, rank, adc_clock));
        let half_cycles = |n: u64| time::seconds(n * adc_clock) / 2.0;
        let sampling = self.sampling(channel);
        let source = pins.source(channel);
        let timing_s = [half_cycles(sampling), half_cycles(sampling + CONVERSION)];
        let mut few = [0.0; FEW];
        let mut many = Vec::new();
        let volts = if let Some(volts) = few.get_mut(..ratio as usize) {
            volts
        } else {
            many.resize(ratio as usize, 0.0);
            &mut many
        };
        match pins.find(channel, begun, timing_s, volts) {
            Some(steady_v) => self.input.sample_steady(&source, timing_s, steady_v, volts),
            None => self.input.sample(&source, timing_s, volts),
        }
        let sum: u32 = volts.iter().map(|volts| code(*volts)).sum();
        let shift = if ratio > 1 {
            self.bank[CFGR2] >> 5 & 0xF
        } else {
            0
        };
        let result = (sum >> shift) & 0xFFFF;
        let last = match group {
            Group::Injected => {
                self.bank[JDR1 + 4 * rank] = result;
                self.bank[ISR] |= JEOC;
                rank == self.bank[JSQR] & 3
            }
            Group::Regular => {
                if self.bank[ISR] & EOC != 0 {
                    self.bank[ISR] |= OVR;
                }
                self.bank[DR] = result;
                self.bank[ISR] |= EOC;
                rank == self.bank[SQR1] & 0xF
            }
        };
        if !last {
            let done = done + self.duration(group, rank + 1, adc_clock);
            self.running = Some(Running {
                group,
                rank: rank + 1,
                done,
            });
            return;
        }
        self.running = None;
        match group {
            Group::Injected => {
                self.bank[ISR] |= JEOS;
                if self.bank[JSQR] >> 7 & 3 == 0 {
                    self.bank[CR] &= !JADSTART;
                }
            }
            Group::Regular => {
                self.bank[ISR] |= EOS;
                self.bank[CR] &= !ADSTART;
            }
        }
    }

    pub(crate) fn interrupt(&self) -> bool {
        self.bank[ISR] & self.bank[IER] & 0x7FF != 0
    }
}

/// Code of 12 bits for a voltage, rounded down.
fn code(volts: f64) -> u32 {
    (volts / VREF_V * 4096.0).clamp(0.0, 4095.0) as u32
}

#[cfg(test)]
mod tests;
