//! Bisection.

/// Halvings of the bracket: the middle of what is left of [0, l] is within 2^-25 l, 3e-6 % of l, about what rounding leaves
/// (`cargo xtask report` shows the error over the number of steps).
pub const BISECTION_STEPS: u32 = 24;

/// Zero of `residual` in `[low, high]`, where its signs must differ (a zero at an end counts); `None` where they do not or
/// the bracket is not finite.
///
/// [`BISECTION_STEPS`] evaluations after the two at the ends, whatever the residual. Only signs are used: the
/// residual must be bounded and change sign once, its scale does not matter.
pub fn bisect(low: f32, high: f32, mut residual: impl FnMut(f32) -> f32) -> Option<f32> {
    if !(low.is_finite() && high.is_finite()) {
        return None;
    }
    let (at_low, at_high) = (residual(low), residual(high));
    if at_low == 0.0 {
        return Some(low);
    }
    if at_high == 0.0 {
        return Some(high);
    }
    // Written so that a NaN at either end fails.
    if !((at_low < 0.0 && at_high > 0.0) || (at_low > 0.0 && at_high < 0.0)) {
        return None;
    }
    // Ends by the sign of the residual instead of by size: one comparison a step.
    let (mut below, mut above) = if at_low < 0.0 {
        (low, high)
    } else {
        (high, low)
    };
    for _ in 0..BISECTION_STEPS {
        let middle = 0.5 * below + 0.5 * above;
        if residual(middle) < 0.0 {
            below = middle;
        } else {
            above = middle;
        }
    }
    Some(0.5 * below + 0.5 * above)
}
