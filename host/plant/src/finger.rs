//! The finger: joints, springs, stops, transmission and contacts, brought to balance step by step.
//!
//! The finger's inertia is small compared with the drivetrain's at the input link, so each joint follows
//! `damping * speed = springs + stops + cable + contacts`, solved implicitly; everything that can only push (cable
//! flank, stop, contact) is a stiff one-sided spring, and which of them push is found by iteration in each step.

mod balance;
#[cfg(test)]
mod reference;
mod returning;
mod stage;

use crate::object::{Body, Grasp, Point};
use crate::parameters::{Object, ObjectMount, Parameters};
use crate::{Contact, Error};
use balance::Pusher;
use returning::Returning;
use stage::Stage;

/// Largest number of phalanges.
pub(crate) const MAX: usize = 3;
/// Joint positions, and unit vectors along the phalanges.
type Pose = ([Point; MAX + 1], [Point; MAX]);
/// What holds the input link during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Hold {
    /// A cable whose other end would put the input link between `low` and `high` without force.
    Cable { low: f64, high: f64, stiffness: f64 },
    /// A given torque, for tests and for placing objects.
    Torque(f64),
}

/// What a joint's own motor holds it by: its worm locks itself, so that the wheel stands, and only the spring between wheel
/// and joint gives way, beyond the wheel's backlash.
#[derive(Clone, Copy, Debug)]
struct Held {
    stiffness: f64,
    /// The joint's angle at either flank.
    flanks: [f64; 2],
}

/// Values of a list, one a joint.
fn list(values: &[f64], f: fn(f64) -> f64) -> [f64; MAX] {
    let mut list = [0.0; MAX];
    list.iter_mut()
        .zip(values)
        .for_each(|(to, &from)| *to = f(from));
    list
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Finger {
    pub count: usize,
    /// Phalanges within the palm, which touch nothing.
    hidden: usize,
    pub length: [f64; MAX],
    pub spring: [f64; MAX],
    /// Share of their stiffness that the springs have left (a fault can take some).
    pub springs_left: f64,
    pub rest: [f64; MAX],
    /// Joints that a motor of their own holds: the spring's stiffness, and the angles beyond which the wheel's flanks load it.
    held: [Option<Held>; MAX],
    returning: Option<Returning>,
    low: [f64; MAX],
    high: [f64; MAX],
    /// Opening and closing stop of the input link.
    pub stops: [f64; 2],
    /// Whether the input link has its stops (a fault can remove them).
    pub stopped: bool,
    /// Whether joint 1 has lost its stops as well, so that nothing ends a motion.
    pub runs_on: bool,
    stages: [Stage; 2],
    half_thickness: f64,
    damping: f64,
    stop_stiffness: f64,
    /// Of a surface, and of that with what holds the object in series.
    surface_stiffness: f64,
    contact_stiffness: f64,
    friction: f64,
    creep_speed: f64,
    joint_friction: f64,
    capstan_share: f64,
    /// Weight per length of a phalanx, newton per metre.
    weight: Point,
    pub angle: [f64; MAX],
    speed: [f64; MAX],
    pub theta_a: f64,
    pub x: [f64; MAX],
    /// Torque at the input link, closing positive.
    pub torque: f64,
    pub contacts: Vec<Contact>,
    memory: Vec<(u8, u8, f64)>,
    pushers: Vec<Pusher>,
}

impl Finger {
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        let finger = &parameters.finger;
        let count = finger.length_m.len();
        let stage = |i: usize| -> Result<Stage, Error> {
            if i + 1 >= count || !finger.held_backlash_deg.is_empty() {
                return Ok(Stage::Tendon { ratio: 0.0 });
            }
            if let [near, far] = finger.pulley_m.chunks(2).nth(i).unwrap_or_default() {
                return Ok(Stage::Tendon { ratio: far / near });
            }
            let fourbar = finger.fourbar(i);
            let open = Error::Open {
                key: "finger".to_owned(),
                stage: i + 1,
                angle_deg: 0.0,
            };
            let zero = fourbar.assemble(0.0).ok_or(open)?;
            Ok(Stage::Linkage {
                fourbar,
                zero,
                gamma: zero,
            })
        };
        let mechanism = &parameters.mechanism;
        let mut spring = list(&finger.spring_nm_per_rad, |k| k);
        spring
            .iter_mut()
            .for_each(|k| *k *= 1.0 + mechanism.spring_error);
        let mut rest = list(&finger.rest_deg, f64::to_radians);
        if spring[0] == 0.0 && finger.return_pulley_m.is_empty() {
            // Without a spring joint 1 has no rest angle; it starts at theta_1 = 0.
            rest[0] = 0.0;
        }
        let mut held = [None; MAX];
        for (i, backlash_deg) in (1..count).zip(&finger.held_backlash_deg) {
            let half = 0.5 * backlash_deg.to_radians();
            held[i] = Some(Held {
                stiffness: std::mem::take(&mut spring[i]),
                flanks: [rest[i] - half, rest[i] + half],
            });
        }
        let low = list(&finger.joint_min_deg, f64::to_radians);
        let returning = Returning::of(parameters);
        for i in (1..count).filter(|_| returning.is_none()) {
            // A spring can be preloaded only if its joint rests at the stop.
            if rest[i] < low[i] + 1e-6 {
                rest[i] -= mechanism.preload_deg.to_radians();
            }
        }
        let mut angle = rest;
        angle
            .iter_mut()
            .zip(low)
            .for_each(|(angle, low)| *angle = angle.max(low));
        let tendon = finger.lever_m.is_empty();
        let weight = mechanism.linear_density_kg_per_m * mechanism.gravity_m_per_s2;
        let (down_y, down_x) = mechanism.mounting_deg.to_radians().sin_cos();
        let mut finger = Self {
            count,
            hidden: usize::from(finger.hidden_base),
            length: list(&finger.length_m, |l| l),
            spring,
            springs_left: 1.0,
            rest,
            held,
            returning,
            low,
            high: list(&finger.joint_max_deg, f64::to_radians),
            stops: [0.0, finger.travel_rad],
            stopped: true,
            runs_on: false,
            stages: [stage(0)?, stage(1)?],
            half_thickness: mechanism.phalanx_half_thickness_m,
            damping: mechanism.damping_nm_s_per_rad,
            stop_stiffness: mechanism.stop_stiffness_nm_per_rad,
            surface_stiffness: parameters.contact.stiffness_n_per_m,
            contact_stiffness: parameters.contact.stiffness_n_per_m,
            friction: parameters.contact.friction,
            creep_speed: parameters.contact.creep_speed_m_per_s,
            joint_friction: mechanism.joint_friction_nm,
            capstan_share: if tendon { mechanism.capstan_share } else { 0.0 },
            weight: [weight * down_x, weight * down_y],
            angle,
            speed: [0.0; MAX],
            theta_a: 0.0,
            x: [0.0; MAX],
            torque: 0.0,
            contacts: Vec::new(),
            memory: Vec::new(),
            pushers: Vec::new(),
        };
        finger.transmit();
        finger.stops = [finger.theta_a, finger.theta_a + finger.stops[1]];
        Ok(finger)
    }

    /// theta_a and its gradient from the joint angles.
    fn transmit(&mut self) {
        let [_, second, third] = self.angle;
        let [first_stage, second_stage] = &mut self.stages;
        let (inner, inner_slope) = second_stage.at(third);
        let (outer, outer_slope) = first_stage.at(second + inner);
        self.theta_a = self.angle[0] + outer;
        self.x = [1.0, outer_slope, outer_slope * inner_slope];
    }

    /// Joint positions and unit vectors along the phalanges.
    pub fn pose(&self) -> Pose {
        let mut joint = [[0.0; 2]; MAX + 1];
        let mut along = [[0.0; 2]; MAX];
        let mut alpha = 0.0;
        for i in 0..self.count {
            alpha += self.angle[i];
            let (sin, cos) = alpha.sin_cos();
            along[i] = [cos, sin];
            joint[i + 1] = [
                joint[i][0] + self.length[i] * cos,
                joint[i][1] + self.length[i] * sin,
            ];
        }
        (joint, along)
    }

    /// See [`Mechanics::mount`](crate::Mechanics::mount).
    pub fn mount(&mut self, object: &Object) -> Result<(), Error> {
        let surface = self.surface_stiffness;
        self.contact_stiffness = match object.mount {
            ObjectMount::Fixed => surface,
            ObjectMount::Spring => 1.0 / (1.0 / surface + 1.0 / object.stiffness_n_per_m),
            ObjectMount::Free => {
                return Err(Error::Engine(
                    "object.mount: the engine plant has no free objects; the engine mujoco has them".into(),
                ));
            }
        };
        Ok(())
    }

    /// Torque of gravity at each joint, newton metre, closing positive.
    fn weight_torques(&self, (joint, along): &Pose) -> [f64; MAX] {
        let mut torques = [0.0; MAX];
        for i in 0..self.count {
            let half = 0.5 * self.length[i];
            let force = self.weight.map(|weight| weight * self.length[i]);
            let middle = [
                joint[i][0] + half * along[i][0],
                joint[i][1] + half * along[i][1],
            ];
            for m in 0..=i {
                let arm = [middle[0] - joint[m][0], middle[1] - joint[m][1]];
                torques[m] += arm[0] * force[1] - arm[1] * force[0];
            }
        }
        torques
    }

    /// Least distance between finger and object, negative when they overlap.
    pub fn clearance(&self, body: &Body) -> f64 {
        let (joint, along) = self.pose();
        let mut least = f64::INFINITY;
        for i in self.hidden..self.count {
            body.approach(
                joint[i],
                along[i],
                self.length[i],
                self.half_thickness,
                |near| least = least.min(near.gap),
            );
        }
        least
    }

    /// The object at the position that `grasp` describes.
    pub fn body(&self, grasp: &Grasp) -> Result<Body, Error> {
        match grasp {
            Grasp::Free => Ok(Body::Nothing),
            Grasp::Touching {
                phalanx,
                k_m,
                theta_1_rad,
                shape,
            } => self.met(*phalanx, *k_m, *theta_1_rad, shape),
            Grasp::At {
                origin_m,
                angle_rad,
                shape,
            } => Body::placed(shape, *origin_m, *angle_rad),
        }
    }

    /// Places the object against the finger in its free posture at `theta_1`.
    pub fn met(
        &self,
        phalanx: u8,
        k: f64,
        theta_1: f64,
        shape: &crate::Shape,
    ) -> Result<Body, Error> {
        let i = usize::from(phalanx).wrapping_sub(1);
        if i >= self.count {
            return Err(Error::Contact(format!(
                "phalanx {phalanx} of {}",
                self.count
            )));
        }
        if i < self.hidden {
            return Err(Error::Contact(format!(
                "phalanx {phalanx} lies within the palm"
            )));
        }
        if !(0.0..=self.length[i]).contains(&k) {
            return Err(Error::Contact(format!(
                "k = {k} m on a phalanx of {} m",
                self.length[i]
            )));
        }
        let mut free = self.clone();
        free.stopped = false;
        free.springs_left = 1.0;
        free.joint_friction = 0.0;
        free.capstan_share = 0.0;
        free.angle = self.rest;
        free.angle[0] = theta_1;
        free.transmit();
        let [returned, ..] = free.return_torques(free.angle);
        let sprung = self.spring[0] * (theta_1 - self.rest[0]) - returned;
        if self.weight == [0.0; 2] {
            free.settle(&Body::Nothing, Hold::Torque(sprung));
        } else {
            // Joint 1 is fixed there; its spring and the weight determine the torque at the input link.
            (free.spring[0], free.rest[0]) = (1e7, theta_1);
            for _ in 0..4 {
                let torque = sprung - free.weight_torques(&free.pose())[0];
                free.settle(&Body::Nothing, Hold::Torque(torque));
            }
        }
        if self.stopped && !(self.stops[0] - 1e-9..=self.stops[1]).contains(&free.theta_a) {
            return Err(Error::Contact(format!(
                "theta_1 = {theta_1} rad is beyond the stops of the input link"
            )));
        }
        let (joint, along) = free.pose();
        let [cos, sin] = along[i];
        let out = self.half_thickness;
        let touch = [
            joint[i][0] + k * cos - out * sin,
            joint[i][1] + k * sin + out * cos,
        ];
        Body::resting(shape, touch, sin.atan2(cos))
    }

    /// Lets the joints come to rest under a constant hold.
    pub fn settle(&mut self, body: &Body, hold: Hold) {
        for _ in 0..4000 {
            self.step(body, hold, 5e-3);
            if self.speed.iter().all(|speed| speed.abs() < 1e-11) {
                break;
            }
        }
        self.speed = [0.0; MAX];
    }

    /// Energy in springs, stops and contacts (not the cable), joule.
    pub fn energy(&self) -> f64 {
        let springs = (0..self.count).map(|i| {
            0.5 * self.springs_left * self.spring[i] * (self.angle[i] - self.rest[i]).powi(2)
        });
        springs.sum::<f64>()
            + self.return_energy()
            + self.pushers.iter().map(Pusher::energy).sum::<f64>()
    }
}
