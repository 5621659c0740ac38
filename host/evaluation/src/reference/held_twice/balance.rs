//! The balance of every joint in a small step, and its root.

use nalgebra::SMatrix;

use super::{Balance, Cylinder, HeldTwice, JOINTS, Joints, STUCK, Stand, UNKNOWNS};
use crate::reference::Stage;

/// Slides are compared with so much for a radian of the input link, metre.
const SLIDE_M: f64 = 0.03;
/// Newton steps at most, and the change at which they end, in the units of the unknowns (radian, newton, newton metre).
const NEWTON_STEPS: usize = 30;
const SETTLED: f64 = 1e-9;
/// Halves of one at most.
const HALVINGS: u8 = 12;
/// Largest change of an angle in one of them, radian.
const STRIDE_RAD: f64 = 0.3;
/// Step of a lever's differences, radian.
const LEVER_STEP_RAD: f64 = 1e-4;

/// Where a contact is on its phalanx: distance of the cylinder's middle from the phalanx's line, and along it from the joint, metre; how
/// both joints' turning changes the distance, and slides the phalanx's surface along itself, metre per radian.
pub(super) struct Seen {
    pub(super) distance_m: f64,
    pub(super) along_m: f64,
    pub(super) normal: Joints,
    pub(super) slip: Joints,
}

/// Friction's share for a motion, of a motion that is slow.
fn sense(motion: f64, slow: f64) -> f64 {
    motion / motion.hypot(slow)
}

impl HeldTwice<'_> {
    /// Places of the joints and the tip, and angles of the phalanges.
    pub(super) fn links(&self, theta: &Joints) -> ([[f64; 2]; JOINTS + 1], Joints) {
        let mut joints = [[0.0; 2]; JOINTS + 1];
        let mut absolute = [0.0; JOINTS];
        let mut angle = 0.0;
        for index in 0..JOINTS {
            angle += theta[index];
            absolute[index] = angle;
            let length = self.opened.finger.lengths[index];
            let [x, y] = joints[index];
            joints[index + 1] = [x + length * angle.cos(), y + length * angle.sin()];
        }
        (joints, absolute)
    }

    pub(super) fn seen(&self, cylinder: &Cylinder, theta: &Joints) -> Seen {
        let (joints, absolute) = self.links(theta);
        let index = cylinder.phalanx - 1;
        let (sin, cos) = absolute[index].sin_cos();
        let from = |joint: usize| {
            let ([x, y], [a, b]) = (cylinder.middle, joints[joint]);
            let (x, y) = (x - a, y - b);
            // Along the phalanx, and away from it to the closing side.
            [x * cos + y * sin, y * cos - x * sin]
        };
        let [along_m, distance_m] = from(index);
        // A joint turns the phalanx about itself: the middle comes nearer by its lever along the phalanx, and the surface, which is
        // nearer to the axis than the middle, slides by its own lever away from it.
        let below_m = distance_m - self.half_thickness_m;
        let each = |of: &dyn Fn([f64; 2]) -> f64| {
            std::array::from_fn(|joint| if joint > index { 0.0 } else { of(from(joint)) })
        };
        Seen {
            distance_m,
            along_m,
            normal: each(&|[along, _]| -along),
            slip: each(&|[_, away]| -(away - below_m)),
        }
    }

    /// Angle of the input link, and by how much each joint turns it.
    pub(super) fn transmission(&self, theta: &Joints) -> (f64, Joints) {
        let finger = &self.opened.finger;
        let of = |index: usize, joint_rad: f64| -> [f64; 2] {
            let stage: Stage = finger.stages[index];
            let length = finger.lengths[index];
            let at = |steps: f64| stage.lever(joint_rad + steps * LEVER_STEP_RAD, length);
            let slope = match stage {
                Stage::Tendon { ratio } => ratio,
                Stage::Linkage { .. } => {
                    (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * LEVER_STEP_RAD)
                }
            };
            let (rest, more) = (self.levers_rad[index], 1.0 + self.rubs.uneven[index]);
            [rest + more * (at(0.0) - rest), more * slope]
        };
        let [carried, x_3] = of(1, theta[2]);
        let [lever, x_2] = of(0, theta[1] + carried);
        (theta[0] + lever, [1.0, x_2, x_2 * x_3])
    }

    /// Moments that are left at the joints, how much too near the cylinders are, and how far the measured angle is from `angle_rad`:
    /// against a motion from a state, with what counts as slow in it, or against closing freely.
    pub(super) fn balance(
        &self,
        x: &Balance,
        angle_rad: f64,
        moved: Option<(&Stand, f64)>,
    ) -> Balance {
        let now = stand(angle_rad, x);
        let finger = &self.opened.finger;
        let (theta_a_rad, lever) = self.transmission(&now.theta);
        let rate = |joint: usize| {
            moved.map(|(from, _)| {
                (now.theta[joint] - from.theta[joint]) / (angle_rad - from.angle_rad)
            })
        };
        let slow = moved.map_or(STUCK, |(_, slow)| slow);
        let mut left = Balance::zeros();
        for joint in 0..JOINTS {
            let turns = rate(joint).map_or(1.0, |rate| sense(rate, slow));
            let lost = if joint > 0 {
                self.rubs.loss * turns
            } else {
                0.0
            };
            left[joint] = finger.springs[joint] * (now.theta[joint] - finger.rest_rad[joint])
                - now.torque_nm * lever[joint] * (1.0 - lost)
                + self.rubs.joint_nm * turns;
        }
        for (which, cylinder) in self.contacts.iter().enumerate() {
            let row = JOINTS + which;
            let Some(cylinder) = cylinder.as_ref().filter(|_| moved.is_some()) else {
                left[row] = now.forces_n[which];
                continue;
            };
            let seen = self.seen(cylinder, &now.theta);
            let slides: f64 = (0..JOINTS)
                .map(|joint| seen.slip[joint] * rate(joint).unwrap_or(0.0))
                .sum();
            let rubs = self.rubs.friction * sense(slides, slow * SLIDE_M);
            for joint in 0..JOINTS {
                left[joint] -= now.forces_n[which] * (seen.normal[joint] - rubs * seen.slip[joint]);
            }
            left[row] = seen.distance_m - cylinder.radius_m;
        }
        left[UNKNOWNS - 1] = theta_a_rad + self.drive.twist_rad(now.torque_nm) - angle_rad;
        left
    }

    /// A root of a balance, by Newton's steps with differences.
    pub(super) fn newton(
        &self,
        start: &Stand,
        width: f64,
        balance: impl Fn(&Balance) -> Balance,
    ) -> Option<Stand> {
        let mut x = unknowns(start);
        for _ in 0..NEWTON_STEPS {
            let missing = balance(&x);
            let mut matrix = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
            for index in 0..UNKNOWNS {
                let beside = |step: f64| {
                    let mut beside = x;
                    beside[index] += step;
                    balance(&beside)
                };
                let column = (beside(width) - beside(-width)) / (2.0 * width);
                matrix.set_column(index, &column);
            }
            let step = matrix.lu().solve(&missing)?;
            let turned = step.fixed_rows::<JOINTS>(0).amax();
            // Friction bends within a narrow width: a step that leads beyond it is halved.
            let mut share = STRIDE_RAD / turned.max(STRIDE_RAD);
            let halvings = if step.amax() > width { HALVINGS } else { 0 };
            for _ in 0..halvings {
                if balance(&(x - step * share)).norm() < missing.norm() {
                    break;
                }
                share *= 0.5;
            }
            x -= step * share;
            if !x.iter().all(|value| value.is_finite()) {
                return None;
            }
            if step.amax() < SETTLED {
                return Some(stand(start.angle_rad, &x));
            }
        }
        None
    }
}

pub(super) fn unknowns(stand: &Stand) -> Balance {
    let [a, b, c] = stand.theta;
    let [first, second] = stand.forces_n;
    Balance::from([a, b, c, first, second, stand.torque_nm])
}

pub(super) fn stand(angle_rad: f64, x: &Balance) -> Stand {
    Stand {
        angle_rad,
        theta: [x[0], x[1], x[2]],
        forces_n: [x[3], x[4]],
        torque_nm: x[5],
    }
}
