//! Decimal numbers as text, small.
//!
//! `core` reads and writes any float exactly, at the price of some 20 KiB of tables and big-number code. A user types
//! "12.5", and three decimals answer him: integers are enough for that.

use core::fmt::{self, Write};

/// Most digits that are read; more would not fit the integer, nor a single-precision number.
const DIGITS_MAX: u32 = 9;

/// Reads a decimal number such as `-12.5`, `.5` or `7`; no exponent, at most nine digits.
///
/// The result is within one unit in the last place of the number written.
pub fn parse(text: &str) -> Option<f32> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let mut value: u32 = 0;
    let mut scale: u32 = 1;
    let mut count: u32 = 0;
    let mut point = false;
    for byte in digits.bytes() {
        match byte {
            b'.' if !point => point = true,
            b'0'..=b'9' => {
                count = count.checked_add(1).filter(|count| *count <= DIGITS_MAX)?;
                value = value
                    .checked_mul(10)?
                    .checked_add(u32::from(byte.wrapping_sub(b'0')))?;
                if point {
                    scale = scale.checked_mul(10)?;
                }
            }
            _ => return None,
        }
    }
    if count == 0 {
        return None;
    }
    let magnitude = value as f32 / scale as f32;
    Some(if negative { -magnitude } else { magnitude })
}

/// Writes a number with at most three decimals, without trailing zeros; beyond two millions, `large`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal(pub f32);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0;
        if value.is_nan() {
            return f.write_str("nan");
        }
        let magnitude = value.abs();
        let large = magnitude > 2.0e6;
        // At most 2e9 + 1: fits.
        let thousandths = if large {
            u32::MAX
        } else {
            (magnitude * 1000.0 + 0.5) as u32
        };
        if value < 0.0 && thousandths > 0 {
            f.write_char('-')?;
        }
        if large {
            return f.write_str("large");
        }
        let (mut rest, mut place) = (thousandths, 1_000_000_000);
        // From the first digit that counts, or the units, to the last that is not zero, or the units.
        while place >= 1000 || rest > 0 {
            let digit = rest / place;
            if place == 100 {
                f.write_char('.')?;
            }
            if place <= 1000 || thousandths >= place {
                f.write_char(char::from(b'0'.wrapping_add(digit as u8)))?;
            }
            rest %= place;
            place /= 10;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "",
            ".",
            "-",
            "+",
            "1.2.3",
            "1e3",
            "nan",
            "inf",
            "--1",
            "1-",
            "0x1",
            "1234567890",
            "٣",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
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
            assert_eq!(Decimal(value).to_string(), text);
        }
    }

    proptest! {
        #[test]
        fn reading_agrees_with_the_standard_library(whole in 0u32..100_000, decimals in 0u32..10_000, negative: bool) {
            let text = format!("{}{whole}.{decimals:04}", if negative { "-" } else { "" });
            let expected: f32 = text.parse().expect("a number");
            let read = parse(&text).expect("a number");
            prop_assert!((read - expected).abs() <= expected.abs() * f32::EPSILON, "{read} {expected}");
        }

        #[test]
        fn what_is_written_is_read_back(value in -1.0e3f32..1.0e3) {
            let read = parse(&Decimal(value).to_string()).expect("a number");
            prop_assert!((read - value).abs() <= 0.5001e-3 + 1e-4);
        }

        #[test]
        fn any_bits_are_written(bits: u32) {
            prop_assert!(!Decimal(f32::from_bits(bits)).to_string().is_empty());
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            if let Some(value) = parse(&text) {
                prop_assert!(value.is_finite());
            }
        }
    }
}
