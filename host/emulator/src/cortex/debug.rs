// SPDX-License-Identifier: GPL-2.0-only
//! Debugging of the core: breakpoints, single steps, registers. While the core is halted, time stops for the chip and for the
//! world.

use std::collections::BTreeSet;

use super::{Engine, Map};

/// Where the core was resumed, and how far it runs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Resumed {
    /// The instruction at which the core was resumed: its breakpoint does not halt it again.
    pub(super) from: Option<u32>,
    /// Whether the core halts again before the next instruction.
    pub(super) step: bool,
}

impl Resumed {
    /// A block has been run: what comes next is no longer where the core was resumed.
    pub(super) fn leave(&mut self) {
        self.from = None;
    }
}

/// Addresses before which the core is halted.
#[derive(Default)]
pub(super) struct Breakpoints(BTreeSet<u32>);

impl Breakpoints {
    pub(super) fn at(&self, address: u32) -> bool {
        self.0.contains(&address)
    }
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

impl Engine {
    /// Sets a breakpoint.
    pub(crate) fn set_breakpoint(&mut self, address: u32) {
        self.bus.breakpoints.0.insert(address & !1);
    }

    /// Removes a breakpoint; false if there was none.
    pub(crate) fn clear_breakpoint(&mut self, address: u32) -> bool {
        self.bus.breakpoints.0.remove(&(address & !1))
    }

    /// Removes all breakpoints.
    pub(crate) fn clear_breakpoints(&mut self) {
        self.bus.breakpoints.0.clear();
        self.chip_mut().core.resumed = Resumed::default();
    }

    /// Resumes the core; with `step` it halts after one instruction.
    pub(crate) fn resume(&mut self, step: bool) {
        let from = Some(self.bus.registers.pc);
        self.chip_mut().core.resumed = Resumed { from, step };
    }

    /// Whether the core must look at every instruction.
    pub(super) fn is_watched(&self) -> bool {
        self.chip().core.resumed.step || !self.bus.breakpoints.0.is_empty()
    }

    /// The registers.
    pub(crate) fn core_registers(&self) -> CoreRegisters {
        let registers = &self.bus.registers;
        CoreRegisters {
            core: std::array::from_fn(|n| {
                if n == 16 {
                    registers.xpsr()
                } else {
                    registers.get(n)
                }
            }),
            stacks: registers.stacks(),
            double: std::array::from_fn(|n| registers.double(n)),
            fpscr: registers.fpu.status(),
        }
    }

    /// Changes those registers that differ.
    pub(crate) fn set_core_registers(&mut self, wanted: &CoreRegisters) {
        let now = self.core_registers();
        let registers = &mut self.bus.registers;
        for (n, (&wanted, now)) in wanted.core.iter().zip(now.core).enumerate() {
            match n {
                _ if wanted == now => {}
                16 => registers.set_xpsr(wanted),
                n => registers.set(n, wanted),
            }
        }
        if wanted.stacks[0] != now.stacks[0] {
            registers.set_main_stack(wanted.stacks[0]);
        }
        if wanted.stacks[1] != now.stacks[1] {
            registers.set_process_stack(wanted.stacks[1]);
        }
        for (n, (&wanted, now)) in wanted.double.iter().zip(now.double).enumerate() {
            if wanted != now {
                registers.set_double(n, wanted);
            }
        }
        if wanted.fpscr != now.fpscr {
            registers.fpu.set_status(wanted.fpscr);
        }
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
