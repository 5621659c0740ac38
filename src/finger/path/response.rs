//! Linear responses of the finger held by the contact.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::local::Local;
use super::newton::Unknown;
use crate::finger::preshape::dot;
use crate::numeric::solve;

/// Linear responses of the finger held by the contact.
pub(super) struct Response<const N: usize> {
    /// To the torques and gap that are amiss.
    pub(super) amiss: [f32; N],
    /// To a unit of input torque: d delta / dT, d f / dT.
    pub(super) by_torque: [f32; N],
    pub(super) force_amiss: f32,
    pub(super) force_by_torque: f32,
}

impl<const N: usize> Local<N> {
    /// The stiffness made regular by a spring across the contact, which moves no solution and lends joint 1 without a
    /// spring a pivot.
    fn braced(&self) -> [[f32; N]; N] {
        let mut a = self.stiffness;
        for m in 0..N {
            for q in 0..N {
                a[m][q] += self.arms[m] * self.arms[q];
            }
        }
        a
    }

    /// Newton's step at a given torque, and the tangent along the path.
    pub(super) fn response(&self) -> Option<Response<N>> {
        let [u, w, y] = solve(self.braced(), [self.torques, self.arms, self.gear.x])?;
        let held = dot(&self.arms, &w);
        let force = (dot(&self.arms, &u) - self.gap) / held;
        let force_by_torque = dot(&self.arms, &y) / held;
        let (mut amiss, mut by_torque) = (u, y);
        for m in 0..N {
            amiss[m] -= w[m] * force;
            by_torque[m] -= w[m] * force_by_torque;
        }
        let all = amiss
            .iter()
            .chain(&by_torque)
            .chain([&force, &force_by_torque]);
        all.into_iter().all(|x| x.is_finite()).then_some(Response {
            amiss,
            by_torque,
            force_amiss: force + self.gap,
            force_by_torque,
        })
    }

    /// y^T H y for the tangent y: the compliance. Unlike x^T y it keeps its digits near e_2, where y vanishes.
    pub(super) fn compliance(&self, tangent: &[f32; N]) -> f32 {
        self.stiffness
            .iter()
            .zip(tangent)
            .map(|(row, y)| y * dot(row, tangent))
            .sum()
    }

    /// Newton's step with the place of the contact unknown and the rotation of the input link `missing` given.
    pub(super) fn place_response(&self, force: f32, missing: f32) -> Option<Unknown<N>> {
        let [u, w, z] = solve(self.braced(), [self.torques, self.arms, self.arms_by_k])?;
        let z = z.map(|z| z * force);
        let (p, x) = (&self.arms, &self.gear.x);
        let rows = [
            [dot(p, &w), dot(p, &z) - self.gap_by_k],
            [dot(x, &w), dot(x, &z)],
        ];
        let [[more, k]] = solve(rows, [[dot(p, &u) - self.gap, dot(x, &u) - missing]])?;
        let mut delta = u;
        for m in 0..N {
            delta[m] -= w[m] * more + z[m] * k;
        }
        Some(Unknown {
            delta,
            force: more + self.gap - self.gap_by_k * k,
            k,
        })
    }
}
