//! A contact anywhere on a finger of any number of phalanges (docs/FINGERS.md#longer-fingers).
//!
//! Joint 1 is the only one that may lack a spring, and no other couples to it (the first row of W is zero). The others'
//! stiffness H' has a root R, H' = R R^T, taken from the tip inwards, so that joints beyond the contact are eliminated on
//! the way. In the metric of its inverse the compliance is a quotient of two sums of squares, each a quadratic in k.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::inverse::PostureStiffness;
use super::quadratic::{Quadratic, QuadraticContact};
use super::statics::contact_arms;
use crate::numeric::{dot, sqrt};
use core::array::from_fn;

/// R of H' = R R^T over joints 2 to N: upper triangular, its first row and column unused. With `FIRST` 0 over all joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct StiffnessRoot<const N: usize, const FIRST: usize = 1> {
    r: [[f32; N]; N],
}

impl<const N: usize, const FIRST: usize> StiffnessRoot<N, FIRST> {
    /// The root; `None` where H' is not positive definite: the springs do not hold the finger.
    pub(super) fn of(h: &[[f32; N]; N]) -> Option<Self> {
        let mut r = [[0.0f32; N]; N];
        for j in (FIRST..N).rev() {
            for i in (FIRST..=j).rev() {
                let mut rest = h[i][j];
                for l in j + 1..N {
                    rest -= r[i][l] * r[j][l];
                }
                r[i][j] = if i < j {
                    rest / r[j][j]
                } else if rest > 0.0 {
                    sqrt(rest)
                } else {
                    return None;
                };
            }
        }
        Some(Self { r })
    }

    /// R^-1 v over the joints of the root; the entries of others are 0.
    pub(super) fn whitened(&self, v: [f32; N]) -> [f32; N] {
        let mut y = [0.0f32; N];
        for j in (FIRST..N).rev() {
            let mut rest = v[j];
            for l in j + 1..N {
                rest -= self.r[j][l] * y[l];
            }
            y[j] = rest / self.r[j][j];
        }
        y
    }

    /// x'^T H'^-1 x': the compliance of the joints beyond the first while that one stands still.
    pub(super) fn compliance(&self, x: [f32; N]) -> f32 {
        let w = self.whitened(x);
        dot(&w, &w)
    }
}

/// The stiffness problem of a contact on one phalanx, the joints beyond it eliminated.
#[derive(Clone, Copy, Debug)]
pub struct ChainContact<const N: usize> {
    k1: f32,
    /// Moment arm about joint 1 at k = 0.
    d1: f32,
    /// R^-1 p' at k = 0, and by what it changes with k.
    arms: [[f32; N]; 2],
    /// R^-1 x' over the joints up to the contact.
    row: [f32; N],
    /// R^-1 (p_1 x' - p') at k = 0, and by what it changes with k.
    motion: [[f32; N]; 2],
    /// What the joints beyond the contact give way.
    beyond: f32,
}

impl<const N: usize> ChainContact<N> {
    /// The contact on a phalanx, 2 for the second.
    pub(super) fn on(
        held: &PostureStiffness<N>,
        root: &StiffnessRoot<N>,
        phalanx: u8,
    ) -> Option<Self> {
        let tip = usize::from(phalanx).checked_sub(1)?;
        if tip == 0 || tip >= N {
            return None;
        }
        let d = contact_arms(&held.lengths, &held.turn, tip, 0.0);
        let loaded = from_fn(|m| if m <= tip { 1.0 } else { 0.0 });
        let (d1, x) = (d[0], held.x);
        let mut motion = [[0.0f32; N]; 2];
        for m in 1..N {
            // Grouped so that k multiplies a difference of transmission factors.
            motion[0][m] = d1 * x[m] - d[m];
            motion[1][m] = x[m] - loaded[m];
        }
        let mut row = root.whitened(x);
        let mut motion = motion.map(|v| root.whitened(v));
        let mut beyond = 0.0;
        for m in tip + 1..N {
            beyond += row[m] * row[m];
            row[m] = 0.0;
            motion[0][m] = 0.0;
            motion[1][m] = 0.0;
        }
        Some(Self {
            k1: held.h[0][0],
            d1,
            arms: [root.whitened(d), root.whitened(loaded)],
            row,
            motion,
            beyond,
        })
    }

    /// What the joints beyond the contact add to the compliance.
    pub(super) fn beyond(&self) -> f32 {
        self.beyond
    }

    /// Of a pair a + k b: at some k.
    fn at(pair: &[[f32; N]; 2], k: f32) -> [f32; N] {
        let mut sum = pair[0];
        for m in 0..N {
            sum[m] += k * pair[1][m];
        }
        sum
    }

    /// (u x row) . (v x row), over all pairs of joints: the part of the arms that the transmission does not share.
    fn crossed(&self, u: &[f32; N], v: &[f32; N]) -> f32 {
        let w = &self.row;
        let mut sum = 0.0;
        for i in 1..N {
            for j in i + 1..N {
                sum += (u[i] * w[j] - u[j] * w[i]) * (v[i] * w[j] - v[j] * w[i]);
            }
        }
        sum
    }
}

impl<const N: usize> QuadraticContact for ChainContact<N> {
    /// |p_1 x' - p'|^2 + K_1 (|p'|^2 |x'|^2 - (p' . x')^2), in the metric of H'^-1.
    fn softness(&self, k: f32) -> f32 {
        let (motion, arms) = (Self::at(&self.motion, k), Self::at(&self.arms, k));
        dot(&motion, &motion) + self.k1 * self.crossed(&arms, &arms)
    }

    /// p_1^2 + K_1 |p'|^2.
    fn energy(&self, k: f32) -> f32 {
        let (p1, arms) = (self.d1 + k, Self::at(&self.arms, k));
        p1 * p1 + self.k1 * dot(&arms, &arms)
    }

    /// p_1 + K_1 p' . x'.
    fn pressing(&self) -> [f32; 2] {
        let [at_joint, along] = self.arms.map(|arms| self.k1 * dot(&arms, &self.row));
        [self.d1 + at_joint, 1.0 + along]
    }

    fn slope(&self) -> (f32, f32) {
        let ([d, one], w) = (&self.arms, &self.row);
        let mut away = *d;
        for m in 0..N {
            away[m] -= self.d1 * one[m];
        }
        let mut l0 = -dot(&away, &self.motion[0]);
        let mut l1 = -dot(&away, &self.motion[1]);
        l0 += self.k1 * (dot(one, w) * dot(d, d) - dot(d, w) * dot(d, one));
        l1 += self.k1 * (dot(one, w) * dot(d, one) - dot(d, w) * dot(one, one));
        (l0, l1)
    }

    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let (v0, v1) = (Self::at(&self.motion, about), &self.motion[1]);
        let (u0, u1) = (Self::at(&self.arms, about), &self.arms[1]);
        let (k1, p1) = (self.k1, self.d1 + about);
        [
            dot(&v0, &v0) + k1 * self.crossed(&u0, &u0)
                - compliance * (p1 * p1 + k1 * dot(&u0, &u0)),
            dot(&v0, v1) + k1 * self.crossed(&u0, u1) - compliance * (p1 + k1 * dot(&u0, u1)),
            dot(v1, v1) + k1 * self.crossed(u1, u1) - compliance * (1.0 + k1 * dot(u1, u1)),
        ]
    }
}
