//! Limits: clamping to a range that is symmetric about zero, and the travel of the finger.

/// `x` clamped to `-limit..=limit`, `limit` not negative, and whether it was beyond; NaN gives `limit`.
///
/// For the control interrupt: a value within its limits, the usual case, takes one comparison; `clamp` and a comparison with
/// its result take three.
pub fn limit_magnitude(x: f32, limit: f32) -> (f32, bool) {
    if x.abs() <= limit {
        (x, false)
    } else if x < 0.0 {
        (-limit, true)
    } else {
        (limit, true)
    }
}

/// The finger's travel, counts from the opening stop.
#[derive(Clone, Copy, Debug)]
pub struct Travel {
    /// Opening end.
    pub min_counts: i32,
    /// Closing end.
    pub max_counts: i32,
}

impl Travel {
    /// Counts beyond the travel: negative on the opening side, 0 within.
    #[inline(always)]
    pub fn beyond_counts(&self, position_counts: i32) -> i32 {
        if position_counts > self.max_counts {
            position_counts.wrapping_sub(self.max_counts)
        } else if position_counts < self.min_counts {
            position_counts.wrapping_sub(self.min_counts)
        } else {
            0
        }
    }
}

/// A wanted motion (speed or current, closing positive) so many counts beyond the travel, and whether it was suppressed because
/// it leads further out.
pub fn inward(wanted: f32, beyond_counts: i32) -> (f32, bool) {
    // The usual case, in the control interrupt: one comparison.
    if beyond_counts == 0 {
        return (wanted, false);
    }
    let outward = (beyond_counts > 0 && wanted > 0.0) || (beyond_counts < 0 && wanted < 0.0);
    (if outward { 0.0 } else { wanted }, outward)
}

#[cfg(test)]
mod tests {
    use super::{Travel, inward, limit_magnitude};
    use crate::numeric::clamp;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_a_clamp_that_says_so(x: f32, limit in 0.0f32..1e30) {
            let (held, beyond) = limit_magnitude(x, limit);
            prop_assert_eq!(held, clamp(x, -limit, limit));
            prop_assert_eq!(beyond, held != x);
        }
    }

    #[test]
    fn beyond_the_travel_is_signed_and_zero_within() {
        let travel = Travel {
            min_counts: -10,
            max_counts: 100,
        };
        for (position, beyond) in [(-11, -1), (-10, 0), (0, 0), (100, 0), (107, 7)] {
            assert_eq!(travel.beyond_counts(position), beyond);
        }
    }

    #[test]
    fn beyond_the_travel_only_the_way_back_is_left() {
        for wanted in [-2.0, 0.0, 2.0] {
            assert_eq!(inward(wanted, 0), (wanted, false));
            assert_eq!(inward(wanted, 7), (wanted.min(0.0), wanted > 0.0));
            assert_eq!(inward(wanted, -7), (wanted.max(0.0), wanted < 0.0));
        }
    }

    #[test]
    fn the_limits_themselves_are_within() {
        assert_eq!(limit_magnitude(2.0, 2.0), (2.0, false));
        assert_eq!(limit_magnitude(-2.0, 2.0), (-2.0, false));
        assert_eq!(limit_magnitude(f32::INFINITY, 2.0), (2.0, true));
        assert_eq!(limit_magnitude(f32::NEG_INFINITY, 2.0), (-2.0, true));
        assert_eq!(limit_magnitude(f32::NAN, 2.0), (2.0, true));
        assert_eq!(limit_magnitude(1e-30, 0.0), (0.0, true));
    }
}
