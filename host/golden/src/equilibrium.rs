//! Equilibria of the finger, and how they move with the torque.

use crate::finger::{Finger, gradient, hessian};
use crate::linear::{Matrix, Vector, border, dot, solve};
use crate::real::Real;

/// Newton steps at most.
const NEWTON_STEPS: usize = 60;
/// Size of the last Newton step, as a power of two; the derivatives' own error is near.
const CLOSE: i32 = -105;
/// The same on the way: near enough to start the next part.
const NEAR: i32 = -20;
/// A Newton step turns no joint by more than this, radian: it stays on the branch where it began.
const STRIDE: f64 = 0.2;
/// Parts of a torque, of the free finger and after contact: each starts from the end of the last, along the same path.
const FREE_PARTS: i32 = 10;
const PARTS: i32 = 4;

/// A contact: the phalanx, from 0, and the point of the object.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Which phalanx, from 0.
    pub phalanx: usize,
    /// Where the object is.
    pub point: (Real, Real),
}

/// A posture in equilibrium and the contact's force.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Joint angles.
    pub theta: Vector,
    /// Force of the contact, zero without one.
    pub force: Real,
}

/// Stationary point of the potential, on the contact where there is one. `None` where Newton's method fails.
fn stationary(
    finger: &Finger,
    torque: &Real,
    contact: Option<&Contact>,
    from: &Equilibrium,
    close: i32,
) -> Option<Equilibrium> {
    let Equilibrium {
        mut theta,
        mut force,
    } = from.clone();
    let joints = finger.joints();
    let potential = |theta: &[Real]| finger.potential(torque, theta);
    for _ in 0..NEWTON_STEPS {
        let mut residual = gradient(&theta, potential);
        let mut matrix = hessian(&theta, potential);
        if let Some(contact) = contact {
            let gap = |theta: &[Real]| finger.seen_from(theta, contact.phalanx, &contact.point).1;
            let normal = gradient(&theta, gap);
            let curvature = hessian(&theta, gap);
            for row in 0..joints {
                residual[row] = &residual[row] - &force * &normal[row];
                for column in 0..joints {
                    matrix[row][column] = &matrix[row][column] - &force * &curvature[row][column];
                }
            }
            residual.push(-gap(&theta));
            let against: Vector = normal.into_iter().map(|value| -value).collect();
            matrix = border(&matrix, &against);
        }
        // A joint without a spring does not know where to go without a contact: it stays.
        if contact.is_none() && finger.springs[0].is_zero() {
            for index in 0..joints {
                matrix[0][index] = Real::zero();
                matrix[index][0] = Real::zero();
            }
            matrix[0][0] = Real::one();
            residual[0] = Real::zero();
        }
        let (mut step, _) = solve(matrix, residual)?;
        let largest = step[..joints]
            .iter()
            .map(Real::abs)
            .fold(Real::zero(), |a, b| if b > a { b } else { a });
        if largest.is_nan() {
            return None;
        }
        let done = largest < Real::power_of_two(close);
        let stride = Real::from(STRIDE);
        if largest > stride {
            let shortened = stride / largest;
            for value in &mut step {
                *value = &*value * &shortened;
            }
        }
        for (angle, change) in theta.iter_mut().zip(&step) {
            *angle = &*angle - change;
        }
        if contact.is_some() {
            force = force - &step[joints];
        }
        if done {
            return Some(Equilibrium { theta, force });
        }
    }
    None
}

/// How close each of so many parts is solved.
fn closeness(part: i32, parts: i32) -> i32 {
    if part == parts { CLOSE } else { NEAR }
}

/// Posture of the free finger, on the path that it takes from `rest` as the torque rises.
#[must_use]
pub fn free(finger: &Finger, torque: &Real, rest: &[Real]) -> Option<Vector> {
    let mut at = Equilibrium {
        theta: rest.to_vec(),
        force: Real::zero(),
    };
    let parts = if torque.is_zero() { 1 } else { FREE_PARTS };
    for part in 1..=parts {
        let share = torque * Real::from(f64::from(part)) / Real::from(f64::from(parts));
        at = stationary(finger, &share, None, &at, closeness(part, parts))?;
    }
    Some(at.theta)
}

/// Posture after the torque has risen by `rise` since contact at `theta`.
#[must_use]
pub fn pressed(
    finger: &Finger,
    torque: &Real,
    rise: &Real,
    contact: &Contact,
    theta: &[Real],
) -> Option<Equilibrium> {
    let mut at = Equilibrium {
        theta: theta.to_vec(),
        force: Real::zero(),
    };
    for part in 1..=PARTS {
        let share = Real::from(f64::from(part) / f64::from(PARTS));
        at = stationary(
            finger,
            &(torque + rise * share),
            Some(contact),
            &at,
            closeness(part, PARTS),
        )?;
    }
    Some(at)
}

/// The finger at the instant of contact, to first order.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Transmission row.
    pub row: Vector,
    /// Hessian of the potential.
    pub stiffness: Matrix,
}

/// How a contact moves with the torque.
#[derive(Clone, Debug)]
pub struct Response {
    /// d theta_a / d T_a.
    pub compliance: Real,
    /// d theta / d T_a.
    pub motion: Vector,
    /// d f / d T_a: negative where the phalanx moves away from the object.
    pub press: Real,
    /// Determinant of the bordered stiffness.
    pub determinant: Real,
}

impl Linear {
    /// At a posture under a torque.
    #[must_use]
    pub fn at(finger: &Finger, torque: &Real, theta: &[Real]) -> Self {
        Self {
            row: gradient(theta, |theta| finger.theta_a(theta)),
            stiffness: hessian(theta, |theta| finger.potential(torque, theta)),
        }
    }

    /// Compliance without contact.
    #[must_use]
    pub fn free_compliance(&self) -> Option<Real> {
        let (motion, _) = solve(self.stiffness.clone(), self.row.clone())?;
        Some(dot(&self.row, &motion))
    }

    /// With the contact's moment arms.
    #[must_use]
    pub fn held(&self, arms: &[Real]) -> Option<Response> {
        let mut right = self.row.clone();
        right.push(Real::zero());
        let (mut motion, determinant) = solve(border(&self.stiffness, arms), right)?;
        let press = motion.pop()?;
        Some(Response {
            compliance: dot(&self.row, &motion),
            motion,
            press,
            determinant,
        })
    }
}

/// Moment arms of a contact: how fast its point of the phalanx closes in on the object, for each joint.
#[must_use]
pub fn arms(finger: &Finger, theta: &[Real], phalanx: usize, k: &Real) -> Vector {
    let point = finger.point(theta, phalanx, k);
    let gaps = gradient(theta, |theta| finger.seen_from(theta, phalanx, &point).1);
    gaps.into_iter().map(|gap| -gap).collect()
}
