//! A line of text, put together piece by piece: what answers are written with.
//!
//! `core::fmt` would do it too, with padding, precision and a pointer to a function for every argument in flash, none of
//! which an answer needs.

use heapless::String;

/// Longest line, bytes.
pub const LINE_BYTES: usize = 120;

/// A line of text. A piece that does not fit any more is left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line(String<LINE_BYTES>);

impl Line {
    /// An empty line.
    pub const fn new() -> Self {
        Self(String::new())
    }

    /// Takes back all that has been written.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// What has been written.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Appends text.
    #[inline(never)]
    pub fn text(&mut self, text: &str) -> &mut Self {
        // What does not fit is left out.
        let _ = self.0.push_str(text);
        self
    }

    /// Appends a number with at most three decimals, without trailing zeros; beyond two millions, `large`.
    #[inline(never)]
    pub fn decimal(&mut self, value: f32) -> &mut Self {
        if value.is_nan() {
            return self.text("nan");
        }
        let magnitude = value.abs();
        let thousandths = (magnitude * 1000.0 + 0.5) as u32;
        if value < 0.0 && thousandths > 0 {
            self.text("-");
        }
        // Up to here, 2e9 + 1 at most: the integer has not saturated.
        if magnitude > 2.0e6 {
            return self.text("large");
        }
        self.digits(thousandths, 1000)
    }

    /// Appends a whole number.
    pub fn integer(&mut self, value: i32) -> &mut Self {
        if value < 0 {
            self.text("-");
        }
        self.digits(value.unsigned_abs(), 1)
    }

    /// Appends `value / unit`, where `unit` is a power of ten: from the first digit that counts, or the units, to the last that
    /// is not zero, or the units.
    #[inline(never)]
    fn digits(&mut self, value: u32, unit: u32) -> &mut Self {
        let (mut rest, mut place) = (value, 1_000_000_000);
        while place >= unit || rest > 0 {
            // Subtracted, not divided: the divisor might be zero for all that the compiler knows.
            let mut digit = b'0';
            while rest >= place {
                rest -= place;
                digit = digit.wrapping_add(1);
            }
            if place == unit / 10 {
                self.text(".");
            }
            if place <= unit || value >= place {
                // ASCII, as the mask says to the compiler: it spares the encoding of all other characters.
                let _ = self.0.push(char::from(digit & 0x7F));
            }
            place /= 10;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::decimal;
    use proptest::prelude::*;

    fn decimal(value: f32) -> String<LINE_BYTES> {
        let mut line = Line::new();
        line.decimal(value);
        line.0
    }

    #[test]
    fn numbers_are_written_as_a_person_would() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0001, "0"),
            (12.5, "12.5"),
            (-0.05, "-0.05"),
            (0.0004, "0"),
            (1.2345, "1.235"),
            (183.0, "183"),
            (f32::NAN, "nan"),
            (f32::NEG_INFINITY, "-large"),
            (f32::MAX, "large"),
        ] {
            assert_eq!(decimal(value), text);
        }
    }

    #[test]
    fn what_does_not_fit_is_left_out() {
        let mut line = Line::new();
        for _ in 0..LINE_BYTES / 7 {
            line.text("seven, ");
        }
        assert_eq!(line.as_str().len(), 119);
        line.text("seven, ").integer(-8);
        assert_eq!(line.as_str().len(), 120);
        assert!(line.as_str().ends_with("seven, -"));
    }

    proptest! {
        #[test]
        fn whole_numbers_are_written_as_the_standard_library_does(value: i32) {
            let mut line = Line::new();
            line.integer(value);
            prop_assert_eq!(line.as_str(), value.to_string());
        }

        #[test]
        fn what_is_written_is_read_back(value in -1.0e3f32..1.0e3) {
            let read = decimal::parse(decimal(value).as_bytes()).expect("a number");
            prop_assert!((read - value).abs() <= 0.5001e-3 + 1e-4);
        }

        #[test]
        fn any_bits_are_written(bits: u32) {
            prop_assert!(!decimal(f32::from_bits(bits)).is_empty());
        }
    }
}
