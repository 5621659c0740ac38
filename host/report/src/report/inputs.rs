//! The inputs of the functions that are judged over sweeps, spread evenly without a random number.

use palpate_bench::function::{Angle, Equations};

/// Points of a sweep.
pub const SWEEP: u32 = 100_000;

/// Evenly spread in (0, 1).
pub fn spread(at: u32, step: f64) -> f64 {
    (f64::from(at) + 0.5) * step % 1.0
}

pub const GOLDEN: f64 = 0.618_033_988_749_895;
pub const PLASTIC: f64 = 0.754_877_666_246_693;

/// 40 octaves.
pub fn number(at: u32) -> f32 {
    (40.0 * spread(at, GOLDEN) - 20.0).exp2() as f32
}

/// Within a turn, the last sample at most 0.02 rad away.
pub fn angle(at: u32) -> Angle {
    let rad = (std::f64::consts::TAU * (spread(at, GOLDEN) - 0.5)) as f32;
    let step = (0.04 * (spread(at, PLASTIC) - 0.5)) as f32;
    let last = f64::from(rad) - f64::from(step);
    Angle {
        rad,
        last_cos: last.cos() as f32,
        last_sin: last.sin() as f32,
        step_rad: step,
    }
}

/// All round, over 10 octaves.
pub fn point(at: u32) -> [f32; 2] {
    let angle = std::f64::consts::TAU * (spread(at, GOLDEN) - 0.5);
    let length = (10.0 * spread(at, PLASTIC) - 5.0).exp2();
    [(length * angle.sin()) as f32, (length * angle.cos()) as f32]
}

/// As the build script makes those that the chip times: M M^T plus a share of the unit matrix.
pub fn equations(at: u32) -> Equations {
    let (u, v) = (spread(at, GOLDEN), spread(at, PLASTIC));
    let m: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| ((3 * i + j) as f64 * 0.7 + 7.0 * u + 11.0 * v).sin())
    });
    let product = |i: usize, j: usize| (0..3).map(|k| m[i][k] * m[j][k]).sum::<f64>();
    Equations {
        a: std::array::from_fn(|i| {
            std::array::from_fn(|j| (product(i, j) + if i == j { 0.1 + v } else { 0.0 }) as f32)
        }),
        b: [(2.0 * u - 1.0) as f32, (2.0 * v - 1.0) as f32, 1.0],
    }
}

/// Largest error of a solution, as a share of the largest unknown; the truth in f64.
pub fn unsolved(of: &Equations, found: [f32; 3]) -> f64 {
    let a = nalgebra::Matrix3::from(of.a.map(|row| row.map(f64::from))).transpose();
    let b = nalgebra::Vector3::from(of.b.map(f64::from));
    let Some(truth) = a.full_piv_lu().solve(&b) else {
        return f64::NAN;
    };
    let found = nalgebra::Vector3::from(found.map(f64::from));
    (found - truth).amax() / truth.amax()
}
