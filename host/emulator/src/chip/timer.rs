// SPDX-License-Identifier: GPL-2.0-only
//! General-purpose and basic timers: up-counting with compare interrupts, and the quadrature encoder interface.

use std::cell::Cell;

use super::bank::{Bank, Clocks, Misuse, Register};
use crate::time::Ticks;

pub(crate) const CR1: u32 = 0x00;
pub(crate) const SMCR: u32 = 0x08;
pub(crate) const DIER: u32 = 0x0C;
pub(crate) const SR: u32 = 0x10;
pub(crate) const EGR: u32 = 0x14;
pub(crate) const CCER: u32 = 0x20;
pub(crate) const CNT: u32 = 0x24;
pub(crate) const PSC: u32 = 0x28;
pub(crate) const ARR: u32 = 0x2C;
pub(crate) const CCR1: u32 = 0x34;

pub(crate) const REGISTERS: &[Register] = &[
    (CR1, "CR1", 0),
    (0x04, "CR2", 0),
    (SMCR, "SMCR", 0),
    (DIER, "DIER", 0),
    (SR, "SR", 0),
    (EGR, "EGR", 0),
    (0x18, "CCMR1", 0),
    (0x1C, "CCMR2", 0),
    (CCER, "CCER", 0),
    (CNT, "CNT", 0),
    (PSC, "PSC", 0),
    (ARR, "ARR", 0xFFFF),
    (0x30, "RCR", 0),
    (CCR1, "CCR1", 0),
    (0x38, "CCR2", 0),
    (0x3C, "CCR3", 0),
    (0x40, "CCR4", 0),
    (0x44, "BDTR", 0),
    (0x58, "ECR", 0),
    (0x5C, "TISEL", 0),
    (0x60, "AF1", 0),
    (0x64, "AF2", 0),
    (0x3DC, "DCR", 0),
];

/// One timer.
#[derive(Debug)]
pub(crate) struct Timer {
    bank: Bank,
    mask: u32,
    /// Prescaler in force; the register is its preload.
    prescaler: u32,
    /// Counter value at `origin`, as a position that does not wrap.
    base: u64,
    origin: Ticks,
    /// Position up to which flags have been raised.
    settled: u64,
    /// Quadrature edges of the world (x4), and their number at a counter value of zero.
    pub(crate) edges: i64,
    edges_zero: i64,
    /// The next event, with the bus period that it was computed for; forgotten whenever a register may have changed.
    next: Cell<Option<(Ticks, Option<Ticks>)>>,
}

impl Timer {
    pub(crate) fn new(name: &'static str, wide: bool) -> Self {
        let mut bank = Bank::new(name, REGISTERS);
        let mask = if wide { u32::MAX } else { 0xFFFF };
        bank[ARR] = mask;
        Self {
            bank,
            mask,
            prescaler: 0,
            base: 0,
            origin: 0,
            settled: 0,
            edges: 0,
            edges_zero: 0,
            next: Cell::new(None),
        }
    }

    pub(crate) fn reset(&mut self) {
        let edges = self.edges;
        *self = Self::new(self.bank.name, self.mask == u32::MAX);
        self.edges = edges;
    }

    fn running(&self) -> bool {
        self.bank[CR1] & 1 != 0
    }

    fn encoder(&self) -> bool {
        matches!(self.bank[SMCR] & 7, 1..=3) && self.bank[SMCR] >> 16 & 1 == 0
    }

    fn modulus(&self) -> u64 {
        u64::from(self.bank[ARR]) + 1
    }

    fn step(&self, clocks: Clocks) -> Ticks {
        clocks.bus * (u64::from(self.prescaler) + 1)
    }

    fn position(&self, clocks: Clocks) -> u64 {
        if self.running() && !self.encoder() {
            self.base + clocks.now.saturating_sub(self.origin) / self.step(clocks)
        } else {
            self.base
        }
    }

    fn counter(&self, clocks: Clocks) -> u32 {
        if self.encoder() {
            let inverted = (self.bank[CCER] >> 1 ^ self.bank[CCER] >> 5) & 1 != 0;
            let moved = self.edges.wrapping_sub(self.edges_zero);
            let moved = if inverted {
                moved.wrapping_neg()
            } else {
                moved
            };
            return moved.rem_euclid(self.modulus() as i64) as u32;
        }
        (self.position(clocks) % self.modulus()) as u32
    }

    /// Restarts counting from `value` at this moment.
    fn rebase(&mut self, value: u32, clocks: Clocks) {
        self.base = u64::from(value);
        self.settled = self.base;
        self.origin = clocks.now;
    }

    /// Raises the flags of all events up to now.
    pub(crate) fn settle(&mut self, clocks: Clocks) {
        let (from, to) = (self.settled, self.position(clocks));
        if to == from {
            return;
        }
        // Flags come at an event or later, and nothing else that it depends on changes before one.
        let quiet = |(bus, next): (Ticks, Option<Ticks>)| {
            bus == clocks.bus && next.is_none_or(|at| at > clocks.now)
        };
        if !self.next.get().is_some_and(quiet) {
            self.next.set(None);
        }
        let modulus = self.modulus();
        let passed = |residue: u64| {
            (to + modulus - residue) / modulus > (from + modulus - residue) / modulus
        };
        let wrapped = passed(0);
        if wrapped {
            self.bank[SR] |= 1;
        }
        for channel in 0..4 {
            let compare = u64::from(self.bank[CCR1 + 4 * channel]);
            if compare < modulus && passed(compare) {
                self.bank[SR] |= 2 << channel;
            }
        }
        self.settled = to;
        if wrapped && self.bank[CR1] & 8 != 0 {
            self.bank[CR1] &= !1;
            self.next.set(None);
            self.rebase(0, clocks);
        } else if wrapped && self.prescaler != self.bank[PSC] {
            let counter = self.counter(clocks);
            self.prescaler = self.bank[PSC];
            self.next.set(None);
            self.rebase(counter, clocks);
        }
    }

    /// Whether the next event is the one that was last asked for.
    pub(crate) fn keeps_event(&self) -> bool {
        self.next.get().is_some()
    }

    pub(crate) fn read(&mut self, offset: u32, clocks: Clocks) -> Result<u32, Misuse> {
        self.settle(clocks);
        if offset == CNT {
            Ok(self.counter(clocks))
        } else {
            self.bank.read(offset)
        }
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, clocks: Clocks) -> Result<(), Misuse> {
        self.settle(clocks);
        self.next.set(None);
        let counter = self.counter(clocks);
        match offset {
            SR => self.bank[SR] &= value,
            EGR => {
                // Bit 0, UG: buffered values take effect and the counter restarts.
                if value & 1 != 0 {
                    self.prescaler = self.bank[PSC];
                    self.rebase(0, clocks);
                    self.edges_zero = self.edges;
                    if self.bank[CR1] & 4 == 0 {
                        self.bank[SR] |= 1;
                    }
                }
                self.bank[SR] |= value & 0x1E;
            }
            CNT => {
                self.rebase(value & self.mask, clocks);
                let value = i64::from(value & self.mask);
                let inverted = (self.bank[CCER] >> 1 ^ self.bank[CCER] >> 5) & 1 != 0;
                self.edges_zero = self
                    .edges
                    .wrapping_sub(if inverted { -value } else { value });
            }
            CR1 if value & 0x70 != 0 => {
                return Err(self.bank.unsupported(
                    CR1,
                    value,
                    "only up-counting is modelled in this timer",
                ));
            }
            SMCR if !matches!(value & 7, 0 | 3) || value >> 16 & 1 != 0 => {
                return Err(self.bank.unsupported(
                    SMCR,
                    value,
                    "of the slave modes only encoder mode 3 is modelled",
                ));
            }
            DIER if value & 0xFF00 != 0 => {
                return Err(self.bank.unsupported(
                    DIER,
                    value,
                    "timer DMA requests are not modelled",
                ));
            }
            CR1 | SMCR | ARR => {
                self.bank.write(
                    offset,
                    value & if offset == ARR { self.mask } else { u32::MAX },
                )?;
                self.rebase(counter, clocks);
                if offset == SMCR && self.encoder() {
                    self.edges_zero = self.edges.wrapping_sub(i64::from(counter));
                }
            }
            0x34..=0x40 => self.bank[offset] = value & self.mask,
            _ => self.bank.write(offset, value)?,
        }
        Ok(())
    }

    /// The next moment at which an enabled interrupt becomes pending.
    pub(crate) fn next_event(&self, clocks: Clocks) -> Option<Ticks> {
        if let Some((bus, next)) = self.next.get()
            && bus == clocks.bus
        {
            return next;
        }
        let next = self.find_next_event(clocks);
        self.next.set(Some((clocks.bus, next)));
        next
    }

    fn find_next_event(&self, clocks: Clocks) -> Option<Ticks> {
        let enabled = self.bank[DIER] & 0x1F & !self.bank[SR];
        if !self.running() || self.encoder() || enabled == 0 {
            return None;
        }
        let modulus = self.modulus();
        let next = |residue: u64| {
            let ahead = (residue + modulus - self.settled % modulus) % modulus;
            self.settled + if ahead == 0 { modulus } else { ahead }
        };
        let wrap = (enabled & 1 != 0).then(|| next(0));
        let compares = (0..4)
            .filter(|c| enabled >> (c + 1) & 1 != 0)
            .filter_map(|c| {
                let compare = u64::from(self.bank[CCR1 + 4 * c]);
                (compare < modulus).then(|| next(compare))
            });
        let position = wrap.into_iter().chain(compares).min()?;
        Some(self.origin + (position - self.base) * self.step(clocks))
    }

    pub(crate) fn interrupt(&self) -> bool {
        self.bank[SR] & self.bank[DIER] & 0x5F != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(now: Ticks) -> Clocks {
        Clocks { now, bus: 24 }
    }

    #[test]
    fn compares_and_wraps_at_the_right_tick() {
        let mut timer = Timer::new("TIM2", false);
        timer.write(PSC, 169, at(0)).unwrap();
        timer.write(EGR, 1, at(0)).unwrap();
        timer.write(SR, 0, at(0)).unwrap();
        timer.write(CCR1, 100, at(0)).unwrap();
        timer.write(DIER, 0b11, at(0)).unwrap();
        timer.write(CR1, 1, at(0)).unwrap();
        let microsecond = 24 * 170;
        assert_eq!(timer.next_event(at(0)), Some(100 * microsecond));
        assert_eq!(timer.read(CNT, at(99 * microsecond)), Ok(99));
        assert_eq!(timer.read(SR, at(99 * microsecond)), Ok(0));
        timer.settle(at(100 * microsecond));
        assert!(timer.interrupt());
        assert_eq!(timer.read(SR, at(100 * microsecond)), Ok(2));
        timer.write(SR, !2, at(101 * microsecond)).unwrap();
        assert_eq!(
            timer.next_event(at(101 * microsecond)),
            Some(65_536 * microsecond)
        );
        assert_eq!(timer.read(SR, at(65_536 * microsecond)).unwrap() & 3, 1);
        assert_eq!(timer.read(CNT, at(65_537 * microsecond)), Ok(1));
    }

    #[test]
    fn the_encoder_wraps_both_ways() {
        let mut timer = Timer::new("TIM3", false);
        timer.write(SMCR, 3, at(0)).unwrap();
        timer.write(CR1, 1, at(0)).unwrap();
        timer.edges = -3;
        assert_eq!(timer.read(CNT, at(0)), Ok(65_533));
        timer.edges = 65_536 * 5 + 7;
        assert_eq!(timer.read(CNT, at(0)), Ok(7));
        timer.write(CNT, 1000, at(0)).unwrap();
        timer.edges += 5;
        assert_eq!(timer.read(CNT, at(0)), Ok(1005));
        timer.write(CCER, 2, at(0)).unwrap();
        timer.write(CNT, 0, at(0)).unwrap();
        timer.edges += 5;
        assert_eq!(
            timer.read(CNT, at(0)),
            Ok(65_531),
            "one inverted input reverses the direction"
        );
    }
}
