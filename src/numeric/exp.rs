//! Exponential function.

use core::f32::consts::LOG2_E;

/// Above it the result is no longer a finite number, below its negative no longer a normal one.
const LIMIT: f32 = 87.0;

/// e to the power of x, relative error below 5e-7; beyond +-87 the value there, 0 for NaN.
///
/// From the exponent and the series of the rest, which is at most ln(2)/2.
pub fn exp(x: f32) -> f32 {
    if x.is_nan() {
        return 0.0;
    }
    let x = x.clamp(-LIMIT, LIMIT);
    let power = (x * LOG2_E + 0.5f32.copysign(x)) as i32;
    // ln 2 in two parts, the first short enough for its product to be exact.
    let high = 0.693_359_4;
    let low = -2.121_944_4e-4;
    let rest = (x - power as f32 * high) - power as f32 * low;
    let series = 1.0
        + rest
            * (1.0
                + rest
                    * (0.5
                        + rest
                            * (1.0 / 6.0
                                + rest * (1.0 / 24.0 + rest * (1.0 / 120.0 + rest / 720.0)))));
    series * f32::from_bits(((power + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::exp;

    #[test]
    fn exp_is_within_its_stated_error() {
        let mut x = -86.9f32;
        while x < 86.9 {
            let error = (f64::from(exp(x)) / f64::from(x).exp() - 1.0).abs();
            assert!(error < 5e-7, "exp {x} is off by {error}");
            x += 0.0137;
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(f32::NAN), 0.0);
        assert!(exp(f32::INFINITY).is_finite() && exp(f32::NEG_INFINITY) < 1e-37);
    }
}
