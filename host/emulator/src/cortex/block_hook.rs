// SPDX-License-Identifier: GPL-2.0-only
//! Callback before every translated block: stops when an event is due, advances time and counts instructions.
//!
//! The hook is installed without the engine's wrapper, which would take as long as everything done here.

use std::ffi::c_void;

use unicorn_engine::{HookType, RegisterARM, uc_engine, uc_error};
use unicorn_engine_sys::uc_hook_add;

use super::decode::{self, Block, Memory};
use super::hooks::Uc;
use crate::time::CYCLES_PER_INSTRUCTION;

/// The hook's handle to its engine. Must live as long as the engine runs: the engine holds its address.
pub(super) struct BlockHook {
    uc: Uc<'static>,
}

impl BlockHook {
    /// Hooks all blocks of an engine.
    #[allow(unsafe_code)]
    pub(super) fn install(uc: &Uc<'static>) -> Result<Box<Self>, uc_error> {
        let hook = Box::new(Self { uc: uc.clone() });
        let mut number = 0;
        // An end below the beginning means every address.
        let (begin, end) = (1u64, 0u64);
        // SAFETY: the callback has the type that hooks of blocks are called with; what it is given is the hook's own heap
        // block, which `Engine` keeps as long as it runs anything.
        let added = unsafe {
            uc_hook_add(
                uc.get_handle(),
                &raw mut number,
                HookType::BLOCK.0 as i32,
                called as *mut c_void,
                (&raw const *hook).cast_mut().cast(),
                begin,
                end,
            )
        };
        match added {
            uc_error::OK => Ok(hook),
            error => Err(error),
        }
    }
}

/// The callback.
#[allow(unsafe_code)]
extern "C" fn called(_: *mut uc_engine, address: u64, size: u32, hook: *mut c_void) {
    // SAFETY: the address given in `install`. Only the engine calls this, while `Engine::run` waits for it, and no hook runs
    // within another: nothing else uses the handle.
    let hook = unsafe { &mut *hook.cast::<BlockHook>() };
    on_block(&mut hook.uc, address as u32, size);
}

/// Before every block: stop if an event is due, otherwise count the block.
#[inline]
fn on_block(uc: &mut Uc<'_>, address: u32, size: u32) {
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
    let chip = uc.get_data_mut();
    let bus = chip.clocks().bus;
    let core = &mut chip.core;
    let returns = core.account.awaited_return() == Some(address);
    // By reference, for speed: this runs every few instructions.
    let instructions = match core.blocks.slot(address) {
        Some(block) if block.size == size && block.watch == 0 && !returns => {
            core.account.charge(block);
            core.event |= block.sends_event;
            block.instructions
        }
        _ => return unusual(uc, address, size, returns),
    };
    chip.now += ticks(instructions, bus);
}

/// Virtual time of a number of instructions.
fn ticks(instructions: u32, bus: u64) -> u64 {
    let (numerator, denominator) = CYCLES_PER_INSTRUCTION;
    u64::from(instructions) * bus * numerator / denominator
}

/// Handles a new block, one that begins a watched function, or one to which a watched function returns.
#[cold]
fn unusual(uc: &mut Uc<'_>, address: u32, size: u32, returns: bool) {
    let register = |uc: &Uc<'_>, register| uc.reg_read(register).unwrap_or(0) as u32;
    if returns {
        let stack = register(uc, RegisterARM::SP);
        uc.get_data_mut().core.account.returned(stack);
    }
    let slot = uc.get_data_mut().core.blocks.slot(address);
    let block = match slot {
        Some(block) if block.size == size => *block,
        slot => {
            let watch = slot.map_or(0, |slot| slot.watch);
            learn(uc, address, size, watch)
        }
    };
    if block.watch != 0 {
        let return_to = register(uc, RegisterARM::LR);
        let stack = register(uc, RegisterARM::SP);
        let account = &mut uc.get_data_mut().core.account;
        account.call(block.watch, return_to, stack);
    }
    let chip = uc.get_data_mut();
    let bus = chip.clocks().bus;
    chip.core.account.charge(&block);
    chip.core.event |= block.sends_event;
    chip.now += ticks(block.instructions, bus);
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

/// Whether the mask registers allow the pending exception.
pub(super) fn takes_exception(uc: &Uc<'_>) -> bool {
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
