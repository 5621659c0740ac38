// SPDX-License-Identifier: GPL-2.0-only
//! TIM1: the bridge's PWM, its update event as ADC trigger, and the break that turns the outputs off by hardware.

use super::bank::{Bank, Clocks, Misuse, Register};
use crate::time::Ticks;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const RCR: u32 = 0x30;
const CCR1: u32 = 0x34;
const BDTR: u32 = 0x44;
const AF1: u32 = 0x60;

const REGISTERS: &[Register] = &[
    (CR1, "CR1", 0),
    (CR2, "CR2", 0),
    (SMCR, "SMCR", 0),
    (DIER, "DIER", 0),
    (SR, "SR", 0),
    (EGR, "EGR", 0),
    (CCMR1, "CCMR1", 0),
    (0x1C, "CCMR2", 0),
    (CCER, "CCER", 0),
    (CNT, "CNT", 0),
    (PSC, "PSC", 0),
    (ARR, "ARR", 0xFFFF),
    (RCR, "RCR", 0),
    (CCR1, "CCR1", 0),
    (0x38, "CCR2", 0),
    (0x3C, "CCR3", 0),
    (0x40, "CCR4", 0),
    (BDTR, "BDTR", 0),
    (0x48, "CCR5", 0),
    (0x4C, "CCR6", 0),
    (0x50, "CCMR3", 0),
    (0x54, "DTR2", 0),
    (0x58, "ECR", 0),
    (0x5C, "TISEL", 0),
    (AF1, "AF1", 1),
    (0x64, "AF2", 1),
    (0x3DC, "DCR", 0),
];

const MOE: u32 = 1 << 15;
const AOE: u32 = 1 << 14;
const BKE: u32 = 1 << 12;
/// Break, and system break, in SR.
const BIF: u32 = 1 << 7;
const SBIF: u32 = 1 << 13;

/// A store to this register may move the next update event.
pub(crate) fn moves_events(offset: u32) -> bool {
    matches!(offset, CR1 | EGR)
}

/// Values in force until the next update event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Shadow {
    prescaler: u32,
    reload: u32,
    repetition: u32,
    compare: [u32; 4],
}

/// The bridge's PWM timer.
#[derive(Debug)]
pub(crate) struct Tim1 {
    bank: Bank,
    shadow: Shadow,
    /// Start of the counting cycle.
    origin: Ticks,
    next_update: Option<Ticks>,
    /// Whether the break input is active; `None` while the pin is not connected to the timer.
    break_pin: Option<bool>,
    /// Whether a system break is active: lockup of the core or an uncorrectable flash error, if SYSCFG enables it.
    pub(crate) system_break: bool,
}

impl Tim1 {
    pub(crate) fn new() -> Self {
        let shadow = Shadow {
            reload: 0xFFFF,
            ..Shadow::default()
        };
        let bank = Bank::new("TIM1", REGISTERS);
        Self {
            bank,
            shadow,
            origin: 0,
            next_update: None,
            break_pin: None,
            system_break: false,
        }
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new();
    }

    fn centre_aligned(&self) -> bool {
        self.bank[CR1] & 0x60 != 0
    }

    /// Time from one overflow or underflow to the next.
    fn half_cycle(&self, clocks: Clocks) -> Ticks {
        let counts = u64::from(self.shadow.reload) + u64::from(!self.centre_aligned());
        counts.max(1) * (u64::from(self.shadow.prescaler) + 1) * clocks.bus
    }

    fn load(&mut self, at: Ticks, clocks: Clocks) {
        self.shadow = Shadow {
            prescaler: self.bank[PSC],
            reload: self.bank[ARR],
            repetition: self.bank[RCR],
            compare: std::array::from_fn(|c| self.bank[CCR1 + 4 * c as u32]),
        };
        self.origin = at;
        self.next_update = (self.bank[CR1] & 1 != 0)
            .then(|| at + (u64::from(self.shadow.repetition) + 1) * self.half_cycle(clocks));
    }

    /// Runs the update event that is due. True if it triggers the ADC (TRGO2).
    pub(crate) fn update(&mut self, clocks: Clocks) -> bool {
        let Some(at) = self.next_update.filter(|&at| at <= clocks.now) else {
            return false;
        };
        if self.bank[CR1] & 2 != 0 {
            // UDIS: no update event, the counter goes on.
            self.origin = at;
            self.next_update =
                Some(at + (u64::from(self.shadow.repetition) + 1) * self.half_cycle(clocks));
            return false;
        }
        self.load(at, clocks);
        self.bank[SR] |= 1;
        if self.bank[BDTR] & AOE != 0 && !self.break_active() {
            self.bank[BDTR] |= MOE;
        }
        self.bank[CR2] >> 20 & 0xF == 2
    }

    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.next_update
    }

    fn break_active(&self) -> bool {
        let pin_selected = self.bank[AF1] & 1 != 0;
        self.bank[BDTR] & BKE != 0 && (self.system_break || pin_selected && self.break_pin_active())
    }

    /// Polarity: BKP of BDTR and BKINP of AF1 (bit 9). Neither set: active low.
    fn break_pin_active(&self) -> bool {
        let high_active = (self.bank[BDTR] >> 13 ^ self.bank[AF1] >> 9) & 1 != 0;
        self.break_pin.is_some_and(|level| level == high_active)
    }

    /// Level of the break pin, `None` if its alternate function is not selected.
    pub(crate) fn set_break_pin(&mut self, level: Option<bool>) {
        self.break_pin = level;
        self.apply_break();
    }

    /// Applies a pulse of this length to the break pin.
    pub(crate) fn pulse_break_pin(&mut self, length: Ticks, clocks: Clocks) {
        if length >= self.break_filter(clocks) && self.bank[BDTR] & BKE != 0 {
            self.bank[BDTR] &= !MOE;
            self.bank[SR] |= BIF;
        }
    }

    /// Length of a pulse that the filter of the break input lets through; BKF of BDTR, with the dead-time clock undivided.
    fn break_filter(&self, clocks: Clocks) -> Ticks {
        const DIVIDED: [(u64, u64); 16] = [
            (1, 0),
            (1, 2),
            (1, 4),
            (1, 8),
            (2, 6),
            (2, 8),
            (4, 6),
            (4, 8),
            (8, 6),
            (8, 8),
            (16, 5),
            (16, 6),
            (16, 8),
            (32, 5),
            (32, 6),
            (32, 8),
        ];
        let (divider, samples) = DIVIDED[(self.bank[BDTR] >> 16 & 0xF) as usize];
        divider * samples * clocks.bus
    }

    /// Acts asynchronously: needs neither clock nor instruction.
    pub(crate) fn apply_break(&mut self) {
        if self.break_active() {
            self.bank[BDTR] &= !MOE;
            self.bank[SR] |= if self.system_break { SBIF } else { BIF };
        }
    }

    pub(crate) fn read(&self, offset: u32, clocks: Clocks) -> Result<u32, Misuse> {
        match offset {
            CNT => Ok(self.counter(clocks)),
            _ => self.bank.read(offset),
        }
    }

    fn counter(&self, clocks: Clocks) -> u32 {
        if self.next_update.is_none() {
            return self.bank[CNT];
        }
        let counts = (clocks.now - self.origin.min(clocks.now))
            / (clocks.bus * (u64::from(self.shadow.prescaler) + 1));
        let reload = u64::from(self.shadow.reload).max(1);
        if self.centre_aligned() {
            let phase = counts % (2 * reload);
            phase.min(2 * reload - phase) as u32
        } else {
            (counts % (reload + 1)) as u32
        }
    }

    pub(crate) fn write(
        &mut self,
        offset: u32,
        value: u32,
        clocks: Clocks,
    ) -> Result<bool, Misuse> {
        let mut triggered = false;
        match offset {
            SR => {
                self.bank[SR] &= value;
                self.apply_break();
            }
            EGR => {
                if value & 1 != 0 {
                    self.load(clocks.now, clocks);
                    if self.bank[CR1] & 4 == 0 {
                        self.bank[SR] |= 1;
                    }
                    triggered = matches!(self.bank[CR2] >> 20 & 0xF, 0 | 2);
                }
                if value & 0x80 != 0 && self.bank[BDTR] & BKE != 0 {
                    self.bank[BDTR] &= !MOE;
                    self.bank[SR] |= BIF;
                }
            }
            CR1 => {
                let was = self.bank[CR1];
                self.bank[CR1] = value;
                if value & 1 == 0 {
                    self.next_update = None;
                } else if (was ^ value) & 0x61 != 0 {
                    self.origin = clocks.now;
                    let events = u64::from(self.shadow.repetition) + 1;
                    self.next_update = Some(clocks.now + events * self.half_cycle(clocks));
                }
            }
            CR2 if value >> 20 & 0xF > 2 => {
                return Err(self.bank.unsupported(
                    CR2,
                    value,
                    "of the TRGO2 sources only reset and update are modelled",
                ));
            }
            SMCR if value & 7 != 0 => {
                return Err(self.bank.unsupported(
                    SMCR,
                    value,
                    "slave modes of TIM1 are not modelled",
                ));
            }
            DIER if value & 0xFF00 != 0 => {
                return Err(self.bank.unsupported(
                    DIER,
                    value,
                    "timer DMA requests are not modelled",
                ));
            }
            PSC | RCR => self.bank[offset] = value & 0xFFFF,
            ARR => {
                self.bank[ARR] = value & 0xFFFF;
                if self.bank[CR1] & 0x80 == 0 {
                    self.shadow.reload = value & 0xFFFF;
                }
            }
            0x34..=0x40 => {
                self.bank[offset] = value & 0xFFFF;
                let channel = (offset - CCR1) / 4;
                if self.compare_mode(channel) & 8 == 0 {
                    self.shadow.compare[channel as usize] = value & 0xFFFF;
                }
            }
            BDTR => {
                let old = self.bank[BDTR];
                // Once locked, only MOE moves until reset.
                self.bank[BDTR] = if old & 0x300 != 0 {
                    old & !MOE | value & MOE
                } else {
                    value
                };
                // The flag of a system break must be cleared first (RM0440, TIMx_SR).
                if self.bank[SR] & SBIF != 0 {
                    self.bank[BDTR] &= !MOE;
                }
                self.apply_break();
            }
            AF1 => {
                if value & 0x1FE != 0 {
                    return Err(self.bank.unsupported(
                        AF1,
                        value,
                        "comparators as break source are not modelled",
                    ));
                }
                self.bank[AF1] = value;
                self.apply_break();
            }
            _ => self.bank.write(offset, value)?,
        }
        Ok(triggered)
    }

    /// Whether a store to this register takes effect at the next update event: compare values with preload.
    pub(crate) fn buffers(&self, offset: u32) -> bool {
        matches!(offset, 0x34..=0x40) && self.compare_mode((offset - CCR1) / 4) & 8 != 0
    }

    /// Mode bits of a channel.
    fn compare_mode(&self, channel: u32) -> u32 {
        self.bank[CCMR1 + 4 * (channel / 2)] >> (8 * (channel % 2))
    }

    /// Main output enable.
    pub(crate) fn main_output(&self) -> bool {
        self.bank[BDTR] & MOE != 0
    }

    /// On-time share of channel 1 while the main output is enabled; `None` if the channel does not drive its pin.
    pub(crate) fn duty(&self) -> Option<f64> {
        if !self.main_output() || self.bank[CCER] & 1 == 0 {
            return None;
        }
        let mode = self.bank[CCMR1] >> 4 & 7 | self.bank[CCMR1] >> 13 & 8;
        let full =
            f64::from(self.shadow.reload.max(1)) + if self.centre_aligned() { 0.0 } else { 1.0 };
        let share = (f64::from(self.shadow.compare[0]) / full).min(1.0);
        let running = self.bank[CR1] & 1 != 0;
        let active = match mode {
            5 => 1.0,
            6 if running => share,
            7 if running => 1.0 - share,
            _ => 0.0,
        };
        Some(if self.bank[CCER] & 2 == 0 {
            active
        } else {
            1.0 - active
        })
    }

    /// Levels of the interrupt lines: break, update, trigger and commutation, compare.
    pub(crate) fn lines(&self) -> [bool; 4] {
        let flags = self.bank[SR];
        let enabled = self.bank[DIER];
        let both = flags & enabled;
        [
            enabled & BIF != 0 && flags & (BIF | 1 << 8 | SBIF) != 0,
            both & 1 != 0,
            both & 0x60 != 0,
            both & 0x1E != 0,
        ]
    }
}

#[cfg(test)]
mod tests;
