//! Natural logarithm.

use super::Bounded;
use core::f32::consts::LN_2;
use micromath::F32Ext;

/// 2^126: takes every normal number below one to one or more.
const LIFT: f32 = 8.507_059e37;

/// Natural logarithm of a positive, normal number, error below 1e-4 absolute (measured: 7.2e-5 from 1e-37 to 1e37); for
/// anything else the value of the smallest normal number, -87.3, or of the largest number, 88.7.
///
/// micromath's polynomial, which is meant for one and more: below, its approximate reciprocal would be 0.12 off, so the
/// argument is multiplied by a power of two instead. The logarithms are those of a detection threshold and of evidences,
/// which are compared with differences of one and more.
pub fn ln(x: f32) -> f32 {
    // NaN becomes the smallest number: its comparison fails.
    let x = x.at_least(f32::MIN_POSITIVE).at_most(f32::MAX);
    let (lifted, lift) = if x < 1.0 {
        (x * LIFT, 126.0 * LN_2)
    } else {
        (x, 0.0)
    };
    // By path: on a PC a method call would find the standard library's.
    F32Ext::ln(lifted) - lift
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn ln_is_within_its_stated_error() {
        let mut x = 1e-37f32;
        while x < 1e37 {
            let error = (f64::from(ln(x)) - f64::from(x).ln()).abs();
            assert!(error < 1e-4, "ln {x} is off by {error}");
            x *= 1.003;
        }
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn ln_of_what_has_none_is_finite() {
        for x in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            assert!((ln(x) + 87.336_54).abs() < 1e-3);
        }
        assert!(ln(f32::INFINITY).is_finite());
    }
}
