// SPDX-License-Identifier: GPL-2.0-only
//! Translates floating-point instructions of single precision. Encodings: ARMv7-M Architecture Reference Manual, A6.4 to A6.7.

use super::op::{Conversion, Op, PC};
use super::thumb32::field;
use super::translate::{Ends, Translator};

/// Number of a single-precision register: four bits, and one below.
fn single(op: u32, four: u32, one: u32) -> u8 {
    field(op, four, 4) << 1 | field(op, one, 1)
}

/// The first of the two single-precision registers of a double; above 31 if the unit does not have it.
fn pair(op: u32, four: u32, one: u32) -> u8 {
    field(op, four, 4) << 1 | field(op, one, 1) << 5
}

impl Translator<'_> {
    /// Translates one instruction of the floating-point unit.
    pub(super) fn floating(&mut self, op: u32) -> Ends {
        if !self.known(op) {
            return self.undefined(op);
        }
        // A store to FPSCR ends the block.
        let stores = op & 0xFFF0_0FF0 == 0xEEE0_0A10;
        if stores { Ends::Yes } else { Ends::No }
    }

    /// False if it does not exist.
    fn known(&mut self, op: u32) -> bool {
        if op & 0xFE00_0000 == 0xEC00_0000 {
            self.transfers(op)
        } else if op & 0xFF00_0010 == 0xEE00_0010 {
            self.core_transfers(op)
        } else if op & 0xFF00_0110 == 0xEE00_0000 {
            self.arithmetic(op)
        } else {
            false
        }
    }

    /// Emits an operation that needs a floating-point context.
    fn in_context(&mut self, op: Op) -> bool {
        self.need_context();
        self.emit(op);
        true
    }

    /// Loads, stores, pairs of core registers.
    fn transfers(&mut self, op: u32) -> bool {
        let n = field(op, 16, 4);
        let double = op & 0x100 != 0;
        let load = op >> 20 & 1 != 0;
        let d = if double {
            pair(op, 12, 22)
        } else {
            single(op, 12, 22)
        };
        let words = op & 0xFF;
        let (pre, up, update) = (op >> 24 & 1 != 0, op >> 23 & 1 != 0, op >> 21 & 1 != 0);
        match (pre, up, update) {
            (false, false, false) => {
                let m = if double {
                    pair(op, 0, 5)
                } else {
                    single(op, 0, 5)
                };
                if op & 0xD0 != 0x10 || op >> 22 & 1 == 0 || m > 30 {
                    return false;
                }
                let (t, t2) = (field(op, 12, 4), n);
                if t == PC || t2 == PC {
                    return false;
                }
                self.in_context(if load {
                    Op::VmovPairToR(m, t, t2)
                } else {
                    Op::VmovPairToS(m, t, t2)
                })
            }
            (true, _, false) => {
                if d > 31 || n == PC && !load {
                    return false;
                }
                let offset = if up {
                    words * 4
                } else {
                    (words * 4).wrapping_neg()
                };
                self.need_context();
                if n == PC && !double {
                    let address = self.literal_base().wrapping_add(offset);
                    self.floating_literal(d, address);
                    return true;
                }
                let n = self.base(n);
                for word in 0..=u8::from(double) {
                    let offset = offset.wrapping_add(4 * u32::from(word));
                    let d = d + word;
                    self.emit(if load {
                        Op::Vldr(d, n, offset)
                    } else {
                        Op::Vstr(d, n, offset)
                    });
                }
                true
            }
            (false, true, _) | (true, false, true) => {
                let count = if double { words & !1 } else { words };
                if n == PC || count == 0 || u32::from(d) + count > 32 || count > 32 {
                    return false;
                }
                // FLDMX and FSTMX count one word more for the base.
                let extra = double && words & 1 != 0;
                let (first, count) = (d, count as u8);
                self.in_context(if load {
                    Op::Vldm(n, first, count, pre, update, extra)
                } else {
                    Op::Vstm(n, first, count, pre, update, extra)
                })
            }
            _ => false,
        }
    }

    fn core_transfers(&mut self, op: u32) -> bool {
        let t = field(op, 12, 4);
        let load = op >> 20 & 1 != 0;
        let kind = op >> 21 & 7;
        if op & 0x100 != 0 {
            // Half of a double register.
            let n = field(op, 16, 4) << 1 | field(op, 21, 1);
            if op & 0x00C0_00E0 != 0 || t == PC || op & 0xF != 0 {
                return false;
            }
            return self.in_context(if load {
                Op::VmovToR(t, n)
            } else {
                Op::VmovToS(n, t)
            });
        }
        if op & 0x6F != 0 || kind == 7 && op & 0x80 != 0 {
            return false;
        }
        match (kind, load) {
            (0, _) if t == PC => false,
            (0, true) => self.in_context(Op::VmovToR(t, single(op, 16, 7))),
            (0, false) => self.in_context(Op::VmovToS(single(op, 16, 7), t)),
            (7, true) if op >> 16 & 0xF == 1 && t == PC => self.in_context(Op::VmrsFlags),
            (7, true) if op >> 16 & 0xF == 1 => self.in_context(Op::Vmrs(t)),
            (7, false) if op >> 16 & 0xF == 1 && t != PC => self.in_context(Op::Vmsr(t)),
            _ => false,
        }
    }

    fn arithmetic(&mut self, op: u32) -> bool {
        let (d, n, m) = (single(op, 12, 22), single(op, 16, 7), single(op, 0, 5));
        let second = op & 0x40 != 0;
        let fused = |negate, negate_first| Op::Vfma(d, n, m, negate, negate_first);
        let translated = match (op >> 20 & 0xB, second) {
            (0x0, false) => Op::Vmla(d, n, m),
            (0x0, true) => Op::Vmls(d, n, m),
            (0x1, false) => Op::Vnmls(d, n, m),
            (0x1, true) => Op::Vnmla(d, n, m),
            (0x2, false) => Op::Vmul(d, n, m),
            (0x2, true) => Op::Vnmul(d, n, m),
            (0x3, false) => Op::Vadd(d, n, m),
            (0x3, true) => Op::Vsub(d, n, m),
            (0x8, false) => Op::Vdiv(d, n, m),
            (0x9, false) => fused(true, false),
            (0x9, true) => fused(true, true),
            (0xA, false) => fused(false, false),
            (0xA, true) => fused(false, true),
            (0xB, false) if op & 0xA0 == 0 => {
                Op::VmovImm(d, expand(field(op, 16, 4) << 4 | field(op, 0, 4)))
            }
            (0xB, true) => return self.one_operand(op, d, m),
            _ => return false,
        };
        self.in_context(translated)
    }

    fn one_operand(&mut self, op: u32, d: u8, m: u8) -> bool {
        let top = op & 0x80 != 0;
        let cvt = |kind| Op::Vcvt(kind, d, m, 0);
        let translated = match (op >> 16 & 0xF, top) {
            (0, false) => Op::Vmov(d, m),
            (0, true) => Op::Vabs(d, m),
            (1, false) => Op::Vneg(d, m),
            (1, true) => Op::Vsqrt(d, m),
            (4, signals) => Op::Vcmp(d, m, signals),
            (5, signals) if op & 0x2F == 0 => Op::VcmpZero(d, signals),
            (8, true) => cvt(Conversion::FromSigned),
            (8, false) => cvt(Conversion::FromUnsigned),
            (12, true) => cvt(Conversion::ToUnsigned),
            (12, false) => cvt(Conversion::ToUnsignedRounded),
            (13, true) => cvt(Conversion::ToSigned),
            (13, false) => cvt(Conversion::ToSignedRounded),
            (10 | 11 | 14 | 15, wide) => {
                let bits = field(op, 0, 4) << 1 | field(op, 5, 1);
                let size = if wide { 32 } else { 16 };
                if bits > size {
                    return false;
                }
                let unsigned = op >> 16 & 1 != 0;
                let kind = match (op >> 18 & 1 != 0, wide, unsigned) {
                    (false, true, false) => Conversion::FromSigned,
                    (false, true, true) => Conversion::FromUnsigned,
                    (false, false, false) => Conversion::FromSigned16,
                    (false, false, true) => Conversion::FromUnsigned16,
                    (true, true, false) => Conversion::ToSigned,
                    (true, true, true) => Conversion::ToUnsigned,
                    (true, false, false) => Conversion::ToSigned16,
                    (true, false, true) => Conversion::ToUnsigned16,
                };
                Op::Vcvt(kind, d, d, size - bits)
            }
            _ => return false,
        };
        self.in_context(translated)
    }
}

/// The constant of VMOV: sign, three bits of exponent, four of fraction.
fn expand(code: u8) -> u32 {
    let code = u32::from(code);
    let exponent = if code & 0x40 == 0 {
        0x4000_0000
    } else {
        0x3E00_0000
    };
    (code & 0x80) << 24 | exponent | (code & 0x3F) << 19
}
