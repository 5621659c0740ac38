// SPDX-License-Identifier: GPL-2.0-only
//! Exception entry and return, which the engine does not implement.

use unicorn_engine::{RegisterARM as R, uc_error};

use super::decode::FLASH_WAIT;
use super::nvic::exception;
use super::system::{BFAR, CFSR, HFSR, VTOR};
use super::{Engine, Map, Trap};

const CORE_FRAME: [R; 8] = [R::R0, R::R1, R::R2, R::R3, R::R12, R::LR, R::PC, R::XPSR];
const FP_FRAME: [R; 8] = [R::D0, R::D1, R::D2, R::D3, R::D4, R::D5, R::D6, R::D7];
const FPCA: u32 = 4;
const SPSEL: u32 = 2;
/// Bit of the stacked xPSR: the frame was aligned by four bytes.
const ALIGNED: u32 = 1 << 9;
const THUMB: u32 = 1 << 24;

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
    pub(crate) fn start(&mut self) -> Result<(), uc_error> {
        let table = Map::FLASH;
        let (stack, entry) = (
            self.word(table).unwrap_or(0),
            self.word(table + 4).unwrap_or(0),
        );
        for register in [
            R::R0,
            R::R1,
            R::R2,
            R::R3,
            R::R4,
            R::R5,
            R::R6,
            R::R7,
            R::R8,
            R::R9,
            R::R10,
            R::R11,
            R::R12,
        ] {
            self.set_register(register, 0)?;
        }
        self.set_register(R::XPSR, THUMB)?;
        for register in [R::CONTROL, R::PRIMASK, R::BASEPRI, R::FAULTMASK, R::PSP] {
            self.set_register(register, 0)?;
        }
        self.set_register(R::MSP, stack & !3)?;
        self.set_register(R::LR, u32::MAX)?;
        self.set_register(R::FPSCR, 0)?;
        self.set_register(R::PC, entry | 1)
    }

    /// Enters an exception at the present program counter.
    pub(crate) fn enter(&mut self, number: u16) -> Result<Result<(), StackingFailed>, uc_error> {
        let control = self.register(R::CONTROL)?;
        let status = self.register(R::XPSR)?;
        let handler = status & 0x1FF != 0;
        let floating = control & FPCA != 0;
        let process = !handler && control & SPSEL != 0;
        let before = self.register(R::SP)?;
        let size = if floating { 0x68 } else { 0x20 };
        let aligned = before & 4 != 0;
        let frame = (before & !7).wrapping_sub(size);
        let mut bytes = [0; 0x68];
        let (words, _) = bytes.as_chunks_mut::<4>();
        for (word, register) in words.iter_mut().zip(CORE_FRAME) {
            let value = match register {
                R::PC => self.register(register)? & !1,
                R::XPSR => status & !ALIGNED | if aligned { ALIGNED } else { 0 } | THUMB,
                _ => self.register(register)?,
            };
            *word = value.to_le_bytes();
        }
        if floating {
            let (pairs, _) = bytes[0x20..].as_chunks_mut::<8>();
            for (pair, register) in pairs.iter_mut().zip(FP_FRAME) {
                *pair = self.wide_register(register)?.to_le_bytes();
            }
            bytes[0x60..0x64].copy_from_slice(&self.register(R::FPSCR)?.to_le_bytes());
        }
        let stacked = self.write(frame, &bytes[..size as usize]);
        self.set_register(R::SP, frame)?;
        let flags = status & 0xF80F_0000;
        self.set_register(R::XPSR, flags | THUMB | u32::from(number))?;
        self.set_register(R::CONTROL, control & !(FPCA | SPSEL))?;
        let mode = if handler {
            0x1
        } else if process {
            0xD
        } else {
            0x9
        };
        let link = 0xFFFF_FFE0 | if floating { 0 } else { 0x10 } | mode;
        self.set_register(R::LR, link)?;
        let table = self.chip().core.scs[VTOR];
        let vector = self.word(table + 4 * u32::from(number)).unwrap_or(0);
        self.set_register(R::PC, vector | 1)?;
        let chip = self.chip_mut();
        chip.core.nvic.enter(number);
        let cycles = ENTRY.cycles(floating);
        // The floating-point registers are stacked when the handler first uses one; the vector comes from flash.
        chip.core
            .account
            .enter(number, ENTRY.least, cycles + FLASH_WAIT);
        chip.core.event = true;
        chip.now += u64::from(cycles) * chip.clocks().bus;
        Ok(if stacked { Ok(()) } else { Err(StackingFailed) })
    }

    /// Leaves the running exception with this EXC_RETURN value.
    pub(crate) fn leave(
        &mut self,
        exc_return: u32,
    ) -> Result<Result<(), StackingFailed>, uc_error> {
        let number = (self.register(R::XPSR)? & 0x1FF) as u16;
        let floating = exc_return & 0x10 == 0;
        let process = exc_return & 0xF == 0xD;
        let frame = if process {
            self.register(R::PSP)?
        } else {
            self.register(R::SP)?
        };
        let size = if floating { 0x68 } else { 0x20 };
        let mut bytes = [0; 0x68];
        if self.read_into(frame, &mut bytes[..size]).is_none() {
            return Ok(Err(StackingFailed));
        }
        let word = |n: usize| {
            u32::from_le_bytes([
                bytes[4 * n],
                bytes[4 * n + 1],
                bytes[4 * n + 2],
                bytes[4 * n + 3],
            ])
        };
        if number != exception::NMI {
            self.set_register(R::FAULTMASK, 0)?;
        }
        let xpsr = word(7);
        let after = frame + size as u32 + if xpsr & ALIGNED != 0 { 4 } else { 0 };
        if !process {
            self.set_register(R::SP, after)?;
        }
        self.set_register(R::XPSR, xpsr & !ALIGNED)?;
        let control = self.register(R::CONTROL)? & !(FPCA | SPSEL);
        let control = control | if floating { FPCA } else { 0 } | if process { SPSEL } else { 0 };
        self.set_register(R::CONTROL, control)?;
        if process {
            self.set_register(R::PSP, after)?;
        }
        for (n, register) in CORE_FRAME.into_iter().enumerate().take(6) {
            self.set_register(register, word(n))?;
        }
        if floating {
            for (n, register) in FP_FRAME.into_iter().enumerate() {
                let value = u64::from(word(8 + 2 * n)) | u64::from(word(9 + 2 * n)) << 32;
                self.set_wide_register(register, value)?;
            }
            self.set_register(R::FPSCR, word(24))?;
        }
        self.set_register(R::PC, word(6) | 1)?;
        let chip = self.chip_mut();
        chip.core.nvic.leave(number);
        let cycles = RETURN.cycles(floating);
        chip.core.account.leave(RETURN.least, cycles);
        chip.core.event = true;
        chip.now += u64::from(cycles) * chip.clocks().bus;
        Ok(Ok(()))
    }

    /// A fault of the running code: status bits, then its handler, or HardFault, or lockup.
    pub(crate) fn fault(&mut self, trap: &Trap) -> Result<(), uc_error> {
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
        self.escalate(number)
    }

    /// Takes a fault exception, escalated to HardFault if it is disabled or its priority is too low.
    pub(crate) fn escalate(&mut self, number: u16) -> Result<(), uc_error> {
        let masked = self.register(R::PRIMASK)? & 1 != 0;
        let faultmask = self.register(R::FAULTMASK)? & 1 != 0;
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
            return Ok(());
        }
        if self.enter(number)?.is_err() {
            self.unstacked(number)?;
        }
        Ok(())
    }

    /// Stacking for exception `entered` failed: the stack has left the RAM.
    pub(crate) fn unstacked(&mut self, entered: u16) -> Result<(), uc_error> {
        let core = &mut self.chip_mut().core;
        core.scs[CFSR] |= 1 << 12;
        core.scs[HFSR] |= 1 << 30;
        if entered == exception::HARD_FAULT || core.nvic.preemption(entered) < 0 {
            // The chip would run the handler until it accesses the stack, so the vector is taken anyway.
            return Ok(());
        }
        // The failing exception stays pending; HardFault comes first.
        if self.enter(exception::HARD_FAULT)?.is_err() {
            self.chip_mut().core.scs[CFSR] |= 1 << 12;
        }
        Ok(())
    }
}
