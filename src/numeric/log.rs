//! Natural logarithm.

const LN_2_HIGH: f32 = 0.693_359_4;
const LN_2_LOW: f32 = -2.121_944_4e-4;

/// Natural logarithm of a positive, normal number, error below 1e-6 absolute for 1e-6 to 1e6; for anything else the
/// value of the smallest normal number, -87.3.
///
/// From the exponent and the series of artanh: ln m = 2 artanh((m - 1)/(m + 1)), m in [1/sqrt 2, sqrt 2].
pub fn ln(x: f32) -> f32 {
    let x = if x.is_nan() {
        f32::MIN_POSITIVE
    } else {
        x.clamp(f32::MIN_POSITIVE, f32::MAX)
    };
    let bits = x.to_bits();
    // Counted from sqrt(1/2), so that the mantissa left is within a factor sqrt 2 of 1.
    let shifted = bits.wrapping_sub(core::f32::consts::FRAC_1_SQRT_2.to_bits());
    let exponent = (shifted as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    let series = 2.0
        * s
        * (1.0 + square * (1.0 / 3.0 + square * (0.2 + square * (1.0 / 7.0 + square / 9.0))));
    // ln 2 in two parts, the first short enough for its product to be exact.
    exponent as f32 * LN_2_HIGH + (exponent as f32 * LN_2_LOW + series)
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn ln_is_within_its_stated_error() {
        let mut x = 1e-6f32;
        while x < 1e6 {
            let error = (f64::from(ln(x)) - f64::from(x).ln()).abs();
            assert!(error < 1e-6, "ln {x} is off by {error}");
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
