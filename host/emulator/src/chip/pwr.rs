// SPDX-License-Identifier: GPL-2.0-only
//! PWR: voltage scaling and boost mode, which the clock needs, and the backup-domain write bit.

use super::bank::{Bank, Misuse, Register};

const REGISTERS: &[Register] = &[
    (0x00, "CR1", 0x0000_0200),
    (0x04, "CR2", 0),
    (0x08, "CR3", 0x0000_8000),
    (0x0C, "CR4", 0),
    (0x10, "SR1", 0),
    (0x14, "SR2", 0),
    (0x18, "SCR", 0),
    (0x20, "PUCRA", 0),
    (0x24, "PDCRA", 0),
    (0x28, "PUCRB", 0),
    (0x2C, "PDCRB", 0),
    (0x30, "PUCRC", 0),
    (0x34, "PDCRC", 0),
    (0x80, "CR5", 0x0000_0100),
];

#[derive(Debug)]
pub(crate) struct Pwr {
    bank: Bank,
}

impl Pwr {
    pub(crate) fn new() -> Self {
        Self {
            bank: Bank::new("PWR", REGISTERS),
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        self.bank.read(offset)
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        self.bank.write(offset, value)
    }

    /// Range 1 boost: the R1MODE bit cleared.
    pub(crate) fn boost(&self) -> bool {
        self.bank[0x80] >> 8 & 1 == 0
    }
}
