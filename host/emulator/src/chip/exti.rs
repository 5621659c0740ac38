// SPDX-License-Identifier: GPL-2.0-only
//! EXTI: edges of pins to interrupts.

use super::bank::{Bank, Misuse, Register};

const IMR1: u32 = 0x00;
const EMR1: u32 = 0x04;
const RTSR1: u32 = 0x08;
const FTSR1: u32 = 0x0C;
const SWIER1: u32 = 0x10;
const PR1: u32 = 0x14;
const SWIER2: u32 = 0x30;
const PR2: u32 = 0x34;

const REGISTERS: &[Register] = &[
    (IMR1, "IMR1", 0xFF84_0000),
    (EMR1, "EMR1", 0),
    (RTSR1, "RTSR1", 0),
    (FTSR1, "FTSR1", 0),
    (SWIER1, "SWIER1", 0),
    (PR1, "PR1", 0),
    (0x20, "IMR2", 0xFFFF_FF87),
    (0x24, "EMR2", 0),
    (0x28, "RTSR2", 0),
    (0x2C, "FTSR2", 0),
    (SWIER2, "SWIER2", 0),
    (PR2, "PR2", 0),
];

#[derive(Debug)]
pub(crate) struct Exti {
    bank: Bank,
    /// Last level of each of the 16 pin lines; `None` while no line is armed.
    level: Option<u16>,
}

impl Exti {
    pub(crate) fn new() -> Self {
        Self {
            bank: Bank::new("EXTI", REGISTERS),
            level: None,
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        self.bank.read(offset)
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        match offset {
            PR1 | PR2 => self.bank[offset] &= !value,
            SWIER1 => self.bank[PR1] |= value & self.bank[IMR1],
            SWIER2 => {
                return Err(self.bank.unsupported(
                    offset,
                    value,
                    "lines above 31 are not modelled",
                ));
            }
            EMR1 if value & 0xFFFF != 0 => {
                return Err(self
                    .bank
                    .unsupported(offset, value, "event mode is not modelled"));
            }
            _ => self.bank.write(offset, value)?,
        }
        Ok(())
    }

    /// Whether any pin line is armed.
    pub(crate) fn armed(&self) -> bool {
        (self.bank[RTSR1] | self.bank[FTSR1]) & 0xFFFF != 0
    }

    /// Present levels of the pin lines.
    pub(crate) fn sense(&mut self, level: u16) {
        let was = self.level.replace(level).unwrap_or(level);
        let rising = u32::from(level & !was) & self.bank[RTSR1];
        let falling = u32::from(!level & was) & self.bank[FTSR1];
        self.bank[PR1] |= (rising | falling) & self.bank[IMR1];
    }

    /// Forgets the levels, because no line is armed any more.
    pub(crate) fn ignore(&mut self) {
        self.level = None;
    }

    /// Levels of the interrupt lines with their numbers.
    pub(crate) fn lines(&self) -> [(u16, bool); 7] {
        let pending = self.bank[PR1] & self.bank[IMR1];
        [
            (6, pending & 1 != 0),
            (7, pending & 1 << 1 != 0),
            (8, pending & 1 << 2 != 0),
            (9, pending & 1 << 3 != 0),
            (10, pending & 1 << 4 != 0),
            (23, pending & 0x03E0 != 0),
            (40, pending & 0xFC00 != 0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_armed_edge_stays_pending_until_cleared() {
        let mut exti = Exti::new();
        exti.write(IMR1, 1 << 13).unwrap();
        exti.write(RTSR1, 1 << 13).unwrap();
        exti.sense(0);
        exti.sense(1 << 13);
        exti.sense(0);
        assert!(exti.lines().contains(&(40, true)));
        exti.write(PR1, 1 << 13).unwrap();
        assert!(exti.lines().contains(&(40, false)));
    }
}
