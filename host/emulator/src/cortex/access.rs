// SPDX-License-Identifier: GPL-2.0-only
//! Loads and stores of the core.

use super::memory::{Memory, flash_offset};
use super::op::Width;
use super::state::Registers;
use super::{Map, Trap};
use crate::chip::{Chip, Misuse};

/// Last pages of the flash, where a firmware keeps records and where damaged double words are looked for.
const RECORDS_SIZE: u32 = 16 * 1024;
const CYCCNT: u32 = 0xE000_1004;

/// The instruction ends with the trap that the chip's core holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trapped;

/// What an instruction works on.
pub(super) struct Bus<'a> {
    pub(super) registers: &'a mut Registers,
    pub(super) memory: &'a mut Memory,
    pub(super) chip: &'a mut Chip,
}

/// Whether an address belongs to a peripheral.
fn is_peripheral(address: u32) -> bool {
    matches!(address, 0x4000_0000..0x4003_0000 | 0x4800_0000..0x4800_2000 | 0x5000_0000..0x5007_0000)
}

/// Whether an address belongs to a peripheral of the core.
fn is_system(address: u32) -> bool {
    matches!(address, 0xE000_0000..0xE010_0000)
}

impl Bus<'_> {
    pub(super) fn trap(&mut self, trap: Trap) -> Trapped {
        self.chip.core.trap.get_or_insert(trap);
        Trapped
    }

    /// Loads a word; `ahead` are the instructions of the block from this one on.
    #[inline(always)]
    pub(super) fn word(&mut self, address: u32, ahead: impl Fn() -> u32) -> Result<u32, Trapped> {
        match self.memory.load(address) {
            Some(bytes) => Ok(u32::from_le_bytes(bytes)),
            None => self.elsewhere(address, 4, ahead()),
        }
    }

    #[inline(always)]
    pub(super) fn byte(&mut self, address: u32, ahead: impl Fn() -> u32) -> Result<u32, Trapped> {
        match self.memory.load(address) {
            Some([byte]) => Ok(byte.into()),
            None => self.elsewhere(address, 1, ahead()),
        }
    }

    #[inline(always)]
    fn half(&mut self, address: u32, ahead: impl Fn() -> u32) -> Result<u32, Trapped> {
        match self.memory.load(address) {
            Some(bytes) => Ok(u16::from_le_bytes(bytes).into()),
            None => self.elsewhere(address, 2, ahead()),
        }
    }

    #[inline(always)]
    pub(super) fn load(
        &mut self,
        width: Width,
        address: u32,
        ahead: impl Fn() -> u32,
    ) -> Result<u32, Trapped> {
        match width {
            Width::Word => self.word(address, ahead),
            Width::Half => self.half(address, ahead),
            Width::Byte => self.byte(address, ahead),
            Width::SignedHalf => Ok(i32::from(self.half(address, ahead)? as i16) as u32),
            Width::SignedByte => Ok(i32::from(self.byte(address, ahead)? as i8) as u32),
        }
    }

    /// A load from anything but RAM.
    #[cold]
    #[inline(never)]
    fn elsewhere(&mut self, address: u32, size: usize, ahead: u32) -> Result<u32, Trapped> {
        if let Some(offset) = flash_offset(address) {
            let start = offset as usize;
            if let Some(bytes) = self.chip.flash.image.get(start..start + size) {
                let value = little(bytes);
                if offset >= Map::FLASH_SIZE - RECORDS_SIZE && self.chip.flash.is_damaged() {
                    self.chip.load_flash(offset);
                }
                return Ok(value);
            }
        }
        let read = if is_peripheral(address) {
            self.chip.read(address, size)
        } else if is_system(address) {
            self.chip.core.instructions_ahead = if address & !3 == CYCCNT {
                ahead.into()
            } else {
                0
            };
            self.chip.read_system(address & !3).map(|word| {
                let value = word >> (8 * (address & 3));
                if size == 4 {
                    value
                } else {
                    value & ((1 << (8 * size)) - 1)
                }
            })
        } else if let Some(bytes) = self.memory.system(address, size) {
            Ok(little(bytes))
        } else {
            return Err(self.trap(Trap::Bus {
                address,
                fetch: false,
            }));
        };
        read.map_err(|misuse| self.misuse(misuse))
    }

    fn misuse(&mut self, misuse: Misuse) -> Trapped {
        self.trap(Trap::Misuse(misuse))
    }

    #[inline(always)]
    pub(super) fn store_word(&mut self, address: u32, value: u32) -> Result<(), Trapped> {
        match self.memory.store(address, value.to_le_bytes()) {
            Some(()) => Ok(()),
            None => self.store_elsewhere(address, 4, value),
        }
    }

    #[inline(always)]
    pub(super) fn store(&mut self, width: Width, address: u32, value: u32) -> Result<(), Trapped> {
        let (stored, size) = match width {
            Width::Word => return self.store_word(address, value),
            Width::Half | Width::SignedHalf => {
                (self.memory.store(address, (value as u16).to_le_bytes()), 2)
            }
            Width::Byte | Width::SignedByte => (self.memory.store(address, [value as u8]), 1),
        };
        match stored {
            Some(()) => Ok(()),
            None => self.store_elsewhere(address, size, value & ((1 << (8 * size)) - 1)),
        }
    }

    /// A store to anything but RAM.
    #[cold]
    #[inline(never)]
    fn store_elsewhere(&mut self, address: u32, size: usize, value: u32) -> Result<(), Trapped> {
        let written = if let Some(offset) = flash_offset(address) {
            self.chip.store_flash(offset, size, value);
            Ok(())
        } else if is_peripheral(address) {
            self.chip.write(address, size, value)
        } else if is_system(address) {
            self.chip.write_system(address, size, value)
        } else {
            return Err(self.trap(Trap::Bus {
                address,
                fetch: false,
            }));
        };
        written.map_err(|misuse| self.misuse(misuse))
    }
}

/// A number of up to four bytes, the least significant first.
fn little(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | u32::from(byte))
}
