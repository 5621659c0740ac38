// SPDX-License-Identifier: GPL-2.0-only
//! SysTick: the core's own down-counter.

use crate::chip::Clocks;
use crate::time::Ticks;

#[derive(Debug, Default)]
pub(crate) struct SysTick {
    control: u32,
    reload: u32,
    /// When the counter last started from its reload value.
    started: Ticks,
    counted: bool,
}

const ENABLE: u32 = 1;
const TICKINT: u32 = 2;
const CORE_CLOCK: u32 = 4;

impl SysTick {
    fn step(&self, clocks: Clocks) -> Ticks {
        if self.control & CORE_CLOCK != 0 {
            clocks.bus
        } else {
            8 * clocks.bus
        }
    }

    fn period(&self, clocks: Clocks) -> Ticks {
        (u64::from(self.reload) + 1) * self.step(clocks)
    }

    pub(crate) fn read(&mut self, offset: u32, clocks: Clocks) -> u32 {
        match offset {
            0x0 => self.control | u32::from(std::mem::take(&mut self.counted)) << 16,
            0x4 => self.reload,
            0x8 if self.control & ENABLE == 0 => 0,
            0x8 => {
                self.reload
                    - ((clocks.now - self.started) / self.step(clocks)).min(u64::from(self.reload))
                        as u32
            }
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, clocks: Clocks) {
        match offset {
            0x0 => {
                if value & ENABLE != 0 && self.control & ENABLE == 0 {
                    self.started = clocks.now;
                }
                self.control = value & 7;
            }
            0x4 => self.reload = value & 0x00FF_FFFF,
            0x8 => {
                self.started = clocks.now;
                self.counted = false;
            }
            _ => {}
        }
    }

    pub(crate) fn next_event(&self, clocks: Clocks) -> Option<Ticks> {
        (self.control & ENABLE != 0 && self.reload != 0).then(|| self.started + self.period(clocks))
    }

    /// True if its exception becomes pending.
    pub(crate) fn advance(&mut self, clocks: Clocks) -> bool {
        match self.next_event(clocks) {
            Some(at) if at <= clocks.now => {
                self.started = at;
                self.counted = true;
                self.control & TICKINT != 0
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_down_and_comes_again() {
        let at = |now| Clocks { now, bus: 24 };
        let mut tick = SysTick::default();
        tick.write(4, 999, at(0));
        tick.write(0, 7, at(0));
        assert_eq!(tick.read(8, at(24 * 10)), 989);
        assert!(!tick.advance(at(24 * 999)));
        assert!(tick.advance(at(24 * 1000)));
        assert_eq!(tick.next_event(at(24 * 1000)), Some(24 * 2000));
        assert_eq!(tick.read(0, at(24 * 1000)), 1 << 16 | 7);
    }
}
