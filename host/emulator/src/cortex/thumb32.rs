// SPDX-License-Identifier: GPL-2.0-only
//! Translates instructions of 32 bits, except floating point: groups, branches, system instructions. Encodings: ARMv7-M
//! Architecture Reference Manual, A5.3.

use super::op::{NOWHERE, Op, PC, Rare, SP, Shift, Width};
use super::translate::{Ends, Translator};

/// Field of an encoding.
pub(super) fn field(op: u32, low: u32, bits: u32) -> u8 {
    (op >> low & ((1 << bits) - 1)) as u8
}

impl Translator<'_> {
    /// Translates one instruction, its first halfword above.
    pub(super) fn wide(&mut self, op: u32) -> Ends {
        match (op >> 27 & 3, op >> 20 & 0x7F) {
            (1, group) if group & 0x64 == 0 => self.multiple(op),
            (1, group) if group & 0x64 == 4 => self.dual(op),
            (1, group) if group & 0x60 == 0x20 => self.shifted_register(op),
            (2, _) if op & 0x8000 != 0 => self.control(op),
            (2, group) if group & 0x20 == 0 => self.modified_constant(op),
            (2, _) => self.plain_constant(op),
            (3, group) if group & 0x60 == 0 => self.single(op),
            (3, group) if group & 0x70 == 0x20 => self.register(op),
            (3, group) if group & 0x78 == 0x30 => self.multiply(op),
            (3, group) if group & 0x78 == 0x38 => self.multiply_long(op),
            _ if op & 0xEC00_0E00 == 0xEC00_0A00 => self.floating(op),
            _ => self.undefined(op),
        }
    }

    /// Branches and miscellaneous control.
    fn control(&mut self, op: u32) -> Ends {
        let sign = op >> 26 & 1;
        let (j1, j2) = (op >> 13 & 1, op >> 11 & 1);
        match op >> 12 & 5 {
            0 if op >> 23 & 7 == 7 => self.system(op),
            0 => {
                let offset =
                    sign << 20 | j2 << 19 | j1 << 18 | (op >> 16 & 0x3F) << 12 | (op & 0x7FF) << 1;
                let offset = (offset << 11) as i32 >> 11;
                let target = self.pc().wrapping_add_signed(offset);
                self.emit(Op::BranchIf(field(op, 22, 4), target));
                Ends::Yes
            }
            kind @ (1 | 5) => {
                let (i1, i2) = ((j1 ^ sign ^ 1), (j2 ^ sign ^ 1));
                let offset =
                    sign << 24 | i1 << 23 | i2 << 22 | (op >> 16 & 0x3FF) << 12 | (op & 0x7FF) << 1;
                let offset = (offset << 7) as i32 >> 7;
                let target = self.pc().wrapping_add_signed(offset);
                if kind == 5 {
                    return self.call(target);
                }
                self.emit(Op::Branch(target));
                Ends::Yes
            }
            _ => self.undefined(op),
        }
    }

    fn system(&mut self, op: u32) -> Ends {
        if op & 0x7000 != 0 {
            return self.undefined(op);
        }
        match op >> 20 & 0x7F {
            0x38 if op >> 16 & 0xF != 0xF && op & 0x300 == 0 => {
                let n = field(op, 16, 4);
                self.emit(Op::WriteSpecial(n, field(op, 8, 4), op as u8));
                return Ends::Yes;
            }
            // Further hints are no operations.
            0x3A if op & 0x000F_2F00 == 0x000F_0000 => return self.hint(op as u8, 0),
            0x3B => match op >> 4 & 0xF {
                2 => self.emit(Op::Clrex),
                // Barriers: accesses are in order.
                4 | 5 => {}
                6 => return Ends::Yes,
                _ => return self.undefined(op),
            },
            0x3E if op >> 16 & 0xF == 0xF && op >> 8 & 0xF != 0xF => {
                let d = field(op, 8, 4);
                self.emit(Op::ReadSpecial(d, op as u8));
            }
            _ => return self.undefined(op),
        }
        Ends::No
    }

    /// Data processing of registers: shifts by register, extensions, parallel and saturating arithmetic.
    fn register(&mut self, op: u32) -> Ends {
        let (n, d, m) = (field(op, 16, 4), field(op, 8, 4), field(op, 0, 4));
        let (first, second) = (op >> 20 & 0xF, op >> 4 & 0xF);
        // Without first operand the extensions name the program counter.
        let extends = first < 6 && second & 8 != 0;
        if op >> 12 & 0xF != 0xF || d == PC || m == PC || n == PC && !extends {
            return self.undefined(op);
        }
        if first < 8 && second == 0 {
            let shift = [Shift::Lsl, Shift::Lsr, Shift::Asr, Shift::Ror][(first >> 1) as usize];
            self.emit(Op::ShiftBy(shift, d, n, m, first & 1 != 0));
            return Ends::No;
        }
        if first < 6 && second & 8 != 0 {
            let kind = [
                Rare::Sxtah,
                Rare::Uxtah,
                Rare::Sxtab16,
                Rare::Uxtab16,
                Rare::Sxtab,
                Rare::Uxtab,
            ][first as usize];
            let rotation = 8 * (second & 3) as u8;
            match (kind, n == PC && rotation == 0) {
                (Rare::Uxtah, true) => self.emit(Op::Uxth(d, m)),
                (Rare::Uxtab, true) => self.emit(Op::Uxtb(d, m)),
                _ => {
                    let n = if n == PC { NOWHERE } else { n };
                    self.rare(kind, d, n, m, rotation, 0);
                }
            }
            return Ends::No;
        }
        let kind = match (first, second) {
            (8.., 0..8) if first & 7 != 3 && first & 7 != 7 && second & 3 != 3 => {
                self.rare(Rare::Parallel, d, n, m, (first & 7) as u8, second as u8);
                return Ends::No;
            }
            (8, 8) => Rare::Qadd,
            (8, 9) => Rare::Qdadd,
            (8, 10) => Rare::Qsub,
            (8, 11) => Rare::Qdsub,
            (9, 8) => Rare::Rev,
            (9, 9) => Rare::Rev16,
            (9, 10) => Rare::Rbit,
            (9, 11) => Rare::Revsh,
            (10, 8) => Rare::Sel,
            (11, 8) => Rare::Clz,
            _ => return self.undefined(op),
        };
        self.rare(kind, d, n, m, 0, 0);
        Ends::No
    }

    fn multiply(&mut self, op: u32) -> Ends {
        let (n, d, m, a) = (
            field(op, 16, 4),
            field(op, 8, 4),
            field(op, 0, 4),
            field(op, 12, 4),
        );
        let second = field(op, 4, 2);
        let adds = a != PC;
        if op & 0xC0 != 0 || n == PC || d == PC || m == PC {
            return self.undefined(op);
        }
        let kind = match (op >> 20 & 7, second) {
            (0, 0) if adds => {
                self.emit(Op::Mla(d, n, m, a));
                return Ends::No;
            }
            (0, 0) => {
                self.emit(Op::Mul(d, n, m));
                return Ends::No;
            }
            (0, 1) if adds => {
                self.emit(Op::Mls(d, n, m, a));
                return Ends::No;
            }
            (1, _) if adds => Rare::Smla,
            (1, _) => Rare::Smul,
            (2, 0 | 1) if adds => Rare::Smlad,
            (2, 0 | 1) => Rare::Smuad,
            (3, 0 | 1) if adds => Rare::Smlaw,
            (3, 0 | 1) => Rare::Smulw,
            (4, 0 | 1) if adds => Rare::Smlsd,
            (4, 0 | 1) => Rare::Smusd,
            (5, 0 | 1) if adds => Rare::Smmla,
            (5, 0 | 1) => Rare::Smmul,
            (6, 0 | 1) if adds => Rare::Smmls,
            (7, 0) if adds => Rare::Usada8,
            (7, 0) => Rare::Usad8,
            _ => return self.undefined(op),
        };
        self.rare(kind, d, n, m, a, second);
        Ends::No
    }

    fn multiply_long(&mut self, op: u32) -> Ends {
        let (n, high, m, low) = (
            field(op, 16, 4),
            field(op, 8, 4),
            field(op, 0, 4),
            field(op, 12, 4),
        );
        let second = field(op, 4, 4);
        let divides = second == 0xF;
        if n == PC || high == PC || m == PC || (low == PC) != divides {
            return self.undefined(op);
        }
        let kind = match (op >> 20 & 7, second) {
            (0, 0) => {
                self.emit(Op::Smull(low, high, n, m));
                return Ends::No;
            }
            (2, 0) => {
                self.emit(Op::Umull(low, high, n, m));
                return Ends::No;
            }
            (1, 0xF) => {
                self.emit(Op::Sdiv(high, n, m));
                return Ends::No;
            }
            (3, 0xF) => {
                self.emit(Op::Udiv(high, n, m));
                return Ends::No;
            }
            (4, 0) => Rare::Smlal,
            (4, 8..=11) => Rare::SmlalHalves,
            (4, 12 | 13) => Rare::Smlald,
            (5, 12 | 13) => Rare::Smlsld,
            (6, 0) => Rare::Umlal,
            (6, 6) => Rare::Umaal,
            _ => return self.undefined(op),
        };
        self.rare(kind, high, n, m, low, second & 3);
        Ends::No
    }

    /// A byte, halfword or word.
    fn single(&mut self, op: u32) -> Ends {
        let (n, t) = (field(op, 16, 4), field(op, 12, 4));
        let (load, signed) = (op >> 20 & 1 != 0, op >> 24 & 1 != 0);
        let width = match (op >> 21 & 3, signed) {
            (0, false) => Width::Byte,
            (1, false) => Width::Half,
            (2, false) => Width::Word,
            (0, true) => Width::SignedByte,
            (1, true) => Width::SignedHalf,
            _ => return self.undefined(op),
        };
        if !load && (signed || n == PC || t == PC) {
            return self.undefined(op);
        }
        let (imm12, imm8) = (op & 0xFFF, op & 0xFF);
        let up = op >> 23 & 1 != 0;
        let preload = load && t == PC && width != Width::Word;
        if n == PC {
            let offset = if up { imm12 } else { imm12.wrapping_neg() };
            let address = self.literal_base().wrapping_add(offset);
            match (preload, width) {
                (true, _) => {}
                (false, Width::Word) => self.literal(t, address),
                _ => {
                    let n = self.base(n);
                    self.load(width, t, n, offset);
                }
            }
        } else if up {
            match (preload, load) {
                (true, _) => {}
                (_, true) => self.load(width, t, n, imm12),
                (_, false) => self.store(width, t, n, imm12),
            }
        } else if op & 0x800 != 0 {
            let (pre, add, update) = (op >> 10 & 1 != 0, op >> 9 & 1 != 0, op >> 8 & 1 != 0);
            let offset = if add { imm8 as i16 } else { -(imm8 as i16) };
            match (pre, update, load) {
                (false, false, _) => return self.undefined(op),
                (true, false, true) if preload && add => return self.undefined(op),
                (true, false, true) if preload => {}
                (true, false, true) => self.load(width, t, n, i32::from(offset) as u32),
                (true, false, false) => self.store(width, t, n, i32::from(offset) as u32),
                (_, true, _) if t == PC && width != Width::Word => return self.undefined(op),
                // Unprivileged access is the same here: no memory protection.
                (_, true, true) => self.emit(Op::LoadUpdate(width, t, n, pre, offset)),
                (_, true, false) => self.emit(Op::StoreUpdate(width, t, n, pre, offset)),
            }
        } else if op & 0x7C0 == 0 {
            let (m, shift) = (field(op, 0, 4), field(op, 4, 2));
            match (preload, load) {
                _ if m == PC => return self.undefined(op),
                (true, _) => {}
                (_, true) => self.emit(Op::LoadIndexed(width, t, n, m, shift)),
                (_, false) => self.emit(Op::StoreIndexed(width, t, n, m, shift)),
            }
        } else {
            return self.undefined(op);
        }
        if load && t == PC && !preload {
            self.emit(Op::Exchange(PC));
            return Ends::Yes;
        }
        Ends::No
    }

    /// Several registers.
    fn multiple(&mut self, op: u32) -> Ends {
        let n = field(op, 16, 4);
        let (load, update) = (op >> 20 & 1 != 0, op >> 21 & 1 != 0);
        let list = op as u16;
        let down = match op >> 23 & 3 {
            1 => false,
            2 => true,
            _ => return self.undefined(op),
        };
        // Unpredictable: fewer than two registers, a base that is written twice, the stack pointer.
        let wrong = list.count_ones() < 2 || update && list >> n & 1 != 0 || list >> SP & 1 != 0;
        if n == PC || wrong || !load && list >> PC & 1 != 0 {
            return self.undefined(op);
        }
        if !load {
            self.emit(Op::Stm(n, down, update, list));
            return Ends::No;
        }
        self.emit(Op::Ldm(n, down, update, list));
        if list >> PC & 1 != 0 {
            self.emit(Op::Exchange(PC));
            return Ends::Yes;
        }
        Ends::No
    }

    /// Two words, exclusive accesses, table branches.
    fn dual(&mut self, op: u32) -> Ends {
        let (n, t, t2, m) = (
            field(op, 16, 4),
            field(op, 12, 4),
            field(op, 8, 4),
            field(op, 0, 4),
        );
        let imm = (op & 0xFF) * 4;
        let table = op & 0xFFF0_FFE0 == 0xE8D0_F000;
        let (pre, up, update, load) = (
            op >> 24 & 1 != 0,
            op >> 23 & 1 != 0,
            op >> 21 & 1 != 0,
            op >> 20 & 1 != 0,
        );
        if pre || update {
            if n == PC && (update || !load) || t == PC || t2 == PC {
                return self.undefined(op);
            }
            let signed = if up { imm as i16 } else { -(imm as i16) };
            let offset = i32::from(signed) as u32;
            let n = self.base(n);
            self.emit(match (update, load) {
                (false, true) => Op::Ldrd(t, t2, n, offset),
                (false, false) => Op::Strd(t, t2, n, offset),
                (true, true) => Op::LdrdUpdate(t, t2, n, pre, signed),
                (true, false) => Op::StrdUpdate(t, t2, n, pre, signed),
            });
            return Ends::No;
        }
        // Fields that name no register are all ones; the result of a store is neither address nor value.
        let (word, bytes) = (!up, up && !table);
        let result = if word { t2 } else { m };
        let wrong = !table && (n == PC || t == PC)
            || table && m == PC
            || load && (word || bytes) && t2 != PC
            || bytes && (t2 != PC || load && m != PC)
            || !load && (result == PC || result == n || result == t);
        if wrong {
            return self.undefined(op);
        }
        let width = match field(op, 4, 4) {
            4 => Some(Width::Byte),
            5 => Some(Width::Half),
            _ => None,
        };
        match (up, load, width) {
            (false, false, _) => self.emit(Op::Strex(Width::Word, t2, t, n, imm as u16)),
            (false, true, _) => self.emit(Op::Ldrex(Width::Word, t, n, imm)),
            (true, false, Some(width)) => self.emit(Op::Strex(width, m, t, n, 0)),
            (true, true, Some(width)) => self.emit(Op::Ldrex(width, t, n, 0)),
            (true, true, None) if table => {
                // Unlike that of literals, the base of a table is not aligned.
                let n = self.source(n);
                self.emit(Op::Table(n, m, op & 0x10 != 0, self.pc()));
                return Ends::Yes;
            }
            _ => return self.undefined(op),
        }
        Ends::No
    }
}
