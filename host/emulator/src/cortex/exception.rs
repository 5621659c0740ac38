// SPDX-License-Identifier: GPL-2.0-only
//! Exception entry and return.

use super::decode::FLASH_WAIT;
use super::nvic::exception;
use super::state::{FPCA, SPSEL};
use super::system::{BFAR, CFSR, HFSR, VTOR};
use super::{Engine, Map, Trap};

/// r0 to r3, r12, lr.
const CORE_FRAME: [usize; 6] = [0, 1, 2, 3, 12, 14];
/// Bit of the stacked xPSR: the frame was aligned by four bytes.
const ALIGNED: u32 = 1 << 9;

/// Cycles of an exception's entry or return.
struct Passage {
    least: u32,
}

const ENTRY: Passage = Passage { least: 12 };
const RETURN: Passage = Passage { least: 10 };

impl Passage {
    /// With the floating-point registers, one cycle each.
    const fn cycles(&self, floating: bool) -> u32 {
        self.least + if floating { 17 } else { 0 }
    }
}

/// Stacking failed: no memory below the stack pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StackingFailed;

impl Engine {
    /// Starts from the vector table, as after a reset.
    pub(crate) fn start(&mut self) {
        let table = Map::FLASH;
        let stack = self.word(table).unwrap_or(0);
        let entry = self.word(table + 4).unwrap_or(0);
        self.bus.registers.reset(stack, entry);
    }

    /// Enters an exception at the present program counter.
    pub(crate) fn enter(&mut self, number: u16) -> Result<(), StackingFailed> {
        let registers = &self.bus.registers;
        let status = registers.xpsr();
        let handler = registers.exception != 0;
        let floating = registers.control & FPCA != 0;
        let process = !handler && registers.control & SPSEL != 0;
        let before = registers.r[13];
        let size = if floating { 0x68 } else { 0x20 };
        let aligned = before & 4 != 0;
        let frame = (before & !7).wrapping_sub(size);
        let mut words = [0; 0x1A];
        for (word, register) in words.iter_mut().zip(CORE_FRAME) {
            *word = registers.get(register);
        }
        words[6] = registers.pc;
        words[7] = status & !ALIGNED | if aligned { ALIGNED } else { 0 };
        words[8..24].copy_from_slice(&registers.fpu.s[..16]);
        words[24] = registers.fpu.status();
        let bytes = words.map(u32::to_le_bytes);
        let stacked = self.write(frame, &bytes.as_flattened()[..size as usize]);
        let mode = if handler {
            0x1
        } else if process {
            0xD
        } else {
            0x9
        };
        let table = self.chip().core.scs[VTOR];
        let vector = self.word(table + 4 * u32::from(number)).unwrap_or(0);
        let registers = &mut self.bus.registers;
        registers.r[13] = frame;
        registers.it = 0;
        registers.set_mode(number, registers.control & !FPCA);
        registers.control &= !SPSEL;
        registers.r[14] = 0xFFFF_FFE0 | if floating { 0 } else { 0x10 } | mode;
        registers.pc = vector & !1;
        let chip = self.chip_mut();
        chip.core.nvic.enter(number);
        let cycles = ENTRY.cycles(floating);
        // The floating-point registers are stacked when the handler first uses one; the vector comes from flash.
        chip.core
            .account
            .enter(number, ENTRY.least, cycles + FLASH_WAIT);
        chip.core.event = true;
        chip.now += u64::from(cycles) * chip.clocks().bus;
        if stacked { Ok(()) } else { Err(StackingFailed) }
    }

    /// Leaves the running exception with this EXC_RETURN value.
    pub(crate) fn leave(&mut self, exc_return: u32) -> Result<(), StackingFailed> {
        let number = self.bus.registers.exception;
        let floating = exc_return & 0x10 == 0;
        let process = exc_return & 0xF == 0xD;
        let [_, process_stack] = self.bus.registers.stacks();
        let frame = if process {
            process_stack
        } else {
            self.bus.registers.r[13]
        };
        let size = if floating { 0x68 } else { 0x20 };
        let mut bytes = [[0; 4]; 0x1A];
        let frame_bytes = &mut bytes.as_flattened_mut()[..size as usize];
        if self.read_into(frame, frame_bytes).is_none() {
            return Err(StackingFailed);
        }
        let words = bytes.map(u32::from_le_bytes);
        let registers = &mut self.bus.registers;
        if number != exception::NMI {
            registers.faultmask = false;
        }
        let xpsr = words[7];
        let after = frame + size + if xpsr & ALIGNED != 0 { 4 } else { 0 };
        if process {
            registers.set_process_stack(after);
        } else {
            registers.r[13] = after;
        }
        registers.set_xpsr(xpsr & !ALIGNED);
        let control = registers.control & !(FPCA | SPSEL)
            | if floating { FPCA } else { 0 }
            | if process { SPSEL } else { 0 };
        registers.set_mode(registers.exception, control);
        for (register, word) in CORE_FRAME.into_iter().zip(words) {
            registers.set(register, word);
        }
        if floating {
            registers.fpu.s[..16].copy_from_slice(&words[8..24]);
            registers.fpu.set_status(words[24]);
        }
        registers.pc = words[6] & !1;
        let chip = self.chip_mut();
        chip.core.nvic.leave(number);
        let cycles = RETURN.cycles(floating);
        chip.core.account.leave(RETURN.least, cycles);
        chip.core.event = true;
        chip.now += u64::from(cycles) * chip.clocks().bus;
        Ok(())
    }

    /// A fault of the running code: status bits, then its handler, or HardFault, or lockup.
    pub(crate) fn fault(&mut self, trap: &Trap) {
        const PRECISE: u32 = 1 << 9 | 1 << 15;
        let (number, status) = match trap {
            Trap::Bus { fetch: true, .. } => (exception::BUS_FAULT, 1 << 8),
            Trap::Bus { .. } => (exception::BUS_FAULT, PRECISE),
            _ => (exception::USAGE_FAULT, 1 << 16),
        };
        let core = &mut self.chip_mut().core;
        core.scs[CFSR] |= status;
        if let Trap::Bus {
            address,
            fetch: false,
        } = trap
        {
            core.scs[BFAR] = *address;
        }
        self.escalate(number);
    }

    /// Takes a fault exception, escalated to HardFault if it is disabled or its priority is too low.
    pub(crate) fn escalate(&mut self, number: u16) {
        let (masked, faultmask) = (self.bus.registers.primask, self.bus.registers.faultmask);
        let core = &mut self.chip_mut().core;
        let running = if faultmask {
            -1
        } else if masked {
            core.nvic.running().min(0)
        } else {
            core.nvic.running()
        };
        let enabled =
            core.nvic.enabled >> number & 1 != 0 && core.nvic.preemption(number) < running;
        if !enabled {
            core.scs[HFSR] |= 1 << 30;
        }
        let number = if enabled {
            number
        } else {
            exception::HARD_FAULT
        };
        if core.nvic.preemption(number) >= running {
            self.chip_mut().lock_up();
            return;
        }
        if self.enter(number).is_err() {
            self.unstacked(number);
        }
    }

    /// Stacking for exception `entered` failed: the stack has left the RAM.
    pub(crate) fn unstacked(&mut self, entered: u16) {
        let core = &mut self.chip_mut().core;
        core.scs[CFSR] |= 1 << 12;
        core.scs[HFSR] |= 1 << 30;
        if entered == exception::HARD_FAULT || core.nvic.preemption(entered) < 0 {
            // The chip would run the handler until it accesses the stack, so the vector is taken anyway.
            return;
        }
        // The failing exception stays pending; HardFault comes first.
        if self.enter(exception::HARD_FAULT).is_err() {
            self.chip_mut().core.scs[CFSR] |= 1 << 12;
        }
    }
}
