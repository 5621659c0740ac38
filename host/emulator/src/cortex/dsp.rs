// SPDX-License-Identifier: GPL-2.0-only
//! Instructions of the DSP extension and other rare data processing.

use super::op::{NOWHERE, Rare};
use super::state::Registers;

fn half(value: u32, top: u32) -> i32 {
    ((value >> (16 * (top & 1))) as i16).into()
}

fn exchange(value: u32, exchanged: bool) -> u32 {
    if exchanged {
        value.rotate_right(16)
    } else {
        value
    }
}

/// Adds and subtracts the halves or bytes of two registers: result and greater-or-equal flags, which the saturating and halving
/// kinds have not. `kind` and `variant` as encoded: ARMv7-M Architecture Reference Manual, A5.3.13 and A5.3.14.
fn parallel(kind: u8, variant: u8, a: u32, b: u32) -> (u32, Option<u8>) {
    let unsigned = variant & 4 != 0;
    let bits = if kind & 3 == 0 { 8 } else { 16 };
    let lane = |value: u32, n: u32| {
        let value = value >> (bits * n);
        match (bits, unsigned) {
            (8, true) => i32::from(value as u8),
            (8, false) => i32::from(value as i8),
            (_, true) => i32::from(value as u16),
            (_, false) => i32::from(value as i16),
        }
    };
    let (least, most) = if unsigned {
        (0, (1 << bits) - 1)
    } else {
        (-1 << (bits - 1), (1 << (bits - 1)) - 1)
    };
    let crossed = kind & 3 == 2;
    let (mut result, mut ge) = (0, 0);
    for n in 0..32 / bits {
        let other = if crossed { n ^ 1 } else { n };
        // Crossed: ASX subtracts below and adds above, SAX the other way round.
        let subtracts = if crossed {
            (kind & 4 != 0) == (n == 1)
        } else {
            kind & 4 != 0
        };
        let (x, y) = (lane(a, n), lane(b, other));
        let exact = if subtracts { x - y } else { x + y };
        let value = match variant & 3 {
            1 => exact.clamp(least, most),
            2 => exact >> 1,
            _ => exact,
        };
        result |= (value as u32 & ((1 << bits) - 1)) << (bits * n);
        let flag = if unsigned && !subtracts {
            exact > most
        } else {
            exact >= 0
        };
        if flag {
            let share = if bits == 8 { 1 } else { 3 };
            ge |= share << (n * bits / 8);
        }
    }
    (result, (variant & 3 == 0).then_some(ge))
}

impl Registers {
    fn saturating(&mut self, value: i64, least: i64, most: i64) -> u32 {
        self.saturated |= value < least || value > most;
        value.clamp(least, most) as u32
    }

    fn saturating_word(&mut self, value: i64) -> u32 {
        self.saturating(value, i32::MIN.into(), i32::MAX.into())
    }

    /// The sum's lower half; Q if it does not fit.
    fn wrapping_word(&mut self, value: i64) -> u32 {
        self.saturated |= i64::from(value as i32) != value;
        value as u32
    }

    fn register(&self, n: u8) -> u32 {
        if n == NOWHERE {
            0
        } else {
            self.r[usize::from(n & 31)]
        }
    }

    /// The 64 bits of registers `a` (low) and `d` (high).
    fn long(&self, a: u8, d: u8) -> u64 {
        u64::from(self.register(a)) | u64::from(self.register(d)) << 32
    }

    fn set_long(&mut self, a: u8, d: u8, value: u64) {
        self.r[usize::from(a & 31)] = value as u32;
        self.r[usize::from(d & 31)] = (value >> 32) as u32;
    }

    /// Carries out one of them; operands as [`Rare`] says.
    pub(super) fn rare(&mut self, op: Rare, d: u8, n: u8, m: u8, a: u8, x: u8) {
        let (vn, vm) = (self.register(n), self.register(m));
        let (sn, sm) = (i64::from(vn as i32), i64::from(vm as i32));
        let addend = i64::from(self.register(a) as i32);
        let top = u32::from(x);
        let exchanged = exchange(vm, x & 1 != 0);
        let product = |top: u32| i64::from(half(vn, top)) * i64::from(half(exchanged, top));
        let rotated = vm.rotate_right(a.into());
        let (both, difference) = (product(0) + product(1), product(0) - product(1));
        let halves = i64::from(half(vn, top >> 1)) * i64::from(half(vm, top));
        let by_half = (sn * i64::from(half(vm, top))) >> 16;
        let round = if x & 1 != 0 { 0x8000_0000 } else { 0 };
        let by_bytes = |value: u32| (value & 0xFF) | (value >> 16 & 0xFF) << 16;
        let signed_bytes = |value: u32| {
            u32::from(i16::from(value as i8) as u16)
                | u32::from(i16::from((value >> 16) as i8) as u16) << 16
        };
        let pairs = |addends: u32| {
            (vn.wrapping_add(addends) & 0xFFFF)
                | (vn & 0xFFFF_0000).wrapping_add(addends & 0xFFFF_0000)
        };
        let value = match op {
            Rare::Parallel => {
                let (value, ge) = parallel(a, x, vn, vm);
                self.ge = ge.unwrap_or(self.ge);
                value
            }
            Rare::Sel => {
                let mask: u32 = (0..4)
                    .filter(|n| self.ge >> n & 1 != 0)
                    .map(|n| 0xFF << (8 * n))
                    .sum();
                vn & mask | vm & !mask
            }
            // The first operand is the second register.
            Rare::Qadd => self.saturating_word(sm + sn),
            Rare::Qsub => self.saturating_word(sm - sn),
            Rare::Qdadd => {
                let double = self.saturating_word(2 * sn);
                self.saturating_word(sm + i64::from(double as i32))
            }
            Rare::Qdsub => {
                let double = self.saturating_word(2 * sn);
                self.saturating_word(sm - i64::from(double as i32))
            }
            Rare::Clz => vm.leading_zeros(),
            Rare::Rbit => vm.reverse_bits(),
            Rare::Rev => vm.swap_bytes(),
            Rare::Rev16 => vm.swap_bytes().rotate_right(16),
            Rare::Revsh => i32::from((vm as u16).swap_bytes() as i16) as u32,
            Rare::Sxtab => vn.wrapping_add(i32::from(rotated as i8) as u32),
            Rare::Uxtab => vn.wrapping_add(rotated & 0xFF),
            Rare::Sxtah => vn.wrapping_add(i32::from(rotated as i16) as u32),
            Rare::Uxtah => vn.wrapping_add(rotated & 0xFFFF),
            Rare::Sxtab16 => pairs(signed_bytes(rotated)),
            Rare::Uxtab16 => pairs(by_bytes(rotated)),
            Rare::Smla => self.wrapping_word(halves + addend),
            Rare::Smul => halves as u32,
            Rare::Smlaw => self.wrapping_word(by_half + addend),
            Rare::Smulw => by_half as u32,
            Rare::Smlad => self.wrapping_word(both + addend),
            Rare::Smuad => self.wrapping_word(both),
            Rare::Smlsd => self.wrapping_word(difference + addend),
            Rare::Smusd => difference as u32,
            Rare::Smmla => ((addend << 32).wrapping_add(sn * sm).wrapping_add(round) >> 32) as u32,
            Rare::Smmul => ((sn * sm).wrapping_add(round) >> 32) as u32,
            Rare::Smmls => ((addend << 32).wrapping_sub(sn * sm).wrapping_add(round) >> 32) as u32,
            Rare::Usad8 | Rare::Usada8 => {
                let bytes = vn.to_le_bytes().into_iter().zip(vm.to_le_bytes());
                let sum: u32 = bytes.map(|(a, b)| u32::from(a.abs_diff(b))).sum();
                if op == Rare::Usada8 {
                    sum.wrapping_add(addend as u32)
                } else {
                    sum
                }
            }
            Rare::Smlal | Rare::Umlal | Rare::SmlalHalves | Rare::Smlald | Rare::Smlsld => {
                let product = match op {
                    Rare::Smlal => (sn * sm) as u64,
                    Rare::Umlal => u64::from(vn) * u64::from(vm),
                    Rare::SmlalHalves => halves as u64,
                    Rare::Smlald => both as u64,
                    _ => difference as u64,
                };
                let sum = self.long(a, d).wrapping_add(product);
                return self.set_long(a, d, sum);
            }
            Rare::Umaal => {
                let sum = u64::from(vn) * u64::from(vm)
                    + u64::from(self.register(a))
                    + u64::from(self.register(d));
                return self.set_long(a, d, sum);
            }
            Rare::Ssat | Rare::Usat => {
                let amount = x & 31;
                let shifted = match (x & 32 != 0, vn as i32) {
                    (true, value) => value >> amount,
                    (false, value) => value << amount,
                };
                let (least, most) = if op == Rare::Ssat {
                    (-1i64 << (a - 1), (1i64 << (a - 1)) - 1)
                } else {
                    (0, (1i64 << a) - 1)
                };
                self.saturating(shifted.into(), least, most)
            }
            Rare::Ssat16 | Rare::Usat16 => {
                let (least, most) = if op == Rare::Ssat16 {
                    (-1i64 << (a - 1), (1i64 << (a - 1)) - 1)
                } else {
                    (0, (1i64 << a) - 1)
                };
                let low = self.saturating(half(vn, 0).into(), least, most);
                let high = self.saturating(half(vn, 1).into(), least, most);
                low & 0xFFFF | high << 16
            }
            Rare::Pkh if a == 1 => {
                let shifted = if x >= 32 {
                    (vm as i32 >> 31) as u32
                } else {
                    (vm as i32 >> x) as u32
                };
                vn & 0xFFFF_0000 | shifted & 0xFFFF
            }
            Rare::Pkh => vn & 0xFFFF | vm << x & 0xFFFF_0000,
            Rare::Sbfx => ((vn << (32 - u32::from(a) - u32::from(x))) as i32 >> (32 - x)) as u32,
        };
        self.r[usize::from(d & 31)] = value;
    }
}
