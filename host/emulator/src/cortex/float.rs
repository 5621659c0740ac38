// SPDX-License-Identifier: GPL-2.0-only
//! Arithmetic of the floating-point unit: IEEE 754 single precision on the host's, which rounds the same to nearest; flags, NaNs,
//! flushing and the other rounding modes as ARMv7-M has them.
//!
//! Results that can only be inexact are taken from the host when that flag is set already. All others are derived from the exact
//! result as a sum of two doubles.

mod compare;
mod convert;

use std::cmp::Ordering;

const INVALID: u32 = 1;
const DIVISION: u32 = 2;
const OVERFLOW: u32 = 4;
const UNDERFLOW: u32 = 8;
const INEXACT: u32 = 1 << 4;
const DENORMAL: u32 = 1 << 7;
const FLAGS: u32 = 0x9F;
const FLUSH: u32 = 1 << 24;
const DEFAULT_NAN: u32 = 1 << 25;
const ROUNDING: u32 = 3 << 22;
const WRITABLE: u32 = 0xF7C0_009F;
const CONDITIONS: u32 = 0xF000_0000;

const NAN: u32 = 0x7FC0_0000;
const QUIET: u32 = 0x0040_0000;
const SIGN: u32 = 0x8000_0000;
const INFINITY: u32 = 0x7F80_0000;

/// The unit's registers.
#[derive(Clone, Debug)]
pub(super) struct Fpu {
    pub(super) s: [u32; 32],
    status: u32,
    /// Nothing but the inexact flag can come of a normal result, and it is set: no modes, or rather the default ones.
    quick: bool,
}

/// An exact result: the nearest double, and a number with the sign of the rest.
type Exact = (f64, f64);

fn is_nan(a: u32) -> bool {
    a & !SIGN > INFINITY
}

fn is_signalling(a: u32) -> bool {
    is_nan(a) && a & QUIET == 0
}

fn is_infinite(a: u32) -> bool {
    a & !SIGN == INFINITY
}

fn is_zero(a: u32) -> bool {
    a & !SIGN == 0
}

fn is_denormal(a: u32) -> bool {
    !is_zero(a) && a & INFINITY == 0
}

/// Above the least normal number, which may be the rounded result of a smaller one, and finite.
fn is_plain(a: u32) -> bool {
    (a & !SIGN).wrapping_sub(0x0080_0001) < INFINITY - 0x0080_0001
}

fn wide(a: u32) -> f64 {
    f32::from_bits(a).into()
}

/// Exact sum (Knuth).
fn sum(a: f64, b: f64) -> Exact {
    let s = a + b;
    let from_b = s - a;
    (s, (a - (s - from_b)) + (b - from_b))
}

impl Fpu {
    pub(super) fn new() -> Self {
        Self {
            s: [0; 32],
            status: 0,
            quick: false,
        }
    }

    pub(super) fn status(&self) -> u32 {
        self.status
    }

    pub(super) fn set_status(&mut self, status: u32) {
        self.status = status & WRITABLE;
        self.update();
    }

    fn update(&mut self) {
        self.quick = self.status & (FLUSH | DEFAULT_NAN | ROUNDING | INEXACT) == INEXACT;
    }

    fn raise(&mut self, flags: u32) {
        if self.status & flags != flags {
            self.status |= flags & FLAGS;
            self.update();
        }
    }

    fn has(&self, mode: u32) -> bool {
        self.status & mode != 0
    }

    /// An operand, flushed to zero if it is denormal and the mode says so.
    fn operand(&mut self, a: u32) -> u32 {
        if self.has(FLUSH) && is_denormal(a) {
            self.raise(DENORMAL);
            return a & SIGN;
        }
        a
    }

    fn invalid(&mut self) -> u32 {
        self.raise(INVALID);
        NAN
    }

    /// The NaN that comes of operands of which one is a NaN: the first signalling one, otherwise the first.
    fn propagate(&mut self, operands: &[u32]) -> u32 {
        let signalling = operands.iter().copied().find(|&a| is_signalling(a));
        if signalling.is_some() {
            self.raise(INVALID);
        }
        let chosen = signalling.or_else(|| operands.iter().copied().find(|&a| is_nan(a)));
        match chosen {
            Some(nan) if !self.has(DEFAULT_NAN) => nan | QUIET,
            _ => NAN,
        }
    }

    /// Rounds an exact, finite result in the present mode; `nearest` is the host's result.
    fn round(&mut self, nearest: f32, (value, rest): Exact) -> u32 {
        const LEAST: f64 = f32::MIN_POSITIVE as f64;
        let bits = nearest.to_bits();
        let side = match f64::from(nearest).partial_cmp(&value) {
            Some(Ordering::Equal) => rest.partial_cmp(&0.0).unwrap_or(Ordering::Equal),
            Some(order) => order.reverse(),
            None => Ordering::Equal,
        };
        let below = value.abs() < LEAST
            || value.abs() == LEAST && rest != 0.0 && (rest < 0.0) != (value < 0.0);
        let tiny = below && (value != 0.0 || rest != 0.0);
        if tiny && self.has(FLUSH) {
            self.raise(UNDERFLOW);
            return bits & SIGN;
        }
        // Directed rounding takes the neighbour if the nearest lies on the wrong side.
        let negative = value < 0.0 || value == 0.0 && bits & SIGN != 0;
        let up = match self.status & ROUNDING {
            0x0040_0000 => Some(true),
            0x0080_0000 => Some(false),
            0x00C0_0000 => Some(negative),
            _ => None,
        };
        let rounded = match (up, side) {
            (Some(true), Ordering::Greater) => nearest.next_up(),
            (Some(false), Ordering::Less) => nearest.next_down(),
            _ => nearest,
        };
        let rounded = if rounded == 0.0 {
            f32::from_bits(bits & SIGN)
        } else {
            rounded
        };
        let too_large = rounded.is_infinite()
            || value.abs() >= f64::from(f32::MAX) * (1.0 + f64::from(f32::EPSILON) / 2.0);
        if too_large && (rounded.is_infinite() || value.abs() >= 2f64.powi(128)) {
            self.raise(OVERFLOW | INEXACT);
        } else if side != Ordering::Equal {
            self.raise(if tiny { UNDERFLOW | INEXACT } else { INEXACT });
        }
        rounded.to_bits()
    }

    /// Zero as a sum of opposite numbers: negative when rounding down.
    fn zero_sum(&self) -> u32 {
        if self.status & ROUNDING == 0x0080_0000 {
            SIGN
        } else {
            0
        }
    }

    /// The sum if nothing but the inexact flag can come of it.
    #[inline(always)]
    pub(super) fn quick_add(&self, a: u32, b: u32) -> Option<u32> {
        let r = (f32::from_bits(a) + f32::from_bits(b)).to_bits();
        (self.quick && r & INFINITY != INFINITY).then_some(r)
    }

    pub(super) fn add(&mut self, a: u32, b: u32) -> u32 {
        match self.quick_add(a, b) {
            Some(r) => r,
            None => self.add_with_flags(a, b),
        }
    }

    #[cold]
    #[inline(never)]
    fn add_with_flags(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.operand(a), self.operand(b));
        if is_nan(a) || is_nan(b) {
            return self.propagate(&[a, b]);
        }
        if is_infinite(a) || is_infinite(b) {
            let opposite = is_infinite(a) && is_infinite(b) && a != b;
            return if opposite {
                self.invalid()
            } else if is_infinite(a) {
                a
            } else {
                b
            };
        }
        let exact = sum(wide(a), wide(b));
        if exact == (0.0, 0.0) {
            return if a == b { a } else { self.zero_sum() };
        }
        self.round(f32::from_bits(a) + f32::from_bits(b), exact)
    }

    /// The difference, likewise.
    #[inline(always)]
    pub(super) fn quick_sub(&self, a: u32, b: u32) -> Option<u32> {
        let r = (f32::from_bits(a) - f32::from_bits(b)).to_bits();
        (self.quick && r & INFINITY != INFINITY).then_some(r)
    }

    pub(super) fn sub(&mut self, a: u32, b: u32) -> u32 {
        if let Some(r) = self.quick_sub(a, b) {
            return r;
        }
        // The sign of a NaN stays.
        if is_nan(a) || is_nan(b) {
            return self.propagate(&[a, b]);
        }
        self.add_with_flags(a, b ^ SIGN)
    }

    /// The product, likewise.
    #[inline(always)]
    pub(super) fn quick_mul(&self, a: u32, b: u32) -> Option<u32> {
        let r = (f32::from_bits(a) * f32::from_bits(b)).to_bits();
        // Of zero, zero is exact.
        let exact = is_zero(r) && (is_zero(a) || is_zero(b));
        (self.quick && (is_plain(r) || exact)).then_some(r)
    }

    pub(super) fn mul(&mut self, a: u32, b: u32) -> u32 {
        match self.quick_mul(a, b) {
            Some(r) => r,
            None => self.mul_with_flags(a, b),
        }
    }

    #[cold]
    #[inline(never)]
    fn mul_with_flags(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.operand(a), self.operand(b));
        let sign = (a ^ b) & SIGN;
        if is_nan(a) || is_nan(b) {
            return self.propagate(&[a, b]);
        }
        match (is_infinite(a) || is_infinite(b), is_zero(a) || is_zero(b)) {
            (true, true) => self.invalid(),
            (true, false) => INFINITY | sign,
            (false, true) => sign,
            (false, false) => self.round(
                f32::from_bits(a) * f32::from_bits(b),
                (wide(a) * wide(b), 0.0),
            ),
        }
    }

    #[inline(always)]
    pub(super) fn div(&mut self, a: u32, b: u32) -> u32 {
        let r = (f32::from_bits(a) / f32::from_bits(b)).to_bits();
        if self.quick && is_plain(r) {
            return r;
        }
        self.div_with_flags(a, b)
    }

    #[cold]
    #[inline(never)]
    fn div_with_flags(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.operand(a), self.operand(b));
        let sign = (a ^ b) & SIGN;
        if is_nan(a) || is_nan(b) {
            return self.propagate(&[a, b]);
        }
        match ((is_infinite(a), is_infinite(b)), (is_zero(a), is_zero(b))) {
            ((true, true), _) | (_, (true, true)) => self.invalid(),
            ((true, _), _) => INFINITY | sign,
            ((_, true), _) | (_, (true, _)) => sign,
            (_, (_, true)) => {
                self.raise(DIVISION);
                INFINITY | sign
            }
            _ => {
                let (x, y) = (wide(a), wide(b));
                let quotient = x / y;
                let rest = (-quotient).mul_add(y, x) * y.signum();
                self.round(f32::from_bits(a) / f32::from_bits(b), (quotient, rest))
            }
        }
    }

    pub(super) fn sqrt(&mut self, a: u32) -> u32 {
        if self.quick && a & SIGN == 0 && is_plain(a) {
            return f32::from_bits(a).sqrt().to_bits();
        }
        let a = self.operand(a);
        if is_nan(a) {
            return self.propagate(&[a]);
        }
        if is_zero(a) || a == INFINITY {
            return a;
        }
        if a & SIGN != 0 {
            return self.invalid();
        }
        let x = wide(a);
        let root = x.sqrt();
        self.round(f32::from_bits(a).sqrt(), (root, (-root).mul_add(root, x)))
    }

    /// `a * b + c`, rounded once.
    pub(super) fn fused(&mut self, a: u32, b: u32, c: u32) -> u32 {
        let r = f32::from_bits(a)
            .mul_add(f32::from_bits(b), f32::from_bits(c))
            .to_bits();
        if self.quick && is_plain(r) {
            return r;
        }
        let (a, b, c) = (self.operand(a), self.operand(b), self.operand(c));
        let undetermined = is_infinite(a) && is_zero(b) || is_zero(a) && is_infinite(b);
        if undetermined && !is_signalling(c) {
            return self.invalid();
        }
        if is_nan(a) || is_nan(b) || is_nan(c) {
            if undetermined {
                self.raise(INVALID);
            }
            return self.propagate(&[c, a, b]);
        }
        let product = (a ^ b) & SIGN;
        if is_infinite(a) || is_infinite(b) {
            let opposite = is_infinite(c) && (c & SIGN) != product;
            return if opposite {
                self.invalid()
            } else {
                INFINITY | product
            };
        }
        if is_infinite(c) {
            return c;
        }
        let exact = sum(wide(a) * wide(b), wide(c));
        if exact == (0.0, 0.0) {
            return if product == c & SIGN {
                product
            } else {
                self.zero_sum()
            };
        }
        self.round(
            f32::from_bits(a).mul_add(f32::from_bits(b), f32::from_bits(c)),
            exact,
        )
    }
}
