//! Any finger of the scenes, free: what opens it, what drives it, and where it stands at a measured angle.

use nalgebra::{DMatrix, DVector};

use super::finger::{Finger, gradient};
use super::measured::MIDDLE_NM;

/// Newton steps at most, and the change at which they end, in the units of the unknowns (radian, newton, newton metre).
const NEWTON_STEPS: usize = 40;
const SETTLED: f64 = 1e-10;
/// Step of the differences of a balance, in the same units.
const STEP: f64 = 1e-5;

/// A cable that opens the finger in place of springs.
#[derive(Clone, Debug, PartialEq)]
pub struct ReturnCable {
    /// Radius of its pulley at each joint, metre.
    pub pulley_m: Vec<f64>,
    /// Tension with all joints at zero, newton.
    pub tension_n: f64,
    /// Stiffness of its spring, newton per metre.
    pub stiffness_n_per_m: f64,
}

/// Weight of the phalanges.
#[derive(Clone, Debug, PartialEq)]
pub struct Weight {
    /// Of each phalanx, even along it, newton.
    pub phalanx_n: Vec<f64>,
    /// Direction of gravity, counterclockwise from phalanx 1 where its joint angle is zero, radian.
    pub down_rad: f64,
}

impl Weight {
    /// Energy of a posture, joule.
    fn energy(&self, finger: &Finger, theta: &DVector<f64>) -> f64 {
        let (down_y, down_x) = self.down_rad.sin_cos();
        let fallen = self.phalanx_n.iter().zip(&finger.lengths).enumerate();
        let work = fallen.map(|(index, (weight_n, length_m))| {
            let middle = finger.point(theta, index + 1, 0.5 * length_m);
            weight_n * (middle.0 * down_x + middle.1 * down_y)
        });
        -work.sum::<f64>()
    }
}

/// A finger with what opens it, and where its joints stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// Links, springs and transmission.
    pub finger: Finger,
    /// A cable beside the springs.
    pub back: Option<ReturnCable>,
    /// What it weighs, where that is not nothing.
    pub weight: Option<Weight>,
    /// Where joints stand that nothing has moved, radian.
    pub stand_rad: Vec<f64>,
    /// They stand at their opening stops, which hold them against what opens them.
    pub stopped: bool,
    /// Closing stops of the joints, radian.
    pub most_rad: Vec<f64>,
}

/// What lies between motor and input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// True torque over the nominal one.
    pub factor: f64,
    /// Twist of the cable per nominal torque, radian per newton metre, at the middle of a probing.
    pub cable_rad_per_nm: f64,
    /// Growth of its stiffness, per newton metre.
    pub stiffening_per_nm: f64,
}

/// A posture with its torque.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Joint angles, radian.
    pub theta: DVector<f64>,
    /// Torque at the input link, newton metre.
    pub torque_nm: f64,
    /// Contact force, newton.
    pub force_n: f64,
}

impl Drive {
    /// Angle by which the drive's end of the cable leads the input link under a torque, radian.
    pub(super) fn twist_rad(&self, torque_nm: f64) -> f64 {
        let nominal_nm = torque_nm / self.factor;
        let bent = self.stiffening_per_nm * nominal_nm * (0.5 * nominal_nm - MIDDLE_NM);
        self.cable_rad_per_nm * (nominal_nm - bent)
    }
}

/// A root of `balance`, by Newton's steps with differences.
pub(super) fn root(
    start: &DVector<f64>,
    balance: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Option<DVector<f64>> {
    let mut x = start.clone();
    for _ in 0..NEWTON_STEPS {
        let columns: Vec<_> = (0..x.len())
            .map(|index| {
                let beside = |step: f64| {
                    let mut beside = x.clone();
                    beside[index] += step;
                    balance(&beside)
                };
                (beside(STEP) - beside(-STEP)) / (2.0 * STEP)
            })
            .collect();
        let step = DMatrix::from_columns(&columns).lu().solve(&balance(&x))?;
        x -= &step;
        if !x.iter().all(|value| value.is_finite()) {
            return None;
        }
        if step.amax() < SETTLED {
            return Some(x);
        }
    }
    None
}

impl Opened {
    /// Energy of springs, return cable and weight, joule.
    pub(super) fn energy(&self, theta: &DVector<f64>) -> f64 {
        let back = self.back.as_ref().map_or(0.0, |back| {
            let wound_m: f64 = theta.iter().zip(&back.pulley_m).map(|(a, r)| a * r).sum();
            wound_m * (back.tension_n + 0.5 * back.stiffness_n_per_m * wound_m)
        });
        let weight = self.weight.as_ref();
        self.finger.energy(theta)
            + back
            + weight.map_or(0.0, |weight| weight.energy(&self.finger, theta))
    }

    /// Joints beyond the first stand until a contact moves them: without a spring at joint 1 the torque alone does not.
    pub(super) fn stands(&self) -> bool {
        self.finger.springs.first() == Some(&0.0)
    }

    /// The free finger at a measured angle, which the cable's twist leads.
    #[must_use]
    pub fn free(&self, angle_rad: f64, drive: &Drive) -> Option<State> {
        let stand = DVector::from_column_slice(&self.stand_rad);
        let joints = if self.stands() { 1 } else { stand.len() };
        let posture = |x: &DVector<f64>| {
            let mut theta = stand.clone();
            theta.rows_mut(0, joints).copy_from(&x.rows(0, joints));
            theta
        };
        let balance = |x: &DVector<f64>| {
            let (theta, torque_nm) = (posture(x), x[joints]);
            let moments = gradient(&theta, |theta| {
                self.energy(theta) - torque_nm * self.finger.theta_a(theta)
            });
            let missing = self.finger.theta_a(&theta) + drive.twist_rad(torque_nm) - angle_rad;
            moments.rows(0, joints).clone_owned().push(missing)
        };
        let x = root(&stand.rows(0, joints).clone_owned().push(0.0), balance)?;
        Some(State {
            theta: posture(&x),
            torque_nm: x[joints],
            force_n: 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::support::{RIGID, opened};
    use super::super::table_1;
    use super::*;

    /// A finger with a weight of its own on every phalanx, and gravity aslant.
    fn heavy() -> Opened {
        Opened {
            weight: Some(Weight {
                phalanx_n: vec![0.3, 0.2, 0.1],
                down_rad: -1.2,
            }),
            ..opened(table_1())
        }
    }

    /// Torque about each joint of slices of the phalanges, each where it is.
    fn by_slices(opened: &Opened, theta: &DVector<f64>) -> DVector<f64> {
        const SLICES: usize = 1000;
        let weight = opened.weight.as_ref().unwrap();
        let (down_y, down_x) = weight.down_rad.sin_cos();
        let finger = &opened.finger;
        DVector::from_fn(theta.len(), |joint, _| {
            let hinge = finger.point(theta, joint + 1, 0.0);
            let of_phalanx = |phalanx: usize| {
                let slice = |n: usize| {
                    let share = (n as f64 + 0.5) / SLICES as f64;
                    let at = finger.point(theta, phalanx + 1, share * finger.lengths[phalanx]);
                    (at.0 - hinge.0) * down_y - (at.1 - hinge.1) * down_x
                };
                weight.phalanx_n[phalanx] / SLICES as f64 * (0..SLICES).map(slice).sum::<f64>()
            };
            (joint..theta.len()).map(of_phalanx).sum()
        })
    }

    #[test]
    fn the_weight_turns_each_joint_as_its_slices_do() {
        let (heavy, light) = (heavy(), opened(table_1()));
        for theta in [[0.0, 0.0, 0.0], [0.6, 0.4, 0.9], [1.3, 1.1, 0.2]] {
            let theta = DVector::from_row_slice(&theta);
            let weight = gradient(&theta, |theta| light.energy(theta) - heavy.energy(theta));
            let error = (weight - by_slices(&heavy, &theta)).amax();
            assert!(error < 1e-7, "{theta} {error:e}");
        }
    }

    /// The free finger takes the energy of springs and weight from its drive.
    #[test]
    fn the_free_finger_is_driven_by_what_its_energy_grows() {
        let heavy = heavy();
        let at = |angle_rad: f64| heavy.free(angle_rad, &RIGID).unwrap();
        let light = opened(table_1()).free(1.6, &RIGID).unwrap();
        assert!((at(1.6).torque_nm / light.torque_nm - 1.0).abs() > 0.1);
        for angle_rad in [1.2, 1.6, 2.0] {
            const STEP_RAD: f64 = 1e-3;
            let [more, less] =
                [STEP_RAD, -STEP_RAD].map(|step| heavy.energy(&at(angle_rad + step).theta));
            let torque_nm = (more - less) / (2.0 * STEP_RAD);
            let error = torque_nm - at(angle_rad).torque_nm;
            assert!(error.abs() < 1e-6, "{angle_rad}: {error:e}");
        }
    }
}
