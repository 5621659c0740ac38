//! A cylinder between two fingers: its centre and radius from what each of them tells of its own contact.
//!
//! A finger's posture says where the phalanx is, its event where along it the cylinder lies: two equations a finger, linear in
//! centre and radius. Two fingers give four for three unknowns.

use crate::Outcome;
use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::Event;

/// How well a posture at contact is known, radian (chosen): the onset to 10 mrad, the backlash to its own 7 mrad, homing and the
/// errors of gears to 5 mrad.
const POSTURE_SIGMA_RAD: f64 = 13e-3;

/// `by` . (x, y, radius) = `is`, with a standard deviation; metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation {
    /// Coefficients of centre and radius.
    pub by: [f64; 3],
    /// Right side.
    pub is: f64,
    /// Its standard deviation.
    pub sigma: f64,
}

impl Equation {
    /// The same for a finger that is the mirror image of the first, across a line parallel to x at half of `apart_m`.
    #[must_use]
    pub fn mirrored(self, apart_m: f64) -> Self {
        let [x, y, r] = self.by;
        Self {
            by: [x, -y, r],
            is: self.is - y * apart_m,
            ..self
        }
    }
}

/// What a finger of scene `S` felt of a cylinder, in its own frame; `None` where it felt no place.
#[must_use]
pub fn felt<S: Scene>(outcome: &Outcome) -> Option<[Equation; 2]> {
    let finger = S::MECHANISM;
    let half_m = f64::from(S::settings().half_thickness_m);
    let theta_a_rad = outcome.events.iter().find_map(|(_, event)| match event {
        Event::Touch { theta_a_rad, .. } => Some(*theta_a_rad),
        _ => None,
    })?;
    let (phalanx, k_m, sigma_m) = outcome.events.iter().rev().find_map(|(_, e)| match *e {
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            ..
        } => Some((phalanx, f64::from(k_m), f64::from(sigma_m))),
        _ => None,
    })?;
    let free = finger.free_at_angle(theta_a_rad, &finger.rest())?;
    let (mut joint, mut angle, mut reach_m) = ([0.0, 0.0], 0.0, k_m);
    for j in 1..=phalanx {
        angle += f64::from(finger.joint_rad(&free.configuration, j)?);
        if j < phalanx {
            let length = f64::from(finger.phalanx_length_m(j)?);
            joint = [
                joint[0] + length * angle.cos(),
                joint[1] + length * angle.sin(),
            ];
            reach_m += length;
        }
    }
    let (sin, cos) = angle.sin_cos();
    // The centre lies at k along the phalanx, and a radius and half the phalanx's thickness before it.
    Some([
        Equation {
            by: [cos, sin, 0.0],
            is: joint[0] * cos + joint[1] * sin + k_m,
            sigma: sigma_m,
        },
        Equation {
            by: [-sin, cos, -1.0],
            is: -joint[0] * sin + joint[1] * cos + half_m,
            sigma: POSTURE_SIGMA_RAD * reach_m,
        },
    ])
}

/// Centre and radius with their standard deviations, metre, by weighted least squares; `None` for fewer than three equations, or
/// where they leave something open.
///
/// What is assumed wrongly of a contact, its friction above all, is wrong in both fingers alike and does not average out: the
/// deviation is the larger of that case and of independent errors.
#[must_use]
pub fn cylinder(equations: &[Equation]) -> Option<([f64; 3], [f64; 3])> {
    let (mut n, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for Equation { by, is, sigma } in equations {
        let weight = 1.0 / (sigma * sigma);
        for i in 0..3 {
            for j in 0..3 {
                n[i][j] += weight * by[i] * by[j];
            }
            right[i] += weight * by[i] * is;
        }
    }
    let minor = |i: usize, j: usize| {
        let ([i1, i2], [j1, j2]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        n[i1][j1] * n[i2][j2] - n[i1][j2] * n[i2][j1]
    };
    let determinant: f64 = (0..3).map(|j| n[0][j] * minor(0, j)).sum();
    let inverse = |i: usize, j: usize| minor(j, i) / determinant;
    let found = std::array::from_fn(|i| (0..3).map(|j| inverse(i, j) * right[j]).sum());
    let sigma: [f64; 3] = std::array::from_fn(|i| {
        // Errors of the places, and of the postures: each kind alike in all fingers, or all errors by themselves.
        let (mut alike, mut apart) = ([0.0; 2], 0.0);
        for Equation { by, sigma, .. } in equations {
            let share = (0..3).map(|j| inverse(i, j) * by[j]).sum::<f64>() / sigma;
            let is_posture = by[2] != 0.0;
            alike[usize::from(is_posture)] += share;
            apart += share * share;
        }
        alike
            .iter()
            .map(|sum| sum * sum)
            .sum::<f64>()
            .max(apart)
            .sqrt()
    });
    let is_known = equations.len() >= 3 && sigma.iter().all(|s| s.is_finite());
    is_known.then_some((found, sigma))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_equations_give_the_cylinder_and_too_few_give_nothing() {
        let truth = [0.1, 0.09, 0.02];
        let equation = |by: [f64; 3]| Equation {
            by,
            is: (0..3).map(|i| by[i] * truth[i]).sum(),
            sigma: 1e-3,
        };
        let rows = [
            [0.6, 0.8, 0.0],
            [-0.8, 0.6, -1.0],
            [0.6, -0.8, 0.0],
            [-0.8, -0.6, -1.0],
        ];
        let all = rows.map(equation);
        let (found, sigma) = cylinder(&all).expect("determined");
        for i in 0..3 {
            assert!((found[i] - truth[i]).abs() < 1e-12, "{found:?}");
            assert!(sigma[i] > 0.5e-3 && sigma[i] < 5e-3, "{sigma:?}");
        }
        assert_eq!(cylinder(&all[..2]), None);
        // A mirrored mirror image is the equation itself.
        let [first, ..] = all;
        let back = first.mirrored(0.18).mirrored(0.18);
        assert!((back.is - first.is).abs() < 1e-12 && back.by == first.by);
    }
}
