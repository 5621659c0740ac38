//! Table look-up. Phalanx 2 is a pair of joints: its table. Phalanx 3 has seven parameters, too many for a table; but N - C D
//! = c + b k + a k^2 has the root nearer to the joint at -c/b g(q) with one parameter, q = a c / b^2:
//! g = 2 / (1 + sqrt(1 - 4 q)), and the other at c / (a k). Linear between the points of g.

use super::ThreePhalanges;
use super::algebra::Distal;
use crate::candidate::{NOWHERE, Roots};
use crate::two::lookup::{cell, pair, root};

const POINTS: usize = 257;
/// Least q of the table; the greatest is that of a double root, 1/4. Beyond them there is no answer.
const LEAST: f32 = -2.0;
const WIDTH: f32 = 0.25 - LEAST;

static TABLE: [f32; POINTS] = build();

const fn build() -> [f32; POINTS] {
    let mut table = [0.0; POINTS];
    let mut i = 0;
    while i < POINTS {
        let q = LEAST + WIDTH * i as f32 / (POINTS - 1) as f32;
        table[i] = 2.0 / (1.0 + root(1.0 - 4.0 * q));
        i += 1;
    }
    table
}

/// Both roots from the tables.
#[inline(never)]
pub fn table(input: &ThreePhalanges) -> Roots {
    if input.phalanx == 2 {
        return input.effective().map_or(NOWHERE, |two| pair(&two));
    }
    let distal = Distal::of(input);
    let [c, b, a] = distal.residual(input.compliance);
    match cell(a * c / (b * b) - LEAST, WIDTH, POINTS) {
        Some((at, share)) => {
            let near = -c / b * (TABLE[at] + share * (TABLE[at + 1] - TABLE[at]));
            [near, c / (a * near)].map(|k| distal.physical(k, input.l[2]))
        }
        None => NOWHERE,
    }
}
