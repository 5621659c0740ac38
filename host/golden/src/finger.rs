//! What a finger is: where its joints and points are, what its springs hold, and how far the input link has turned.

use crate::linear::{Matrix, Vector};
use crate::real::Real;

/// Step of the numerical derivatives, as a power of two: their own error is its square, some 36 digits down.
const STEP: i32 = -60;

/// A four-bar: ground, driving lever, coupler, driven lever, the latter's offset, and the assembly.
#[derive(Clone, Debug)]
pub struct FourBar {
    /// Length of the ground link, from O_(i-1) to O_i.
    pub ground: Real,
    /// Driving lever, at O_(i-1).
    pub drive: Real,
    /// Coupler.
    pub coupler: Real,
    /// Driven lever, at O_i.
    pub driven: Real,
    /// Angle of the driven lever before the phalanx.
    pub offset: Real,
    /// On which side of the diagonal the driving lever lies: 1 or -1.
    pub mode: Real,
}

impl FourBar {
    /// Four bars on a ground link; the columns' names are those of the files.
    pub fn of(ground: Real, column: impl Fn(&str) -> Real) -> Self {
        let [drive, coupler, driven, offset, mode] = ["a", "b", "c", "psi", "mode"].map(column);
        Self {
            ground,
            drive,
            coupler,
            driven,
            offset,
            mode,
        }
    }

    /// End of the driven lever, with the joint turned by `v`.
    fn driven_end(&self, v: &Real) -> (Real, Real) {
        let (sine, cosine) = (v - &self.offset).sin_cos();
        (&self.ground + &self.driven * cosine, &self.driven * sine)
    }

    /// Angle of the driving lever against the ground link; not a number where the loop does not close.
    #[must_use]
    pub fn lever(&self, v: &Real) -> Real {
        let (x, y) = self.driven_end(v);
        let square = &x * &x + &y * &y;
        let two = Real::from(2.0);
        let cosine = (&square + &self.drive * &self.drive - &self.coupler * &self.coupler)
            / (two * &self.drive * square.sqrt());
        Real::atan2(&y, &x) + &self.mode * cosine.acos()
    }

    /// Rotation of the driving lever since `v = 0`.
    #[must_use]
    pub fn rotation(&self, v: &Real) -> Real {
        self.lever(v) - self.lever(&Real::zero())
    }

    /// Signed distance from O_i to where the coupler's line meets the ground line.
    #[must_use]
    pub fn pole(&self, v: &Real) -> Real {
        let (bx, by) = self.driven_end(v);
        let (sine, cosine) = self.lever(v).sin_cos();
        let (ax, ay) = (&self.drive * cosine, &self.drive * sine);
        // The point of the line from A to B at height zero.
        let along = &ay / (&ay - by);
        &ax + along * (bx - &ax) - &self.ground
    }
}

/// One stage of the transmission.
#[derive(Clone, Debug)]
pub enum Stage {
    /// Pulleys: ratio of the driven one to the driving one.
    Tendon(Real),
    /// A four-bar, and its lever's angle at rest.
    Linkage(Box<FourBar>, Real),
}

impl Stage {
    /// A four-bar as a stage.
    #[must_use]
    pub fn linkage(bars: FourBar) -> Self {
        let start = bars.lever(&Real::zero());
        Self::Linkage(Box::new(bars), start)
    }

    fn rotation(&self, v: &Real) -> Real {
        match self {
            Self::Tendon(ratio) => ratio * v,
            Self::Linkage(bars, start) => bars.lever(v) - start,
        }
    }
}

/// A finger of any number of phalanges.
#[derive(Clone, Debug)]
pub struct Finger {
    /// Lengths of the phalanges.
    pub lengths: Vector,
    /// Stiffness of the springs.
    pub springs: Vector,
    /// Joint angles at which the springs are at rest.
    pub rest: Vector,
    /// From the input link to the tip.
    pub stages: Vec<Stage>,
}

impl Finger {
    /// Number of joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.lengths.len()
    }

    /// Angle of the input link.
    #[must_use]
    pub fn theta_a(&self, theta: &[Real]) -> Real {
        let last = self.joints() - 1;
        let driven = self.stages.iter().enumerate().rev().fold(
            Real::zero(),
            |turned, (stage, transmission)| {
                debug_assert!(stage < last);
                transmission.rotation(&(&theta[stage + 1] + turned))
            },
        );
        &theta[0] + driven
    }

    /// What springs and a torque on the input link hold together: stationary where the finger is in equilibrium.
    #[must_use]
    pub fn potential(&self, torque: &Real, theta: &[Real]) -> Real {
        let half = Real::from(0.5);
        let springs = self.springs.iter().zip(&self.rest).zip(theta);
        let energy = springs.fold(Real::zero(), |sum, ((spring, rest), angle)| {
            let turned = angle - rest;
            sum + &half * spring * &turned * &turned
        });
        if torque.is_zero() {
            energy
        } else {
            energy - torque * self.theta_a(theta)
        }
    }

    /// Joint O_i and the direction of phalanx i, from 0: x, y, cosine, sine.
    fn frame(&self, theta: &[Real], phalanx: usize) -> [Real; 4] {
        let (mut x, mut y, mut angle) = (Real::zero(), Real::zero(), Real::zero());
        for (joint, (turned, length)) in theta.iter().zip(&self.lengths).enumerate() {
            angle = angle + turned;
            let (sine, cosine) = angle.sin_cos();
            if joint == phalanx {
                return [x, y, cosine, sine];
            }
            x = x + length * cosine;
            y = y + length * sine;
        }
        unreachable!("the finger has {} phalanges", self.joints())
    }

    /// The point of a phalanx at `k` from its joint.
    #[must_use]
    pub fn point(&self, theta: &[Real], phalanx: usize, k: &Real) -> (Real, Real) {
        let [x, y, cosine, sine] = self.frame(theta, phalanx);
        (x + k * cosine, y + k * sine)
    }

    /// Where a point lies: along the phalanx from its joint, and before its palm side.
    #[must_use]
    pub fn seen_from(&self, theta: &[Real], phalanx: usize, (x, y): &(Real, Real)) -> (Real, Real) {
        let [joint_x, joint_y, cosine, sine] = self.frame(theta, phalanx);
        let (x, y) = (x - joint_x, y - joint_y);
        (&x * &cosine + &y * &sine, y * cosine - x * sine)
    }
}

/// The vector with one entry moved by so many steps.
fn moved(at: &[Real], moves: &[(usize, f64)]) -> Vector {
    let step = Real::power_of_two(STEP);
    let mut moved = at.to_vec();
    for (index, times) in moves {
        moved[*index] = &moved[*index] + Real::from(*times) * &step;
    }
    moved
}

/// Gradient, by central differences.
#[must_use]
pub fn gradient(at: &[Real], function: impl Fn(&[Real]) -> Real) -> Vector {
    let over = Real::power_of_two(-STEP - 1);
    let slope = |joint| {
        (function(&moved(at, &[(joint, 1.0)])) - function(&moved(at, &[(joint, -1.0)]))) * &over
    };
    (0..at.len()).map(slope).collect()
}

/// Hessian, by central differences.
#[must_use]
pub fn hessian(at: &[Real], function: impl Fn(&[Real]) -> Real) -> Matrix {
    let size = at.len();
    let over = Real::power_of_two(-2 * STEP);
    let quarter = Real::from(0.25);
    let two = Real::from(2.0);
    let centre = function(at);
    let mut matrix = vec![vec![Real::zero(); size]; size];
    for i in 0..size {
        let (ahead, behind) = (
            function(&moved(at, &[(i, 1.0)])),
            function(&moved(at, &[(i, -1.0)])),
        );
        matrix[i][i] = (ahead + behind - &two * &centre) * &over;
        for j in 0..i {
            let at_corner = |a: f64, b: f64| function(&moved(at, &[(i, a), (j, b)]));
            let mixed = at_corner(1.0, 1.0) - at_corner(1.0, -1.0) - at_corner(-1.0, 1.0)
                + at_corner(-1.0, -1.0);
            matrix[i][j] = mixed * &over * &quarter;
            matrix[j][i] = matrix[i][j].clone();
        }
    }
    matrix
}

/// First, second and third derivative of a function of one variable.
#[must_use]
pub fn derivatives(at: &Real, function: impl Fn(&Real) -> Real) -> [Real; 3] {
    let step = Real::power_of_two(STEP);
    let [far_back, back, here, ahead, far_ahead] =
        [-2.0, -1.0, 0.0, 1.0, 2.0].map(|times| function(&(at + Real::from(times) * &step)));
    let two = Real::from(2.0);
    let half = Real::from(0.5);
    let over = Real::power_of_two(-STEP);
    let first = (&ahead - &back) * &half * &over;
    let second = (&ahead + &back - &two * here) * &over * &over;
    let third = (far_ahead - far_back - two * (ahead - back)) * half * &over * &over * &over;
    [first, second, third]
}
