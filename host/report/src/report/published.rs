//! The published baseline with Brent's method of the crate `roots`, which needs the standard library and cannot run on the
//! chip. Judged on the same rows as the others; it has no cost there.

use palpate_bench::candidate::{Candidate, Roots};
use palpate_bench::published::{MOST, Method, three, two};
use palpate_bench::three::ThreePhalanges;
use palpate_bench::two::TwoPhalanges;
use roots::{SimpleConvergency, find_root_brent};

/// Two phalanges.
pub const TWO: &[Candidate<TwoPhalanges, Roots>] = &[
    Candidate::rival("nalgebra_roots_f32", |input| two::<InF32>(input, f32::cos)),
    Candidate::rival("nalgebra_roots_f64", |input| {
        two::<InF64>(input, |rad| f64::from(rad).cos())
    }),
];

/// Three phalanges.
pub const THREE: &[Candidate<ThreePhalanges, Roots>] = &[
    Candidate::rival("nalgebra_roots_f32", |input| {
        three::<InF32>(input, f32::cos)
    }),
    Candidate::rival("nalgebra_roots_f64", |input| {
        three::<InF64>(input, |rad| f64::from(rad).cos())
    }),
];

macro_rules! method {
    ($name:ident, $real:ident) => {
        struct $name;

        impl Method for $name {
            type Real = $real;

            fn search(f: impl Fn($real) -> $real, [lo, hi]: [$real; 2]) -> Option<$real> {
                let mut convergency = SimpleConvergency {
                    eps: $real::EPSILON,
                    max_iter: MOST,
                };
                find_root_brent(lo, hi, f, &mut convergency).ok()
            }
        }
    };
}

method!(InF32, f32);
method!(InF64, f64);
