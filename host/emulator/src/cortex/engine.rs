// SPDX-License-Identifier: GPL-2.0-only
//! The instruction engine with its memories; hides its callbacks from the rest of the crate.

use unicorn_engine::{Arch, ArmCpuModel, Mode, Prot, RegisterARM, Unicorn, uc_error};

use super::block_hook::{self, BlockHook};
use super::debug::Breakpoints;
use super::decode;
use super::hooks;
use super::memory::Ram;
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

/// The engine and the data of its callbacks.
pub(crate) struct Engine {
    pub(super) uc: Unicorn<'static, Chip>,
    /// Dropped after the engine, which holds a pointer to it.
    _block_hook: Box<BlockHook>,
    /// Dropped after the engine, which holds a pointer into it.
    ram: Ram,
    /// Whether loads from the records are hooked, because some of them are damaged.
    watches_records: bool,
    pub(super) breakpoints: Breakpoints,
}

impl Engine {
    pub(crate) fn new(chip: Chip) -> Result<Self, uc_error> {
        let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, chip)?;
        uc.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        // The CCM SRAM's size is no multiple of the default page.
        uc.ctl_set_page_size(1024)?;
        let ram = Ram::new();
        ram.map(&mut uc)?;
        let code = Prot::READ | Prot::EXEC;
        uc.mem_map(0, Map::FLASH_SIZE.into(), code)?;
        uc.mem_map(Map::FLASH.into(), Map::FLASH_SIZE.into(), code)?;
        uc.mem_map(Map::SYSTEM.into(), Map::SYSTEM_SIZE.into(), Prot::READ)?;
        // Unique identity and flash size in KiB.
        uc.mem_write(0x1FFF_7590, b"EMULATED\0\0\0\0")?;
        uc.mem_write(0x1FFF_75E0, &128u16.to_le_bytes())?;
        hooks::install(&mut uc, &ram)?;
        let block_hook = BlockHook::install(&uc)?;
        let mut engine = Self {
            uc,
            _block_hook: block_hook,
            ram,
            watches_records: false,
            breakpoints: Breakpoints::default(),
        };
        engine.refresh_flash()?;
        Ok(engine)
    }

    /// Makes CYCCNT count executed instructions exactly, at the price of slower loads.
    pub(crate) fn count_instructions(&mut self) -> Result<(), uc_error> {
        self.chip_mut().core.count_instructions = true;
        hooks::count_instructions(&mut self.uc)
    }

    pub(crate) fn chip(&self) -> &Chip {
        self.uc.get_data()
    }

    pub(crate) fn chip_mut(&mut self) -> &mut Chip {
        self.uc.get_data_mut()
    }

    /// Runs from the program counter until something is due.
    pub(crate) fn run(&mut self) -> Result<Exit, uc_error> {
        let pc = self.register(RegisterARM::PC)?;
        let result = self.uc.emu_start(u64::from(pc | 1), 0, 0, 0);
        if let Some(trap) = self.chip_mut().core.trap.take() {
            if matches!(trap, Trap::Bus { .. } | Trap::Undefined | Trap::Held { .. }) {
                self.refund()?;
            }
            return Ok(Exit::Trap(trap));
        }
        if result == Err(uc_error::FETCH_PROT) {
            return Ok(Exit::Trap(Trap::Misuse(Misuse::CodeInRam {
                address: self.register(RegisterARM::PC)?,
            })));
        }
        result?;
        let pc = self.register(RegisterARM::PC)?;
        Ok(match self.halfword(pc.wrapping_sub(2)) {
            Some(decode::WFI) if pc != self.chip().core.block_address => Exit::WaitForInterrupt,
            _ => Exit::Due,
        })
    }

    /// Subtracts the instructions of a block that a fault or a breakpoint interrupted.
    fn refund(&mut self) -> Result<(), uc_error> {
        let pc = self.register(RegisterARM::PC)?;
        let core = &self.chip().core;
        let (start, size) = (core.block_address, core.block_size);
        let Some(code) = self.read(start, size as usize) else {
            return Ok(());
        };
        let executed = pc.wrapping_sub(start).min(size) as usize;
        let refund = decode::count(&code) - decode::count(&code[..executed]);
        self.chip_mut().core.account.refund(refund);
        Ok(())
    }

    pub(crate) fn register(&self, register: RegisterARM) -> Result<u32, uc_error> {
        self.uc.reg_read(register).map(|value| value as u32)
    }

    pub(crate) fn set_register(
        &mut self,
        register: RegisterARM,
        value: u32,
    ) -> Result<(), uc_error> {
        self.uc.reg_write(register, value.into())
    }

    pub(super) fn wide_register(&self, register: RegisterARM) -> Result<u64, uc_error> {
        self.uc.reg_read(register)
    }

    pub(super) fn set_wide_register(
        &mut self,
        register: RegisterARM,
        value: u64,
    ) -> Result<(), uc_error> {
        self.uc.reg_write(register, value)
    }

    /// Memory as the core sees it; `None` if part of it is not there.
    pub(crate) fn read(&self, address: u32, size: usize) -> Option<Vec<u8>> {
        let mut bytes = vec![0; size];
        self.read_into(address, &mut bytes)?;
        Some(bytes)
    }

    pub(super) fn read_into(&self, address: u32, bytes: &mut [u8]) -> Option<()> {
        match self.ram.read(address, bytes) {
            Some(()) => Some(()),
            None => self.uc.mem_read(address.into(), bytes).ok(),
        }
    }

    pub(crate) fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read_into(address, &mut bytes)?;
        Some(u32::from_le_bytes(bytes))
    }

    fn halfword(&self, address: u32) -> Option<u16> {
        if let Some(code) = self.chip().flash.halfword(address) {
            return Some(code);
        }
        let mut bytes = [0; 2];
        self.read_into(address, &mut bytes)?;
        Some(u16::from_le_bytes(bytes))
    }

    /// Writes RAM as a debugger would. False if it is not RAM.
    pub(crate) fn write(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.ram.write(address, bytes).is_some()
    }

    /// Fills the RAM with `byte`, code included.
    pub(crate) fn forget_ram(&mut self, byte: u8) -> Result<(), uc_error> {
        self.write(Map::RAM, &vec![byte; Map::RAM_SIZE as usize]);
        self.chip_mut().core.blocks.change_ccm();
        self.refresh_changed()
    }

    /// Copies the whole flash into the core's memory.
    fn refresh_flash(&mut self) -> Result<(), uc_error> {
        let image = self.chip().flash.image.clone();
        self.uc.mem_write(0, &image)?;
        self.uc.mem_write(Map::FLASH.into(), &image)
    }

    /// Copies changes of the flash controller into the core's memory, and applies changes of code.
    pub(crate) fn refresh_changed(&mut self) -> Result<(), uc_error> {
        if !self.watches_records && self.chip().flash.is_damaged() {
            self.watches_records = true;
            hooks::watch_records(&mut self.uc)?;
        }
        if self.chip_mut().core.blocks.forget_stale() {
            self.uc.ctl_flush_tb()?;
        }
        for (start, length) in std::mem::take(&mut self.chip_mut().flash.changed) {
            let bytes = self.chip().flash.image[start..start + length].to_vec();
            self.uc.mem_write(start as u64, &bytes)?;
            self.uc
                .mem_write(u64::from(Map::FLASH) + start as u64, &bytes)?;
        }
        Ok(())
    }

    /// Watches a function from now on; see [`Account::watch`](super::account::Account::watch).
    pub(crate) fn watch(&mut self, address: u32, name: String, apart: bool) {
        let core = &mut self.chip_mut().core;
        let number = core.account.watch(name, apart);
        if let Some(slot) = core.blocks.slot(address & !1) {
            slot.watch = number;
        }
    }

    /// The exception to take now, if any.
    pub(crate) fn takes(&self) -> Option<u16> {
        let candidate = self.chip().core.nvic.candidate()?;
        block_hook::takes_exception(&self.uc).then_some(candidate.0)
    }
}
