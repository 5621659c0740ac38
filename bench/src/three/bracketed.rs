//! Bracketing methods: on phalanx 2 those of two phalanges, on phalanx 3 the polynomial N - C D between the places where
//! the compliance turns.

use super::ThreePhalanges;
use super::algebra::Distal;
use crate::candidate::{NOWHERE, Roots};
use crate::solver;
use crate::two::bracketed::part as pair;
use palpate::numeric::sqrt;

const WIDTH: f32 = 6e-8;

/// Ends of the stretches of phalanx 3 on which the compliance is monotone: where N' D = N D', between 0 and the length.
#[inline(always)]
fn stretches(distal: &Distal, length: f32) -> [f32; 4] {
    let ([n0, n1, n2], [d0, d1, d2]) = (distal.numerator, distal.denominator);
    let (a, half_b, c) = (n2 * d1 - n1 * d2, n2 * d0 - n0 * d2, n1 * d0 - n0 * d1);
    let mut ends = [0.0, length, length, length];
    let discriminant = half_b * half_b - a * c;
    if discriminant > 0.0 {
        let q = -(half_b + sqrt(discriminant).copysign(half_b));
        let (one, other) = (q / a, c / q);
        let (lower, upper) = if one < other {
            (one, other)
        } else {
            (other, one)
        };
        let inside = |k: f32| k > 0.0 && k < length;
        match (inside(lower), inside(upper)) {
            (true, true) => ends = [0.0, lower, upper, length],
            (true, false) => ends[1] = lower,
            (false, true) => ends[1] = upper,
            (false, false) => {}
        }
    }
    ends
}

#[inline(always)]
fn both(input: &ThreePhalanges, find: impl Fn([f32; 3], f32, f32) -> f32) -> Roots {
    let distal = Distal::of(input);
    let residual = distal.residual(input.compliance);
    let ends = stretches(&distal, input.l[2]);
    let mut roots = NOWHERE;
    for [lo, hi] in [[ends[0], ends[1]], [ends[1], ends[2]], [ends[2], ends[3]]] {
        if lo < hi {
            let k = distal.physical(find(residual, lo, hi), input.l[2]);
            if k > 0.0 {
                roots = [roots[1], k];
            }
        }
    }
    roots
}

#[inline(always)]
fn at([c, b, a]: [f32; 3], k: f32) -> f32 {
    c + k * (b + k * a)
}

/// One function for all numbers of steps, as it would be in a firmware.
#[inline(never)]
fn bisect(input: &ThreePhalanges, steps: u32) -> Roots {
    both(input, |residual, lo, hi| {
        solver::bisect(|k| at(residual, k), lo, hi, steps)
    })
}

macro_rules! methods {
    ($($(#[$doc:meta])* $name:ident: |$input:ident| $distal:expr;)*) => {$(
        $(#[$doc])*
        #[inline(never)]
        pub fn $name($input: &ThreePhalanges) -> Roots {
            if $input.phalanx == 2 {
                return $input.effective().map_or(NOWHERE, |two| pair::$name(&two));
            }
            $distal
        }
    )*};
}

methods! {
    /// Bisection, 12 steps a stretch.
    bisection_12: |input| bisect(input, 12);
    /// Bisection, 20 steps a stretch.
    bisection_20: |input| bisect(input, 20);
    /// Bisection, 28 steps a stretch.
    bisection_28: |input| bisect(input, 28);
    /// ITP.
    itp: |input| both(input, |r, lo, hi| {
        solver::itp(|k| at(r, k), lo, hi, WIDTH * input.l[2])
    });
    /// Chandrupatla.
    chandrupatla: |input| both(input, |r, lo, hi| {
        solver::chandrupatla(|k| at(r, k), lo, hi, WIDTH * input.l[2])
    });
    /// Newton inside the bracket.
    newton: |input| both(input, |r, lo, hi| {
        solver::newton(|k| (at(r, k), r[1] + 2.0 * k * r[2]), lo, hi, WIDTH * input.l[2])
    });
}
