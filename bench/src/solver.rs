//! Root finders over a bracket, all with one signature: a residual, the bracket, the wanted width.
//!
//! Each returns NaN where the residual has the same sign at both ends.

/// Most evaluations of the faster methods; they end far sooner, or the bracket has stopped shrinking.
const MOST: u32 = 60;

/// Halves the bracket `steps` times.
#[inline(always)]
pub fn bisect(f: impl Fn(f32) -> f32, mut lo: f32, mut hi: f32, steps: u32) -> f32 {
    let low_is_positive = f(lo) > 0.0;
    if (f(hi) > 0.0) == low_is_positive {
        return f32::NAN;
    }
    for _ in 0..steps {
        let middle = 0.5 * (lo + hi);
        if (f(middle) > 0.0) == low_is_positive {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    0.5 * (lo + hi)
}

/// Interpolate, truncate, project (Oliveira and Takahashi 2020), with kappa_1 = 0.2 / (b - a), kappa_2 = 2, n_0 = 1.
#[inline(always)]
pub fn itp(f: impl Fn(f32) -> f32, lo: f32, hi: f32, width: f32) -> f32 {
    let (mut a, mut b) = (lo, hi);
    let (mut at_a, mut at_b) = (f(a), f(b));
    if (at_a > 0.0) == (at_b > 0.0) {
        return f32::NAN;
    }
    let rising = at_b > 0.0;
    let kappa = 0.2 / (b - a);
    // Radius of the projection: what bisection would have left after the same number of steps, with one to spare.
    let mut reach = b - a;
    for _ in 0..MOST {
        if b - a <= width {
            break;
        }
        let middle = 0.5 * (a + b);
        let secant = (at_b * a - at_a * b) / (at_b - at_a);
        let towards = middle - secant;
        let truncation = kappa * (b - a) * (b - a);
        let truncated = if truncation <= towards.abs() {
            secant + truncation.copysign(towards)
        } else {
            middle
        };
        let radius = reach - 0.5 * (b - a);
        let x = if (truncated - middle).abs() <= radius {
            truncated
        } else {
            middle - radius.copysign(towards)
        };
        reach *= 0.5;
        // Rounding may put the trial on an end, from where nothing moves.
        let x = if x > a && x < b { x } else { middle };
        if x <= a || x >= b {
            break;
        }
        let at_x = f(x);
        if at_x == 0.0 {
            return x;
        }
        if (at_x > 0.0) == rising {
            (b, at_b) = (x, at_x);
        } else {
            (a, at_a) = (x, at_x);
        }
    }
    0.5 * (a + b)
}

/// Chandrupatla's method (1997): inverse quadratic interpolation where its test says that it is safe, else bisection.
#[inline(always)]
pub fn chandrupatla(f: impl Fn(f32) -> f32, lo: f32, hi: f32, width: f32) -> f32 {
    let (mut b, mut a) = (lo, hi);
    let (mut at_b, mut at_a) = (f(b), f(a));
    if (at_a > 0.0) == (at_b > 0.0) {
        return f32::NAN;
    }
    let (mut c, mut at_c);
    let mut share = 0.5;
    for _ in 0..MOST {
        let x = a + share * (b - a);
        let at_x = f(x);
        if (at_x > 0.0) == (at_a > 0.0) {
            (c, at_c) = (a, at_a);
        } else {
            (c, at_c) = (b, at_b);
            (b, at_b) = (a, at_a);
        }
        (a, at_a) = (x, at_x);
        let span = (b - a).abs();
        if at_a == 0.0 || span <= width {
            break;
        }
        let xi = (a - b) / (c - b);
        let phi = (at_a - at_b) / (at_c - at_b);
        let safe = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        share = if safe {
            at_a / (at_b - at_a) * at_c / (at_b - at_c)
                + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
        } else {
            0.5
        };
        let least = 0.5 * width / span;
        // Not `clamp`: it would bring the text of its panic.
        share = share.max(least).min(1.0 - least);
    }
    if at_a.abs() < at_b.abs() { a } else { b }
}

/// Newton's method kept inside a shrinking bracket; `f` gives the residual and its derivative.
#[inline(always)]
pub fn newton(f: impl Fn(f32) -> (f32, f32), lo: f32, hi: f32, width: f32) -> f32 {
    let (mut a, mut b) = (lo, hi);
    let rising = f(b).0 > 0.0;
    if (f(a).0 > 0.0) == rising {
        return f32::NAN;
    }
    let mut x = 0.5 * (a + b);
    for _ in 0..MOST {
        let (residual, slope) = f(x);
        if (residual > 0.0) == rising {
            b = x;
        } else {
            a = x;
        }
        let guess = x - residual / slope;
        let next = if guess > a && guess < b {
            guess
        } else {
            0.5 * (a + b)
        };
        let step = (next - x).abs();
        x = next;
        if step <= width {
            break;
        }
    }
    x
}
