//! Text of the answers, and the numbers in it and in commands.
//!
//! Numbers are read and written as thousandths by `core`'s own integers: `core`'s floating-point text brings tables and
//! big-number code for digits that no answer shows.

use core::fmt::{self, Display};
use core::str;

/// Longest answer, bytes.
pub const ANSWER_BYTES: usize = 120;

/// An answer. What does not fit any more is left out, from the first piece that does not.
pub type Answer = heapless::String<ANSWER_BYTES>;

/// Most decimals that are read; a single-precision number has no more than nine digits that count.
const DECIMALS_READ: u32 = 6;
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
        let (whole, fraction) = (thousandths / ONE, thousandths % ONE);
        match fraction {
            0 => write!(f, "{whole}"),
            _ if fraction % 100 == 0 => write!(f, "{whole}.{}", fraction / 100),
            _ if fraction % 10 == 0 => write!(f, "{whole}.{:02}", fraction / 10),
            _ => write!(f, "{whole}.{fraction:03}"),
        }
    }
}

/// Reads a decimal number such as `-12.5`, `.5` or `7`: no exponent, at most nine digits before the point and six behind it.
///
/// The result is within two units in the last place of the number written.
pub fn number(text: &[u8]) -> Option<f32> {
    let text = str::from_utf8(text).ok()?;
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    if whole.is_empty() && fraction.is_empty() || fraction.len() > DECIMALS_READ as usize {
        return None;
    }
    let scale = 10_u32.pow(fraction.len() as u32);
    let magnitude = integer(whole)? as f32 + integer(fraction)? as f32 / scale as f32;
    Some(if negative { -magnitude } else { magnitude })
}

/// Digits alone; none at all are zero.
fn integer(digits: &str) -> Option<u32> {
    if digits.is_empty() {
        return Some(0);
    }
    // `parse` would take a sign.
    let plain = digits.len() <= 9 && digits.bytes().all(|digit| digit.is_ascii_digit());
    plain.then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::fmt::Write;
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
        fn any_bits_are_written(bits: u32) {
            prop_assert!(!Decimal(f32::from_bits(bits)).to_string().is_empty());
        }
    }
}
