// SPDX-License-Identifier: GPL-2.0-only
//! A bank of 32-bit registers with names: an access to any other offset is an error.

use crate::time::Ticks;

/// An operation of the firmware whose result is not modelled. The emulator stops instead of guessing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Misuse {
    /// No peripheral at this address.
    #[error(
        "{address:#010x} belongs to no modelled peripheral: model it in src/chip before using it"
    )]
    NoPeripheral {
        /// The address accessed.
        address: u32,
    },
    /// The core runs code from RAM, which the emulator maps for data only, except for the CCM SRAM at its own address.
    #[error(
        "code at {address:#010x} in RAM: only code in flash and in CCM SRAM at 0x1000_0000 is modelled"
    )]
    CodeInRam {
        /// Where.
        address: u32,
    },
    /// The peripheral has no register there, or it is not modelled.
    #[error("{peripheral} has no modelled register at offset {offset:#05x}")]
    UnknownRegister {
        /// Name of the peripheral.
        peripheral: &'static str,
        /// Offset from its base address.
        offset: u32,
    },
    /// The peripheral's clock is off in the RCC: on the chip it would read as zero and ignore writes.
    #[error("{peripheral}.{register} accessed while the clock is off: set {enable} in RCC first")]
    Unclocked {
        /// Name of the peripheral.
        peripheral: &'static str,
        /// Name of the register.
        register: &'static str,
        /// The enable register.
        enable: &'static str,
    },
    /// A byte or halfword access to a register that only takes words here.
    #[error("{peripheral} offset {offset:#05x}: access of {size} bytes, only words are modelled")]
    Width {
        /// Name of the peripheral.
        peripheral: &'static str,
        /// Offset from its base address.
        offset: u32,
        /// Bytes accessed.
        size: usize,
    },
    /// A function of the peripheral that is not modelled was enabled.
    #[error("{peripheral}.{register} = {value:#010x}: {what}")]
    Unsupported {
        /// Name of the peripheral.
        peripheral: &'static str,
        /// Name of the register.
        register: &'static str,
        /// The value written.
        value: u32,
        /// What is not modelled, or what the chip forbids.
        what: &'static str,
    },
}

/// Offset, name and reset value of a register.
pub(crate) type Register = (u32, &'static str, u32);

/// Values of the registers of one peripheral.
#[derive(Clone, Debug)]
pub(crate) struct Bank {
    pub(crate) name: &'static str,
    registers: &'static [Register],
    values: Vec<Option<u32>>,
}

impl Bank {
    pub(crate) fn new(name: &'static str, registers: &'static [Register]) -> Self {
        let words = registers.iter().map(|r| r.0 / 4 + 1).max().unwrap_or(0);
        let mut bank = Self {
            name,
            registers,
            values: vec![None; words as usize],
        };
        bank.reset();
        bank
    }

    pub(crate) fn reset(&mut self) {
        for &(offset, _, reset) in self.registers {
            self[offset] = reset;
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        let value = self.values.get((offset / 4) as usize).copied().flatten();
        value.ok_or(Misuse::UnknownRegister {
            peripheral: self.name,
            offset,
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        self.read(offset)?;
        self[offset] = value;
        Ok(())
    }

    #[cold]
    fn missing(&self, offset: u32) -> ! {
        panic!(
            "{} has no register at {offset:#x}: a mistake in its model",
            self.name
        )
    }

    pub(crate) fn register(&self, offset: u32) -> &'static str {
        self.registers
            .iter()
            .find(|r| r.0 == offset)
            .map_or("?", |r| r.1)
    }

    pub(crate) fn unsupported(&self, offset: u32, value: u32, what: &'static str) -> Misuse {
        Misuse::Unsupported {
            peripheral: self.name,
            register: self.register(offset),
            value,
            what,
        }
    }
}

/// Index of an offset, which must be in the bank's table.
impl std::ops::Index<u32> for Bank {
    type Output = u32;
    #[inline]
    fn index(&self, offset: u32) -> &u32 {
        match self.values.get((offset / 4) as usize) {
            Some(Some(value)) => value,
            _ => self.missing(offset),
        }
    }
}

impl std::ops::IndexMut<u32> for Bank {
    fn index_mut(&mut self, offset: u32) -> &mut u32 {
        self.values[(offset / 4) as usize].get_or_insert(0)
    }
}

/// Time and clocks that a peripheral needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Clocks {
    /// Now.
    pub(crate) now: Ticks,
    /// Period of the core, bus and timer clock.
    pub(crate) bus: Ticks,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_its_registers_and_no_others() {
        let mut bank = Bank::new("X", &[(0x0, "CR", 5), (0x8, "SR", 0)]);
        assert_eq!(bank.read(0), Ok(5));
        assert_eq!(bank.write(8, 7), Ok(()));
        assert_eq!(bank[8], 7);
        for offset in [4, 12, 4096] {
            let unknown = Err(Misuse::UnknownRegister {
                peripheral: "X",
                offset,
            });
            assert_eq!(bank.read(offset), unknown);
        }
        bank.reset();
        assert_eq!(bank[8], 0);
    }
}
