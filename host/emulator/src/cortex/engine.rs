// SPDX-License-Identifier: GPL-2.0-only
//! The instruction engine with its memories and hooks, wrapped so that the rest of the crate sees no callback.

use unicorn_engine::{
    Arch, ArmCpuModel, HookType, MemType, Mode, Prot, RegisterARM, TlbEntry, TlbType, Unicorn,
    uc_error,
};

use super::decode::{self, Block, Memory};
use super::memory::Ram;
use super::{Map, Trap};
use crate::chip::{Chip, Misuse};
use crate::time::CYCLES_PER_INSTRUCTION;

/// Last pages of the flash, where a firmware keeps records and where damaged double words are looked for.
const RECORDS_SIZE: u32 = 16 * 1024;

type Uc<'a> = Unicorn<'a, Chip>;

/// Why the engine came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// A deadline, or an exception to take.
    Due,
    WaitForInterrupt,
    Trap(Trap),
}

/// The engine and everything it calls back into.
pub(crate) struct Engine {
    uc: Uc<'static>,
    /// Dropped after the engine, which holds a pointer into it.
    ram: Ram,
    /// Loads from the records are looked at, because some of them are damaged.
    watches_records: bool,
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
        for (base, size) in [
            (0x4000_0000, 0x0003_0000),
            (0x4800_0000, 0x2000),
            (0x5000_0000, 0x0007_0000),
        ] {
            uc.mmio_map(
                base,
                size,
                Some(move |uc: &mut Uc<'_>, offset, bytes| {
                    load(uc, (base + offset) as u32, bytes, Chip::read)
                }),
                Some(move |uc: &mut Uc<'_>, offset, bytes, value| {
                    store(uc, (base + offset) as u32, bytes, value, Chip::write);
                }),
            )?;
        }
        let base = 0xE000_0000;
        uc.mmio_map(
            base,
            0x0010_0000,
            Some(move |uc: &mut Uc<'_>, offset, bytes| {
                load(uc, (base + offset) as u32, bytes, |chip, address, size| {
                    let word = chip.read_system(address & !3)? >> (8 * (address & 3));
                    Ok(if size >= 4 {
                        word
                    } else {
                        word & ((1 << (8 * size)) - 1)
                    })
                })
            }),
            Some(move |uc: &mut Uc<'_>, offset, bytes, value| {
                store(uc, (base + offset) as u32, bytes, value, Chip::write_system);
            }),
        )?;
        // The processor's own map lets code run in the RAM, and the engine then checks every store there for changed code.
        // In this one the RAM holds data; what is mapped elsewhere is allowed and refused by the memories themselves.
        uc.ctl_set_tlb_type(TlbType::VIRTUAL)?;
        uc.add_tlb_hook(0, u32::MAX.into(), |uc: &mut Uc<'_>, page, kind| {
            let fetch = kind == MemType::FETCH;
            // Between two blocks the state is the core's own.
            if !fetch {
                forget_it_state(uc);
            }
            let page_of_ram = (page as u32).wrapping_sub(Map::RAM) < Map::RAM_SIZE;
            let data = page_of_ram && !fetch;
            let perms = if data {
                Prot::READ | Prot::WRITE
            } else {
                Prot::ALL
            };
            Some(TlbEntry { paddr: page, perms })
        })?;
        uc.add_block_hook(1, 0, on_block)?;
        uc.add_intr_hook(on_interrupt)?;
        uc.add_insn_invalid_hook(on_invalid)?;
        // Hooks must not cover the RAM: a store to a page with a hook is slow.
        let (ccm_end, ram_end) = (Map::CCM + Map::CCM_SIZE, Map::RAM + Map::RAM_SIZE);
        for (from, to) in [
            (0, Map::CCM - 1),
            (ccm_end, Map::RAM - 1),
            (ram_end, u32::MAX),
        ] {
            let (from, to) = (from.into(), to.into());
            uc.add_mem_hook(
                HookType::MEM_UNMAPPED,
                from,
                to,
                |uc: &mut Uc<'_>, kind, address, _, _| {
                    let fetch = kind == MemType::FETCH_UNMAPPED;
                    if !fetch {
                        forget_it_state(uc);
                    }
                    trap(
                        uc,
                        Trap::Bus {
                            address: address as u32,
                            fetch,
                        },
                    );
                    false
                },
            )?;
        }
        for base in [0, Map::FLASH] {
            let (from, to) = (base.into(), (base + Map::FLASH_SIZE - 1).into());
            uc.add_mem_hook(
                HookType::MEM_WRITE_PROT,
                from,
                to,
                move |uc: &mut Uc<'_>, _, address, size, value| {
                    forget_it_state(uc);
                    uc.get_data_mut()
                        .store_flash(address as u32 - base, size, value as u32);
                    true
                },
            )?;
        }
        let code = ram.clone();
        // What the engine and the books keep of code must follow its changes. Only the firmware's start stores here, so
        // that stores may be as slow as refused ones; a hook of stores would make those to every address slow.
        let (from, to) = (Map::CCM.into(), (ccm_end - 1).into());
        uc.add_mem_hook(
            HookType::MEM_WRITE_PROT,
            from,
            to,
            move |uc: &mut Uc<'_>, _, address, size, value| {
                forget_it_state(uc);
                uc.get_data_mut().core.blocks.change_ccm();
                let bytes = value.to_le_bytes();
                // A store of the core is never wider than these, and the hook's range is RAM.
                let _ = code.write(address as u32, &bytes[..size.min(bytes.len())]);
                true
            },
        )?;
        let mut engine = Self {
            uc,
            ram,
            watches_records: false,
        };
        engine.refresh_flash()?;
        Ok(engine)
    }

    /// From now on, loads of damaged double words of the records are noticed. With a hook of loads all of them are slow,
    /// wherever they go: only a flash that has been damaged is worth that.
    fn watch_records(&mut self) -> Result<(), uc_error> {
        self.watches_records = true;
        let records = Map::FLASH + Map::FLASH_SIZE - RECORDS_SIZE;
        let (from, to) = (records.into(), (records + RECORDS_SIZE - 1).into());
        self.uc.add_mem_hook(
            HookType::MEM_READ,
            from,
            to,
            |uc: &mut Uc<'_>, _, address, _, _| {
                forget_it_state(uc);
                uc.get_data_mut().load_flash(address as u32 - Map::FLASH);
                true
            },
        )?;
        // What was translated before does not call it.
        self.uc.ctl_flush_tb()
    }

    /// Makes CYCCNT count executed instructions exactly, at the price of slower loads.
    pub(crate) fn count_instructions(&mut self) -> Result<(), uc_error> {
        self.chip_mut().core.count_instructions = true;
        // The mere presence of the hook makes the engine keep the program counter exact at loads.
        let cyccnt = 0xE000_1004;
        self.uc.add_mem_hook(
            HookType::MEM_READ,
            cyccnt,
            cyccnt + 3,
            |uc: &mut Uc<'_>, _, _, _, _| {
                forget_it_state(uc);
                let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0) as u32;
                let core = &uc.get_data().core;
                let (start, size) = (core.block_address, core.block_size);
                let before = pc.wrapping_sub(start).min(size) as usize;
                let mut code = vec![0; size as usize];
                let ahead = match uc.mem_read(start.into(), &mut code) {
                    Ok(()) => decode::count(&code) - decode::count(&code[..before]),
                    Err(_) => 0,
                };
                uc.get_data_mut().core.instructions_ahead = ahead.into();
                true
            },
        )?;
        Ok(())
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
            if matches!(trap, Trap::Bus { .. } | Trap::Undefined) {
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

    /// Takes back the instructions of a block that a fault cut short.
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

    /// Shows the core the whole flash.
    fn refresh_flash(&mut self) -> Result<(), uc_error> {
        let image = self.chip().flash.image.clone();
        self.uc.mem_write(0, &image)?;
        self.uc.mem_write(Map::FLASH.into(), &image)
    }

    /// Shows the core what the flash controller changed, and what was stored where code runs.
    pub(crate) fn refresh_changed(&mut self) -> Result<(), uc_error> {
        if !self.watches_records && self.chip().flash.is_damaged() {
            self.watch_records()?;
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
}

/// To be called by every hook of loads and stores.
///
/// Before such a hook the engine writes program counter and IT state of the access into the core. A translated block that
/// runs on does not take the IT state from there and leaves it behind, so that the block after it would start as if it stood
/// within an IT block, and skip instructions. Between the accesses of a block the core holds none.
fn forget_it_state(uc: &mut Uc<'_>) {
    // The register exists, the one error there is. Its other field is the Thumb bit.
    let _ = uc.reg_write(RegisterARM::EPSR, 1 << 24);
}

fn trap(uc: &mut Uc<'_>, trap: Trap) {
    uc.get_data_mut().core.trap.get_or_insert(trap);
}

fn load(
    uc: &mut Uc<'_>,
    address: u32,
    size: usize,
    read: impl FnOnce(&mut Chip, u32, usize) -> Result<u32, Misuse>,
) -> u64 {
    match read(uc.get_data_mut(), address, size) {
        Ok(value) => value.into(),
        Err(misuse) => {
            trap(uc, Trap::Misuse(misuse));
            0
        }
    }
}

fn store(
    uc: &mut Uc<'_>,
    address: u32,
    size: usize,
    value: u64,
    write: impl FnOnce(&mut Chip, u32, usize, u32) -> Result<(), Misuse>,
) {
    if let Err(misuse) = write(uc.get_data_mut(), address, size, value as u32) {
        trap(uc, Trap::Misuse(misuse));
    }
}

/// Before every block: stop if something is due, else charge the block.
fn on_block(uc: &mut Uc<'_>, address: u64, size: u32) {
    let address = address as u32;
    let chip = uc.get_data_mut();
    (chip.core.block_address, chip.core.block_size) = (address, size);
    let stop = chip.now >= chip.deadline
        || chip.core.trap.is_some()
        || chip.reset_request.is_some()
        || !chip.flash.changed.is_empty()
        || chip.core.blocks.is_stale(address);
    if stop || chip.core.nvic.candidate().is_some() && takes_exception(uc) {
        // The result says only that the engine is not running, which a hook of its own rules out.
        let _ = uc.emu_stop();
        return;
    }
    if uc.get_data().core.account.awaited_return() == Some(address) {
        let stack = uc.reg_read(RegisterARM::SP).unwrap_or(0) as u32;
        uc.get_data_mut().core.account.returned(stack);
    }
    let chip = uc.get_data_mut();
    let bus = chip.clocks().bus;
    let core = &mut chip.core;
    // By reference: this runs before every few instructions of the chip.
    let instructions = match core.blocks.slot(address) {
        Some(block) if block.size == size && block.watch == 0 => {
            core.account.charge(block);
            core.event |= block.sends_event;
            block.instructions
        }
        slot => {
            let watch = slot.map_or(0, |slot| slot.watch);
            let block = learn(uc, address, size, watch);
            if watch != 0 {
                let return_to = uc.reg_read(RegisterARM::LR).unwrap_or(0) as u32;
                let stack = uc.reg_read(RegisterARM::SP).unwrap_or(0) as u32;
                let account = &mut uc.get_data_mut().core.account;
                account.call(watch, return_to, stack);
            }
            let core = &mut uc.get_data_mut().core;
            core.account.charge(&block);
            core.event |= block.sends_event;
            block.instructions
        }
    };
    let (numerator, denominator) = CYCLES_PER_INSTRUCTION;
    uc.get_data_mut().now += u64::from(instructions) * bus * numerator / denominator;
}

fn learn(uc: &mut Uc<'_>, address: u32, size: u32, watch: u16) -> Block {
    let mut code = vec![0; size as usize];
    let readable = uc.mem_read(address.into(), &mut code).is_ok();
    let block = if readable {
        decode::decode(&code, Memory::at(address))
    } else {
        Block {
            size,
            ..Block::default()
        }
    };
    let block = Block { watch, ..block };
    if let Some(slot) = uc.get_data_mut().core.blocks.slot(address) {
        *slot = block;
    }
    block
}

/// The mask registers let the pending exception through.
fn takes_exception(uc: &Uc<'_>) -> bool {
    let Some((_, priority)) = uc.get_data().core.nvic.candidate() else {
        return false;
    };
    let mask = |register| uc.reg_read(register).unwrap_or(0) as u32;
    let base = mask(RegisterARM::BASEPRI) as i16;
    let masked = mask(RegisterARM::FAULTMASK) & 1 != 0 && priority >= -1
        || mask(RegisterARM::PRIMASK) & 1 != 0 && priority >= 0
        || base != 0 && priority >= base;
    !masked
}

impl Engine {
    /// The exception to take now, if any.
    pub(crate) fn takes(&self) -> Option<u16> {
        let candidate = self.chip().core.nvic.candidate()?;
        takes_exception(&self.uc).then_some(candidate.0)
    }
}

fn on_interrupt(uc: &mut Uc<'_>, number: u32) {
    let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0) as u32;
    let what = match number {
        2 => Trap::Supervisor,
        7 => Trap::Breakpoint,
        8 => Trap::Return(pc | 1),
        3 | 4 => Trap::Bus {
            address: pc,
            fetch: number == 3,
        },
        _ => Trap::Undefined,
    };
    trap(uc, what);
    let _ = uc.emu_stop();
}

fn on_invalid(uc: &mut Uc<'_>) -> bool {
    let pc = uc.reg_read(RegisterARM::PC).unwrap_or(0) as u32;
    let at = pc.wrapping_sub(2);
    let before = uc.get_data().flash.halfword(at).or_else(|| {
        let mut bytes = [0; 2];
        uc.mem_read(at.into(), &mut bytes).ok()?;
        Some(u16::from_le_bytes(bytes))
    });
    if before == Some(decode::WFE) {
        let core = &mut uc.get_data_mut().core;
        if core.event {
            core.event = false;
        } else {
            trap(uc, Trap::WaitForEvent);
            let _ = uc.emu_stop();
        }
        return true;
    }
    trap(uc, Trap::Undefined);
    false
}
