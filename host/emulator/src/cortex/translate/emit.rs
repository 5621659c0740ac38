// SPDX-License-Identifier: GPL-2.0-only
//! Operations for instructions of several encodings, with as much resolved as is known: constants, literals, shifts.

use super::super::Map;
use super::super::memory::{PROGRAM_SIZE, flash_offset};
use super::super::op::{Alu, BASE, NOWHERE, Op, PC, Rare, Shift, Width};
use super::{Ends, Translator};

impl Translator<'_> {
    /// A word of the program or of the CCM SRAM beside this code: a store there drops the blocks that have taken it.
    fn constant_at(&mut self, address: u32) -> Option<u32> {
        let in_program =
            |address| flash_offset(address).is_some_and(|offset| offset <= PROGRAM_SIZE - 4);
        let in_ccm = |address: u32| address.wrapping_sub(Map::CCM) <= Map::CCM_SIZE - 4;
        let beside = in_ccm(address) && in_ccm(self.begin);
        if !in_program(address) && !beside {
            return None;
        }
        let low = (self.fetch)(address)?;
        let high = (self.fetch)(address.wrapping_add(2))?;
        if beside {
            let (from, to) = self.taken;
            self.taken = (from.min(address), to.max(address + 4));
        }
        Some(u32::from(low) | u32::from(high) << 16)
    }

    /// A load of a literal.
    pub(in crate::cortex) fn literal(&mut self, t: u8, address: u32) {
        let op = match self.constant_at(address) {
            Some(value) => Op::MovImm(t, value),
            None => Op::LdrLiteral(t, address),
        };
        self.emit(op);
    }

    /// A load of a literal of the floating-point unit.
    pub(in crate::cortex) fn floating_literal(&mut self, d: u8, address: u32) {
        let op = match self.constant_at(address) {
            Some(value) => Op::VmovImm(d, value),
            None => Op::VldrLiteral(d, address),
        };
        self.emit(op);
    }

    /// Base register of an access; the program counter becomes a constant.
    pub(in crate::cortex) fn base(&mut self, n: u8) -> u8 {
        if n != PC {
            return n;
        }
        self.emit(Op::SetBase(self.literal_base()));
        BASE
    }

    /// A floating-point instruction follows, which creates a context if there is none.
    pub(in crate::cortex) fn need_context(&mut self) {
        if !self.in_context {
            self.emit(Op::Context);
            // A conditional one may be left out.
            self.in_context = self.flags();
        }
    }

    pub(in crate::cortex) fn undefined(&mut self, encoding: u32) -> Ends {
        self.emit(Op::Undefined(encoding));
        Ends::Yes
    }

    pub(in crate::cortex) fn rare(&mut self, op: Rare, d: u8, n: u8, m: u8, a: u8, x: u8) {
        self.emit(Op::Rare(op, d, n, m, a, x));
    }

    pub(in crate::cortex) fn load(&mut self, width: Width, t: u8, n: u8, offset: u32) {
        self.emit(match width {
            Width::Word => Op::Ldr(t, n, offset),
            Width::Byte => Op::Ldrb(t, n, offset),
            _ => Op::Load(width, t, n, offset),
        });
    }

    pub(in crate::cortex) fn store(&mut self, width: Width, t: u8, n: u8, offset: u32) {
        self.emit(match width {
            Width::Word => Op::Str(t, n, offset),
            Width::Byte => Op::Strb(t, n, offset),
            _ => Op::Store(width, t, n, offset),
        });
    }

    /// A register and a constant.
    pub(in crate::cortex) fn constant(&mut self, op: Alu, d: u8, n: u8, imm: u32, flags: bool) {
        self.emit(match (op, flags) {
            (Alu::Mov, false) => Op::MovImm(d, imm),
            (Alu::Mov, true) => Op::MovsImm(d, imm),
            (Alu::Add, false) => Op::AddImm(d, n, imm),
            (Alu::Sub, false) => Op::AddImm(d, n, imm.wrapping_neg()),
            (Alu::And, false) => Op::AndImm(d, n, imm),
            (Alu::Bic, false) => Op::AndImm(d, n, !imm),
            (Alu::Orr, false) => Op::OrrImm(d, n, imm),
            (Alu::Mvn, false) => Op::MovImm(d, !imm),
            (Alu::Add, true) => Op::AddsImm(d, n, imm),
            (Alu::Sub, true) if d == NOWHERE => Op::CmpImm(n, imm),
            (Alu::Sub, true) => Op::SubsImm(d, n, imm),
            (Alu::And, true) => Op::AndsImm(d, n, imm),
            (_, false) => Op::AluImm(op, d, n, imm),
            (_, true) => Op::AluImmS(op, d, n, imm),
        });
    }

    /// Two registers, the second shifted as encoded.
    pub(in crate::cortex) fn shifted(
        &mut self,
        op: Alu,
        d: u8,
        n: u8,
        m: u8,
        (shift, amount): (Shift, u8),
        flags: bool,
    ) {
        let (shift, amount) = match (shift, amount) {
            (Shift::Lsl, 0) => (Shift::None, 0),
            (Shift::Lsr | Shift::Asr, 0) => (shift, 32),
            (Shift::Ror, 0) => (Shift::Rrx, 0),
            other => other,
        };
        self.emit(match (op, shift, flags) {
            (Alu::Mov, Shift::None, false) => Op::Mov(d, m),
            (Alu::Mov, Shift::Lsl, false) => Op::LslImm(d, m, amount),
            (Alu::Mov, Shift::Lsr, false) if amount < 32 => Op::LsrImm(d, m, amount),
            (Alu::Mov, Shift::Asr, false) => Op::AsrImm(d, m, amount.min(31)),
            (Alu::Add, Shift::None, false) => Op::Add(d, n, m),
            (Alu::Add, Shift::Lsl, false) => Op::AddShifted(d, n, m, amount),
            (Alu::Sub, Shift::None, false) => Op::Sub(d, n, m),
            (Alu::Sub, Shift::None, true) if d == NOWHERE => Op::Cmp(n, m),
            (Alu::And, Shift::None, false) => Op::And(d, n, m),
            (Alu::Orr, Shift::None, false) => Op::Orr(d, n, m),
            (Alu::Eor, Shift::None, false) => Op::Eor(d, n, m),
            (Alu::Mov, Shift::None, true) => Op::Movs(d, m),
            (Alu::Mov, Shift::Lsl, true) => Op::LslsImm(d, m, amount),
            (Alu::Mov, Shift::Lsr, true) if amount < 32 => Op::LsrsImm(d, m, amount),
            (Alu::Mov, Shift::Asr, true) if amount < 32 => Op::AsrsImm(d, m, amount),
            (Alu::Add, Shift::None, true) => Op::Adds(d, n, m),
            (Alu::Sub, Shift::None, true) => Op::Subs(d, n, m),
            (Alu::And, Shift::None, true) => Op::Ands(d, n, m),
            (Alu::Orr, Shift::None, true) => Op::Orrs(d, n, m),
            (Alu::Eor, Shift::None, true) => Op::Eors(d, n, m),
            (_, _, false) => Op::Alu(op, d, n, m, shift, amount),
            (_, _, true) => Op::AluS(op, d, n, m, shift, amount),
        });
    }
}
