// SPDX-License-Identifier: GPL-2.0-only
//! Translates instructions of 16 bits. Encodings: ARMv7-M Architecture Reference Manual, A5.2.

use super::op::{Alu, BASE, NOWHERE, Op, PC, Rare, SP, Shift, Width};
use super::translate::{Ends, Translator};

impl Translator<'_> {
    /// Translates one instruction; `Ends::Yes` after the last of a block.
    pub(super) fn narrow(&mut self, op: u16) -> Ends {
        let low = (op & 7) as u8;
        let next = (op >> 3 & 7) as u8;
        let third = (op >> 6 & 7) as u8;
        let imm5 = u32::from(op >> 6 & 0x1F);
        let imm8 = u32::from(op & 0xFF);
        let middle = (op >> 8 & 7) as u8;
        match op >> 11 {
            0b00000..=0b00010 => {
                let shift = [Shift::Lsl, Shift::Lsr, Shift::Asr][usize::from(op >> 11)];
                self.shifted(Alu::Mov, low, 0, next, (shift, imm5 as u8), self.flags());
            }
            0b00011 => {
                let kind = if op & 0x200 == 0 { Alu::Add } else { Alu::Sub };
                if op & 0x400 == 0 {
                    self.plain(kind, low, next, third);
                } else {
                    self.constant(kind, low, next, u32::from(third), self.flags());
                }
            }
            0b00100 => self.constant(Alu::Mov, middle, 0, imm8, self.flags()),
            0b00101 => self.constant(Alu::Sub, NOWHERE, middle, imm8, true),
            0b00110 => self.constant(Alu::Add, middle, middle, imm8, self.flags()),
            0b00111 => self.constant(Alu::Sub, middle, middle, imm8, self.flags()),
            0b01000 if op & 0x400 == 0 => self.data(op >> 6 & 0xF, low, next),
            0b01000 => return self.high(op),
            0b01001 => {
                let address = self.literal_base().wrapping_add(imm8 * 4);
                self.literal(middle, address);
            }
            0b01010 | 0b01011 => self.indexed(op >> 9 & 7, low, next, third),
            0b01100 => self.store(Width::Word, low, next, imm5 * 4),
            0b01101 => self.load(Width::Word, low, next, imm5 * 4),
            0b01110 => self.store(Width::Byte, low, next, imm5),
            0b01111 => self.load(Width::Byte, low, next, imm5),
            0b10000 => self.store(Width::Half, low, next, imm5 * 2),
            0b10001 => self.load(Width::Half, low, next, imm5 * 2),
            0b10010 => self.store(Width::Word, middle, SP, imm8 * 4),
            0b10011 => self.load(Width::Word, middle, SP, imm8 * 4),
            0b10100 => {
                let imm = self.literal_base().wrapping_add(imm8 * 4);
                self.emit(Op::MovImm(middle, imm));
            }
            0b10101 => self.constant(Alu::Add, middle, SP, imm8 * 4, false),
            0b10110 | 0b10111 => return self.miscellaneous(op),
            0b11000 => self.emit(Op::Stm(middle, false, true, op & 0xFF)),
            0b11001 => {
                let list = op & 0xFF;
                let update = list >> middle & 1 == 0;
                self.emit(Op::Ldm(middle, false, update, list));
            }
            0b11010 | 0b11011 => return self.conditional(op, imm8),
            _ => {
                let offset = i32::from((op << 5) as i16 >> 4);
                let target = self.pc().wrapping_add_signed(offset);
                self.emit(Op::Branch(target));
                return Ends::Yes;
            }
        }
        Ends::No
    }

    fn conditional(&mut self, op: u16, imm8: u32) -> Ends {
        match op >> 8 & 0xF {
            14 => self.undefined(op.into()),
            15 => {
                self.emit(Op::Supervisor);
                Ends::Yes
            }
            condition => {
                let offset = i32::from(imm8 as u8 as i8) * 2;
                let target = self.pc().wrapping_add_signed(offset);
                self.emit(Op::BranchIf(condition as u8, target));
                Ends::Yes
            }
        }
    }

    /// Data processing of two low registers.
    fn data(&mut self, kind: u16, d: u8, m: u8) {
        let flags = self.flags();
        match kind {
            0 => self.plain(Alu::And, d, d, m),
            1 => self.plain(Alu::Eor, d, d, m),
            2 => self.emit(Op::ShiftBy(Shift::Lsl, d, d, m, flags)),
            3 => self.emit(Op::ShiftBy(Shift::Lsr, d, d, m, flags)),
            4 => self.emit(Op::ShiftBy(Shift::Asr, d, d, m, flags)),
            5 => self.plain(Alu::Adc, d, d, m),
            6 => self.plain(Alu::Sbc, d, d, m),
            7 => self.emit(Op::ShiftBy(Shift::Ror, d, d, m, flags)),
            8 => self.shifted(Alu::And, NOWHERE, d, m, (Shift::None, 0), true),
            9 => self.constant(Alu::Rsb, d, m, 0, flags),
            10 => self.emit(Op::Cmp(d, m)),
            11 => self.shifted(Alu::Add, NOWHERE, d, m, (Shift::None, 0), true),
            12 => self.plain(Alu::Orr, d, d, m),
            13 if flags => self.emit(Op::Muls(d, d, m)),
            13 => self.emit(Op::Mul(d, d, m)),
            14 => self.plain(Alu::Bic, d, d, m),
            _ => self.plain(Alu::Mvn, d, 0, m),
        }
    }

    /// Two registers, flags unless in an IT block.
    fn plain(&mut self, op: Alu, d: u8, n: u8, m: u8) {
        self.shifted(op, d, n, m, (Shift::None, 0), self.flags());
    }

    /// Operations with high registers, branches to registers.
    fn high(&mut self, op: u16) -> Ends {
        let d = (op >> 4 & 8 | op & 7) as u8;
        let m = (op >> 3 & 0xF) as u8;
        match op >> 8 & 3 {
            0 if m == PC => {
                let imm = self.pc();
                let n = self.source(d);
                self.emit(Op::AddImm(d, n, imm));
            }
            0 if d == PC => {
                self.emit(Op::SetBase(self.pc()));
                self.emit(Op::Add(d, BASE, m));
            }
            0 => self.emit(Op::Add(d, d, m)),
            1 if d == PC || m == PC => return self.undefined(op.into()),
            1 => {
                self.emit(Op::Cmp(d, m));
                return Ends::No;
            }
            2 if m == PC => {
                let imm = self.pc();
                self.emit(Op::MovImm(d, imm));
            }
            2 => self.emit(Op::Mov(d, m)),
            _ => {
                if m == PC || op & 7 != 0 {
                    return self.undefined(op.into());
                }
                self.emit(if op & 0x80 == 0 {
                    Op::Exchange(m)
                } else {
                    Op::CallRegister(m)
                });
                return Ends::Yes;
            }
        }
        if d == PC {
            self.emit(Op::Jump(PC));
            return Ends::Yes;
        }
        Ends::No
    }

    /// A register to read; the program counter becomes a constant.
    pub(super) fn source(&mut self, n: u8) -> u8 {
        if n == PC {
            let value = self.pc();
            self.emit(Op::SetBase(value));
            return BASE;
        }
        n
    }

    fn indexed(&mut self, kind: u16, t: u8, n: u8, m: u8) {
        let (width, load) = match kind {
            0 => (Width::Word, false),
            1 => (Width::Half, false),
            2 => (Width::Byte, false),
            3 => (Width::SignedByte, true),
            4 => (Width::Word, true),
            5 => (Width::Half, true),
            6 => (Width::Byte, true),
            _ => (Width::SignedHalf, true),
        };
        self.emit(if load {
            Op::LoadIndexed(width, t, n, m, 0)
        } else {
            Op::StoreIndexed(width, t, n, m, 0)
        });
    }

    fn miscellaneous(&mut self, op: u16) -> Ends {
        let low = (op & 7) as u8;
        let m = (op >> 3 & 7) as u8;
        match op >> 8 & 0xF {
            0x0 => {
                let bytes = u32::from(op & 0x7F) * 4;
                let imm = if op & 0x80 == 0 {
                    bytes
                } else {
                    bytes.wrapping_neg()
                };
                self.emit(Op::AddImm(SP, SP, imm));
            }
            0x1 | 0x3 | 0x9 | 0xB => {
                let offset = u32::from(op >> 3 & 0x40 | op >> 2 & 0x3E);
                let target = self.pc().wrapping_add(offset);
                self.emit(if op & 0x800 == 0 {
                    Op::BranchZero(low, target)
                } else {
                    Op::BranchNotZero(low, target)
                });
                return Ends::Yes;
            }
            0x2 => match op >> 6 & 3 {
                0 => self.rare(Rare::Sxtah, low, NOWHERE, m, 0, 0),
                1 => self.rare(Rare::Sxtab, low, NOWHERE, m, 0, 0),
                2 => self.emit(Op::Uxth(low, m)),
                _ => self.emit(Op::Uxtb(low, m)),
            },
            0x4 | 0x5 => {
                let list = op & 0xFF | (op & 0x100) << 6;
                self.emit(Op::Stm(SP, true, true, list));
            }
            0x6 if op & 0xFFE8 == 0xB660 => {
                let (primask, faultmask) = (op & 2 != 0, op & 1 != 0);
                self.emit(Op::ChangeMasks(op & 0x10 != 0, primask, faultmask));
                return Ends::Yes;
            }
            0xA => match op >> 6 & 3 {
                0 => self.rare(Rare::Rev, low, 0, m, 0, 0),
                1 => self.rare(Rare::Rev16, low, 0, m, 0, 0),
                3 => self.rare(Rare::Revsh, low, 0, m, 0, 0),
                _ => return self.undefined(op.into()),
            },
            0xC => self.emit(Op::Ldm(SP, false, true, op & 0xFF)),
            0xD => {
                let list = op & 0xFF | 1 << PC;
                self.emit(Op::Ldm(SP, false, true, list));
                self.emit(Op::Exchange(PC));
                return Ends::Yes;
            }
            0xE => {
                self.emit(Op::Breakpoint);
                return Ends::Yes;
            }
            0xF => return self.hint((op >> 4 & 0xF) as u8, (op & 0xF) as u8),
            _ => return self.undefined(op.into()),
        }
        Ends::No
    }

    /// Hints, and the start of an IT block.
    pub(super) fn hint(&mut self, which: u8, mask: u8) -> Ends {
        if mask != 0 {
            self.begin_it(which << 4 | mask);
            return Ends::No;
        }
        match which {
            2 => self.emit(Op::WaitForEvent),
            3 => self.emit(Op::WaitForInterrupt),
            // No operation, yield; SEV is known from the block.
            _ => return Ends::No,
        }
        Ends::Yes
    }

    pub(super) fn call(&mut self, target: u32) -> Ends {
        self.emit(Op::Call(target));
        Ends::Yes
    }
}
