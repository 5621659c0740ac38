//! Any finger of the scenes held by a contact that rolls and rubs, from a balance of every joint: the energy of what opens it, the
//! positions of its links, and numerical differentiation.

use nalgebra::DVector;

use super::finger::gradient;
use super::opened::{Drive, Opened, State, root};

/// Rise of the torque by which a finger is tried that has not moved yet, newton metre.
const SENSING_NM: f64 = 2e-3;

/// A contact with what gives way and rubs there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Phalanx, from 1.
    pub phalanx: usize,
    /// Distance from its joint at first contact, metre.
    pub k_m: f64,
    /// Radius of the object plus half the phalanx's thickness, metre.
    pub radius_m: f64,
    /// Half the phalanx's thickness, metre.
    pub half_thickness_m: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Friction of each joint beyond the first against its motion, newton metre. In a finger whose joints closed before the contact the
    /// free finger's torque has it already: there joints that close on take no more, and those that turn back twice as much.
    pub joint_nm: f64,
    /// Share that is lost at each joint beyond the first, against its motion, of the torque since the contact; with a return cable, which
    /// the whole torque has to overcome, of all of it. A joint that turns back, which the free finger has closed, first gives up what it
    /// took then, and takes as much.
    pub lost: f64,
    /// Compliance of the object, metre per newton.
    pub give_m_per_n: f64,
}

/// Which way contact and joints move under a rising torque: 1, -1, or 0 where nothing is said to rub.
#[derive(Clone, Debug, PartialEq)]
struct Senses {
    slide: f64,
    joints: Vec<f64>,
}

/// A finger pressed on an object that stands.
#[derive(Clone, Debug)]
pub struct Held<'a> {
    opened: &'a Opened,
    press: Press,
    /// The instant of contact.
    start: State,
    middle: (f64, f64),
    senses: Senses,
}

impl<'a> Held<'a> {
    /// From first contact at a measured angle. `None` where the free finger does not get there, or where the contact would not press.
    #[must_use]
    pub fn new(opened: &'a Opened, press: Press, onset_rad: f64, drive: &Drive) -> Option<Self> {
        let start = opened.free(onset_rad, drive)?;
        let at = opened.finger.point(&start.theta, press.phalanx, press.k_m);
        let absolute: f64 = start.theta.iter().take(press.phalanx).sum();
        let middle = (
            at.0 - press.radius_m * absolute.sin(),
            at.1 + press.radius_m * absolute.cos(),
        );
        let joints = start.theta.len();
        let mut held = Self {
            opened,
            press,
            start,
            middle,
            senses: Senses {
                slide: 0.0,
                joints: vec![0.0; joints],
            },
        };
        // Which way it moves without friction, once a preload has given way.
        let mut torque_nm = held.start.torque_nm + SENSING_NM;
        while held.is_held_by_its_stop(torque_nm) {
            torque_nm += SENSING_NM;
        }
        let moved = held.under(torque_nm, &held.start)?;
        let turned = &moved.theta - &held.start.theta;
        let [_, slip] = held.arms(&moved.theta);
        held.senses = Senses {
            slide: slip.dot(&turned).signum(),
            joints: (0..joints)
                .map(|joint| match joint {
                    0 => 0.0,
                    _ => turned[joint].signum(),
                })
                .collect(),
        };
        Some(held)
    }

    /// The instant of contact.
    #[must_use]
    pub fn start(&self) -> &State {
        &self.start
    }

    /// Change of the object's distance from the phalanx's line, and motion of the phalanx's surface along itself at the contact, by each
    /// joint.
    fn arms(&self, theta: &DVector<f64>) -> [DVector<f64>; 2] {
        let (finger, press) = (&self.opened.finger, &self.press);
        let normal = gradient(theta, |theta| {
            finger.distance(theta, press.phalanx, self.middle)
        });
        let along_m = self.along_m(theta);
        let absolute: f64 = theta.iter().take(press.phalanx).sum();
        let (sin, cos) = absolute.sin_cos();
        let base = finger.point(theta, press.phalanx, along_m);
        let height_m = press.half_thickness_m;
        let surface = (base.0 - height_m * sin, base.1 + height_m * cos);
        let slip = DVector::from_fn(theta.len(), |joint, _| {
            if joint >= press.phalanx {
                return 0.0;
            }
            let hinge = finger.point(theta, joint + 1, 0.0);
            (surface.0 - hinge.0) * sin - (surface.1 - hinge.1) * cos
        });
        // A point turned about a hinge moves at right angles to their distance: (-y, x), along (cos, sin).
        [normal, slip]
    }

    /// Distance of the contact from the phalanx's joint, metre.
    #[must_use]
    pub fn along_m(&self, theta: &DVector<f64>) -> f64 {
        let (finger, press) = (&self.opened.finger, &self.press);
        let joint = finger.point(theta, press.phalanx, 0.0);
        let absolute: f64 = theta.iter().take(press.phalanx).sum();
        let (sin, cos) = absolute.sin_cos();
        (self.middle.0 - joint.0) * cos + (self.middle.1 - joint.1) * sin
    }

    /// Moments that are left at the joints, and how much too near or far the object is.
    fn missing(&self, theta: &DVector<f64>, force_n: f64, torque_nm: f64) -> DVector<f64> {
        let (finger, press) = (&self.opened.finger, &self.press);
        let [normal, slip] = self.arms(theta);
        let mut left = gradient(theta, |theta| {
            self.opened.energy(theta) - torque_nm * finger.theta_a(theta)
        });
        left -= (normal - slip * (press.friction * self.senses.slide)) * force_n;
        let levers = gradient(theta, |theta| finger.theta_a(theta));
        for (joint, sense) in self.senses.joints.iter().enumerate() {
            let passed_nm = match self.opened.back {
                Some(_) => torque_nm,
                None if self.turns_back(joint) => torque_nm + self.start.torque_nm,
                None => torque_nm - self.start.torque_nm,
            };
            let lost_nm = press.lost * levers[joint].abs() * passed_nm;
            let rubs = if self.opened.stands() {
                1.0
            } else {
                1.0 - sense
            };
            left[joint] += (rubs * press.joint_nm + lost_nm) * sense;
        }
        let distance_m = finger.distance(theta, press.phalanx, self.middle);
        left.push(distance_m - press.radius_m + press.give_m_per_n * force_n)
    }

    /// Whether the contact opens a joint that the free finger has closed.
    fn turns_back(&self, joint: usize) -> bool {
        !self.opened.stands() && self.senses.joints[joint] < 0.0
    }

    /// Whether preload and friction of joint 2 still press it on its opening stop under this torque, in a finger of two phalanges.
    fn is_held_by_its_stop(&self, torque_nm: f64) -> bool {
        let theta = &self.start.theta;
        if !self.opened.stopped || theta.len() != 2 {
            return false;
        }
        // The contact bears what joint 1 does not need.
        let left = self.missing(theta, 0.0, torque_nm);
        let pressed = self.missing(theta, 1.0, torque_nm) - &left;
        left[1] - pressed[1] * left[0] / pressed[0] > 0.0
    }

    /// The finger under a torque, searched from a state near to it.
    fn under(&self, torque_nm: f64, near: &State) -> Option<State> {
        let joints = near.theta.len();
        let x = root(&near.theta.clone().push(near.force_n), |x| {
            self.missing(&x.rows(0, joints).clone_owned(), x[joints], torque_nm)
        })?;
        Some(State {
            theta: x.rows(0, joints).clone_owned(),
            torque_nm,
            force_n: x[joints],
        })
    }

    /// The finger at a measured angle after the contact, searched from a state near to it. Where friction or a preload holds the joints,
    /// the cable alone gives way.
    #[must_use]
    pub fn at(&self, angle_rad: f64, drive: &Drive, near: &State) -> Option<State> {
        let finger = &self.opened.finger;
        let start_rad = finger.theta_a(&self.start.theta);
        let stands = root(&DVector::from_element(1, self.start.torque_nm), |x| {
            DVector::from_element(1, start_rad + drive.twist_rad(x[0]) - angle_rad)
        });
        if let Some(torque_nm) = stands.map(|x| x[0])
            && self.is_held_by_its_stop(torque_nm)
        {
            return Some(State {
                torque_nm,
                ..self.start.clone()
            });
        }
        // A joint that turns back stands until what holds it is overcome.
        let joints = near.theta.len();
        let mut moves: Vec<bool> = (0..joints).map(|joint| !self.turns_back(joint)).collect();
        loop {
            let state = self.moved_to(angle_rad, drive, near, &moves)?;
            let left = self.missing(&state.theta, state.force_n, state.torque_nm);
            let opened = (0..joints).filter(|&joint| !moves[joint] && left[joint] > 0.0);
            match opened.max_by(|&one, &other| left[one].total_cmp(&left[other])) {
                Some(joint) => moves[joint] = true,
                None => return Some(state),
            }
        }
    }

    /// The finger at a measured angle, where only some joints have moved since the contact.
    fn moved_to(
        &self,
        angle_rad: f64,
        drive: &Drive,
        near: &State,
        moves: &[bool],
    ) -> Option<State> {
        let moving: Vec<usize> = (0..moves.len()).filter(|&joint| moves[joint]).collect();
        let number = moving.len();
        let posture = |x: &DVector<f64>| {
            let mut theta = self.start.theta.clone();
            for (&joint, angle) in moving.iter().zip(x) {
                theta[joint] = *angle;
            }
            theta
        };
        let balance = |x: &DVector<f64>| {
            let (theta, force_n, torque_nm) = (posture(x), x[number], x[number + 1]);
            let missing = self.missing(&theta, force_n, torque_nm);
            let past_rad =
                self.opened.finger.theta_a(&theta) + drive.twist_rad(torque_nm) - angle_rad;
            let distance = missing[moves.len()];
            missing.select_rows(&moving).push(distance).push(past_rad)
        };
        let start = near.theta.select_rows(&moving);
        let x = root(&start.push(near.force_n).push(near.torque_nm), balance)?;
        Some(State {
            theta: posture(&x),
            torque_nm: x[number + 1],
            force_n: x[number],
        })
    }

    /// Whether another phalanx, from this one on, touches the object as well.
    #[must_use]
    pub fn touches_elsewhere(&self, state: &State, first: usize) -> bool {
        let finger = &self.opened.finger;
        (first..=finger.phalanges())
            .filter(|&phalanx| phalanx != self.press.phalanx)
            .any(|phalanx| finger.apart_m(&state.theta, phalanx, self.middle) < self.press.radius_m)
    }

    /// Whether contact and joints are within their ends.
    #[must_use]
    pub fn stays(&self, state: &State, length_m: f64) -> bool {
        let along_m = self.along_m(&state.theta);
        let stops = state.theta.iter().zip(&self.opened.most_rad);
        (0.0..=length_m).contains(&along_m) && stops.into_iter().all(|(angle, most)| angle < most)
    }
}

#[cfg(test)]
mod tests {
    use super::super::support::{RIGID, opened};
    use super::super::{Rolling, Touch, contact_curve, p70, table_1};
    use super::*;

    fn press(phalanx: usize, k_m: f64, radius_m: f64) -> Press {
        Press {
            phalanx,
            k_m,
            radius_m,
            half_thickness_m: 0.0,
            friction: 0.0,
            joint_nm: 0.0,
            lost: 0.0,
            give_m_per_n: 0.0,
        }
    }

    /// On a point without friction: the path of least potential energy, with springs at all joints.
    #[test]
    fn on_a_point_it_is_the_path_of_least_energy() {
        let opened = opened(table_1());
        for (phalanx, k) in [(2, 0.3), (3, 0.2), (3, 0.4)] {
            let curve = contact_curve(&opened.finger, 0.3, phalanx, k, 0.5, 4);
            let rest = opened
                .finger
                .theta_a(&DVector::from_vec(opened.stand_rad.clone()));
            let onset = curve[0].theta_a_rad + rest;
            let held = Held::new(&opened, press(phalanx, k, 0.0), onset, &RIGID).unwrap();
            assert!((held.start().torque_nm - 0.3).abs() < 1e-9);
            let mut near = held.start().clone();
            for point in &curve[1..] {
                near = held.at(point.theta_a_rad + rest, &RIGID, &near).unwrap();
                let error = near.torque_nm / point.torque - 1.0;
                assert!(error.abs() < 1e-6, "{phalanx}, {k}: {error:e}");
            }
        }
    }

    /// With friction of contact and joint on a round object: the closed equations of the prototype.
    #[test]
    fn the_prototype_rolls_and_rubs_as_in_closed_form() {
        let finger = p70(0.05);
        let rolling = Rolling::of(&finger).unwrap();
        let opened = opened(finger);
        for (k_m, friction, joint_nm) in [(0.02, 0.0, 0.0), (0.02, 0.3, 4e-4), (0.05, 0.2, 0.0)] {
            let touch = Touch {
                k_m,
                radius_m: 0.02,
                half_thickness_m: 0.006,
                friction,
                joint_nm,
            };
            let press = Press {
                half_thickness_m: 0.006,
                friction,
                joint_nm,
                ..press(2, k_m, 0.02)
            };
            let held = Held::new(&opened, press, 0.6, &RIGID).unwrap();
            let mut near = held.start().clone();
            for turned_rad in [0.05, 0.1, 0.2] {
                let rolled = rolling.rolled(&touch, turned_rad).unwrap();
                near = held.at(0.6 + rolled.rotation_rad, &RIGID, &near).unwrap();
                let error = near.torque_nm / rolled.torque_nm - 1.0;
                assert!(error.abs() < 1e-6, "{k_m}, {friction}: {error:e}");
                let force = near.force_n / rolled.force_n - 1.0;
                assert!(force.abs() < 1e-6, "{k_m}, {friction}: {force:e}");
            }
        }
    }

    /// What is lost on the way to the joints, and in those that turn back, is work that the springs do not get. Joint 2 turns back, and
    /// stands at first.
    #[test]
    fn what_is_lost_is_missing_in_the_springs() {
        const STEP_RAD: f64 = 2e-3;
        let opened = opened(table_1());
        let rest = DVector::from_vec(opened.stand_rad.clone());
        let onset_rad = opened.finger.theta_a(&rest) + 0.4;
        let through_a_cable = Drive {
            cable_rad_per_nm: 0.2,
            ..RIGID
        };
        let done = |lost: f64| {
            let pressed = Press {
                lost,
                joint_nm: 0.1 * lost,
                ..press(3, 0.3, 0.0)
            };
            let held = Held::new(&opened, pressed, onset_rad, &through_a_cable).unwrap();
            assert_eq!([1, 2].map(|joint| held.turns_back(joint)), [true, false]);
            let start = held.start().clone();
            let (mut near, mut work, mut taken, mut stood) = (start.clone(), 0.0, 0.0, 0);
            for step in 1..=100 {
                let angle_rad = onset_rad + STEP_RAD * f64::from(step);
                let next = held.at(angle_rad, &through_a_cable, &near).unwrap();
                let [was_rad, now_rad] =
                    [&near, &next].map(|state| opened.finger.theta_a(&state.theta));
                let torque_nm = 0.5 * (near.torque_nm + next.torque_nm);
                work += torque_nm * (now_rad - was_rad);
                let levers = gradient(&next.theta, |theta| opened.finger.theta_a(theta));
                let turned = &next.theta - &near.theta;
                let back_nm = lost * levers[1] * (torque_nm + start.torque_nm) + 0.2 * lost;
                let on_nm = lost * levers[2] * (torque_nm - start.torque_nm);
                assert!(turned[1] <= 0.0 && turned[2] >= 0.0, "{turned}");
                taken += on_nm * turned[2] - back_nm * turned[1];
                stood += i32::from(turned[1] == 0.0);
                near = next;
            }
            assert_eq!(stood > 5, lost > 0.0, "{stood}");
            let stored = opened.energy(&near.theta) - opened.energy(&start.theta);
            // What is left is the trapezoids.
            assert!(
                (work - stored - taken).abs() < 5e-4 * work,
                "{work} {stored} {taken}"
            );
            near.torque_nm
        };
        assert!(done(0.04) > 1.01 * done(0.0));
    }
}
