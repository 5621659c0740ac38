//! Natural logarithm.

use micromath::F32Ext;

/// Natural logarithm of a positive, normal number, error below 1e-4 absolute; for anything else the value of the smallest
/// normal number, -87.3.
///
/// micromath's polynomial, whose error is 6.2e-5 from one on. Below one micromath takes an approximate reciprocal, 12 % off,
/// which leaves 0.12: here the reciprocal is exact. The logarithms are those of a detection threshold and of evidences, which
/// are compared with differences of one and more.
pub fn ln(x: f32) -> f32 {
    let x = if x.is_nan() {
        f32::MIN_POSITIVE
    } else {
        x.clamp(f32::MIN_POSITIVE, f32::MAX)
    };
    // By path: on a PC a method call would find the standard library's.
    if x < 1.0 {
        -F32Ext::ln(1.0 / x)
    } else {
        F32Ext::ln(x)
    }
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn ln_is_within_its_stated_error() {
        let mut x = 1e-30f32;
        while x < 1e30 {
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
