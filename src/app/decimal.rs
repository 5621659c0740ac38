//! Decimal numbers as a user types them.
//!
//! `core` reads any float exactly, at the price of tables and big-number code of many KiB. A user types "12.5": integers are
//! enough for that.

/// Most digits that are read; more would not fit the integer, nor a single-precision number.
const DIGITS_MAX: u32 = 9;

/// Reads a decimal number such as `-12.5`, `.5` or `7`; no exponent, at most nine digits.
///
/// The result is within one unit in the last place of the number written.
pub fn parse(text: &[u8]) -> Option<f32> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let (mut value, mut left): (u32, u32) = (0, DIGITS_MAX);
    // One, ten, a hundred behind the point; zero before it.
    let mut scale: u32 = 0;
    for &byte in digits {
        if byte == b'.' && scale == 0 {
            scale = 1;
            continue;
        }
        // So few digits that neither integer overflows.
        if !byte.is_ascii_digit() || left == 0 {
            return None;
        }
        left -= 1;
        value = value * 10 + u32::from(byte - b'0');
        scale *= 10;
    }
    if left == DIGITS_MAX {
        return None;
    }
    let magnitude = value as f32 / scale.max(1) as f32;
    Some(if negative { -magnitude } else { magnitude })
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
            assert_eq!(parse(text.as_bytes()), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn reading_agrees_with_the_standard_library(whole in 0u32..100_000, decimals in 0u32..10_000, negative: bool) {
            let text = format!("{}{whole}.{decimals:04}", if negative { "-" } else { "" });
            let expected: f32 = text.parse().expect("a number");
            let read = parse(text.as_bytes()).expect("a number");
            prop_assert!((read - expected).abs() <= expected.abs() * f32::EPSILON, "{read} {expected}");
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            if let Some(value) = parse(text.as_bytes()) {
                prop_assert!(value.is_finite());
            }
        }
    }
}
