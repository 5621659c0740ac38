// SPDX-License-Identifier: GPL-2.0-only
//! Conversions between floating point, integers and fixed point.

use super::super::op::Conversion;
use super::{Fpu, INEXACT, INVALID, ROUNDING, is_nan, wide};

impl Fpu {
    /// VCVT: the operand as the kind says, with bits of fraction.
    pub(in super::super) fn convert(&mut self, kind: Conversion, a: u32, fraction: u8) -> u32 {
        const I16: (i64, i64) = (i16::MIN as i64, i16::MAX as i64);
        const U16: (i64, i64) = (0, u16::MAX as i64);
        const I32: (i64, i64) = (i32::MIN as i64, i32::MAX as i64);
        const U32: (i64, i64) = (0, u32::MAX as i64);
        if self.quick && fraction == 0 {
            let x = f32::from_bits(a);
            match kind {
                Conversion::FromSigned => return (a as i32 as f32).to_bits(),
                Conversion::FromUnsigned => return (a as f32).to_bits(),
                Conversion::ToSigned if x.abs() < 2_147_483_648.0 => return x as i32 as u32,
                Conversion::ToUnsigned if (0.0..4_294_967_296.0).contains(&x) => return x as u32,
                _ => {}
            }
        }
        let (rounded, limits) = match kind {
            Conversion::FromSigned => return self.float_of((a as i32).into(), fraction),
            Conversion::FromUnsigned => return self.float_of(a.into(), fraction),
            Conversion::FromSigned16 => return self.float_of((a as i16).into(), fraction),
            Conversion::FromUnsigned16 => return self.float_of((a as u16).into(), fraction),
            Conversion::ToSigned => (false, I32),
            Conversion::ToUnsigned => (false, U32),
            Conversion::ToSignedRounded => (true, I32),
            Conversion::ToUnsignedRounded => (true, U32),
            Conversion::ToSigned16 => (false, I16),
            Conversion::ToUnsigned16 => (false, U16),
        };
        self.integer_of(a, fraction, rounded, limits) as u32
    }

    /// An integer or fixed-point number to floating point. The unit rounds fixed point to nearest in every mode.
    fn float_of(&mut self, value: i64, fraction: u8) -> u32 {
        let exact = value as f64 / (1u64 << fraction) as f64;
        if exact == 0.0 {
            return 0;
        }
        let before = self.status;
        if fraction != 0 {
            self.status &= !ROUNDING;
        }
        let bits = self.round(exact as f32, (exact, 0.0));
        self.status |= before & ROUNDING;
        bits
    }

    /// To an integer or fixed-point number between the limits: towards zero, or in the present mode.
    fn integer_of(&mut self, a: u32, fraction: u8, rounded: bool, limits: (i64, i64)) -> i64 {
        let a = self.operand(a);
        if is_nan(a) {
            self.raise(INVALID);
            return 0;
        }
        let exact = wide(a) * (1u64 << fraction) as f64;
        let whole = match self.status & ROUNDING {
            _ if !rounded => exact.trunc(),
            0 => exact.round_ties_even(),
            0x0040_0000 => exact.ceil(),
            0x0080_0000 => exact.floor(),
            _ => exact.trunc(),
        };
        let (least, most) = limits;
        if whole < least as f64 || whole > most as f64 {
            self.raise(INVALID);
            return if whole < 0.0 { least } else { most };
        }
        if whole != exact {
            self.raise(INEXACT);
        }
        whole as i64
    }
}
