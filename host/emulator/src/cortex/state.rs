// SPDX-License-Identifier: GPL-2.0-only
//! Registers of the core.

use super::float::Fpu;

const THUMB: u32 = 1 << 24;
/// CONTROL: floating-point context active.
pub(super) const FPCA: u32 = 4;
/// CONTROL: thread mode uses the process stack.
pub(super) const SPSEL: u32 = 2;

/// All registers of the core.
#[derive(Clone, Debug)]
pub(crate) struct Registers {
    /// r0 to r12, the active stack pointer, lr; above, what only the interpreter uses.
    pub(super) r: [u32; 32],
    /// Address of the next instruction.
    pub(super) pc: u32,
    /// Sign in bit 31.
    pub(super) negative: u32,
    /// Zero if the flag is set.
    pub(super) nonzero: u32,
    pub(super) carry: bool,
    pub(super) overflow: bool,
    pub(super) saturated: bool,
    /// Greater-or-equal flags, bits 3:0.
    pub(super) ge: u8,
    /// IT state of the next instruction.
    pub(super) it: u8,
    /// Number of the running exception; 0 in thread mode.
    pub(super) exception: u16,
    /// The stack pointer that is not active.
    other_stack: u32,
    pub(super) control: u32,
    pub(super) primask: bool,
    pub(super) faultmask: bool,
    pub(super) basepri: u8,
    pub(super) fpu: Fpu,
    /// Address and value of an exclusive load.
    pub(super) exclusive: Option<(u32, u32)>,
}

impl Registers {
    pub(super) fn new() -> Self {
        Self {
            r: [0; 32],
            pc: 0,
            negative: 0,
            nonzero: 1,
            carry: false,
            overflow: false,
            saturated: false,
            ge: 0,
            it: 0,
            exception: 0,
            other_stack: 0,
            control: 0,
            primask: false,
            faultmask: false,
            basepri: 0,
            fpu: Fpu::new(),
            exclusive: None,
        }
    }

    /// As after a reset, which leaves the floating-point registers.
    pub(super) fn reset(&mut self, stack: u32, entry: u32) {
        let fpu = std::mem::replace(&mut self.fpu, Fpu::new());
        *self = Self::new();
        self.fpu = fpu;
        self.fpu.set_status(0);
        self.r[13] = stack & !3;
        self.r[14] = u32::MAX;
        self.pc = entry & !1;
    }

    /// Register 0 to 15.
    pub(crate) fn get(&self, n: usize) -> u32 {
        if n == 15 { self.pc } else { self.r[n & 31] }
    }

    /// Sets register 0 to 15.
    pub(super) fn set(&mut self, n: usize, value: u32) {
        match n {
            13 => self.r[13] = value & !3,
            15 => self.pc = value & !1,
            _ => self.r[n & 31] = value,
        }
    }

    /// N, Z, C and V in bits 3:0.
    #[inline(always)]
    pub(super) fn conditions(&self) -> u32 {
        self.negative >> 31 << 3
            | u32::from(self.nonzero == 0) << 2
            | u32::from(self.carry) << 1
            | u32::from(self.overflow)
    }

    pub(super) fn set_conditions(&mut self, nzcv: u32) {
        self.negative = nzcv << 28;
        self.nonzero = !nzcv & 4;
        self.carry = nzcv & 2 != 0;
        self.overflow = nzcv & 1 != 0;
    }

    /// Whether a condition holds.
    #[inline(always)]
    pub(super) fn holds(&self, condition: u8) -> bool {
        // By condition, one bit for each value of N, Z, C and V.
        const TRUE_FOR: [u16; 16] = [
            0xF0F0, 0x0F0F, 0xCCCC, 0x3333, 0xFF00, 0x00FF, 0xAAAA, 0x5555, 0x0C0C, 0xF3F3, 0xAA55,
            0x55AA, 0x0A05, 0xF5FA, 0xFFFF, 0xFFFF,
        ];
        TRUE_FOR[usize::from(condition & 15)] >> self.conditions() & 1 != 0
    }

    /// The status register.
    pub(crate) fn xpsr(&self) -> u32 {
        let it = u32::from(self.it);
        self.conditions() << 28
            | u32::from(self.saturated) << 27
            | (it & 3) << 25
            | THUMB
            | u32::from(self.ge) << 16
            | (it & 0xFC) << 8
            | u32::from(self.exception)
    }

    /// Sets the status register, and with the exception's number the active stack pointer.
    pub(super) fn set_xpsr(&mut self, value: u32) {
        self.set_conditions(value >> 28);
        self.saturated = value >> 27 & 1 != 0;
        self.ge = (value >> 16 & 0xF) as u8;
        self.it = (value >> 25 & 3 | value >> 8 & 0xFC) as u8;
        self.set_mode((value & 0x1FF) as u16, self.control);
    }

    fn on_process_stack(&self) -> bool {
        self.exception == 0 && self.control & SPSEL != 0
    }

    /// Changes exception and CONTROL; the stack pointer follows.
    pub(super) fn set_mode(&mut self, exception: u16, control: u32) {
        let before = self.on_process_stack();
        (self.exception, self.control) = (exception, control & 7);
        if before != self.on_process_stack() {
            std::mem::swap(&mut self.r[13], &mut self.other_stack);
        }
    }

    /// Main and process stack pointer.
    pub(crate) fn stacks(&self) -> [u32; 2] {
        let both = [self.r[13], self.other_stack];
        if self.on_process_stack() {
            [both[1], both[0]]
        } else {
            both
        }
    }

    pub(super) fn set_main_stack(&mut self, value: u32) {
        let active = !self.on_process_stack();
        *(if active {
            &mut self.r[13]
        } else {
            &mut self.other_stack
        }) = value & !3;
    }

    pub(super) fn set_process_stack(&mut self, value: u32) {
        let active = self.on_process_stack();
        *(if active {
            &mut self.r[13]
        } else {
            &mut self.other_stack
        }) = value & !3;
    }

    /// A double-precision register, as the debugger shows them.
    pub(crate) fn double(&self, n: usize) -> u64 {
        let s = &self.fpu.s;
        u64::from(s[(2 * n) & 31]) | u64::from(s[(2 * n + 1) & 31]) << 32
    }

    pub(super) fn set_double(&mut self, n: usize, value: u64) {
        let s = &mut self.fpu.s;
        (s[(2 * n) & 31], s[(2 * n + 1) & 31]) = (value as u32, (value >> 32) as u32);
    }

    /// MRS.
    pub(super) fn special(&self, which: u8) -> u32 {
        let [main, process] = self.stacks();
        match which {
            0..=7 => {
                let exception = if which & 1 != 0 { 0x1FF } else { 0 };
                let flags = if which & 4 == 0 { 0xF80F_0000 } else { 0 };
                self.xpsr() & (exception | flags)
            }
            8 => main,
            9 => process,
            16 => self.primask.into(),
            17 | 18 => self.basepri.into(),
            19 => self.faultmask.into(),
            20 => self.control,
            _ => 0,
        }
    }

    /// MSR.
    pub(super) fn set_special(&mut self, which: u8, mask: u8, value: u32) {
        match which {
            0..=3 => {
                if mask & 8 != 0 {
                    self.set_conditions(value >> 28);
                    self.saturated = value >> 27 & 1 != 0;
                }
                if mask & 4 != 0 {
                    self.ge = (value >> 16 & 0xF) as u8;
                }
            }
            8 => self.set_main_stack(value),
            9 => self.set_process_stack(value),
            16 => self.primask = value & 1 != 0,
            17 => self.basepri = value as u8,
            18 => {
                let new = value as u8;
                if new != 0 && (new < self.basepri || self.basepri == 0) {
                    self.basepri = new;
                }
            }
            19 => self.faultmask = value & 1 != 0,
            20 => {
                // In handler mode the stack is not chosen here.
                let changes = if self.exception == 0 { 7 } else { 5 };
                self.set_mode(self.exception, self.control & !changes | value & changes);
            }
            _ => {}
        }
    }
}
