// SPDX-License-Identifier: GPL-2.0-only
//! The core with its memories: runs translated blocks from one event to the next.

use super::access::Bus;
use super::blocks::Blocks;
use super::execute::Ended;
use super::memory::flash_offset;
use super::state::Registers;
use super::translate::{Code, How, NoCode, translate};
use super::{Map, Trap};
use crate::chip::{Chip, Misuse};

/// Why the engine stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// A deadline, or an exception to take.
    Due,
    WaitForInterrupt,
    Trap(Trap),
}

/// The core, its memories and the chip around it.
pub(crate) struct Engine {
    pub(super) bus: Bus,
    blocks: Blocks,
    /// Blocks of one stretch with an operation for every instruction, for breakpoints and steps.
    steps: Blocks,
}

impl Engine {
    pub(crate) fn new(chip: Chip) -> Self {
        Self {
            bus: Bus::new(chip),
            blocks: Blocks::new(),
            steps: Blocks::new(),
        }
    }

    /// Makes CYCCNT count executed instructions exactly.
    pub(crate) fn count_instructions(&mut self) {
        self.bus.chip.core.count_instructions = true;
    }

    pub(crate) fn chip(&self) -> &Chip {
        &self.bus.chip
    }

    pub(crate) fn chip_mut(&mut self) -> &mut Chip {
        &mut self.bus.chip
    }

    pub(crate) fn registers(&self) -> &Registers {
        &self.bus.registers
    }

    /// Runs from the program counter until something is due.
    pub(crate) fn run(&mut self) -> Exit {
        self.bus.chip.core.attention = true;
        if self.is_watched() {
            self.blocks_until_due::<true>()
        } else {
            self.blocks_until_due::<false>()
        }
    }

    /// The same; with `HELD` the core looks at every instruction. Twice, so that the frequent one is compact.
    #[inline(never)]
    fn blocks_until_due<const HELD: bool>(&mut self) -> Exit {
        loop {
            let (pc, it) = (self.bus.registers.pc, self.bus.registers.it);
            self.bus.chip.core.block_address = pc;
            if self.stops() {
                break;
            }
            let blocks = if HELD { &self.steps } else { &self.blocks };
            let Some(code) = blocks.find(pc, it) else {
                match self.translate(HELD) {
                    Ok(()) => continue,
                    Err(trap) => return Exit::Trap(trap),
                }
            };
            follow_calls(&mut self.bus.chip, &self.bus.registers, code);
            let ended = self.bus.execute(code);
            if HELD {
                self.bus.chip.core.resumed.leave();
            }
            match ended {
                Ended::Next => {}
                Ended::WaitForInterrupt => return Exit::WaitForInterrupt,
                Ended::Trap => break,
            }
        }
        match self.bus.chip.core.trap.take() {
            Some(trap) => Exit::Trap(trap),
            None => Exit::Due,
        }
    }

    /// Whether something is due before the next block.
    #[inline(always)]
    fn stops(&mut self) -> bool {
        let chip = &self.bus.chip;
        chip.now >= chip.deadline
            || self.bus.memory.code_changed
            || chip.core.attention && self.stops_for_more()
    }

    /// Whether what the last blocks did with peripherals or masks stops the core.
    fn stops_for_more(&mut self) -> bool {
        let chip = &self.bus.chip;
        let stops = chip
            .core
            .nvic
            .candidate()
            .is_some_and(|(_, priority)| self.allows(priority))
            || chip.core.trap.is_some()
            || chip.reset_request.is_some()
            || !chip.flash.changed.is_empty();
        self.bus.chip.core.attention = stops;
        stops
    }

    /// Whether the mask registers allow an exception of this priority.
    fn allows(&self, priority: i16) -> bool {
        let registers = &self.bus.registers;
        let base = i16::from(registers.basepri);
        let masked = registers.faultmask && priority >= -1
            || registers.primask && priority >= 0
            || base != 0 && priority >= base;
        !masked
    }

    /// Translates the block at the program counter.
    fn translate(&mut self, steps: bool) -> Result<(), Trap> {
        let (pc, it) = (self.bus.registers.pc, self.bus.registers.it);
        let fetch = |address| self.fetch(address);
        let how = match steps {
            true => How::Steps,
            false if self.blocks.watches() => How::Single,
            false => How::Joined,
        };
        let code = translate(pc, it, how, &fetch).map_err(|NoCode { address }| {
            if address.wrapping_sub(Map::RAM) < Map::RAM_SIZE
                || self.bus.memory.system(address, 2).is_some()
            {
                Trap::Misuse(Misuse::CodeInRam { address })
            } else {
                Trap::Bus {
                    address,
                    fetch: true,
                }
            }
        })?;
        if code.start.wrapping_sub(Map::CCM) < Map::CCM_SIZE {
            let (from, to) = code.taken;
            self.bus.memory.holds_code(from, to);
        }
        (if steps {
            &mut self.steps
        } else {
            &mut self.blocks
        })
        .keep(code, it);
        Ok(())
    }

    /// A halfword of code: from flash or CCM SRAM.
    fn fetch(&self, address: u32) -> Option<u16> {
        if let Some(offset) = flash_offset(address) {
            return self.bus.chip.flash.halfword(Map::FLASH + offset);
        }
        let in_ccm = address.wrapping_sub(Map::CCM) < Map::CCM_SIZE;
        in_ccm.then(|| self.bus.memory.load(address).map(u16::from_le_bytes))?
    }

    /// Memory as the core sees it; `None` if part of it is not there.
    pub(crate) fn read(&self, address: u32, size: usize) -> Option<Vec<u8>> {
        let mut bytes = vec![0; size];
        self.read_into(address, &mut bytes)?;
        Some(bytes)
    }

    pub(super) fn read_into(&self, address: u32, bytes: &mut [u8]) -> Option<()> {
        if self.bus.memory.read(address, bytes).is_some() {
            return Some(());
        }
        let found = match flash_offset(address) {
            Some(offset) => {
                let start = offset as usize;
                self.bus
                    .chip
                    .flash
                    .image
                    .get(start..start.checked_add(bytes.len())?)
            }
            None => self.bus.memory.system(address, bytes.len()),
        };
        bytes.copy_from_slice(found?);
        Some(())
    }

    pub(crate) fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read_into(address, &mut bytes)?;
        Some(u32::from_le_bytes(bytes))
    }

    /// Writes RAM as a debugger would. False if it is not RAM.
    pub(crate) fn write(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.bus.memory.write(address, bytes).is_some()
    }

    /// Fills the RAM with `byte`, code included.
    pub(crate) fn forget_ram(&mut self, byte: u8) {
        self.write(Map::RAM, &vec![byte; Map::RAM_SIZE as usize]);
        self.refresh_changed();
    }

    /// Drops translated code that has changed.
    pub(crate) fn refresh_changed(&mut self) {
        if self.bus.memory.code_changed {
            self.bus.memory.forget_code();
            self.blocks.forget_ccm();
            self.steps.forget_ccm();
        }
        for (start, length) in std::mem::take(&mut self.bus.chip.flash.changed) {
            self.blocks.forget_flash(start, length);
            self.steps.forget_flash(start, length);
        }
    }

    /// Watches a function from now on; see [`Account::watch`](super::account::Account::watch).
    pub(crate) fn watch(&mut self, address: u32, name: String, apart: bool) {
        let number = self.bus.chip.core.account.watch(name, apart);
        for blocks in [&mut self.blocks, &mut self.steps] {
            blocks.watch(address & !1, number);
        }
    }

    /// The exception to take now, if any.
    pub(crate) fn takes(&self) -> Option<u16> {
        let (exception, priority) = self.bus.chip.core.nvic.candidate()?;
        self.allows(priority).then_some(exception)
    }
}

/// Notes returns from watched functions and calls of them before a block runs.
#[inline(always)]
fn follow_calls(chip: &mut Chip, registers: &Registers, code: &Code) {
    let account = &mut chip.core.account;
    let (link, stack) = (registers.r[14], registers.r[13]);
    if account.awaited_return() == Some(code.start) {
        account.returned(stack);
    }
    if code.cost.watch != 0 {
        account.call(code.cost.watch, link, stack);
    }
}
