//! Bisection.

/// Halvings of the bracket: a bracket [0, l] ends up 2^-32 l wide, or at neighbouring numbers before that.
pub const BISECTION_STEPS: u32 = 32;

/// Zero of `residual` in `[low, high]`, where its signs must differ (a zero at an end counts); `None` where they do not.
///
/// At most [`BISECTION_STEPS`] evaluations after the two at the ends, whatever the residual. Only signs are used: the
/// residual must be bounded and change sign once, its scale does not matter.
pub fn bisect(low: f32, high: f32, mut residual: impl FnMut(f32) -> f32) -> Option<f32> {
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
    let rising = at_low < 0.0;
    let (mut low, mut high) = (low, high);
    for _ in 0..BISECTION_STEPS {
        let middle = low + 0.5 * (high - low);
        if middle == low || middle == high {
            break;
        }
        if (residual(middle) < 0.0) == rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low + 0.5 * (high - low))
}
