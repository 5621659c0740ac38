// SPDX-License-Identifier: GPL-2.0-only
//! Callbacks of the instruction engine: registers, stores to flash and CCM, watched loads, traps. Blocks: `block_hook`.

use unicorn_engine::{HookType, MemType, Prot, RegisterARM, TlbEntry, TlbType, Unicorn, uc_error};

use super::decode;
use super::memory::Ram;
use super::{Map, Trap};
use crate::chip::{Chip, Misuse};

/// Last pages of the flash, where a firmware keeps records and where damaged double words are looked for.
const RECORDS_SIZE: u32 = 16 * 1024;

pub(super) type Uc<'a> = Unicorn<'a, Chip>;

/// Installs the hooks of every run.
pub(super) fn install(uc: &mut Unicorn<'static, Chip>, ram: &Ram) -> Result<(), uc_error> {
    map_registers(uc)?;
    map_pages(uc)?;
    uc.add_intr_hook(on_interrupt)?;
    uc.add_insn_invalid_hook(on_invalid)?;
    watch_stores(uc, ram)
}

/// The peripherals' registers, and those of the core.
fn map_registers(uc: &mut Unicorn<'static, Chip>) -> Result<(), uc_error> {
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
    Ok(())
}

fn map_pages(uc: &mut Unicorn<'static, Chip>) -> Result<(), uc_error> {
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
    Ok(())
}

/// Stores to flash and to CCM SRAM, and accesses where no memory answers.
fn watch_stores(uc: &mut Unicorn<'static, Chip>, ram: &Ram) -> Result<(), uc_error> {
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
        hook_refused_stores(uc, from, to, move |uc, address, size, value| {
            let chip = uc.get_data_mut();
            chip.store_flash(address - base, size, value as u32);
        })?;
    }
    let code = ram.clone();
    // Translated and decoded code must follow its changes. Only the start of the firmware stores here, so these stores may be
    // slow; a hook of stores would slow down those to every address.
    let (from, to) = (Map::CCM.into(), (ccm_end - 1).into());
    hook_refused_stores(uc, from, to, move |uc, address, size, value| {
        uc.get_data_mut().core.blocks.change_ccm();
        let bytes = value.to_le_bytes();
        // A store of the core is never wider than these, and the hook's range is RAM.
        let _ = code.write(address, &bytes[..size.min(bytes.len())]);
    })
}

/// Calls `store` with address, size and value for every store to a range that the engine has mapped read-only.
fn hook_refused_stores(
    uc: &mut Unicorn<'static, Chip>,
    from: u64,
    to: u64,
    store: impl Fn(&mut Uc<'_>, u32, usize, i64) + 'static,
) -> Result<(), uc_error> {
    uc.add_mem_hook(
        HookType::MEM_WRITE_PROT,
        from,
        to,
        move |uc: &mut Uc<'_>, _, address, size, value| {
            forget_it_state(uc);
            store(uc, address as u32, size, value);
            true
        },
    )?;
    Ok(())
}

/// Detects loads of damaged double words of the records from now on. A hook of loads slows all of them down, so it is installed
/// only when flash has been damaged.
pub(super) fn watch_records(uc: &mut Unicorn<'static, Chip>) -> Result<(), uc_error> {
    let records = Map::FLASH + Map::FLASH_SIZE - RECORDS_SIZE;
    let (from, to) = (records.into(), (records + RECORDS_SIZE - 1).into());
    uc.add_mem_hook(
        HookType::MEM_READ,
        from,
        to,
        |uc: &mut Uc<'_>, _, address, _, _| {
            forget_it_state(uc);
            uc.get_data_mut().load_flash(address as u32 - Map::FLASH);
            true
        },
    )?;
    // Blocks that are already translated do not call the hook.
    uc.ctl_flush_tb()
}

/// Keeps the program counter exact at loads of CYCCNT, so that it counts executed instructions exactly.
pub(super) fn count_instructions(uc: &mut Unicorn<'static, Chip>) -> Result<(), uc_error> {
    // The mere presence of the hook makes the engine keep the program counter exact at loads.
    let cyccnt = 0xE000_1004;
    uc.add_mem_hook(
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
