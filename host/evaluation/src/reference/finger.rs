//! Where the links are, and what the springs hold.

use nalgebra::{DMatrix, DVector};

/// How one stage of the transmission maps its joint angle to the lever before it (docs/MECHANICS.md#transmission).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// Pulleys: constant ratio.
    Tendon {
        /// Radius at this joint over the radius at the joint before.
        ratio: f64,
    },
    /// A four-bar on the link before it.
    Linkage {
        /// Driving lever a at the joint before.
        drive: f64,
        /// Coupler b.
        coupler: f64,
        /// Driven lever c at this joint.
        driven: f64,
        /// Angle psi of the driven lever, dorsal positive, radian.
        offset_rad: f64,
        /// Which of the two closures, +1 or -1.
        mode: f64,
    },
}

impl Stage {
    /// Angle of the lever before, from the rest of the joint, on a ground link of this length; NaN where the
    /// four-bar does not close.
    pub(super) fn lever(self, joint_rad: f64, ground: f64) -> f64 {
        match self {
            Self::Tendon { ratio } => ratio * joint_rad,
            Self::Linkage {
                drive,
                coupler,
                driven,
                offset_rad,
                mode,
            } => {
                let angle = |joint: f64| {
                    let delta = joint - offset_rad;
                    let (x, y) = (ground + driven * delta.cos(), driven * delta.sin());
                    let span = x.hypot(y);
                    y.atan2(x)
                        + mode
                            * ((span * span + drive * drive - coupler * coupler)
                                / (2.0 * drive * span))
                                .acos()
                };
                angle(joint_rad) - angle(0.0)
            }
        }
    }
}

/// A finger of two or three phalanges in any consistent unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Phalanx lengths, proximal first.
    pub lengths: Vec<f64>,
    /// Joint spring stiffness, torque per radian.
    pub springs: Vec<f64>,
    /// Joint angles at rest, radian.
    pub rest_rad: Vec<f64>,
    /// One stage for every joint after the first.
    pub stages: Vec<Stage>,
}

/// Step of the central differences, radian: fourth-order formulas, so truncation and cancellation are both below 1e-9.
const STEP: f64 = 2e-3;

impl Finger {
    /// Number of phalanges.
    #[must_use]
    pub fn phalanges(&self) -> usize {
        self.lengths.len()
    }

    /// Angle of the input link for these joint angles, radian.
    #[must_use]
    pub fn theta_a(&self, theta: &DVector<f64>) -> f64 {
        let mut carried = 0.0;
        for (index, stage) in self.stages.iter().enumerate().rev() {
            carried = stage.lever(theta[index + 1] + carried, self.lengths[index]);
        }
        theta[0] + carried
    }

    /// Energy of the springs.
    #[must_use]
    pub fn energy(&self, theta: &DVector<f64>) -> f64 {
        theta
            .iter()
            .zip(&self.rest_rad)
            .zip(&self.springs)
            .map(|((angle, rest), spring)| 0.5 * spring * (angle - rest).powi(2))
            .sum()
    }

    /// The point at distance `k` from the joint of phalanx `phalanx` (1 is the proximal), in the plane.
    #[must_use]
    pub fn point(&self, theta: &DVector<f64>, phalanx: usize, k: f64) -> (f64, f64) {
        let mut absolute = 0.0;
        let mut at = (0.0, 0.0);
        for (index, &length) in self.lengths.iter().enumerate().take(phalanx) {
            absolute += theta[index];
            let reach = if index + 1 == phalanx { k } else { length };
            at.0 += reach * absolute.cos();
            at.1 += reach * absolute.sin();
        }
        at
    }

    /// Distance of a fixed point from the line of phalanx `phalanx`, positive on the closing side.
    #[must_use]
    pub fn distance(&self, theta: &DVector<f64>, phalanx: usize, point: (f64, f64)) -> f64 {
        let joint = self.point(theta, phalanx, 0.0);
        let absolute: f64 = theta.iter().take(phalanx).sum();
        (point.1 - joint.1) * absolute.cos() - (point.0 - joint.0) * absolute.sin()
    }

    /// Distance of a point from the nearest of a phalanx's middle line.
    pub(super) fn apart_m(&self, theta: &DVector<f64>, phalanx: usize, (x, y): (f64, f64)) -> f64 {
        let length = self.lengths[phalanx - 1];
        let [joint, end] = [0.0, length].map(|k| self.point(theta, phalanx, k));
        let along =
            ((x - joint.0) * (end.0 - joint.0) + (y - joint.1) * (end.1 - joint.1)) / length;
        let nearest = self.point(theta, phalanx, along.clamp(0.0, length));
        (x - nearest.0).hypot(y - nearest.1)
    }
}

/// Gradient by fourth-order central differences.
pub(super) fn gradient(at: &DVector<f64>, f: impl Fn(&DVector<f64>) -> f64) -> DVector<f64> {
    DVector::from_fn(at.len(), |index, _| {
        let along = |steps: f64| {
            let mut moved = at.clone();
            moved[index] += steps * STEP;
            f(&moved)
        };
        (8.0 * (along(1.0) - along(-1.0)) - (along(2.0) - along(-2.0))) / (12.0 * STEP)
    })
}

/// Hessian by central differences of second order along the diagonals, extrapolated to fourth.
pub(super) fn hessian(at: &DVector<f64>, f: impl Fn(&DVector<f64>) -> f64) -> DMatrix<f64> {
    let second = |row: usize, column: usize, step: f64| {
        let along = |a: f64, b: f64| {
            let mut moved = at.clone();
            moved[row] += a * step;
            moved[column] += b * step;
            f(&moved)
        };
        (along(1.0, 1.0) - along(1.0, -1.0) - along(-1.0, 1.0) + along(-1.0, -1.0))
            / (4.0 * step * step)
    };
    DMatrix::from_fn(at.len(), at.len(), |row, column| {
        (4.0 * second(row, column, STEP) - second(row, column, 2.0 * STEP)) / 3.0
    })
}

#[cfg(test)]
mod tests {
    use super::super::table_1;
    use super::*;

    #[test]
    fn a_point_is_as_far_from_a_phalanx_as_from_the_nearest_of_its_slices() {
        const SLICES: usize = 2000;
        let finger = table_1();
        let theta = DVector::from_row_slice(&[0.6, 0.4, 0.9]);
        // Beside a phalanx, before its joint and beyond its tip.
        for point in [(0.4, 0.9), (-0.5, -0.3), (0.9, 2.5), (1.5, 0.2)] {
            for phalanx in 1..=3 {
                let length = finger.lengths[phalanx - 1];
                let slices = (0..=SLICES).map(|n| length * n as f64 / SLICES as f64);
                let nearest = slices
                    .map(|k| finger.point(&theta, phalanx, k))
                    .map(|(x, y)| (x - point.0).hypot(y - point.1))
                    .fold(f64::INFINITY, f64::min);
                let error = nearest - finger.apart_m(&theta, phalanx, point);
                assert!(
                    (0.0..1e-3).contains(&error),
                    "{phalanx} {point:?}: {error:e}"
                );
            }
        }
    }
}
