//! A finger that knows its positions and energies alone, in f64; every derivative by differences.

use nalgebra::{DMatrix, DVector};
use palpate::finger::Parameters;

const GRAVITY: f64 = 9.81;
/// Parts into which a rise of the torque is divided.
const PARTS: u32 = 20;
/// Step of the differences, radian.
const STEP: f64 = 1e-4;
/// A stage of a linkage: levers and coupler, offset; or the ratio of a tendon's pulleys.
#[derive(Clone, Copy)]
pub enum Stage {
    Tendon(f64),
    Linkage([f64; 4], f64),
}

/// What a finger's energy knows.
pub struct Energy {
    pub lengths: Vec<f64>,
    pub masses: Vec<f64>,
    pub springs: Vec<f64>,
    pub rest: Vec<f64>,
    pub stages: Vec<Stage>,
    /// Radii, tension, stiffness.
    pub cable: Option<([f64; 2], f64, f64)>,
    pub down: [f64; 2],
}

impl Energy {
    pub fn of<const N: usize>(
        parameters: &Parameters<N>,
        stages: Vec<Stage>,
        (gravity_rad, share): (f64, f64),
    ) -> Self {
        let all = |list: [f32; N]| list.map(f64::from).to_vec();
        let lengths = all(parameters.lengths_m);
        Self {
            masses: lengths.iter().map(|length| 0.1 * length).collect(),
            lengths,
            springs: all(parameters.stiffness_nm_per_rad),
            rest: all(parameters.rest_rad),
            stages,
            cable: None,
            down: [gravity_rad.cos(), gravity_rad.sin()].map(|part| share * GRAVITY * part),
        }
    }

    /// Where a point of a phalanx is.
    pub fn point(&self, theta: &DVector<f64>, phalanx: usize, along: f64) -> [f64; 2] {
        let (mut at, mut angle) = ([0.0, 0.0], 0.0f64);
        for j in 0..=phalanx {
            angle += theta[j];
            let length = if j == phalanx { along } else { self.lengths[j] };
            at = [at[0] + length * angle.cos(), at[1] + length * angle.sin()];
        }
        at
    }

    pub fn theta_a(&self, theta: &DVector<f64>) -> f64 {
        let mut inner = 0.0;
        for (j, stage) in self.stages.iter().enumerate().rev() {
            let u = theta[j + 1] + inner;
            inner = match stage {
                Stage::Tendon(ratio) => ratio * u,
                Stage::Linkage([a, b, c, psi], mode) => {
                    let ground = self.lengths[j];
                    let gamma = |delta: f64| {
                        let end = [ground + c * delta.cos(), c * delta.sin()];
                        let reach = end[0].hypot(end[1]);
                        let cosine = (reach * reach + a * a - b * b) / (2.0 * a * reach);
                        end[1].atan2(end[0]) + mode * cosine.acos()
                    };
                    gamma(u - psi) - gamma(-psi)
                }
            };
        }
        theta[0] + inner
    }

    /// Height times weight, springs, return cable, less what the motor gives.
    pub fn energy(&self, theta: &DVector<f64>, torque: f64) -> f64 {
        let mut sum = -torque * self.theta_a(theta);
        for j in 0..self.lengths.len() {
            let middle = self.point(theta, j, 0.5 * self.lengths[j]);
            sum -= self.masses[j] * (self.down[0] * middle[0] + self.down[1] * middle[1]);
            let bent = theta[j] - self.rest[j];
            sum += 0.5 * self.springs[j] * bent * bent;
        }
        if let Some((radii, tension, stiffness)) = self.cable {
            let wound = radii[0] * theta[0] + radii[1] * theta[1];
            sum += wound * (tension + 0.5 * stiffness * wound);
        }
        sum
    }

    pub fn gradient(
        &self,
        theta: &DVector<f64>,
        of: impl Fn(&DVector<f64>) -> f64,
    ) -> DVector<f64> {
        DVector::from_fn(theta.len(), |j, _| {
            let beside = |steps: f64| {
                let mut beside = theta.clone();
                beside[j] += steps * STEP;
                of(&beside)
            };
            // Of fourth order.
            (8.0 * (beside(1.0) - beside(-1.0)) - (beside(2.0) - beside(-2.0))) / (12.0 * STEP)
        })
    }

    /// What is left at every joint.
    pub fn left(&self, theta: &DVector<f64>, torque: f64) -> DVector<f64> {
        self.gradient(theta, |theta| self.energy(theta, torque))
    }

    /// Distance of a point in space from a phalanx's axis.
    pub fn distance(&self, theta: &DVector<f64>, phalanx: usize, point: [f64; 2]) -> f64 {
        let joint = self.point(theta, phalanx, 0.0);
        let angle: f64 = theta.iter().take(phalanx + 1).sum();
        (point[0] - joint[0]) * -angle.sin() + (point[1] - joint[1]) * angle.cos()
    }

    /// A root of some balance by Newton's steps.
    pub fn root(
        start: DVector<f64>,
        balance: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> DVector<f64> {
        let mut x = start;
        for _ in 0..30 {
            let columns: Vec<_> = (0..x.len())
                .map(|j| {
                    let beside = |step: f64| {
                        let mut beside = x.clone();
                        beside[j] += step;
                        balance(&beside)
                    };
                    (beside(STEP) - beside(-STEP)) / (2.0 * STEP)
                })
                .collect();
            let step = DMatrix::from_columns(&columns)
                .lu()
                .solve(&balance(&x))
                .expect("regular");
            x -= &step;
            if step.amax() < 1e-12 {
                break;
            }
        }
        x
    }

    /// The free finger at an angle of the input link: joint angles and torque. A return cable lets joint 1 alone turn.
    pub fn free(&self, theta_a: f64) -> (DVector<f64>, f64) {
        let joints = self.lengths.len();
        let turning = if self.cable.is_some() { 1 } else { joints };
        let posture = |x: &DVector<f64>| {
            let mut theta = DVector::from_column_slice(&self.rest);
            theta.rows_mut(0, turning).copy_from(&x.rows(0, turning));
            theta
        };
        let start = DVector::from_column_slice(&self.rest)
            .rows(0, turning)
            .clone_owned()
            .push(0.0);
        let x = Self::root(start, |x| {
            let theta = posture(x);
            let left = self.left(&theta, x[turning]);
            left.rows(0, turning)
                .clone_owned()
                .push(self.theta_a(&theta) - theta_a)
        });
        (posture(&x), x[turning])
    }

    /// The finger on a point that its phalanx met in a posture, followed from there: rotation and force after a rise of the torque, and
    /// compliance.
    pub fn pressed(
        &self,
        at: &DVector<f64>,
        phalanx: usize,
        k: f64,
        torques: [f64; 2],
    ) -> [f64; 3] {
        let point = self.point(at, phalanx, k);
        let joints = at.len();
        let under = |torque: f64, near: &DVector<f64>| {
            Self::root(near.clone(), |x| {
                let theta = x.rows(0, joints).clone_owned();
                let normal = self.gradient(&theta, |theta| self.distance(theta, phalanx, point));
                let left = self.left(&theta, torque) - normal * x[joints];
                left.push(self.distance(&theta, phalanx, point))
            })
        };
        let turned = |x: &DVector<f64>| self.theta_a(&x.rows(0, joints).clone_owned());
        let [from, rise] = torques;
        let mut now = at.clone().push(0.0);
        // Below break-away a return cable holds what this balance knows nothing of.
        let parts = if self.cable.is_some() { 1 } else { PARTS };
        for part in 1..=parts {
            now = under(from + rise * f64::from(part) / f64::from(parts), &now);
        }
        let step = 1e-4;
        let [more, less] = [step, -step].map(|step| turned(&under(from + rise + step, &now)));
        [
            turned(&now) - self.theta_a(at),
            now[joints],
            (more - less) / (2.0 * step),
        ]
    }

    /// 1/K_c at contact: the energy's Hessian, bordered with the contact's gradient.
    pub fn compliance(&self, at: &DVector<f64>, torque: f64, phalanx: usize, k: f64) -> f64 {
        let joints = at.len();
        let point = self.point(at, phalanx, k);
        let normal = self.gradient(at, |theta| self.distance(theta, phalanx, point));
        let x = self.gradient(at, |theta| self.theta_a(theta));
        let columns: Vec<_> = (0..joints)
            .map(|j| {
                let beside = |step: f64| {
                    let mut beside = at.clone();
                    beside[j] += step;
                    self.left(&beside, torque)
                };
                let column = (beside(STEP) - beside(-STEP)) / (2.0 * STEP);
                column.push(normal[j])
            })
            .chain([normal.clone().push(0.0)])
            .collect();
        let turned = DMatrix::from_columns(&columns)
            .lu()
            .solve(&x.clone().push(0.0))
            .expect("regular");
        x.dot(&turned.rows(0, joints))
    }
}
