// SPDX-License-Identifier: GPL-2.0-only
//! The frequent operations, and which of them are executed together.

use std::hint::select_unpredictable;
use std::marker::PhantomData;

use super::super::access::Bus;
use super::super::op::{Alu, LR, Op, Width};
use super::super::state::FPCA;
use super::super::system::FPDSCR;
use super::super::translate::Code;
use super::action::{Action, Alone, Assign, Behind, If, Seam, Select, Then, When, actions};
use super::float::SIGN;
use super::transfer::{Numbers, block};
use super::{Ended, Handler, Step, elsewhere, r, s};
use crate::cortex::fuse::SIGNALS;

/// A result that sets N and Z.
macro_rules! result {
    ($bus:ident, $d:expr, $value:expr) => {{
        let value = $value;
        r!($bus, $d) = value;
        $bus.registers.set_result(value);
    }};
}

actions! { assign assigning, conditional, bus;
    MovImm: Op::MovImm(d, imm) => r d = imm,
    Mov: Op::Mov(d, m) => r d = r!(bus, m),
    AddImm: Op::AddImm(d, n, imm) => r d = r!(bus, n).wrapping_add(imm),
    Negate: Op::AluImm(Alu::Rsb, d, n, imm) => r d = imm.wrapping_sub(r!(bus, n)),
    VmovImm: Op::VmovImm(d, imm) => s d = imm,
    Vmov: Op::Vmov(d, m) => s d = s!(bus, m),
}

actions! { plain plain, bus, code;
    MovsImm: Op::MovsImm(d, imm) => result!(bus, d, imm),
    Movt: Op::Movt(d, imm) => r!(bus, d) = r!(bus, d) & 0xFFFF | u32::from(imm) << 16,
    Add: Op::Add(d, n, m) => r!(bus, d) = r!(bus, n).wrapping_add(r!(bus, m)),
    AddsImm: Op::AddsImm(d, n, imm) => r!(bus, d) = bus.registers.sum_with_flags(r!(bus, n), imm, false),
    Subs: Op::Subs(d, n, m) => r!(bus, d) = bus.registers.sum_with_flags(r!(bus, n), !r!(bus, m), true),
    CmpImm: Op::CmpImm(n, imm) => bus.registers.sum_with_flags(r!(bus, n), !imm, true),
    Cmp: Op::Cmp(n, m) => bus.registers.sum_with_flags(r!(bus, n), !r!(bus, m), true),
    AndImm: Op::AndImm(d, n, imm) => r!(bus, d) = r!(bus, n) & imm,
    LslsImm: Op::LslsImm(d, m, amount) => {
        bus.registers.carry = r!(bus, m) >> ((32 - u32::from(amount)) & 31) & 1 != 0;
        result!(bus, d, r!(bus, m) << (amount & 31));
    },
    Uxth: Op::Uxth(d, m) => r!(bus, d) = r!(bus, m) & 0xFFFF,
    VmovToS: Op::VmovToS(d, t) => s!(bus, d) = r!(bus, t),
    Vabs: Op::Vabs(d, m) => s!(bus, d) = s!(bus, m) & !SIGN,
    VmrsFlags: Op::VmrsFlags => {
        let conditions = bus.registers.fpu.status() >> 28;
        bus.registers.set_conditions(conditions);
    },
    Context: Op::Context => {
        if bus.registers.control & FPCA == 0 {
            bus.registers.control |= FPCA;
            bus.registers.fpu.set_status(bus.chip.core.scs[FPDSCR]);
        }
    },
}

actions! { plain less_plain, bus, code;
    Sub: Op::Sub(d, n, m) => r!(bus, d) = r!(bus, n).wrapping_sub(r!(bus, m)),
    Adds: Op::Adds(d, n, m) => r!(bus, d) = bus.registers.sum_with_flags(r!(bus, n), r!(bus, m), false),
    And: Op::And(d, n, m) => r!(bus, d) = r!(bus, n) & r!(bus, m),
    Orr: Op::Orr(d, n, m) => r!(bus, d) = r!(bus, n) | r!(bus, m),
    LslImm: Op::LslImm(d, m, amount) => r!(bus, d) = r!(bus, m) << (amount & 31),
    LsrImm: Op::LsrImm(d, m, amount) => r!(bus, d) = r!(bus, m) >> (amount & 31),
    SubsImm: Op::SubsImm(d, n, imm) => r!(bus, d) = bus.registers.sum_with_flags(r!(bus, n), !imm, true),
    LsrsImm: Op::LsrsImm(d, m, amount) => {
        bus.registers.carry = r!(bus, m) >> ((u32::from(amount) - 1) & 31) & 1 != 0;
        result!(bus, d, r!(bus, m) >> (amount & 31));
    },
    VmovToR: Op::VmovToR(t, n) => r!(bus, t) = s!(bus, n),
    Vneg: Op::Vneg(d, m) => s!(bus, d) = s!(bus, m) ^ SIGN,
    Uxtb: Op::Uxtb(d, m) => r!(bus, d) = r!(bus, m) & 0xFF,
}

// In RAM or on constants of the program, on numbers without special results: a function that calls nothing that comes back needs no
// registers saved.
actions! { quick quick, bus, code;
    Ldr: Op::Ldr(t, n, offset) => r!(bus, t) = u32::from_le_bytes(bus.known(r!(bus, n).wrapping_add(offset))?),
    Ldrb: Op::Ldrb(t, n, offset) => {
        let [byte] = bus.known(r!(bus, n).wrapping_add(offset))?;
        r!(bus, t) = byte.into();
    },
    Str: Op::Str(t, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        bus.memory.store(address, r!(bus, t).to_le_bytes())?;
    },
    Strb: Op::Strb(t, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        bus.memory.store(address, [r!(bus, t) as u8])?;
    },
    Strh: Op::Store(Width::Half, t, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        bus.memory.store(address, (r!(bus, t) as u16).to_le_bytes())?;
    },
    Vldr: Op::Vldr(d, n, offset) => s!(bus, d) = u32::from_le_bytes(bus.known(r!(bus, n).wrapping_add(offset))?),
    Vstr: Op::Vstr(d, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        bus.memory.store(address, s!(bus, d).to_le_bytes())?;
    },
    Vadd: Op::Vadd(d, n, m) => s!(bus, d) = bus.registers.fpu.quick_add(s!(bus, n), s!(bus, m))?,
    Vsub: Op::Vsub(d, n, m) => s!(bus, d) = bus.registers.fpu.quick_sub(s!(bus, n), s!(bus, m))?,
    Vmul: Op::Vmul(d, n, m) => s!(bus, d) = bus.registers.fpu.quick_mul(s!(bus, n), s!(bus, m))?,
    Vmla: Op::Vmla(d, n, m) => {
        let fpu = &bus.registers.fpu;
        let product = fpu.quick_mul(s!(bus, n), s!(bus, m))?;
        s!(bus, d) = fpu.quick_add(s!(bus, d), product)?;
    },
    VcmpZero: Op::VcmpZero(d, _) => bus.registers.fpu.quick_compare(s!(bus, d), 0)?,
}

actions! { quick less_quick, bus, code;
    Ldrh: Op::Load(Width::Half, t, n, offset) => {
        r!(bus, t) = u16::from_le_bytes(bus.known(r!(bus, n).wrapping_add(offset))?).into();
    },
    LdrIndexed: Op::LoadIndexed(Width::Word, t, n, m, shift) => {
        let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
        r!(bus, t) = u32::from_le_bytes(bus.known(address)?);
    },
    LdrbIndexed: Op::LoadIndexed(Width::Byte, t, n, m, shift) => {
        let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
        let [byte] = bus.known(address)?;
        r!(bus, t) = byte.into();
    },
    Ldrd: Op::Ldrd(t, t2, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        let (first, second) = (bus.known(address)?, bus.known(address.wrapping_add(4))?);
        r!(bus, t) = u32::from_le_bytes(first);
        r!(bus, t2) = u32::from_le_bytes(second);
    },
    Stm: Op::Stm(n, down, update, list) => {
        let count = list.count_ones();
        let (address, after) = block(r!(bus, n), down, count);
        for (t, word) in Numbers(list).zip(bus.memory.words_mut(address, count)?) {
            *word = r!(bus, t).to_le_bytes();
        }
        if update {
            r!(bus, n) = after;
        }
    },
    Strd: Op::Strd(t, t2, n, offset) => {
        let address = r!(bus, n).wrapping_add(offset);
        let [first, second] = [t, t2].map(|t| r!(bus, t).to_le_bytes());
        let words = bus.memory.words_mut(address, 2)?;
        words.copy_from_slice(&[first, second]);
    },
    Vstm: Op::Vstm(n, first, count, down, update, extra) => {
        let words = u32::from(count) + u32::from(extra);
        let (address, after) = block(r!(bus, n), down, words);
        let memory = bus.memory.words_mut(address, count.into())?;
        for (d, word) in (first..first + count).zip(memory) {
            *word = s!(bus, d).to_le_bytes();
        }
        if update {
            r!(bus, n) = after;
        }
    },
    Vldm: Op::Vldm(n, first, count, down, update, extra) => {
        let words = u32::from(count) + u32::from(extra);
        let (address, after) = block(r!(bus, n), down, words);
        for (d, word) in (first..first + count).zip(bus.memory.words(address, count.into())?) {
            s!(bus, d) = u32::from_le_bytes(*word);
        }
        if update {
            r!(bus, n) = after;
        }
    },
    Ldm: Op::Ldm(n, down, update, list) => {
        let count = list.count_ones();
        let (address, after) = block(r!(bus, n), down, count);
        for (t, word) in Numbers(list).zip(bus.memory.words(address, count)?) {
            r!(bus, t) = u32::from_le_bytes(*word);
        }
        if update {
            r!(bus, n) = after;
        }
    },
    Vcmp: Op::Vcmp(d, m, _) => bus.registers.fpu.quick_compare(s!(bus, d), s!(bus, m))?,
    VcmpFlags: Op::VcmpFlags(d, m, _) => {
        let conditions = bus.registers.fpu.quick_compare(s!(bus, d), s!(bus, m))?;
        bus.registers.set_conditions(conditions);
    },
    VcmpZeroFlags: Op::VcmpZeroFlags(d, _) => {
        let conditions = bus.registers.fpu.quick_compare(s!(bus, d), 0)?;
        bus.registers.set_conditions(conditions);
    },
}

// Their stretches end with them. At their end stands the program counter.
actions! { jumping jumping, bus, code;
    CmpImmBranch: Op::CmpImmBranch(n, imm, condition, target) => {
        bus.registers.sum_with_flags(r!(bus, n), !u32::from(imm), true);
        bus.registers.holds(condition).then_some(target)
    },
    CmpBranch: Op::CmpBranch(n, m, condition, target) => {
        bus.registers.sum_with_flags(r!(bus, n), !r!(bus, m), true);
        bus.registers.holds(condition).then_some(target)
    },
    VcmpBranch: Op::VcmpBranch(d, m, how, target) => {
        bus.registers.compare(s!(bus, d), s!(bus, m), how & SIGNALS != 0);
        bus.registers.holds(how).then_some(target)
    },
    VcmpZeroBranch: Op::VcmpZeroBranch(d, how, target) => {
        bus.registers.compare(s!(bus, d), 0, how & SIGNALS != 0);
        bus.registers.holds(how).then_some(target)
    },
    BranchIf: Op::BranchIf(condition, target) => bus.registers.holds(condition).then_some(target),
    BranchZero: Op::BranchZero(n, target) => (r!(bus, n) == 0).then_some(target),
    BranchNotZero: Op::BranchNotZero(n, target) => (r!(bus, n) != 0).then_some(target),
}

actions! { crossing crossing, bus, code;
    Branch: Op::Branch(target) => bus.registers.pc = target & !1,
    Call: Op::Call(target) => {
        r!(bus, LR) = bus.registers.pc | 1;
        bus.registers.pc = target & !1;
    },
}

actions! { ending ending, bus, code;
    Exchange: Op::Exchange(m) => bus.exchange(r!(bus, m)),
}

/// One operation, or a conditional one with its condition, of those that others follow; and what is behind.
fn going(ops: &[Op], select: impl Select) -> Option<Handler> {
    match *ops {
        [Op::If(_, 1), op, ..] => conditional(op, select),
        [op, ..] => assigning(op, select)
            .or_else(|| plain(op, select))
            .or_else(|| quick(op, select)),
        [] => None,
    }
}

/// One operation that others need not follow.
fn any(ops: &[Op], select: impl Select) -> Option<Handler> {
    let &op = ops.first()?;
    going(ops, select)
        .or_else(|| less_plain(op, select))
        .or_else(|| less_quick(op, select))
        .or_else(|| jumping(op, select))
        .or_else(|| crossing(op, select))
        .or_else(|| ending(op, select))
        .or_else(|| match op {
            Op::If(..) => select.of::<If>(),
            Op::Seam(..) => select.of::<Seam>(),
            _ => None,
        })
}

/// Selects what is executed behind an action.
#[derive(Clone, Copy)]
struct Before<'a>(&'a [Op]);

impl Select for Before<'_> {
    fn of<A: Action>(self) -> Option<Handler> {
        any(self.0, Behind::<A>(PhantomData))
    }
}

/// What executes the first of these operations, or it and the next one.
pub(super) fn handler(ops: &[Op]) -> Option<Handler> {
    let ([Op::If(_, 1), _, rest @ ..] | [_, rest @ ..]) = ops else {
        return None;
    };
    going(ops, Before(rest)).or_else(|| any(ops, Alone))
}
