//! A finger of three phalanges held at one contact or at two, by a balance of every joint at each of many small steps: springs, positions
//! of the links, and friction wherever something slides or turns.
//!
//! Each contact is a cylinder that is fixed in space and that the phalanx rolls and slides on. Friction of contacts and joints, and what
//! pulleys take of the torque that they carry on, act against the motion of the step, so what turns back sticks first, in whatever order.
//! Sticking is a slow motion: see [`STUCK`]. Weight, inertia and objects that yield are left out.

use nalgebra::SVector;

use super::opened::{Drive, Opened};

mod balance;
#[cfg(test)]
mod tests;

use balance::{stand, unknowns};

/// Joints, and the unknowns of a balance: their angles, two forces and the torque.
const JOINTS: usize = 3;
const UNKNOWNS: usize = 6;
/// A joint that turns by less than this share of the input link's way sticks, and a contact that slides by less than this share of it
/// times 0.03 m.
const STUCK: f64 = 1e-3;
/// Softer friction, with which a balance begins that is not found at once, as multiples of [`STUCK`].
const SOFTER: [f64; 5] = [100.0, 30.0, 10.0, 3.0, 1.0];
/// Step of the free finger's balance for its differences, in the units of the unknowns, and, of one in contact, the share of the way
/// within which something sticks.
const STEP: f64 = 1e-6;
const STEP_SHARE: f64 = 0.03;
/// A contact that pulls by less than this still presses: digits of a finger that sticks, newton.
const PULLS_N: f64 = 1e-4;

type Joints = [f64; JOINTS];
type Balance = SVector<f64, UNKNOWNS>;

/// What rubs in a finger, and what its levers are off by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rubs {
    /// Coefficient of friction of both contacts.
    pub friction: f64,
    /// Friction of each joint, newton metre.
    pub joint_nm: f64,
    /// Share of the torque carried to each joint beyond the first that is lost there.
    pub loss: f64,
    /// Share by which each stage of the transmission turns its lever farther than its lengths say.
    pub uneven: [f64; 2],
}

/// A cylinder on a phalanx.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    /// Phalanx, from 1.
    pub phalanx: usize,
    /// Distance from its joint as it touches, metre.
    pub k_m: f64,
    /// Radius of the cylinder plus half the phalanx's thickness, metre.
    pub radius_m: f64,
}

/// Where the finger stands at a measured angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Measured angle of the input link, which the cable's twist leads, radian.
    pub angle_rad: f64,
    /// Joint angles, radian.
    pub theta: [f64; 3],
    /// Torque at the input link, newton metre.
    pub torque_nm: f64,
    /// Contact forces normal to the phalanges, first and second, newton.
    pub forces_n: [f64; 2],
}

/// A cylinder in space.
#[derive(Clone, Copy, Debug)]
struct Cylinder {
    phalanx: usize,
    middle: [f64; 2],
    radius_m: f64,
}

/// A finger that closes on, free or in contact.
#[derive(Clone, Debug)]
pub struct HeldTwice<'a> {
    opened: &'a Opened,
    rubs: Rubs,
    drive: Drive,
    half_thickness_m: f64,
    /// Lever of each stage where nothing moved the joints, radian.
    levers_rad: [f64; 2],
    contacts: [Option<Cylinder>; 2],
    now: Stand,
    /// Its change over the last step.
    changed: Balance,
    free: Stand,
}

impl<'a> HeldTwice<'a> {
    /// The free finger at a measured angle, closing. `None` of other fingers than those of three phalanges with springs alone, and where
    /// it does not get there.
    #[must_use]
    pub fn new(
        opened: &'a Opened,
        rubs: Rubs,
        half_thickness_m: f64,
        drive: Drive,
        angle_rad: f64,
    ) -> Option<Self> {
        let stand: Joints = opened.stand_rad.as_slice().try_into().ok()?;
        let &[near, far] = opened.finger.stages.as_slice() else {
            return None;
        };
        if opened.back.is_some() {
            return None;
        }
        let lengths = &opened.finger.lengths;
        let carried = far.lever(stand[2], lengths[1]);
        let start = Stand {
            angle_rad,
            theta: stand,
            torque_nm: 0.0,
            forces_n: [0.0; 2],
        };
        let mut finger = Self {
            opened,
            rubs,
            drive,
            half_thickness_m,
            levers_rad: [near.lever(stand[1] + carried, lengths[0]), carried],
            contacts: [None; 2],
            now: start,
            changed: Balance::zeros(),
            free: start,
        };
        finger.free_nm(angle_rad)?;
        finger.now = finger.free;
        Some(finger)
    }

    /// Where it stands.
    #[must_use]
    pub fn now(&self) -> &Stand {
        &self.now
    }

    /// Torque of the free finger at a measured angle, newton metre.
    pub fn free_nm(&mut self, angle_rad: f64) -> Option<f64> {
        let start = Stand {
            angle_rad,
            ..self.free
        };
        self.free = self.newton(&start, STEP, |x| self.balance(x, angle_rad, None))?;
        Some(self.free.torque_nm)
    }

    /// A cylinder touches in the present posture: the first, or the second.
    pub fn touch(&mut self, touching: &Touching) {
        let (joints, absolute) = self.links(&self.now.theta);
        let index = touching.phalanx.clamp(1, JOINTS) - 1;
        let ([x, y], (sin, cos)) = (joints[index], absolute[index].sin_cos());
        let [along, away] = [touching.k_m, touching.radius_m];
        let cylinder = Cylinder {
            phalanx: index + 1,
            middle: [x + along * cos - away * sin, y + along * sin + away * cos],
            radius_m: away,
        };
        let which = usize::from(self.contacts[0].is_some());
        self.contacts[which] = Some(cylinder);
    }

    /// Closes on to a measured angle, in one step. False where no balance is found; then it stays where it was.
    pub fn close_to(&mut self, angle_rad: f64) -> bool {
        let from = self.now;
        let way_rad = angle_rad - from.angle_rad;
        let before = unknowns(&from);
        let guess = stand(angle_rad, &(before + self.changed * way_rad));
        let at = |start: &Stand, slow: f64| {
            let width = STEP_SHARE * slow * way_rad.abs();
            self.newton(start, width, |x| {
                self.balance(x, angle_rad, Some((&from, slow)))
            })
        };
        let found = at(&guess, STUCK).or_else(|| {
            let start = Stand { angle_rad, ..from };
            SOFTER
                .iter()
                .try_fold(start, |near, softer| at(&near, softer * STUCK))
        });
        if let Some(next) = found {
            self.changed = (unknowns(&next) - before) / way_rad;
            self.now = next;
        }
        found.is_some()
    }

    /// Distance of the first contact's cylinder from the surface of another phalanx, and along that phalanx from its joint, metre.
    #[must_use]
    pub fn gap_m(&self, phalanx: usize) -> Option<[f64; 2]> {
        let first = self.contacts[0].as_ref()?;
        let there = Cylinder { phalanx, ..*first };
        let seen = self.seen(&there, &self.now.theta);
        Some([seen.distance_m - first.radius_m, seen.along_m])
    }

    /// Distance of a contact from its phalanx's joint, 0 the first and 1 the second, metre.
    #[must_use]
    pub fn along_m(&self, which: usize) -> Option<f64> {
        let cylinder = self.contacts.get(which)?.as_ref()?;
        Some(self.seen(cylinder, &self.now.theta).along_m)
    }

    /// Distance of the first contact's cylinder from a joint, less its radius, metre: not positive where the joint is within it.
    #[must_use]
    pub fn clear_of_m(&self, joint: usize) -> Option<f64> {
        let first = self.contacts[0].as_ref()?;
        let (joints, _) = self.links(&self.now.theta);
        let [x, y] = joints.get(joint)?;
        Some((x - first.middle[0]).hypot(y - first.middle[1]) - first.radius_m)
    }

    /// The same cylinder, seen by the finger where nothing has moved it yet: whether it fits between open finger and its place.
    #[must_use]
    pub fn opened_fully(&self) -> Self {
        let theta = std::array::from_fn(|joint| self.opened.stand_rad[joint]);
        Self {
            now: Stand { theta, ..self.now },
            ..self.clone()
        }
    }

    /// Whether joints and contacts are within their ends, and whatever touches presses.
    #[must_use]
    pub fn stays(&self) -> bool {
        let lengths = &self.opened.finger.lengths;
        let stops = self.now.theta.iter().zip(&self.opened.most_rad);
        let joints = stops.into_iter().all(|(angle, most)| angle < most);
        let contacts = self.contacts.iter().enumerate().all(|(which, cylinder)| {
            cylinder.as_ref().is_none_or(|cylinder| {
                let along_m = self.seen(cylinder, &self.now.theta).along_m;
                (0.0..=lengths[cylinder.phalanx - 1]).contains(&along_m)
                    && self.now.forces_n[which] >= -PULLS_N
            })
        });
        joints && contacts
    }
}
