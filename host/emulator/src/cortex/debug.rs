// SPDX-License-Identifier: GPL-2.0-only
//! Debugging of the core: breakpoints, single steps, registers. While the core is halted, time stops for the chip and for the
//! world.

use std::collections::BTreeMap;

use unicorn_engine::{RegisterARM, UcHookId, Unicorn, uc_error};

use super::{Engine, Map, Trap};
use crate::chip::Chip;

/// State that the hooks of breakpoints and steps share.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Resumed {
    /// The instruction at which the core was resumed: its breakpoint does not halt it again.
    from: Option<u32>,
    /// Whether the core halts again before the next instruction.
    step: bool,
}

/// Hooks by address.
#[derive(Default)]
pub(super) struct Breakpoints {
    at: BTreeMap<u32, UcHookId>,
    step: Option<UcHookId>,
}

/// The registers that a debugger shows, in the order of its target description.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoreRegisters {
    /// r0 to r12, sp, lr, pc, xpsr.
    pub core: [u32; 17],
    /// Main and process stack pointer.
    pub stacks: [u32; 2],
    /// d0 to d15.
    pub double: [u64; 16],
    /// Floating-point status.
    pub fpscr: u32,
}

const CORE: [RegisterARM; 17] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R4,
    RegisterARM::R5,
    RegisterARM::R6,
    RegisterARM::R7,
    RegisterARM::R8,
    RegisterARM::R9,
    RegisterARM::R10,
    RegisterARM::R11,
    RegisterARM::R12,
    RegisterARM::SP,
    RegisterARM::LR,
    RegisterARM::PC,
    RegisterARM::XPSR,
];
const STACKS: [RegisterARM; 2] = [RegisterARM::MSP, RegisterARM::PSP];
const DOUBLE: [RegisterARM; 16] = [
    RegisterARM::D0,
    RegisterARM::D1,
    RegisterARM::D2,
    RegisterARM::D3,
    RegisterARM::D4,
    RegisterARM::D5,
    RegisterARM::D6,
    RegisterARM::D7,
    RegisterARM::D8,
    RegisterARM::D9,
    RegisterARM::D10,
    RegisterARM::D11,
    RegisterARM::D12,
    RegisterARM::D13,
    RegisterARM::D14,
    RegisterARM::D15,
];

impl Engine {
    /// Sets a breakpoint.
    pub(crate) fn set_breakpoint(&mut self, address: u32) -> Result<(), uc_error> {
        let address = address & !1;
        if self.breakpoints.at.contains_key(&address) {
            return Ok(());
        }
        let hook = self
            .uc
            .add_code_hook(address.into(), address.into(), |uc, address, _| {
                before(uc, address as u32, false);
            })?;
        self.breakpoints.at.insert(address, hook);
        // Blocks that are already translated do not call the hook.
        self.uc.ctl_flush_tb()
    }

    /// Removes a breakpoint; false if there was none.
    pub(crate) fn clear_breakpoint(&mut self, address: u32) -> Result<bool, uc_error> {
        let Some(hook) = self.breakpoints.at.remove(&(address & !1)) else {
            return Ok(false);
        };
        self.uc.remove_hook(hook)?;
        self.uc.ctl_flush_tb()?;
        Ok(true)
    }

    /// Removes all breakpoints.
    pub(crate) fn clear_breakpoints(&mut self) -> Result<(), uc_error> {
        let all: Vec<u32> = self.breakpoints.at.keys().copied().collect();
        for address in all {
            self.clear_breakpoint(address)?;
        }
        self.resume(false)?;
        self.chip_mut().core.resumed = Resumed::default();
        Ok(())
    }

    /// Resumes the core; with `step` it halts after one instruction.
    pub(crate) fn resume(&mut self, step: bool) -> Result<(), uc_error> {
        let from = self.register(RegisterARM::PC)? & !1;
        self.chip_mut().core.resumed = Resumed {
            from: Some(from),
            step,
        };
        if step && self.breakpoints.step.is_none() {
            let everywhere = self
                .uc
                .add_code_hook(0, u32::MAX.into(), |uc, address, _| {
                    before(uc, address as u32, true);
                })?;
            self.breakpoints.step = Some(everywhere);
            self.uc.ctl_flush_tb()?;
        } else if !step && let Some(hook) = self.breakpoints.step.take() {
            // A hook before every instruction slows all of them down, so it exists only while stepping.
            self.uc.remove_hook(hook)?;
            self.uc.ctl_flush_tb()?;
        }
        Ok(())
    }

    /// The registers.
    pub(crate) fn core_registers(&self) -> Result<CoreRegisters, uc_error> {
        let mut all = CoreRegisters::default();
        for (value, register) in all.core.iter_mut().zip(CORE) {
            *value = self.register(register)?;
        }
        for (value, register) in all.stacks.iter_mut().zip(STACKS) {
            *value = self.register(register)?;
        }
        for (value, register) in all.double.iter_mut().zip(DOUBLE) {
            *value = self.wide_register(register)?;
        }
        all.fpscr = self.register(RegisterARM::FPSCR)?;
        Ok(all)
    }

    /// Changes those registers that differ.
    pub(crate) fn set_core_registers(&mut self, wanted: &CoreRegisters) -> Result<(), uc_error> {
        let now = self.core_registers()?;
        let words = CORE.into_iter().zip(wanted.core.into_iter().zip(now.core));
        let stacks = STACKS
            .into_iter()
            .zip(wanted.stacks.into_iter().zip(now.stacks));
        let status = [(RegisterARM::FPSCR, (wanted.fpscr, now.fpscr))];
        for (register, (wanted, now)) in words.chain(stacks).chain(status) {
            if wanted != now {
                self.set_register(register, wanted)?;
            }
        }
        for (register, (wanted, now)) in DOUBLE
            .into_iter()
            .zip(wanted.double.into_iter().zip(now.double))
        {
            if wanted != now {
                self.set_wide_register(register, wanted)?;
            }
        }
        Ok(())
    }

    /// Reads memory without side effects: flash and RAM, no peripheral registers. Returns the bytes up to the first unmapped
    /// address.
    pub(crate) fn peek(&self, address: u32, into: &mut [u8]) -> usize {
        let end = [
            (0, Map::FLASH_SIZE),
            (Map::CCM, Map::CCM_SIZE),
            (Map::FLASH, Map::FLASH_SIZE),
            (Map::SYSTEM, Map::SYSTEM_SIZE),
            (Map::RAM, Map::RAM_SIZE),
        ]
        .into_iter()
        .find_map(|(base, size)| (address.wrapping_sub(base) < size).then(|| base + size));
        let Some(end) = end else { return 0 };
        let length = into.len().min((end - address) as usize);
        self.read(address, length).map_or(0, |bytes| {
            into[..length].copy_from_slice(&bytes);
            length
        })
    }
}

/// Called before an instruction with a breakpoint, and before every one while stepping.
fn before(uc: &mut Unicorn<'_, Chip>, address: u32, stepping: bool) {
    let core = &mut uc.get_data_mut().core;
    if core.resumed.from == Some(address) {
        // Both hooks may be called here: while stepping only that of the step clears the resume address.
        if stepping || !core.resumed.step {
            core.resumed.from = None;
        }
        return;
    }
    core.trap.get_or_insert(Trap::Held { stepping });
    // The result says only that the engine is not running, which a hook of its own rules out.
    let _ = uc.emu_stop();
}
