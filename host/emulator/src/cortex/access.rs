// SPDX-License-Identifier: GPL-2.0-only
//! Loads and stores of the core.

use super::Trap;
use super::debug::Breakpoints;
use super::execute::At;
use super::memory::{Memory, PROGRAM_SIZE, flash_offset};
use super::op::Width;
use super::state::Registers;
use crate::chip::{Chip, Misuse};

const CYCCNT: u32 = 0xE000_1004;

/// The instruction ends with the trap that the chip's core holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trapped;

/// What an instruction works on.
pub(super) struct Bus {
    pub(super) registers: Registers,
    pub(super) memory: Memory,
    pub(super) chip: Chip,
    pub(super) breakpoints: Breakpoints,
}

/// Whether an address belongs to a peripheral.
fn is_peripheral(address: u32) -> bool {
    matches!(address, 0x4000_0000..0x4003_0000 | 0x4800_0000..0x4800_2000 | 0x5000_0000..0x5007_0000)
}

/// Whether an address belongs to a peripheral of the core.
fn is_system(address: u32) -> bool {
    matches!(address, 0xE000_0000..0xE010_0000)
}

impl Bus {
    pub(super) fn new(chip: Chip) -> Self {
        Self {
            registers: Registers::new(),
            memory: Memory::new(),
            chip,
            breakpoints: Breakpoints::default(),
        }
    }

    pub(super) fn trap(&mut self, trap: Trap) -> Trapped {
        self.chip.core.trap.get_or_insert(trap);
        Trapped
    }

    /// Whether something may be due before the next stretch.
    #[inline(always)]
    pub(super) fn pauses(&self) -> bool {
        let chip = &self.chip;
        chip.now >= chip.deadline || self.memory.code_changed || chip.core.attention
    }

    /// Bytes of the RAM or the program.
    #[inline(always)]
    pub(super) fn known<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        if let Some(bytes) = self.memory.load(address) {
            return Some(bytes);
        }
        let offset = flash_offset(address)?;
        if offset > PROGRAM_SIZE - N as u32 {
            return None;
        }
        let image = &self.chip.flash.image;
        image.get(offset as usize..)?.first_chunk().copied()
    }

    /// Loads a word, at this place of the block.
    #[inline(always)]
    pub(super) fn word(&mut self, address: u32, at: At<'_>) -> Result<u32, Trapped> {
        match self.known(address) {
            Some(bytes) => Ok(u32::from_le_bytes(bytes)),
            None => self.elsewhere(address, 4, at.ahead()),
        }
    }

    #[inline(always)]
    pub(super) fn byte(&mut self, address: u32, at: At<'_>) -> Result<u32, Trapped> {
        match self.known(address) {
            Some([byte]) => Ok(byte.into()),
            None => self.elsewhere(address, 1, at.ahead()),
        }
    }

    #[inline(always)]
    fn half(&mut self, address: u32, at: At<'_>) -> Result<u32, Trapped> {
        match self.known(address) {
            Some(bytes) => Ok(u16::from_le_bytes(bytes).into()),
            None => self.elsewhere(address, 2, at.ahead()),
        }
    }

    #[inline(always)]
    pub(super) fn load(&mut self, width: Width, address: u32, at: At<'_>) -> Result<u32, Trapped> {
        match width {
            Width::Word => self.word(address, at),
            Width::Half => self.half(address, at),
            Width::Byte => self.byte(address, at),
            Width::SignedHalf => Ok(i32::from(self.half(address, at)? as i16) as u32),
            Width::SignedByte => Ok(i32::from(self.byte(address, at)? as i8) as u32),
        }
    }

    /// A load from anything but RAM and the program.
    #[cold]
    #[inline(never)]
    fn elsewhere(&mut self, address: u32, size: usize, ahead: u32) -> Result<u32, Trapped> {
        self.chip.core.attention = true;
        if let Some(offset) = flash_offset(address) {
            let start = offset as usize;
            if let Some(bytes) = self.chip.flash.image.get(start..start + size) {
                let value = little(bytes);
                if offset >= PROGRAM_SIZE && self.chip.flash.is_damaged() {
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
        self.chip.core.attention = true;
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
