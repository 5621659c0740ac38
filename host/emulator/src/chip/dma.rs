// SPDX-License-Identifier: GPL-2.0-only
//! DMA and DMAMUX: the registers exist because the hardware abstraction layer clears them; enabling a channel is an error,
//! because transfers are not modelled.

use super::bank::{Bank, Misuse, Register};

pub(super) const DMA: &[Register] = &[
    (0x00, "ISR", 0),
    (0x04, "IFCR", 0),
    (0x08, "CCR1", 0),
    (0x0C, "CNDTR1", 0),
    (0x10, "CPAR1", 0),
    (0x14, "CMAR1", 0),
    (0x1C, "CCR2", 0),
    (0x20, "CNDTR2", 0),
    (0x24, "CPAR2", 0),
    (0x28, "CMAR2", 0),
    (0x30, "CCR3", 0),
    (0x34, "CNDTR3", 0),
    (0x38, "CPAR3", 0),
    (0x3C, "CMAR3", 0),
    (0x44, "CCR4", 0),
    (0x48, "CNDTR4", 0),
    (0x4C, "CPAR4", 0),
    (0x50, "CMAR4", 0),
    (0x58, "CCR5", 0),
    (0x5C, "CNDTR5", 0),
    (0x60, "CPAR5", 0),
    (0x64, "CMAR5", 0),
    (0x6C, "CCR6", 0),
    (0x70, "CNDTR6", 0),
    (0x74, "CPAR6", 0),
    (0x78, "CMAR6", 0),
];

pub(super) const DMAMUX: &[Register] = &[
    (0x00, "C0CR", 0),
    (0x04, "C1CR", 0),
    (0x08, "C2CR", 0),
    (0x0C, "C3CR", 0),
    (0x10, "C4CR", 0),
    (0x14, "C5CR", 0),
    (0x18, "C6CR", 0),
    (0x1C, "C7CR", 0),
    (0x20, "C8CR", 0),
    (0x24, "C9CR", 0),
    (0x28, "C10CR", 0),
    (0x2C, "C11CR", 0),
    (0x80, "CSR", 0),
    (0x84, "CCFR", 0),
];

#[derive(Debug)]
pub(crate) struct Dma {
    bank: Bank,
}

impl Dma {
    pub(crate) fn controller(name: &'static str) -> Self {
        Self {
            bank: Bank::new(name, DMA),
        }
    }

    pub(crate) fn multiplexer() -> Self {
        Self {
            bank: Bank::new("DMAMUX", DMAMUX),
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        self.bank.read(offset)
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        if self.bank.register(offset).starts_with("CCR") && value & 1 != 0 {
            return Err(self
                .bank
                .unsupported(offset, value, "DMA transfers are not modelled"));
        }
        self.bank.write(offset, value)
    }
}
