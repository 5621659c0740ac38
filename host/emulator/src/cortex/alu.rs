// SPDX-License-Identifier: GPL-2.0-only
//! Arithmetic and logic with flags.

use super::op::{Alu, Shift};
use super::state::Registers;

/// Shifts by a constant or the lower byte of a register: result and carry.
#[inline]
pub(super) fn shifted(value: u32, shift: Shift, amount: u32, carry: bool) -> (u32, bool) {
    let bit = |n: u32| value >> (n & 31) & 1 != 0;
    match (shift, amount) {
        (Shift::None, _) | (Shift::Lsl | Shift::Lsr | Shift::Asr | Shift::Ror, 0) => (value, carry),
        (Shift::Lsl, 1..32) => (value << amount, bit(32 - amount)),
        (Shift::Lsl, _) => (0, amount == 32 && bit(0)),
        (Shift::Lsr, 1..32) => (value >> amount, bit(amount - 1)),
        (Shift::Lsr, _) => (0, amount == 32 && bit(31)),
        (Shift::Asr, 1..32) => ((value as i32 >> amount) as u32, bit(amount - 1)),
        (Shift::Asr, _) => ((value as i32 >> 31) as u32, bit(31)),
        (Shift::Ror, _) => (value.rotate_right(amount), bit(amount.wrapping_sub(1))),
        (Shift::Rrx, _) => (value >> 1 | u32::from(carry) << 31, bit(0)),
    }
}

/// Sum with carry, its carry and overflow.
#[inline(always)]
fn sum(a: u32, b: u32, carry: bool) -> (u32, bool, bool) {
    let exact = u64::from(a) + u64::from(b) + u64::from(carry);
    let value = exact as u32;
    (value, exact >> 32 != 0, (!(a ^ b) & (a ^ value)) >> 31 != 0)
}

impl Registers {
    /// Result without flags.
    #[inline]
    pub(super) fn value(&self, op: Alu, a: u32, b: u32) -> u32 {
        match op {
            Alu::And => a & b,
            Alu::Bic => a & !b,
            Alu::Orr => a | b,
            Alu::Orn => a | !b,
            Alu::Eor => a ^ b,
            Alu::Add => a.wrapping_add(b),
            Alu::Adc => a.wrapping_add(b).wrapping_add(self.carry.into()),
            Alu::Sub => a.wrapping_sub(b),
            Alu::Sbc => a.wrapping_add(!b).wrapping_add(self.carry.into()),
            Alu::Rsb => b.wrapping_sub(a),
            Alu::Mov => b,
            Alu::Mvn => !b,
        }
    }

    /// Result with flags; `carry` is that of the shift, which logical operations leave.
    #[inline]
    pub(super) fn value_with_flags(&mut self, op: Alu, a: u32, b: u32, carry: bool) -> u32 {
        match op {
            Alu::Add => self.sum_with_flags(a, b, false),
            Alu::Adc => self.sum_with_flags(a, b, self.carry),
            Alu::Sub => self.sum_with_flags(a, !b, true),
            Alu::Sbc => self.sum_with_flags(a, !b, self.carry),
            Alu::Rsb => self.sum_with_flags(!a, b, true),
            _ => {
                let value = self.value(op, a, b);
                self.carry = carry;
                self.set_result(value);
                value
            }
        }
    }

    #[inline(always)]
    pub(super) fn sum_with_flags(&mut self, a: u32, b: u32, carry: bool) -> u32 {
        let value;
        (value, self.carry, self.overflow) = sum(a, b, carry);
        self.set_result(value);
        value
    }

    /// Compares floating-point numbers, and moves the flags.
    #[inline(always)]
    pub(super) fn compare(&mut self, a: u32, b: u32, signals: bool) {
        let quick = self.fpu.quick_compare(a, b);
        let conditions = quick.unwrap_or_else(|| self.fpu.compare(a, b, signals));
        self.set_conditions(conditions);
    }

    /// N and Z of a result.
    #[inline(always)]
    pub(super) fn set_result(&mut self, value: u32) {
        (self.negative, self.nonzero) = (value, value);
    }
}
