//! Bisection.

/// Halvings of the bracket: the middle of what is left of [0, l] is within 2^-25 l, 3e-6 % of l, about what rounding leaves
/// (`cargo xtask report` shows the error over the number of steps).
pub const BISECTION_STEPS: u32 = 24;

/// Zero of `residual` in `[low, high]`, where its signs must differ (a zero at an end counts); `None` where they do not or
/// the bracket or its width is not finite.
///
/// [`BISECTION_STEPS`] evaluations after the two at the ends, whatever the residual. Only signs are used: the
/// residual must be bounded and change sign once, its scale does not matter.
pub fn bisect(low: f32, high: f32, mut residual: impl FnMut(f32) -> f32) -> Option<f32> {
    let mut width = high - low;
    if !(low.is_finite() && width.is_finite()) {
        return None;
    }
    let (at_low, at_high) = (residual(low), residual(high));
    // From the end where the residual is negative, to either side: one comparison a step. A NaN at either end fails.
    let mut below = if at_low < 0.0 && at_high > 0.0 {
        low
    } else if at_low > 0.0 && at_high < 0.0 {
        width = -width;
        high
    } else if at_low == 0.0 {
        return Some(low);
    } else if at_high == 0.0 {
        return Some(high);
    } else {
        return None;
    };
    width *= 0.5;
    let (mut middle, mut steps) = (below + width, BISECTION_STEPS);
    // Asked at its end whether to go on, this loop is two instructions shorter than with a range.
    loop {
        if residual(middle) < 0.0 {
            below = middle;
        }
        width *= 0.5;
        middle = below + width;
        steps -= 1;
        if steps == 0 {
            return Some(middle);
        }
    }
}
