//! Clamps a value to limits of both signs; the common case, no clamping, is fast.

/// `x` within `-limit..=limit`, `limit` not negative, and whether it was beyond; NaN gives `limit`.
///
/// For the control interrupt: a value within its limits, the usual case, costs one comparison; `clamp` and a comparison with
/// its result cost three.
pub fn within(x: f32, limit: f32) -> (f32, bool) {
    if x.abs() <= limit {
        (x, false)
    } else if x < 0.0 {
        (-limit, true)
    } else {
        (limit, true)
    }
}

#[cfg(test)]
mod tests {
    use super::within;
    use crate::numeric::clamp;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_a_clamp_that_says_so(x: f32, limit in 0.0f32..1e30) {
            let (held, beyond) = within(x, limit);
            prop_assert_eq!(held, clamp(x, -limit, limit));
            prop_assert_eq!(beyond, held != x);
        }
    }

    #[test]
    fn the_limits_themselves_are_within() {
        assert_eq!(within(2.0, 2.0), (2.0, false));
        assert_eq!(within(-2.0, 2.0), (-2.0, false));
        assert_eq!(within(f32::INFINITY, 2.0), (2.0, true));
        assert_eq!(within(f32::NEG_INFINITY, 2.0), (-2.0, true));
        assert_eq!(within(f32::NAN, 2.0), (2.0, true));
        assert_eq!(within(1e-30, 0.0), (0.0, true));
    }
}
