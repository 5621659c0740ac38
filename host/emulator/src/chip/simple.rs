// SPDX-License-Identifier: GPL-2.0-only
//! Peripherals without modelled behaviour: registers keep what was written.

use super::bank::{Bank, Misuse, Register};

/// SYSCFG.
pub(crate) const SYSCFG: &[Register] = &[
    (0x00, "MEMRMP", 0),
    (0x04, "CFGR1", 0x7C00_0001),
    (0x08, "EXTICR1", 0),
    (0x0C, "EXTICR2", 0),
    (0x10, "EXTICR3", 0),
    (0x14, "EXTICR4", 0),
    (0x18, "SCSR", 0),
    (0x1C, "CFGR2", 0),
    (0x20, "SWPR", 0),
    (0x24, "SKR", 0),
];
/// Offset of SYSCFG.EXTICR1.
pub(crate) const SYSCFG_EXTICR1: u32 = 0x08;
/// Offset of SYSCFG.CFGR2, whose bit 0 lets a lockup break the timers, and bit 3 a double error of the flash.
pub(crate) const SYSCFG_CFGR2: u32 = 0x1C;

/// DBGMCU; the identity is that of the STM32G431.
pub(crate) const DBGMCU: &[Register] = &[
    (0x00, "IDCODE", 0x2003_6468),
    (0x04, "CR", 0),
    (0x08, "APB1FZR1", 0),
    (0x0C, "APB1FZR2", 0),
    (0x10, "APB2FZR", 0),
];

/// A register bank that keeps what was written.
#[derive(Debug)]
pub(crate) struct Plain {
    pub(crate) bank: Bank,
}

impl Plain {
    pub(crate) fn new(name: &'static str, registers: &'static [Register]) -> Self {
        Self {
            bank: Bank::new(name, registers),
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        self.bank.read(offset)
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        self.bank.write(offset, value)
    }
}
