//! Text of the answers, and the numbers in it and in commands.
//!
//! Numbers are read and written as thousandths, digit by digit: `core`'s floating-point text brings tables and big-number code for
//! digits that no answer shows, its text of integers 900 bytes of padding, and `itoa` a table.

use core::fmt::{self, Display, Write};

/// Longest answer, bytes.
pub const ANSWER_BYTES: usize = 120;

/// An answer. What does not fit any more is left out, from the first piece that does not.
pub type Answer = heapless::String<ANSWER_BYTES>;

/// Most digits that are read before the point, and what six behind it are divided by; a single-precision number has no more
/// than nine digits that count.
const WHOLE_READ: u32 = 9;
const SCALE_MAX: f32 = 1e6;
const ONE: u32 = 1000;

/// A number with at most three decimals, without trailing zeros; beyond two millions, `large`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal(pub f32);

impl Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if self.0.is_nan() {
            return f.write_str("nan");
        }
        let thousandths = (magnitude * ONE as f32 + 0.5) as u32;
        if self.0 < 0.0 && thousandths > 0 {
            f.write_str("-")?;
        }
        // Up to here 2e9 + 1 at most: the integer has not saturated.
        if magnitude > 2.0e6 {
            return f.write_str("large");
        }
        // Without trailing zeros, in units of the last decimal that is left.
        let (mut number, mut one) = (thousandths, ONE);
        while one > 1 && number % 10 == 0 {
            (number, one) = (number / 10, one / 10);
        }
        write_digits(f, number, one)
    }
}

/// A whole number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole(pub i32);

impl Display for Whole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 0 {
            f.write_str("-")?;
        }
        write_digits(f, self.0.unsigned_abs(), 1)
    }
}

/// Writes the digits of `number / one`, where `one` is a power of ten up to a thousand.
fn write_digits(f: &mut fmt::Formatter<'_>, number: u32, one: u32) -> fmt::Result {
    // From the first digit on; its place is not above the number, or is that of a zero before the point, and does not overflow.
    let mut place = one;
    while number / 10 >= place {
        place *= 10;
    }
    while place > 0 {
        f.write_char(char::from(b'0' + (number / place % 10) as u8))?;
        if place == one && one > 1 {
            f.write_char('.')?;
        }
        place /= 10;
    }
    Ok(())
}

/// Text that is written without padding. Writing a `&str` with `{}` links `core`'s padding, 640 bytes that no answer needs.
#[derive(Clone, Copy, Debug)]
pub struct Plain<'t>(pub &'t str);

impl Display for Plain<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// Reads a decimal number such as `-12.5`, `.5` or `7`: no exponent, at most nine digits before the point and six behind it.
///
/// The result is within two units in the last place of the number written.
pub fn number(text: &[u8]) -> Option<f32> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    // Before the point and behind it.
    let (mut whole, mut fraction) = (0, None);
    let mut before = 0;
    let mut scale = 1.0;
    for &byte in digits {
        match (byte, &mut fraction) {
            (b'.', None) => fraction = Some(0),
            (b'0'..=b'9', None) => {
                before += 1;
                if before > WHOLE_READ {
                    return None;
                }
                whole = 10 * whole + u32::from(byte - b'0');
            }
            (b'0'..=b'9', Some(fraction)) => {
                if scale >= SCALE_MAX {
                    return None;
                }
                scale *= 10.0;
                *fraction = 10 * *fraction + u32::from(byte - b'0');
            }
            _ => return None,
        }
    }
    if before == 0 && scale == 1.0 {
        return None;
    }
    let magnitude = whole as f32 + fraction.unwrap_or(0) as f32 / scale;
    Some(if negative { -magnitude } else { magnitude })
}

/// Whether a word is this one; case does not matter.
// Not inlined: wanted in eight places.
#[inline(never)]
pub(super) fn same(word: &[u8], this: &str) -> bool {
    word.eq_ignore_ascii_case(this.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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

    #[test]
    fn what_does_not_fit_is_left_out() {
        let mut answer = Answer::new();
        for _ in 0..20 {
            let _ = write!(answer, "seven, ");
        }
        assert_eq!(answer.len(), 119);
    }

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
            "-+1",
            "1.+2",
            "1-",
            "0x1",
            "1234567890",
            "0.1234567",
            "٣",
        ] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn reading_agrees_with_the_standard_library(whole in 0u32..100_000, decimals in 0u32..10_000, negative: bool) {
            let text = format!("{}{whole}.{decimals:04}", if negative { "-" } else { "" });
            let expected: f32 = text.parse().expect("a number");
            let read = number(text.as_bytes()).expect("a number");
            prop_assert!((read - expected).abs() <= 2.0 * expected.abs() * f32::EPSILON, "{read} {expected}");
        }

        #[test]
        fn any_text_is_read_or_refused(text in proptest::collection::vec(any::<u8>(), 0..20)) {
            if let Some(value) = number(&text) {
                prop_assert!(value.is_finite());
            }
        }

        #[test]
        fn what_is_written_is_read_back(value in -1.0e3f32..1.0e3) {
            let read = number(Decimal(value).to_string().as_bytes()).expect("a number");
            prop_assert!((read - value).abs() <= 0.5001e-3 + 1e-4);
        }

        #[test]
        fn whole_numbers_are_the_standard_library_s(value: i32) {
            prop_assert_eq!(Whole(value).to_string(), value.to_string());
        }

        #[test]
        fn any_bits_are_written(bits: u32) {
            prop_assert!(!Decimal(f32::from_bits(bits)).to_string().is_empty());
        }
    }
}
