//! Clamping that cannot panic and treats NaN as beyond the bound.

/// `x` held between `low` and `high`, of which `low` is not above `high`.
///
/// Four instructions a bound. `f32::clamp` panics where the bounds are crossed; `x.min(high).max(low)` costs 13 a bound,
/// because either argument may be NaN. Here a NaN becomes `high`: never a silent NaN behind a clamp.
#[inline(always)]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    let below = if x < high { x } else { high };
    if below > low { below } else { low }
}

/// Lower and upper bound of a number, four instructions each. `f32::max` and `f32::min` take 13, because either argument may
/// be NaN. Here a NaN becomes the bound, which must be a number itself.
pub trait Bounded {
    /// The number, or `low` where it is below.
    fn at_least(self, low: Self) -> Self;
    /// The number, or `high` where it is above.
    fn at_most(self, high: Self) -> Self;
}

impl Bounded for f32 {
    #[inline(always)]
    fn at_least(self, low: f32) -> f32 {
        if self > low { self } else { low }
    }

    #[inline(always)]
    fn at_most(self, high: f32) -> f32 {
        if self < high { self } else { high }
    }
}

#[cfg(test)]
mod tests {
    use super::{Bounded, clamp};
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
    fn a_bound_holds_and_replaces_nan() {
        for (x, low, high) in [
            (-2.0f32, -1.0f32, -2.0f32),
            (3.0, 3.0, 1.0),
            (0.5, 0.5, 0.5),
        ] {
            assert_eq!((x.at_least(-1.0), x.at_most(1.0)), (low, high));
        }
        assert_eq!(f32::NAN.at_least(-1.0), -1.0);
        assert_eq!(f32::NAN.at_most(1.0), 1.0);
        assert_eq!(f32::INFINITY.at_most(1.0), 1.0);
        assert_eq!(f32::NEG_INFINITY.at_least(-1.0), -1.0);
    }

    #[test]
    fn ends_and_nan() {
        assert_eq!(clamp(f32::NEG_INFINITY, -1.0, 2.0), -1.0);
        assert_eq!(clamp(f32::INFINITY, -1.0, 2.0), 2.0);
        assert_eq!(clamp(f32::NAN, -1.0, 2.0), 2.0);
        assert_eq!(clamp(3.0, 0.0, 0.0), 0.0);
    }
}
