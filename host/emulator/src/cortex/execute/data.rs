// SPDX-License-Identifier: GPL-2.0-only
//! Arithmetic and logic of the core registers.

use super::super::access::Bus;
use super::super::alu::shifted;
use super::super::op::{BASE, NOWHERE, Op};
use super::super::translate::Code;
use super::{At, Ended, Handler, Step, handlers, r};

/// A result that sets N and Z.
macro_rules! result {
    ($bus:ident, $d:expr, $value:expr) => {{
        let value = $value;
        r!($bus, $d) = value;
        $bus.registers.set_result(value);
    }};
}

/// What executes an operation, if it is one of these.
pub(super) fn handler(op: Op) -> Option<Handler> {
    handlers! { plain op, bus, at;
        Op::Nothing => {},
        Op::Carry(set) => bus.registers.carry = set,
        Op::SetBase(value) => r!(bus, BASE) = value,
        Op::OrrImm(d, n, imm) => r!(bus, d) = r!(bus, n) | imm,
        Op::AsrImm(d, m, amount) => r!(bus, d) = (r!(bus, m) as i32 >> (amount & 31)) as u32,
        Op::AddShifted(d, n, m, amount) => r!(bus, d) = r!(bus, n).wrapping_add(r!(bus, m) << (amount & 31)),
        Op::Alu(op, d, n, m, shift, amount) => {
                let (second, _) = shifted(r!(bus, m), shift, amount.into(), bus.registers.carry);
                r!(bus, d) = bus.registers.value(op, r!(bus, n), second);
            },
        Op::AluS(op, d, n, m, shift, amount) => {
                let (second, carry) = shifted(r!(bus, m), shift, amount.into(), bus.registers.carry);
                r!(bus, d) = bus.registers.value_with_flags(op, r!(bus, n), second, carry);
            },
        Op::Ands(d, n, m) => result!(bus, d, r!(bus, n) & r!(bus, m)),
        Op::Orrs(d, n, m) => result!(bus, d, r!(bus, n) | r!(bus, m)),
        Op::Eors(d, n, m) => result!(bus, d, r!(bus, n) ^ r!(bus, m)),
        Op::Eor(d, n, m) => r!(bus, d) = r!(bus, n) ^ r!(bus, m),
        Op::Movs(d, m) => result!(bus, d, r!(bus, m)),
        Op::AsrsImm(d, m, amount) => {
                bus.registers.carry = r!(bus, m) >> ((u32::from(amount) - 1) & 31) & 1 != 0;
                result!(bus, d, (r!(bus, m) as i32 >> (amount & 31)) as u32);
            },
        Op::AndsImm(d, n, imm) => result!(bus, d, r!(bus, n) & imm),
        Op::AluImm(op, d, n, imm) => r!(bus, d) = bus.registers.value(op, r!(bus, n), imm),
        Op::AluImmS(op, d, n, imm) => {
                let carry = bus.registers.carry;
                r!(bus, d) = bus.registers.value_with_flags(op, r!(bus, n), imm, carry);
            },
        Op::ShiftBy(shift, d, n, m, flags) => {
                let amount = r!(bus, m) & 0xFF;
                let (value, carry) = shifted(r!(bus, n), shift, amount, bus.registers.carry);
                r!(bus, d) = value;
                if flags {
                    bus.registers.carry = carry;
                    bus.registers.set_result(value);
                }
            },
        Op::Ubfx(d, n, lsb, width) => {
                r!(bus, d) = r!(bus, n) >> (lsb & 31) & u32::MAX >> ((32 - u32::from(width)) & 31)
            },
        Op::Bfi(d, n, lsb, width) => {
                let mask = (u32::MAX >> ((32 - u32::from(width)) & 31)) << (lsb & 31);
                let bits = if n == NOWHERE { 0 } else { r!(bus, n) << (lsb & 31) };
                r!(bus, d) = r!(bus, d) & !mask | bits & mask;
            },
        Op::Mul(d, n, m) => r!(bus, d) = r!(bus, n).wrapping_mul(r!(bus, m)),
        Op::Muls(d, n, m) => result!(bus, d, r!(bus, n).wrapping_mul(r!(bus, m))),
        Op::Mla(d, n, m, a) => r!(bus, d) = r!(bus, n).wrapping_mul(r!(bus, m)).wrapping_add(r!(bus, a)),
        Op::Mls(d, n, m, a) => r!(bus, d) = r!(bus, a).wrapping_sub(r!(bus, n).wrapping_mul(r!(bus, m))),
        Op::Umull(low, high, n, m) => {
                let product = u64::from(r!(bus, n)) * u64::from(r!(bus, m));
                (r!(bus, low), r!(bus, high)) = (product as u32, (product >> 32) as u32);
            },
        Op::Smull(low, high, n, m) => {
                let product = i64::from(r!(bus, n) as i32) * i64::from(r!(bus, m) as i32);
                (r!(bus, low), r!(bus, high)) = (product as u32, (product >> 32) as u32);
            },
            // By zero: zero, as the core does unless it is told to trap.
        Op::Udiv(d, n, m) => r!(bus, d) = r!(bus, n).checked_div(r!(bus, m)).unwrap_or(0),
        Op::Sdiv(d, n, m) => {
                let (n, m) = (r!(bus, n) as i32, r!(bus, m) as i32);
                r!(bus, d) = if m == 0 { 0 } else { n.wrapping_div(m) as u32 };
            },
        Op::Rare(op, d, n, m, a, x) => bus.registers.rare(op, d, n, m, a, x),
    }
}
