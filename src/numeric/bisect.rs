//! Bisection: of any residual, and of a quadratic one at nine instructions a halving.

/// Halvings of the bracket: the middle of what remains of [0, l] is within 2^-25 l, 3e-6 % of l, about the rounding of f32
/// (`cargo xtask report` shows the error over the number of halvings).
pub const BISECTION_STEPS: u32 = 24;

/// Where the residual u (slope + bend u) - bound turns from positive, at `inside`, to zero or negative, at u = 0:
/// [`BISECTION_STEPS`] halvings of nine instructions without a branch. The answer lies between the two and within 2^-25 of
/// their distance of the change.
///
/// Neither end is evaluated: the caller knows their signs. `inside` must be finite, of either sign.
// A function of its own: the report counts its calls in the firmware.
#[inline(never)]
pub fn bisect_quadratic(inside: f32, slope: f32, bend: f32, bound: f32) -> f32 {
    let (mut last, mut width) = (inside, -0.5 * inside);
    let mut middle = last + width;
    let mut halve = || {
        if middle * (slope + bend * middle) > bound {
            last = middle;
        }
        width *= 0.5;
        middle = last + width;
    };
    // Eight at a time: the counter would cost as much as a quarter of the residual.
    for _ in 0..BISECTION_STEPS / 8 {
        halve();
        halve();
        halve();
        halve();
        halve();
        halve();
        halve();
        halve();
    }
    middle
}

/// Zero of `residual` in `[low, high]`, where its signs must differ (a zero at an end counts); `None` where they do not or
/// the bracket or its width is not finite.
///
/// [`BISECTION_STEPS`] evaluations after the two at the ends, whatever the residual. Only signs are used: the
/// residual must be bounded and change sign once, its scale does not matter.
pub fn bisect(low: f32, high: f32, mut residual: impl FnMut(f32) -> f32) -> Option<f32> {
    if !(low.is_finite() && (high - low).is_finite()) {
        return None;
    }
    let (at_low, at_high) = (residual(low), residual(high));
    // A NaN at either end fails every comparison.
    if at_low == 0.0 {
        Some(low)
    } else if at_high == 0.0 {
        Some(high)
    } else if at_low < 0.0 && at_high > 0.0 {
        Some(halve(low, high, |x| residual(x) < 0.0))
    } else if at_low > 0.0 && at_high < 0.0 {
        Some(halve(high, low, |x| residual(x) < 0.0))
    } else {
        None
    }
}

/// Where `is_inside` changes between `inside`, where it holds, and `outside`, where it does not.
fn halve(inside: f32, outside: f32, mut is_inside: impl FnMut(f32) -> bool) -> f32 {
    let (mut last, mut width) = (inside, 0.5 * (outside - inside));
    let mut middle = last + width;
    for _ in 0..BISECTION_STEPS {
        if is_inside(middle) {
            last = middle;
        }
        width *= 0.5;
        middle = last + width;
    }
    middle
}
