// SPDX-License-Identifier: GPL-2.0-only
//! Translates data processing in 32 bits with a constant or a shifted register.

use super::op::{Alu, NOWHERE, Op, PC, Rare, Shift};
use super::thumb32::field;
use super::translate::{Ends, Translator};

/// Operation of an encoding; `None` if there is none.
fn kind(code: u32) -> Option<Alu> {
    Some(match code {
        0 => Alu::And,
        1 => Alu::Bic,
        2 => Alu::Orr,
        3 => Alu::Orn,
        4 => Alu::Eor,
        8 => Alu::Add,
        10 => Alu::Adc,
        11 => Alu::Sbc,
        13 => Alu::Sub,
        14 => Alu::Rsb,
        _ => return None,
    })
}

/// Operation and destination after the encodings without first operand (MOV, MVN) and without result (TST, TEQ, CMN, CMP).
fn variant(op: Alu, n: u8, d: u8, flags: bool) -> (Alu, u8) {
    match op {
        Alu::Orr if n == PC => (Alu::Mov, d),
        Alu::Orn if n == PC => (Alu::Mvn, d),
        Alu::And | Alu::Eor | Alu::Add | Alu::Sub if flags && d == PC => (op, NOWHERE),
        _ => (op, d),
    }
}

/// The constant of a 12-bit code, and the carry that a rotation leaves.
fn expand(code: u32) -> (u32, Option<bool>) {
    let byte = code & 0xFF;
    match code >> 8 {
        0 => (byte, None),
        1 => (byte << 16 | byte, None),
        2 => (byte << 24 | byte << 8, None),
        3 => (byte * 0x0101_0101, None),
        _ => {
            let value = (byte & 0x7F | 0x80).rotate_right(code >> 7);
            (value, Some(value >> 31 != 0))
        }
    }
}

impl Translator<'_> {
    /// With a shifted register.
    pub(super) fn shifted_register(&mut self, op: u32) -> Ends {
        let (n, d, m) = (field(op, 16, 4), field(op, 8, 4), field(op, 0, 4));
        let flags = op >> 20 & 1 != 0;
        let amount = field(op, 12, 3) << 2 | field(op, 6, 2);
        let code = op >> 21 & 0xF;
        if code == 6 && !flags && op & 0x10 == 0 && ![n, d, m].contains(&PC) {
            let top = field(op, 5, 1);
            let amount = if top == 1 && amount == 0 { 32 } else { amount };
            self.rare(Rare::Pkh, d, n, m, top, amount);
            return Ends::No;
        }
        let Some(alu) = kind(code) else {
            return self.undefined(op);
        };
        let shift = [Shift::Lsl, Shift::Lsr, Shift::Asr, Shift::Ror][usize::from(field(op, 4, 2))];
        let (alu, d) = variant(alu, n, d, flags);
        if d == PC || m == PC || n == PC && !matches!(alu, Alu::Mov | Alu::Mvn) {
            return self.undefined(op);
        }
        self.shifted(alu, d, n, m, (shift, amount), flags);
        Ends::No
    }

    /// With a rotated or repeated constant.
    pub(super) fn modified_constant(&mut self, op: u32) -> Ends {
        let (n, d) = (field(op, 16, 4), field(op, 8, 4));
        let flags = op >> 20 & 1 != 0;
        let Some(alu) = kind(op >> 21 & 0xF) else {
            return self.undefined(op);
        };
        let (alu, d) = variant(alu, n, d, flags);
        if d == PC || n == PC && !matches!(alu, Alu::Mov | Alu::Mvn) {
            return self.undefined(op);
        }
        let (imm, carry) = expand((op >> 26 & 1) << 11 | (op >> 12 & 7) << 8 | op & 0xFF);
        self.constant(alu, d, n, imm, flags);
        let logical = matches!(
            alu,
            Alu::And | Alu::Bic | Alu::Orr | Alu::Orn | Alu::Eor | Alu::Mov | Alu::Mvn
        );
        if let (true, true, Some(set)) = (flags, logical, carry) {
            self.emit(Op::Carry(set));
        }
        Ends::No
    }

    /// With a plain constant; bit fields; saturation.
    pub(super) fn plain_constant(&mut self, op: u32) -> Ends {
        let (n, d) = (field(op, 16, 4), field(op, 8, 4));
        let imm12 = (op >> 26 & 1) << 11 | (op >> 12 & 7) << 8 | op & 0xFF;
        let imm16 = (op >> 16 & 0xF) << 12 | imm12;
        let lsb = field(op, 12, 3) << 2 | field(op, 6, 2);
        let bits = field(op, 0, 5);
        // ADR, MOVW, MOVT and BFC have no first register.
        let kind = op >> 20 & 0x1F;
        if d == PC || n == PC && !matches!(kind, 0 | 4 | 10 | 12 | 22) {
            return self.undefined(op);
        }
        let wrong = kind >= 16 && op & 0x0400_0020 != 0;
        if wrong {
            return self.undefined(op);
        }
        let halves = op >> 21 & 1 != 0 && lsb == 0;
        match kind {
            0 | 10 if n == PC => {
                let offset = if op >> 23 & 1 == 0 {
                    imm12
                } else {
                    imm12.wrapping_neg()
                };
                let imm = self.literal_base().wrapping_add(offset);
                self.emit(Op::MovImm(d, imm));
            }
            0 => self.constant(Alu::Add, d, n, imm12, false),
            10 => self.constant(Alu::Sub, d, n, imm12, false),
            4 => self.emit(Op::MovImm(d, imm16)),
            12 => self.emit(Op::Movt(d, imm16 as u16)),
            18 | 26 if halves && bits > 15 => return self.undefined(op),
            18 if halves => self.rare(Rare::Ssat16, d, n, 0, field(op, 0, 4) + 1, 0),
            26 if halves => self.rare(Rare::Usat16, d, n, 0, field(op, 0, 4), 0),
            // Bit 5 of the shift: to the right.
            16 | 18 => self.rare(Rare::Ssat, d, n, 0, bits + 1, lsb | field(op, 21, 1) << 5),
            24 | 26 => self.rare(Rare::Usat, d, n, 0, bits, lsb | field(op, 21, 1) << 5),
            20 if lsb + bits < 32 => self.rare(Rare::Sbfx, d, n, 0, lsb, bits + 1),
            28 if lsb + bits < 32 => self.emit(Op::Ubfx(d, n, lsb, bits + 1)),
            22 if bits >= lsb => {
                let n = if n == PC { NOWHERE } else { n };
                self.emit(Op::Bfi(d, n, lsb, bits + 1 - lsb));
            }
            _ => return self.undefined(op),
        }
        Ends::No
    }
}
