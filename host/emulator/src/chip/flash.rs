// SPDX-License-Identifier: GPL-2.0-only
//! FLASH: the memory and its controller, with the rules of the chip: keys, erased double words, pages, stalls.

use super::Quirks;
use super::bank::{Bank, Misuse, Register};
use super::ecc::{Ecc, Reading};
use crate::time::{TICKS_PER_US, Ticks};

/// Size of the flash memory.
pub const FLASH_SIZE: usize = 128 * 1024;
/// Erase unit.
pub const PAGE_SIZE: usize = 2048;

const ACR: u32 = 0x00;
const KEYR: u32 = 0x08;
const OPTKEYR: u32 = 0x0C;
const SR: u32 = 0x10;
const CR: u32 = 0x14;
const ECCR: u32 = 0x18;
const OPTR: u32 = 0x20;

const REGISTERS: &[Register] = &[
    (ACR, "ACR", 0x0004_0600),
    (0x04, "PDKEYR", 0),
    (KEYR, "KEYR", 0),
    (OPTKEYR, "OPTKEYR", 0),
    (SR, "SR", 0),
    (CR, "CR", 0xC000_0000),
    (ECCR, "ECCR", 0),
    (OPTR, "OPTR", 0xFFEF_F8AA),
    (0x24, "PCROP1SR", 0xFFFF_FFFF),
    (0x28, "PCROP1ER", 0),
    (0x2C, "WRP1AR", 0x0000_00FF),
    (0x30, "WRP1BR", 0x0000_00FF),
    (0x70, "SEC1R", 0),
];

// SR
const EOP: u32 = 1;
const OPERR: u32 = 1 << 1;
const PROGERR: u32 = 1 << 3;
const WRPERR: u32 = 1 << 4;
const PGAERR: u32 = 1 << 5;
const SIZERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
const BSY: u32 = 1 << 16;
const ERRORS: u32 = 0xC3FA;
// CR
const PG: u32 = 1;
const PER: u32 = 1 << 1;
const MER: u32 = 1 << 2;
const STRT: u32 = 1 << 16;
const EOPIE: u32 = 1 << 24;
const ERRIE: u32 = 1 << 25;
const LOCK: u32 = 1 << 31;
// ECCR
const ECCIE: u32 = 1 << 24;
const ECCC: u32 = 1 << 30;
const ECCD: u32 = 1 << 31;

/// Typical times of the data sheet.
const PROGRAM: Ticks = 82 * TICKS_PER_US;
const ERASE: Ticks = 22_020 * TICKS_PER_US;

/// State that a power cut leaves of the interrupted operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PowerCut {
    /// The operation had not begun.
    Before,
    /// A double word with some of its bits programmed, a page with some of its bits erased.
    During,
    /// The operation had just ended.
    After,
}

/// One operation on the flash memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// A double word at this offset.
    Program(u32),
    /// The page with this number.
    Erase(u32),
}

/// The memory and its controller.
#[derive(Debug)]
pub(crate) struct Flash {
    bank: Bank,
    quirks: Quirks,
    /// Contents.
    pub(crate) image: Vec<u8>,
    /// Ranges changed since the core's view was last refreshed.
    pub(crate) changed: Vec<(usize, usize)>,
    ecc: Ecc,
    keys: u8,
    /// First half of a double word being written.
    half: Option<(u32, u32)>,
    busy_until: Ticks,
    /// Operations carried out since power-on of the emulator.
    pub(crate) operations: Vec<Operation>,
    /// Index of the operation at which the power fails, and the state that it leaves.
    pub(crate) cut: Option<(usize, PowerCut)>,
    /// The cut has happened.
    pub(crate) power_lost: bool,
    /// On the chip a write against the controller's rules raises a bus fault; here it sets an error flag.
    locked_until_reset: bool,
}

impl Flash {
    pub(crate) fn new(image: Vec<u8>, quirks: Quirks) -> Self {
        Self {
            bank: Bank::new("FLASH", REGISTERS),
            quirks,
            image,
            changed: Vec::new(),
            ecc: Ecc::default(),
            keys: 0,
            half: None,
            busy_until: 0,
            operations: Vec::new(),
            cut: None,
            power_lost: false,
            locked_until_reset: false,
        }
    }

    pub(crate) fn reset(&mut self) {
        self.bank.reset();
        if self.quirks.stale_flash_flags {
            self.bank[SR] = PGSERR;
        }
        self.keys = 0;
        self.half = None;
        self.busy_until = 0;
        self.locked_until_reset = false;
    }

    /// Whether an uncorrectable error is not acknowledged yet.
    pub(crate) fn double_error(&self) -> bool {
        self.bank[ECCR] & ECCD != 0
    }

    /// Flash wait states.
    pub(crate) fn latency(&self) -> u32 {
        self.bank[ACR] & 0xF
    }

    pub(crate) fn read(&self, offset: u32, now: Ticks) -> Result<u32, Misuse> {
        let value = self.bank.read(offset)?;
        Ok(match offset {
            SR if now < self.busy_until => value | BSY,
            KEYR | OPTKEYR | 0x04 => 0,
            _ => value,
        })
    }

    /// Returns how long the core stalls if it runs from flash.
    pub(crate) fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<Ticks, Misuse> {
        match offset {
            KEYR => self.key(value),
            OPTKEYR => {
                return Err(self
                    .bank
                    .unsupported(offset, value, "option bytes are not modelled"));
            }
            SR => self.bank[SR] &= !(value & (ERRORS | EOP)),
            CR => return self.control(value, now),
            ECCR => {
                let flags = self.bank[ECCR] & (ECCC | ECCD) & !value;
                self.bank[ECCR] = self.bank[ECCR] & !(ECCC | ECCD | ECCIE) | flags | value & ECCIE;
            }
            _ => self.bank.write(offset, value)?,
        }
        Ok(0)
    }

    fn key(&mut self, value: u32) {
        match (self.keys, value) {
            (0, 0x4567_0123) => self.keys = 1,
            (1, 0xCDEF_89AB) if !self.locked_until_reset => {
                self.bank[CR] &= !LOCK;
                self.keys = 0;
            }
            // A wrong key locks the controller until the next reset.
            _ => self.locked_until_reset = true,
        }
    }

    fn control(&mut self, value: u32, now: Ticks) -> Result<Ticks, Misuse> {
        let old = self.bank[CR];
        if value & LOCK != 0 {
            self.bank[CR] |= LOCK;
            self.keys = 0;
        }
        if old & LOCK != 0 {
            return Ok(0);
        }
        if now < self.busy_until {
            return Err(self
                .bank
                .unsupported(CR, value, "written while an operation is running"));
        }
        self.bank[CR] = value & !STRT;
        if value & PG == 0 {
            self.half = None;
        }
        if value & STRT == 0 {
            return Ok(0);
        }
        if value & MER != 0 {
            return Err(self.bank.unsupported(
                CR,
                value,
                "a mass erase would erase the running firmware",
            ));
        }
        // Error flags that are still set prevent the next operation.
        if value & PER == 0 || value & PG != 0 || self.bank[SR] & ERRORS != 0 {
            self.bank[SR] |= PGSERR;
            return Ok(0);
        }
        let page = value >> 3 & 0x7F;
        if page as usize >= FLASH_SIZE / PAGE_SIZE {
            return Err(self.bank.unsupported(CR, value, "no such page"));
        }
        if self.protected(page) {
            self.bank[SR] |= WRPERR | OPERR;
            return Ok(0);
        }
        let start = page as usize * PAGE_SIZE;
        self.perform(Operation::Erase(page), start, &[0xFF; PAGE_SIZE]);
        self.busy_until = now + ERASE;
        Ok(ERASE)
    }

    fn protected(&self, page: u32) -> bool {
        [0x2C, 0x30].iter().any(|&register| {
            let (first, last) = (self.bank[register] & 0x7F, self.bank[register] >> 16 & 0x7F);
            (first..=last).contains(&page)
        })
    }

    /// A store of the core into the flash's address range. Returns how long the core stalls.
    pub(crate) fn store(&mut self, offset: u32, size: usize, value: u32, now: Ticks) -> Ticks {
        // The engine has already written there, so the core's view must be refreshed in any case.
        self.changed.push((offset as usize & !7, 8));
        let flags = if self.bank[CR] & (LOCK | PG) != PG || self.bank[SR] & ERRORS != 0 {
            PGSERR
        } else if size != 4 {
            SIZERR
        } else if !offset.is_multiple_of(4) {
            PGAERR
        } else if self.protected(offset / PAGE_SIZE as u32) {
            WRPERR
        } else {
            0
        };
        if flags != 0 {
            self.bank[SR] |= flags | OPERR;
            return 0;
        }
        match self.half.take() {
            None if offset.is_multiple_of(8) => {
                self.half = Some((offset, value));
                0
            }
            Some((low_offset, low)) if offset == low_offset + 4 => {
                self.program(low_offset, low, value, now)
            }
            _ => {
                self.bank[SR] |= PGAERR | OPERR;
                0
            }
        }
    }

    fn program(&mut self, offset: u32, low: u32, high: u32, now: Ticks) -> Ticks {
        let start = offset as usize;
        let mut data = [0; 8];
        data[..4].copy_from_slice(&low.to_le_bytes());
        data[4..].copy_from_slice(&high.to_le_bytes());
        let erased = self.image[start..start + 8]
            .iter()
            .all(|&byte| byte == 0xFF);
        // Because of the error-correcting code only zero may be written over old data.
        if !erased && data != [0; 8] {
            self.bank[SR] |= PROGERR | OPERR;
            return 0;
        }
        self.perform(Operation::Program(offset), start, &data);
        self.busy_until = now + PROGRAM;
        PROGRAM
    }

    /// Carries out one operation, unless the power fails at this one.
    fn perform(&mut self, operation: Operation, start: usize, data: &[u8]) {
        let index = self.operations.len();
        self.operations.push(operation);
        self.changed.push((start, data.len()));
        let cut = self.cut.filter(|&(at, _)| at == index).map(|(_, cut)| cut);
        self.power_lost |= cut.is_some();
        if cut == Some(PowerCut::Before) {
            return;
        }
        for (position, (cell, &new)) in self.image[start..].iter_mut().zip(data).enumerate() {
            let double_word = (start + position) as u32 & !7;
            if cut == Some(PowerCut::During) {
                // About half of the changing bits reach their value, in a fixed pattern.
                let reached = scramble(index as u64, position as u64);
                *cell = match operation {
                    Operation::Program(_) => *cell & (new | !reached),
                    Operation::Erase(_) => *cell | reached,
                };
                self.ecc.spoil(double_word);
            } else {
                *cell = new;
                self.ecc.renew(double_word);
            }
        }
        self.bank[SR] |= if self.bank[CR] & EOPIE != 0 { EOP } else { 0 };
    }

    /// Flips one bit, as wear or radiation would.
    pub(crate) fn flip(&mut self, bit: usize) {
        let double_word = bit / 64 * 8;
        if double_word + 8 > self.image.len() {
            return;
        }
        for wrong in self.ecc.flip(double_word as u32, (bit % 64) as u32) {
            self.image[double_word + wrong as usize / 8] ^= 1 << (wrong % 8);
        }
        self.changed.push((double_word, 8));
    }

    /// A load of the core from this offset; true if it raises a non-maskable interrupt.
    pub(crate) fn load(&mut self, offset: u32) -> bool {
        let double_word = offset & !7;
        let flag = match self.ecc.read(double_word) {
            Reading::Good => return false,
            Reading::Corrected => ECCC,
            Reading::Bad => ECCD,
        };
        // The first error keeps its address until it is acknowledged.
        if self.bank[ECCR] & (ECCC | ECCD) == 0 {
            let address = if self.quirks.wrong_ecc_address {
                0
            } else {
                double_word
            };
            self.bank[ECCR] = self.bank[ECCR] & ECCIE | address | flag;
        }
        flag == ECCD
    }

    /// A halfword at an address of the core; `None` if it is not in flash.
    pub(crate) fn halfword(&self, address: u32) -> Option<u16> {
        let start = address.checked_sub(crate::cortex::Map::FLASH)? as usize;
        let bytes = self.image.get(start..start + 2)?;
        Some(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    /// Whether any double word has a wrong bit.
    pub(crate) fn is_damaged(&self) -> bool {
        self.ecc.any()
    }

    pub(crate) fn next_event(&self, now: Ticks) -> Option<Ticks> {
        (self.busy_until > now).then_some(self.busy_until)
    }

    pub(crate) fn interrupt(&self) -> bool {
        let (status, control) = (self.bank[SR], self.bank[CR]);
        status & EOP != 0 && control & EOPIE != 0 || status & OPERR != 0 && control & ERRIE != 0
    }
}

/// A fixed hash that selects the bits which an interrupted operation has changed.
fn scramble(a: u64, b: u64) -> u8 {
    let mut x = a.wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ b.wrapping_add(1).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 29;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    (x >> 56) as u8
}

#[cfg(test)]
mod tests;
