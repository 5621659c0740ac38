// SPDX-License-Identifier: GPL-2.0-only
//! Comparisons of the floating-point unit.

use std::cmp::Ordering;

use super::{CONDITIONS, FLUSH, Fpu, INVALID, is_signalling};

impl Fpu {
    /// Compares numbers, not NaNs, without flushing: sets the condition flags and returns them.
    #[inline(always)]
    pub(in crate::cortex) fn quick_compare(&mut self, a: u32, b: u32) -> Option<u32> {
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        // Without branches: the result is as random as the numbers.
        let conditions = 8 * u32::from(x < y) + 6 * u32::from(x == y) + 2 * u32::from(x > y);
        if conditions == 0 || self.has(FLUSH) {
            return None;
        }
        self.status = self.status & !CONDITIONS | conditions << 28;
        Some(conditions)
    }

    /// The same of all numbers; with `signals` every NaN is invalid, otherwise signalling ones.
    #[cold]
    #[inline(never)]
    pub(in crate::cortex) fn compare(&mut self, a: u32, b: u32, signals: bool) -> u32 {
        let (a, b) = (self.operand(a), self.operand(b));
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let conditions = match x.partial_cmp(&y) {
            Some(Ordering::Less) => 8,
            Some(Ordering::Equal) => 6,
            Some(Ordering::Greater) => 2,
            None => {
                if signals || is_signalling(a) || is_signalling(b) {
                    self.raise(INVALID);
                }
                3
            }
        };
        self.status = self.status & !CONDITIONS | conditions << 28;
        conditions
    }
}
