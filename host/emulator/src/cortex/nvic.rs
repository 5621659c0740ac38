// SPDX-License-Identifier: GPL-2.0-only
//! Selects the next exception: pending, enabled, active and priority of the core's own exceptions and the chip's
//! interrupts.

/// Exception numbers of the core; interrupt n is 16 + n.
pub mod exception {
    pub(crate) const NMI: u16 = 2;
    pub(crate) const HARD_FAULT: u16 = 3;
    pub(crate) const MEM_MANAGE: u16 = 4;
    pub(crate) const BUS_FAULT: u16 = 5;
    pub(crate) const USAGE_FAULT: u16 = 6;
    pub(crate) const SV_CALL: u16 = 11;
    pub(crate) const PEND_SV: u16 = 14;
    pub(crate) const SYS_TICK: u16 = 15;
    /// Of interrupt 0.
    pub(crate) const EXTERNAL: u16 = 16;
}

/// Interrupts of the STM32G431.
pub(crate) const INTERRUPTS: u16 = 102;
const EXCEPTIONS: u16 = exception::EXTERNAL + INTERRUPTS;
/// The core's own exceptions cannot be disabled here; the configurable faults are, by SHCSR.
const ALWAYS: u128 = 0xFFFF
    & !(1 << exception::MEM_MANAGE | 1 << exception::BUS_FAULT | 1 << exception::USAGE_FAULT);

/// Priority of thread mode: below every exception.
pub(crate) const THREAD: i16 = 256;

/// The interrupt controller.
#[derive(Debug)]
pub struct Nvic {
    pub(crate) enabled: u128,
    pending: u128,
    active: u128,
    lines: u128,
    priority: [u8; EXCEPTIONS as usize],
    /// AIRCR.PRIGROUP.
    group: u8,
    candidate: Option<(u16, i16)>,
}

impl Nvic {
    pub(crate) fn new() -> Self {
        Self {
            enabled: ALWAYS,
            pending: 0,
            active: 0,
            lines: 0,
            priority: [0; EXCEPTIONS as usize],
            group: 0,
            candidate: None,
        }
    }

    /// The pending exception that would preempt the running code if no mask register prevents it, with its priority.
    pub(crate) fn candidate(&self) -> Option<(u16, i16)> {
        self.candidate
    }

    pub(crate) fn is_pending(&self, exception: u16) -> bool {
        self.pending >> exception & 1 != 0
    }

    /// Sets the level of a peripheral's interrupt line. A rising line makes its interrupt pending.
    pub(crate) fn set_line(&mut self, interrupt: u16, high: bool) {
        let bit = 1u128 << (exception::EXTERNAL + interrupt);
        if high && self.lines & bit == 0 {
            self.lines |= bit;
            if self.active & bit == 0 {
                self.pending |= bit;
                self.update();
            }
        } else if !high {
            self.lines &= !bit;
        }
    }

    pub(crate) fn set_pending(&mut self, exception: u16, pending: bool) {
        let bit = 1u128 << exception;
        self.pending = if pending {
            self.pending | bit
        } else {
            self.pending & !bit
        };
        self.update();
    }

    pub(crate) fn set_enabled(&mut self, exception: u16, enabled: bool) {
        let bit = 1u128 << exception;
        self.enabled = if enabled {
            self.enabled | bit
        } else {
            self.enabled & !bit
        };
        self.update();
    }

    pub(crate) fn enter(&mut self, exception: u16) {
        let bit = 1u128 << exception;
        self.pending &= !bit;
        self.active |= bit;
        self.update();
    }

    /// Ends an exception; if its line is still high it becomes pending again. False if it was not active.
    pub(crate) fn leave(&mut self, exception: u16) -> bool {
        let bit = 1u128 << exception;
        let was = self.active & bit != 0;
        self.active &= !bit;
        self.pending |= self.lines & bit;
        self.update();
        was
    }

    pub(crate) fn priority(&self, exception: u16) -> u8 {
        self.priority
            .get(usize::from(exception))
            .copied()
            .unwrap_or(0)
    }

    /// Four bits are implemented.
    pub(crate) fn set_priority(&mut self, exception: u16, priority: u8) {
        if let Some(slot) = self.priority.get_mut(usize::from(exception)) {
            *slot = priority & 0xF0;
            self.update();
        }
    }

    pub(crate) fn set_group(&mut self, group: u8) {
        self.group = group & 7;
        self.update();
    }

    pub(crate) fn group(&self) -> u8 {
        self.group
    }

    /// Preemption priority: the group part of the priority, negative for NMI and HardFault.
    pub(crate) fn preemption(&self, exception: u16) -> i16 {
        match exception {
            exception::NMI => -2,
            exception::HARD_FAULT => -1,
            _ => i16::from(self.priority(exception) & !((2u16 << self.group) - 1) as u8),
        }
    }

    /// Priority of the running code, without mask registers.
    pub(crate) fn running(&self) -> i16 {
        bits(self.active)
            .map(|e| self.preemption(e))
            .min()
            .unwrap_or(THREAD)
    }

    fn update(&mut self) {
        let running = self.running();
        self.candidate = bits(self.pending & self.enabled)
            .map(|e| (e, self.preemption(e), self.priority(e)))
            .min_by_key(|&(e, group, full)| (group, full, e))
            .filter(|&(_, group, _)| group < running)
            .map(|(e, group, _)| (e, group));
    }

    /// Bits of a bank of 32 interrupts.
    pub(crate) fn bank(&self, which: Bank, bank: u32) -> u32 {
        let all = match which {
            Bank::Enabled => self.enabled,
            Bank::Pending => self.pending,
            Bank::Active => self.active,
        };
        (all >> exception::EXTERNAL >> (32 * bank.min(3))) as u32
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Bank {
    Enabled,
    Pending,
    Active,
}

fn bits(mut set: u128) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        (set != 0).then(|| {
            let lowest = set.trailing_zeros() as u16;
            set &= set - 1;
            lowest
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(interrupts: &[(u16, u8)]) -> Nvic {
        let mut nvic = Nvic::new();
        for &(interrupt, priority) in interrupts {
            nvic.set_enabled(16 + interrupt, true);
            nvic.set_priority(16 + interrupt, priority);
        }
        nvic
    }

    #[test]
    fn the_most_urgent_preempts_and_the_others_wait() {
        let mut nvic = with(&[(3, 0x80), (5, 0x40), (7, 0x40)]);
        for interrupt in [3, 7, 5] {
            nvic.set_pending(16 + interrupt, true);
        }
        assert_eq!(
            nvic.candidate(),
            Some((16 + 5, 0x40)),
            "equal priority: the lower number first"
        );
        nvic.enter(16 + 5);
        assert_eq!(
            nvic.candidate(),
            None,
            "neither an equal nor a lower priority preempts"
        );
        assert!(nvic.leave(16 + 5));
        assert_eq!(nvic.candidate(), Some((16 + 7, 0x40)));
    }

    #[test]
    fn a_line_still_high_comes_again_and_a_cleared_one_does_not() {
        let mut nvic = with(&[(18, 0x10)]);
        nvic.set_line(18, true);
        nvic.enter(34);
        assert_eq!(nvic.candidate(), None);
        nvic.leave(34);
        assert_eq!(nvic.candidate(), Some((34, 0x10)));
        nvic.enter(34);
        nvic.set_line(18, false);
        nvic.leave(34);
        assert_eq!(nvic.candidate(), None);
    }

    #[test]
    fn a_group_decides_preemption_alone() {
        let mut nvic = with(&[(1, 0x40), (2, 0x50)]);
        nvic.set_group(4); // bits 7:5
        nvic.set_pending(18, true);
        nvic.enter(18);
        nvic.set_pending(17, true);
        assert_eq!(nvic.candidate(), None, "0x40 and 0x50 are one group");
    }

    #[test]
    fn faults_stand_above_every_interrupt() {
        let mut nvic = with(&[(1, 0)]);
        nvic.set_pending(17, true);
        nvic.enter(17);
        nvic.set_pending(exception::HARD_FAULT, true);
        assert_eq!(nvic.candidate(), Some((exception::HARD_FAULT, -1)));
    }
}
