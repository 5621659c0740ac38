//! A phalanx that rolls on a round object: torque and rotation of the input link after contact, from positions and moments.
//!
//! Two phalanges without a spring at joint 1, at rest at the instant of contact, so that all torque is the contact's. Phalanx 1
//! then lies along x with its joint in the origin, turned by the rest angle of joint 2 against phalanx 2.

use super::finger::Finger;

/// Rotation of joint 2 up to which the transmission is tabulated, radian.
const MOST_RAD: f64 = 1.4;
/// Intervals of that table: a cubic between two entries is good to 1e-10.
const INTERVALS: usize = 700;
/// Step of the central differences at the entries, radian.
const STEP_RAD: f64 = 1e-3;
/// A search ends with a step of this size, radian, or without success after so many.
const SETTLED_RAD: f64 = 1e-10;
const SECANTS: usize = 40;

/// The finger, with its transmission tabulated.
#[derive(Clone, Debug)]
pub struct Rolling {
    /// Length of phalanx 1, metre.
    pub proximal_m: f64,
    /// Length of phalanx 2, metre.
    pub distal_m: f64,
    /// Stiffness of the spring at joint 2, newton metre per radian.
    pub spring_nm_per_rad: f64,
    rest_rad: f64,
    /// Its sine and cosine.
    rest: [f64; 2],
    /// Rotation of the input link by joint 2 with its derivative.
    lever: Vec<[f64; 2]>,
}

/// A contact on phalanx 2 with what rubs there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Distance from joint 2 at first contact, metre.
    pub k_m: f64,
    /// Radius of the object plus half the phalanx's thickness, metre.
    pub radius_m: f64,
    /// Half the phalanx's thickness, metre.
    pub half_thickness_m: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Friction or preload of joint 2 against closing, newton metre.
    pub joint_nm: f64,
}

/// The finger after some rotation of joint 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolled {
    /// Rotation of the input link since contact, radian.
    pub rotation_rad: f64,
    /// Torque at the input link, newton metre.
    pub torque_nm: f64,
    /// Contact force normal to the phalanx, newton.
    pub force_n: f64,
    /// Distance of the contact from joint 2 now, metre.
    pub k_m: f64,
}

impl Rolling {
    /// Of a finger of two phalanges; `None` of another, or of one with a spring at joint 1.
    #[must_use]
    pub fn of(finger: &Finger) -> Option<Self> {
        let (&[proximal_m, distal_m], &[0.0, spring_nm_per_rad], &[_, rest_rad]) = (
            finger.lengths.as_slice(),
            finger.springs.as_slice(),
            finger.rest_rad.as_slice(),
        ) else {
            return None;
        };
        let &[stage] = finger.stages.as_slice() else {
            return None;
        };
        let at =
            |rad: f64| stage.lever(rest_rad + rad, proximal_m) - stage.lever(rest_rad, proximal_m);
        let lever = (0..=INTERVALS)
            .map(|index| {
                let rad = MOST_RAD * index as f64 / INTERVALS as f64;
                let along = |steps: f64| at(rad + steps * STEP_RAD);
                let slope = (8.0 * (along(1.0) - along(-1.0)) - (along(2.0) - along(-2.0)))
                    / (12.0 * STEP_RAD);
                [at(rad), slope]
            })
            .collect();
        Some(Self {
            proximal_m,
            distal_m,
            spring_nm_per_rad,
            rest_rad,
            rest: [rest_rad.sin(), rest_rad.cos()],
            lever,
        })
    }

    /// Rotation of the input link by a rotation of joint 2 alone, and its derivative.
    fn lever(&self, rad: f64) -> Option<[f64; 2]> {
        let width = MOST_RAD / INTERVALS as f64;
        let place = rad / width;
        let index = place.floor().max(0.0) as usize;
        let (&[a, b], &[c, d]) = (self.lever.get(index)?, self.lever.get(index + 1)?);
        let t = place - index as f64;
        let (rise, b, d) = (c - a, b * width, d * width);
        let (square, cube) = (3.0 * rise - 2.0 * b - d, b + d - 2.0 * rise);
        let value = a + t * (b + t * (square + t * cube));
        let slope = (b + t * (2.0 * square + 3.0 * t * cube)) / width;
        Some([value, slope])
    }

    /// The finger once joint 2 has turned by `rad`; `None` beyond the reach of transmission or contact.
    #[must_use]
    pub fn rolled(&self, touch: &Touch, rad: f64) -> Option<Rolled> {
        let [lever_rad, x_2] = self.lever(rad)?;
        // The object's middle at contact, seen from joint 1, phalanx 2 along x.
        let [sin_rest, cos_rest] = self.rest;
        let middle = [
            self.proximal_m * cos_rest + touch.k_m,
            touch.radius_m - self.proximal_m * sin_rest,
        ];
        // Phalanx 2 has turned by phi: its distance from the middle is still the radius,
        // -sin(phi) middle_x + cos(phi) middle_y + l_1 sin(theta_2) = R.
        let (sin_2, cos_2) = (self.rest_rad + rad).sin_cos();
        let square = middle[0] * middle[0] + middle[1] * middle[1];
        let beside = self.proximal_m * sin_2 - touch.radius_m;
        let along = (square - beside * beside).sqrt();
        let sin = (beside * middle[0] + along * middle[1]) / square;
        let cos = (along * middle[0] - beside * middle[1]) / square;
        let phi = sin.atan2(cos);
        let k_m = along - self.proximal_m * cos_2;
        // Moment arms of a force of 1 normal to the phalanx, and of its friction along it.
        let height_m = touch.half_thickness_m;
        let arm_2 = k_m + touch.friction * height_m;
        let arm_1 =
            k_m + self.proximal_m * cos_2 + touch.friction * (height_m - self.proximal_m * sin_2);
        let spring_nm = self.spring_nm_per_rad * rad + touch.joint_nm;
        // T = f p_1 and x_2 T - K_2 delta_2 = f p_2.
        let torque_nm = spring_nm / (x_2 - arm_2 / arm_1);
        let rolled = Rolled {
            rotation_rad: phi - rad + lever_rad,
            torque_nm,
            force_n: torque_nm / arm_1,
            k_m,
        };
        let sum = rolled.rotation_rad + rolled.torque_nm + rolled.k_m;
        (sum.is_finite() && x_2 * arm_1 > arm_2).then_some(rolled)
    }

    /// Rotation of joint 2 at which `angle` of the finger is `wanted_rad`, by secants from two neighbouring rotations.
    pub fn solve(
        &self,
        touch: &Touch,
        [near_rad, beside_rad]: [f64; 2],
        wanted_rad: f64,
        angle: impl Fn(&Rolled) -> f64,
    ) -> Option<f64> {
        let missing = |rad: f64| Some(wanted_rad - angle(&self.rolled(touch, rad)?));
        let (mut before, mut rad) = (beside_rad, near_rad);
        let mut missed = missing(before)?;
        for _ in 0..SECANTS {
            let misses = missing(rad)?;
            let step = misses * (rad - before) / (missed - misses);
            if !step.is_finite() || step.abs() < SETTLED_RAD {
                return Some(rad);
            }
            (before, missed) = (rad, misses);
            rad = (rad + step).clamp(0.0, 0.5 * (rad + MOST_RAD));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::{contact_curve, p70};
    use super::*;

    fn touch(k_m: f64, radius_m: f64) -> Touch {
        Touch {
            k_m,
            radius_m,
            half_thickness_m: 0.006,
            friction: 0.0,
            joint_nm: 0.0,
        }
    }

    /// A point in space is a radius of zero; without friction the path is that of the least potential energy.
    #[test]
    fn on_a_point_it_is_the_path_of_least_energy() {
        let finger = p70(0.05);
        let rolling = Rolling::of(&finger).unwrap();
        for k_m in [0.01, 0.035, 0.06] {
            let touch = touch(k_m, 0.0);
            let curve = contact_curve(&finger, 0.0, 2, k_m, 0.05, 5);
            let start = curve[0].theta_a_rad;
            for point in &curve[1..] {
                let rad = rolling
                    .solve(&touch, [0.01, 0.02], point.theta_a_rad - start, |r| {
                        r.rotation_rad
                    })
                    .unwrap();
                let found = rolling.rolled(&touch, rad).unwrap();
                let error = found.torque_nm / point.torque - 1.0;
                assert!(error.abs() < 1e-5, "{k_m}: {error:e}");
            }
        }
    }

    /// Without friction the motor's work is the spring's energy.
    #[test]
    fn work_is_conserved_while_it_rolls_and_friction_takes_its_share() {
        let rolling = Rolling::of(&p70(0.05)).unwrap();
        for (k_m, friction) in [(0.02, 0.0), (0.05, 0.0), (0.02, 0.3), (0.05, 0.3)] {
            let touch = Touch {
                friction,
                ..touch(k_m, 0.02)
            };
            let (end, steps) = (0.2, 2000);
            let mut work = 0.0;
            let mut before = rolling.rolled(&touch, 0.0).unwrap();
            for step in 1..=steps {
                let now = rolling
                    .rolled(&touch, end * f64::from(step) / f64::from(steps))
                    .unwrap();
                let turned = now.rotation_rad - before.rotation_rad;
                work += 0.5 * (now.torque_nm + before.torque_nm) * turned;
                before = now;
            }
            let share = work / (0.5 * 0.05 * end * end) - 1.0;
            if friction > 0.0 {
                assert!(share > 0.005, "{k_m}: {share}");
            } else {
                assert!(share.abs() < 1e-5, "{k_m}: {share:e}");
            }
        }
    }
}
