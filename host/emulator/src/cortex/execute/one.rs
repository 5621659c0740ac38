// SPDX-License-Identifier: GPL-2.0-only
//! Executes one operation.

use super::super::Trap;
use super::super::access::{Bus, Trapped};
use super::super::alu::shifted;
use super::super::op::{BASE, LR, NOWHERE, Op, Width};
use super::super::state::FPCA;
use super::super::system::FPDSCR;
use super::super::translate::Code;
use super::{Ended, Flow};

impl Bus<'_> {
    #[inline(always)]
    pub(super) fn one(&mut self, op: Op, code: &Code, at: usize) -> Result<Flow, Trapped> {
        let ahead = || code.ahead(at);
        // Numbers are below 32; the mask spares the check.
        macro_rules! r {
            ($n:expr) => {
                self.registers.r[usize::from($n & 31)]
            };
        }
        macro_rules! s {
            ($n:expr) => {
                self.registers.fpu.s[usize::from($n & 31)]
            };
        }
        macro_rules! float {
            ($operation:ident, $d:expr, $n:expr, $m:expr) => {{
                let (n, m) = (s!($n), s!($m));
                s!($d) = self.registers.fpu.$operation(n, m);
            }};
        }
        // Sum of a product and the destination, rounded twice, with the signs of the two.
        macro_rules! chained {
            ($d:expr, $n:expr, $m:expr, $product:expr, $addend:expr) => {{
                let (n, m, d) = (s!($n), s!($m), s!($d));
                let product = self.registers.fpu.mul(n, m) ^ $product;
                s!($d) = self.registers.fpu.add(d ^ $addend, product);
            }};
        }
        match op {
            Op::Nop => {}
            Op::If(condition, skip) => {
                if !self.registers.holds(condition) {
                    return Ok(Flow::Skip(skip));
                }
            }
            Op::Carry(set) => self.registers.carry = set,
            Op::SetBase(value) => r!(BASE) = value,
            Op::MovImm(d, imm) => r!(d) = imm,
            Op::MovsImm(d, imm) => {
                r!(d) = imm;
                self.registers.set_result(imm);
            }
            Op::Mov(d, m) => r!(d) = r!(m),
            Op::Movt(d, imm) => r!(d) = r!(d) & 0xFFFF | u32::from(imm) << 16,
            Op::AddImm(d, n, imm) => r!(d) = r!(n).wrapping_add(imm),
            Op::Add(d, n, m) => r!(d) = r!(n).wrapping_add(r!(m)),
            Op::Sub(d, n, m) => r!(d) = r!(n).wrapping_sub(r!(m)),
            Op::AddsImm(d, n, imm) => r!(d) = self.registers.sum_with_flags(r!(n), imm, false),
            Op::SubsImm(d, n, imm) => r!(d) = self.registers.sum_with_flags(r!(n), !imm, true),
            Op::CmpImm(n, imm) => {
                self.registers.sum_with_flags(r!(n), !imm, true);
            }
            Op::Cmp(n, m) => {
                self.registers.sum_with_flags(r!(n), !r!(m), true);
            }
            Op::AndImm(d, n, imm) => r!(d) = r!(n) & imm,
            Op::And(d, n, m) => r!(d) = r!(n) & r!(m),
            Op::OrrImm(d, n, imm) => r!(d) = r!(n) | imm,
            Op::Orr(d, n, m) => r!(d) = r!(n) | r!(m),
            Op::LslImm(d, m, amount) => r!(d) = r!(m) << (amount & 31),
            Op::LsrImm(d, m, amount) => r!(d) = r!(m) >> (amount & 31),
            Op::AsrImm(d, m, amount) => r!(d) = (r!(m) as i32 >> (amount & 31)) as u32,
            Op::AddShifted(d, n, m, amount) => r!(d) = r!(n).wrapping_add(r!(m) << (amount & 31)),
            Op::Alu(op, d, n, m, shift, amount) => {
                let (second, _) = shifted(r!(m), shift, amount.into(), self.registers.carry);
                r!(d) = self.registers.value(op, r!(n), second);
            }
            Op::AluS(op, d, n, m, shift, amount) => {
                let (second, carry) = shifted(r!(m), shift, amount.into(), self.registers.carry);
                r!(d) = self.registers.value_with_flags(op, r!(n), second, carry);
            }
            Op::AluImm(op, d, n, imm) => r!(d) = self.registers.value(op, r!(n), imm),
            Op::AluImmS(op, d, n, imm) => {
                let carry = self.registers.carry;
                r!(d) = self.registers.value_with_flags(op, r!(n), imm, carry);
            }
            Op::ShiftBy(shift, d, n, m, flags) => {
                let amount = r!(m) & 0xFF;
                let (value, carry) = shifted(r!(n), shift, amount, self.registers.carry);
                r!(d) = value;
                if flags {
                    self.registers.carry = carry;
                    self.registers.set_result(value);
                }
            }
            Op::Uxtb(d, m) => r!(d) = r!(m) & 0xFF,
            Op::Uxth(d, m) => r!(d) = r!(m) & 0xFFFF,
            Op::Ubfx(d, n, lsb, width) => {
                r!(d) = r!(n) >> (lsb & 31) & u32::MAX >> ((32 - u32::from(width)) & 31)
            }
            Op::Bfi(d, n, lsb, width) => {
                let mask = (u32::MAX >> ((32 - u32::from(width)) & 31)) << (lsb & 31);
                let bits = if n == NOWHERE { 0 } else { r!(n) << (lsb & 31) };
                r!(d) = r!(d) & !mask | bits & mask;
            }
            Op::Mul(d, n, m) => r!(d) = r!(n).wrapping_mul(r!(m)),
            Op::Muls(d, n, m) => {
                r!(d) = r!(n).wrapping_mul(r!(m));
                self.registers.set_result(r!(d));
            }
            Op::Mla(d, n, m, a) => r!(d) = r!(n).wrapping_mul(r!(m)).wrapping_add(r!(a)),
            Op::Mls(d, n, m, a) => r!(d) = r!(a).wrapping_sub(r!(n).wrapping_mul(r!(m))),
            Op::Umull(low, high, n, m) => {
                let product = u64::from(r!(n)) * u64::from(r!(m));
                (r!(low), r!(high)) = (product as u32, (product >> 32) as u32);
            }
            Op::Smull(low, high, n, m) => {
                let product = i64::from(r!(n) as i32) * i64::from(r!(m) as i32);
                (r!(low), r!(high)) = (product as u32, (product >> 32) as u32);
            }
            // By zero: zero, as the core does unless it is told to trap.
            Op::Udiv(d, n, m) => r!(d) = r!(n).checked_div(r!(m)).unwrap_or(0),
            Op::Sdiv(d, n, m) => {
                let (n, m) = (r!(n) as i32, r!(m) as i32);
                r!(d) = if m == 0 { 0 } else { n.wrapping_div(m) as u32 };
            }
            Op::Rare(op, d, n, m, a, x) => self.registers.rare(op, d, n, m, a, x),

            Op::Ldr(t, n, offset) => r!(t) = self.word(r!(n).wrapping_add(offset), ahead)?,
            Op::Str(t, n, offset) => self.store_word(r!(n).wrapping_add(offset), r!(t))?,
            Op::Ldrb(t, n, offset) => r!(t) = self.byte(r!(n).wrapping_add(offset), ahead)?,
            Op::Strb(t, n, offset) => self.store(Width::Byte, r!(n).wrapping_add(offset), r!(t))?,
            Op::LdrLiteral(t, address) => r!(t) = self.word(address, ahead)?,
            Op::Load(width, t, n, offset) => {
                r!(t) = self.load(width, r!(n).wrapping_add(offset), ahead)?
            }
            Op::Store(width, t, n, offset) => {
                self.store(width, r!(n).wrapping_add(offset), r!(t))?
            }
            Op::LoadIndexed(width, t, n, m, shift) => {
                let address = r!(n).wrapping_add(r!(m) << (shift & 3));
                r!(t) = self.load(width, address, ahead)?;
            }
            Op::StoreIndexed(width, t, n, m, shift) => {
                let address = r!(n).wrapping_add(r!(m) << (shift & 3));
                self.store(width, address, r!(t))?;
            }
            Op::LoadUpdate(width, t, n, pre, offset) => {
                let (address, after) = updated(r!(n), pre, offset);
                let value = self.load(width, address, ahead)?;
                r!(n) = after;
                r!(t) = value;
            }
            Op::StoreUpdate(width, t, n, pre, offset) => {
                let (address, after) = updated(r!(n), pre, offset);
                self.store(width, address, r!(t))?;
                r!(n) = after;
            }
            Op::Ldrd(t, t2, n, offset) => {
                let address = r!(n).wrapping_add(offset);
                let first = self.word(address, ahead)?;
                let second = self.word(address.wrapping_add(4), ahead)?;
                (r!(t), r!(t2)) = (first, second);
            }
            Op::Strd(t, t2, n, offset) => {
                let address = r!(n).wrapping_add(offset);
                self.store_word(address, r!(t))?;
                self.store_word(address.wrapping_add(4), r!(t2))?;
            }
            Op::LdrdUpdate(t, t2, n, pre, offset) => {
                let (address, after) = updated(r!(n), pre, offset);
                let first = self.word(address, ahead)?;
                let second = self.word(address.wrapping_add(4), ahead)?;
                (r!(t), r!(t2)) = (first, second);
                r!(n) = after;
            }
            Op::StrdUpdate(t, t2, n, pre, offset) => {
                let (address, after) = updated(r!(n), pre, offset);
                self.store_word(address, r!(t))?;
                self.store_word(address.wrapping_add(4), r!(t2))?;
                r!(n) = after;
            }
            Op::Ldm(n, down, update, list) => {
                let (mut address, after) = block(r!(n), down, list.count_ones());
                let mut rest = list;
                while rest != 0 {
                    let t = rest.trailing_zeros() as u8;
                    rest &= rest - 1;
                    r!(t) = self.word(address, ahead)?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(n) = after;
                }
            }
            Op::Stm(n, down, update, list) => {
                let (mut address, after) = block(r!(n), down, list.count_ones());
                let mut rest = list;
                while rest != 0 {
                    let t = rest.trailing_zeros() as u8;
                    rest &= rest - 1;
                    self.store_word(address, r!(t))?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(n) = after;
                }
            }
            Op::Ldrex(width, t, n, offset) => {
                let address = r!(n).wrapping_add(offset);
                let value = self.load(width, address, ahead)?;
                self.registers.exclusive = Some((address, value));
                r!(t) = value;
            }
            Op::Strex(width, d, t, n, offset) => {
                let address = r!(n).wrapping_add(offset.into());
                let exclusive = self.registers.exclusive.take();
                let unchanged = match exclusive {
                    Some((at, value)) if at == address => {
                        self.load(width, address, ahead)? == value
                    }
                    _ => false,
                };
                if unchanged {
                    self.store(width, address, r!(t))?;
                }
                r!(d) = u32::from(!unchanged);
            }
            Op::Clrex => self.registers.exclusive = None,

            Op::Branch(target) => return self.jump(target),
            Op::BranchIf(condition, target) => {
                if self.registers.holds(condition) {
                    return self.jump(target);
                }
            }
            Op::BranchZero(n, target) => {
                if r!(n) == 0 {
                    return self.jump(target);
                }
            }
            Op::BranchNotZero(n, target) => {
                if r!(n) != 0 {
                    return self.jump(target);
                }
            }
            Op::Call(target) => {
                r!(LR) = code.end | 1;
                return self.jump(target);
            }
            Op::CallRegister(m) => {
                let target = r!(m);
                r!(LR) = code.end | 1;
                self.registers.pc = target & !1;
                if target & 1 == 0 {
                    return self.after(Trap::Undefined { encoding: None });
                }
                return Ok(Flow::End(Ended::Next));
            }
            Op::Exchange(m) => return self.exchange(r!(m)),
            Op::Jump(m) => return self.jump(r!(m)),
            Op::Table(n, m, half, from) => {
                let (width, index) = if half {
                    (Width::Half, r!(m) << 1)
                } else {
                    (Width::Byte, r!(m))
                };
                let entry = self.load(width, r!(n).wrapping_add(index), ahead)?;
                return self.jump(from.wrapping_add(2 * entry));
            }

            Op::ReadSpecial(d, special) => r!(d) = self.registers.special(special),
            Op::WriteSpecial(n, mask, special) => self.registers.set_special(special, mask, r!(n)),
            Op::ChangeMasks(disable, primask, faultmask) => {
                if primask {
                    self.registers.primask = disable;
                }
                if faultmask {
                    self.registers.faultmask = disable;
                }
            }
            Op::Supervisor => return self.after(Trap::Supervisor),
            Op::Breakpoint => return Err(self.trap(Trap::Breakpoint)),
            Op::Undefined(encoding) => {
                return Err(self.trap(Trap::Undefined {
                    encoding: Some(encoding),
                }));
            }
            Op::WaitForInterrupt => return Ok(Flow::End(Ended::WaitForInterrupt)),
            Op::WaitForEvent => {
                if !std::mem::take(&mut self.chip.core.event) {
                    return self.after(Trap::WaitForEvent);
                }
            }

            Op::Context => {
                if self.registers.control & FPCA == 0 {
                    self.registers.control |= FPCA;
                    self.registers.fpu.set_status(self.chip.core.scs[FPDSCR]);
                }
            }
            Op::Vldr(d, n, offset) => s!(d) = self.word(r!(n).wrapping_add(offset), ahead)?,
            Op::Vstr(d, n, offset) => self.store_word(r!(n).wrapping_add(offset), s!(d))?,
            Op::VldrLiteral(d, address) => s!(d) = self.word(address, ahead)?,
            Op::Vldm(n, first, count, down, update, extra) => {
                let words = u32::from(count) + u32::from(extra);
                let (mut address, after) = block(r!(n), down, words);
                for d in first..first + count {
                    s!(d) = self.word(address, ahead)?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(n) = after;
                }
            }
            Op::Vstm(n, first, count, down, update, extra) => {
                let words = u32::from(count) + u32::from(extra);
                let (mut address, after) = block(r!(n), down, words);
                for d in first..first + count {
                    self.store_word(address, s!(d))?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(n) = after;
                }
            }
            Op::VmovToS(d, t) => s!(d) = r!(t),
            Op::VmovToR(t, n) => r!(t) = s!(n),
            Op::VmovPairToS(d, t, t2) => (s!(d), s!(d + 1)) = (r!(t), r!(t2)),
            Op::VmovPairToR(d, t, t2) => (r!(t), r!(t2)) = (s!(d), s!(d + 1)),
            Op::VmovImm(d, imm) => s!(d) = imm,
            Op::Vmov(d, m) => s!(d) = s!(m),
            Op::Vabs(d, m) => s!(d) = s!(m) & !SIGN,
            Op::Vneg(d, m) => s!(d) = s!(m) ^ SIGN,
            Op::Vsqrt(d, m) => {
                let m = s!(m);
                s!(d) = self.registers.fpu.sqrt(m);
            }
            Op::Vadd(d, n, m) => float!(add, d, n, m),
            Op::Vsub(d, n, m) => float!(sub, d, n, m),
            Op::Vmul(d, n, m) => float!(mul, d, n, m),
            Op::Vnmul(d, n, m) => {
                let (n, m) = (s!(n), s!(m));
                s!(d) = self.registers.fpu.mul(n, m) ^ SIGN;
            }
            Op::Vdiv(d, n, m) => float!(div, d, n, m),
            Op::Vmla(d, n, m) => chained!(d, n, m, 0, 0),
            Op::Vmls(d, n, m) => chained!(d, n, m, SIGN, 0),
            Op::Vnmla(d, n, m) => chained!(d, n, m, SIGN, SIGN),
            Op::Vnmls(d, n, m) => chained!(d, n, m, 0, SIGN),
            Op::Vfma(d, n, m, negate, negate_first) => {
                let sign = |negate| if negate { SIGN } else { 0 };
                let (a, b, c) = (s!(n) ^ sign(negate_first), s!(m), s!(d) ^ sign(negate));
                s!(d) = self.registers.fpu.fused(a, b, c);
            }
            Op::Vcmp(d, m, signals) => {
                let (d, m) = (s!(d), s!(m));
                self.registers.fpu.compare(d, m, signals);
            }
            Op::VcmpZero(d, signals) => {
                let d = s!(d);
                self.registers.fpu.compare(d, 0, signals);
            }
            Op::Vcvt(kind, d, m, fraction) => {
                s!(d) = self.registers.fpu.convert(kind, s!(m), fraction)
            }
            Op::VmrsFlags => {
                let conditions = self.registers.fpu.status() >> 28;
                self.registers.set_conditions(conditions);
            }
            Op::Vmrs(t) => r!(t) = self.registers.fpu.status(),
            Op::Vmsr(t) => {
                let status = r!(t);
                self.registers.fpu.set_status(status);
            }
        }
        Ok(Flow::Next)
    }
}

const SIGN: u32 = 1 << 31;

/// Address of an access with write-back, and the base after it.
fn updated(base: u32, pre: bool, offset: i16) -> (u32, u32) {
    let after = base.wrapping_add_signed(offset.into());
    (if pre { after } else { base }, after)
}

/// First address of an access to several words, and the base after it.
fn block(base: u32, down: bool, words: u32) -> (u32, u32) {
    if down {
        let start = base.wrapping_sub(4 * words);
        (start, start)
    } else {
        (base, base.wrapping_add(4 * words))
    }
}
