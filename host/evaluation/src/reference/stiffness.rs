//! Preshaping, stiffness at contact and the motion after it, as minima of the potential energy.

use nalgebra::{DMatrix, DVector};

use super::finger::{Finger, gradient, hessian};

/// Newton steps at most; the energies are smooth and started close, five are typical.
const NEWTON_STEPS: usize = 60;
/// Residual at which a posture counts as an equilibrium, in units of the problem.
const CONVERGED: f64 = 1e-11;

/// Stationary point of `energy - torque * theta_a`, held on `line` (phalanx and fixed point) where there is one.
///
/// `None` where Newton does not converge: no equilibrium, or the four-bar does not close.
fn equilibrium(
    finger: &Finger,
    torque: f64,
    line: Option<(usize, (f64, f64))>,
    start: &DVector<f64>,
) -> Option<DVector<f64>> {
    let joints = start.len();
    let potential = |theta: &DVector<f64>| finger.energy(theta) - torque * finger.theta_a(theta);
    let mut theta = start.clone();
    let mut reaction = 0.0;
    for _ in 0..NEWTON_STEPS {
        let mut residual = gradient(&theta, potential);
        let mut matrix = hessian(&theta, potential);
        if let Some((phalanx, point)) = line {
            let distance = |at: &DVector<f64>| finger.distance(at, phalanx, point);
            let normal = gradient(&theta, distance);
            residual -= &normal * reaction;
            matrix -= hessian(&theta, distance) * reaction;
            residual = residual.push(distance(&theta));
            matrix = border(matrix, &normal);
        }
        let step = matrix.lu().solve(&residual)?;
        for joint in 0..joints {
            theta[joint] -= step[joint];
        }
        if line.is_some() {
            reaction += step[joints];
        }
        if step.amax() < CONVERGED {
            return Some(theta);
        }
        if !step.iter().all(|value| value.is_finite()) {
            return None;
        }
    }
    None
}

/// `[H n; n^T 0]`.
fn border(hessian: DMatrix<f64>, normal: &DVector<f64>) -> DMatrix<f64> {
    let size = normal.len();
    let mut bordered = hessian.resize(size + 1, size + 1, 0.0);
    for index in 0..size {
        bordered[(index, size)] = normal[index];
        bordered[(size, index)] = normal[index];
    }
    bordered
}

/// Joint angles while free under an input torque (6). With K_1 = 0 the torque is 0 and theta_1 stays at rest.
#[must_use]
pub fn free_posture(finger: &Finger, torque: f64) -> Option<DVector<f64>> {
    let rest = DVector::from_vec(finger.rest_rad.clone());
    if finger.springs.first() == Some(&0.0) {
        return (torque == 0.0).then_some(rest);
    }
    equilibrium(finger, torque, None, &rest)
}

/// Compliance `d theta_a / d T_a` of the finger held at `k` on `phalanx`, in the posture and under the torque of the
/// instant of contact: 1 / K_c of (8).
#[must_use]
pub fn tangent_compliance(
    finger: &Finger,
    posture: &DVector<f64>,
    torque: f64,
    phalanx: usize,
    k: f64,
) -> Option<f64> {
    let point = finger.point(posture, phalanx, k);
    let lever = gradient(posture, |theta| finger.theta_a(theta));
    let stiffness = hessian(posture, |theta| {
        finger.energy(theta) - torque * finger.theta_a(theta)
    });
    let normal = gradient(posture, |theta| finger.distance(theta, phalanx, point));
    let turned = border(stiffness, &normal)
        .lu()
        .solve(&lever.clone().push(0.0))?;
    Some(lever.dot(&turned.rows(0, posture.len())))
}

/// One equilibrium after the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosurePoint {
    /// Torque at the input link.
    pub torque: f64,
    /// Angle of the input link from rest, radian.
    pub theta_a_rad: f64,
}

/// Equilibria with the contact point fixed in space, from the contact torque up to `last_torque` in equal steps.
///
/// Ends early where the finger leaves the reach of its transmission.
#[must_use]
pub fn contact_curve(
    finger: &Finger,
    contact_torque: f64,
    phalanx: usize,
    k: f64,
    last_torque: f64,
    steps: u32,
) -> Vec<ClosurePoint> {
    let Some(posture) = free_posture(finger, contact_torque) else {
        return Vec::new();
    };
    let rest = finger.theta_a(&DVector::from_vec(finger.rest_rad.clone()));
    let point = finger.point(&posture, phalanx, k);
    let mut theta = posture;
    let mut curve = Vec::new();
    for step in 0..=steps {
        let share = f64::from(step) / f64::from(steps.max(1));
        let torque = contact_torque + share * (last_torque - contact_torque);
        let Some(next) = equilibrium(finger, torque, Some((phalanx, point)), &theta) else {
            break;
        };
        theta = next;
        curve.push(ClosurePoint {
            torque,
            theta_a_rad: finger.theta_a(&theta) - rest,
        });
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::super::{p70, table_1, table_1_two_phalanges};
    use super::*;

    #[test]
    fn table_1_is_as_stiff_as_published() {
        // docs/MECHANICS.md#preshaping: K_a of Table I, constant because the transmission factors are.
        let finger = table_1();
        let posture = free_posture(&finger, 0.5).unwrap();
        let rest = DVector::from_vec(finger.rest_rad.clone());
        let k_a = 0.5 / (finger.theta_a(&posture) - finger.theta_a(&rest));
        assert!((k_a - 0.519_630).abs() < 1e-6, "{k_a}");
    }

    #[test]
    fn prototype_is_as_stiff_as_published() {
        // docs/MECHANICS.md#prototype: K_c / K_2 at theta_2 = 0, three figures given.
        let finger = p70(1.0);
        let posture = free_posture(&finger, 0.0).unwrap();
        for (k_mm, expected) in [(1.0, 5.0), (30.0, 23.2), (50.0, 98.9), (60.0, 300.0)] {
            let compliance = tangent_compliance(&finger, &posture, 0.0, 2, k_mm * 1e-3).unwrap();
            let ratio = 1.0 / compliance / expected;
            assert!((ratio - 1.0).abs() < 0.01, "{k_mm} mm: {ratio}");
        }
    }

    #[test]
    fn a_small_step_after_contact_is_the_tangent() {
        let finger = table_1_two_phalanges();
        let posture = free_posture(&finger, 0.3).unwrap();
        let tangent = tangent_compliance(&finger, &posture, 0.3, 2, 0.4).unwrap();
        let curve = contact_curve(&finger, 0.3, 2, 0.4, 0.301, 1);
        let secant = (curve[1].theta_a_rad - curve[0].theta_a_rad) / 0.001;
        assert!((secant / tangent - 1.0).abs() < 2e-3, "{secant} {tangent}");
    }
}
