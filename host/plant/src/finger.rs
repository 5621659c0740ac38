//! The finger: joints, springs, stops, transmission and contacts, brought to balance step by step.
//!
//! Its own inertia is small beside the drivetrain's as seen at the input link, so each joint follows
//! `damping * speed = springs + stops + cable + contacts`, solved implicitly; everything that can only push (cable
//! flank, stop, contact) is a stiff one-sided spring, and which of them push is found by iteration in each step.

use crate::linkage::Fourbar;
use crate::object::{Body, Point, dot};
use crate::parameters::{FingerKind, Parameters};
use crate::{Contact, Error};

/// Most phalanges.
pub(crate) const MAX: usize = 3;
/// Most things that can push at once: two cable flanks, two stops of the input link, two a joint, contacts.
const MAX_PUSHERS: usize = 48;
/// Beyond this gap (metre or radian) nothing can come into touch within a step.
const FAR: f64 = 0.02;

/// One stage of the transmission, joint angle to the lever before it.
#[derive(Clone, Debug)]
enum Stage {
    Tendon {
        ratio: f64,
    },
    Linkage {
        fourbar: Fourbar,
        zero: f64,
        gamma: f64,
    },
}

impl Stage {
    /// F and F' at a joint angle; a linkage follows on from its last position.
    fn at(&mut self, angle: f64) -> (f64, f64) {
        match self {
            Self::Tendon { ratio } => (*ratio * angle, *ratio),
            Self::Linkage {
                fourbar,
                zero,
                gamma,
            } => {
                let slope;
                (*gamma, slope) = fourbar.follow(*gamma, angle);
                (*gamma - *zero, slope)
            }
        }
    }
}

/// Something that pushes the joints along `gradient` with `stiffness * -gap` while `gap` is negative.
#[derive(Clone, Copy, Debug)]
struct Pusher {
    gap: f64,
    gradient: [f64; MAX],
    stiffness: f64,
    source: Source,
    active: bool,
    force: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    Closing,
    Opening,
    Stop,
    Contact {
        phalanx: u8,
        feature: u8,
        k: f64,
        back: bool,
        slide: [f64; MAX],
    },
}

/// What holds the input link during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Hold {
    /// A cable whose other end would put the input link between `low` and `high` without force.
    Cable { low: f64, high: f64, stiffness: f64 },
    /// A given torque (for tests and for the placing of objects).
    Torque(f64),
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Finger {
    pub count: usize,
    pub length: [f64; MAX],
    pub spring: [f64; MAX],
    pub rest: [f64; MAX],
    low: [f64; MAX],
    high: [f64; MAX],
    /// Opening and closing stop of the input link.
    pub stops: [f64; 2],
    /// Stops of the input link are there (they can be broken off).
    pub stopped: bool,
    stages: [Stage; 2],
    half_thickness: f64,
    damping: f64,
    stop_stiffness: f64,
    contact_stiffness: f64,
    friction: f64,
    creep_speed: f64,
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
    pub fn new(parameters: &Parameters, kind: FingerKind) -> Result<Self, Error> {
        let finger = parameters.finger.of(kind);
        let count = finger.length_m.len();
        let list = |values: &[f64], f: fn(f64) -> f64| {
            let mut list = [0.0; MAX];
            list.iter_mut()
                .zip(values)
                .for_each(|(to, &from)| *to = f(from));
            list
        };
        let stage = |i: usize| -> Result<Stage, Error> {
            if i + 1 >= count {
                return Ok(Stage::Tendon { ratio: 0.0 });
            }
            if let [near, far] = finger.pulley_m.chunks(2).nth(i).unwrap_or_default() {
                return Ok(Stage::Tendon { ratio: far / near });
            }
            let fourbar = finger.fourbar(i);
            let open = Error::Open {
                key: format!("{kind:?}"),
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
        if spring[0] == 0.0 {
            // Without a spring, nothing defines where joint 1 rests; it opens until theta_1 is zero.
            rest[0] = 0.0;
        }
        let mut finger = Self {
            count,
            length: list(&finger.length_m, |l| l),
            spring,
            rest,
            low: list(&finger.joint_min_deg, f64::to_radians),
            high: list(&finger.joint_max_deg, f64::to_radians),
            stops: [0.0, finger.travel_rad],
            stopped: true,
            stages: [stage(0)?, stage(1)?],
            half_thickness: mechanism.phalanx_half_thickness_m,
            damping: mechanism.damping_nm_s_per_rad,
            stop_stiffness: mechanism.stop_stiffness_nm_per_rad,
            contact_stiffness: parameters.contact.stiffness_n_per_m,
            friction: parameters.contact.friction,
            creep_speed: parameters.contact.creep_speed_m_per_s,
            angle: rest,
            speed: [0.0; MAX],
            theta_a: 0.0,
            x: [0.0; MAX],
            torque: 0.0,
            contacts: Vec::new(),
            memory: Vec::new(),
            pushers: Vec::with_capacity(MAX_PUSHERS),
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
    pub fn pose(&self) -> ([Point; MAX + 1], [Point; MAX]) {
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

    /// Least distance between finger and object, negative when they overlap.
    pub fn clearance(&self, body: &Body) -> f64 {
        let (joint, along) = self.pose();
        let mut least = f64::INFINITY;
        for i in 0..self.count {
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

    /// The object of a wanted first contact: against the finger in its free posture at `theta_1`.
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
        if !(0.0..=self.length[i]).contains(&k) {
            return Err(Error::Contact(format!(
                "k = {k} m on a phalanx of {} m",
                self.length[i]
            )));
        }
        let mut free = self.clone();
        free.stopped = false;
        let torque = self.spring[0] * (theta_1 - self.rest[0]);
        free.angle = self.rest;
        free.angle[0] = theta_1;
        free.transmit();
        free.settle(&Body::Nothing, Hold::Torque(torque));
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

    fn push(&mut self, gap: f64, gradient: [f64; MAX], stiffness: f64, source: Source) {
        if gap < FAR {
            self.pushers.push(Pusher {
                gap,
                gradient,
                stiffness,
                source,
                active: gap < 0.0,
                force: 0.0,
            });
        }
    }

    fn collect(&mut self, body: &Body, hold: Hold) {
        self.pushers.clear();
        let (theta_a, x, stop) = (self.theta_a, self.x, self.stop_stiffness);
        let back = x.map(|x| -x);
        if let Hold::Cable {
            low,
            high,
            stiffness,
        } = hold
        {
            self.push(theta_a - low, x, stiffness, Source::Closing);
            self.push(high - theta_a, back, stiffness, Source::Opening);
        }
        if self.stopped {
            self.push(theta_a - self.stops[0], x, stop, Source::Stop);
            self.push(self.stops[1] - theta_a, back, stop, Source::Stop);
        }
        for i in 0..self.count {
            let mut up = [0.0; MAX];
            let mut down = [0.0; MAX];
            (up[i], down[i]) = (1.0, -1.0);
            self.push(self.angle[i] - self.low[i], up, stop, Source::Stop);
            self.push(self.high[i] - self.angle[i], down, stop, Source::Stop);
        }
        if *body == Body::Nothing {
            return;
        }
        let (joint, along) = self.pose();
        let (half_thickness, stiffness) = (self.half_thickness, self.contact_stiffness);
        for i in 0..self.count {
            let pushers = &mut self.pushers;
            body.approach(joint[i], along[i], self.length[i], half_thickness, |near| {
                if near.gap >= FAR {
                    return;
                }
                let [cos, sin] = along[i];
                let axis = [joint[i][0] + near.k * cos, joint[i][1] + near.k * sin];
                let normal = near.normal;
                let tangent = [normal[1], -normal[0]];
                let mut gradient = [0.0; MAX];
                let mut slide = [0.0; MAX];
                for m in 0..=i {
                    let arm = [axis[0] - joint[m][0], axis[1] - joint[m][1]];
                    gradient[m] = normal[0] * arm[1] - normal[1] * arm[0];
                    let surface = [
                        arm[0] + half_thickness * normal[0],
                        arm[1] + half_thickness * normal[1],
                    ];
                    slide[m] = tangent[1] * surface[0] - tangent[0] * surface[1];
                }
                #[expect(clippy::cast_possible_truncation, reason = "at most three phalanges")]
                let phalanx = i as u8 + 1;
                let back = dot(normal, [-sin, cos]) < -1e-3;
                let source = Source::Contact {
                    phalanx,
                    feature: near.feature,
                    k: near.k,
                    back,
                    slide,
                };
                let active = near.gap < 0.0;
                pushers.push(Pusher {
                    gap: near.gap,
                    gradient,
                    stiffness,
                    source,
                    active,
                    force: 0.0,
                });
            });
        }
    }

    /// One implicit step of `dt` seconds.
    pub fn step(&mut self, body: &Body, hold: Hold, dt: f64) {
        self.collect(body, hold);
        let mut matrix = [[0.0; MAX]; MAX];
        let mut right = [0.0; MAX];
        for i in 0..MAX {
            matrix[i][i] = self.damping / dt + self.spring[i];
            right[i] = -self.spring[i] * (self.angle[i] - self.rest[i]);
            if i >= self.count {
                (matrix[i][i], right[i]) = (1.0, 0.0);
            }
        }
        if let Hold::Torque(torque) = hold {
            right
                .iter_mut()
                .zip(self.x)
                .for_each(|(r, x)| *r += x * torque);
        }
        if self.friction > 0.0 {
            self.rub(&mut matrix, dt);
        }
        let mut change = [0.0; MAX];
        for _ in 0..8 {
            let (mut m, mut r) = (matrix, right);
            for pusher in self.pushers.iter().filter(|p| p.active) {
                for i in 0..self.count {
                    let weighted = pusher.stiffness * pusher.gradient[i];
                    r[i] -= weighted * pusher.gap;
                    m[i].iter_mut()
                        .zip(pusher.gradient)
                        .for_each(|(cell, g)| *cell += weighted * g);
                }
            }
            change = solve(&m, r);
            let mut same = true;
            for pusher in &mut self.pushers {
                let gap = pusher.gap + dot3(pusher.gradient, change);
                pusher.force = pusher.stiffness * (-gap).max(0.0);
                same &= (gap < 0.0) == pusher.active;
                pusher.active = gap < 0.0;
            }
            if same {
                break;
            }
        }
        for i in 0..self.count {
            // A dead point of a linkage must not be jumped over in one step.
            let change = change[i].clamp(-0.05, 0.05);
            self.angle[i] += change;
            self.speed[i] = change / dt;
        }
        self.transmit();
        self.read(hold);
    }

    /// Coulomb friction as a viscous one that would have given the right force in the last step.
    fn rub(&self, matrix: &mut [[f64; MAX]; MAX], dt: f64) {
        for pusher in &self.pushers {
            let Source::Contact {
                phalanx,
                feature,
                slide,
                ..
            } = pusher.source
            else {
                continue;
            };
            let last = self
                .memory
                .iter()
                .find(|(p, f, _)| (*p, *f) == (phalanx, feature));
            let Some(&(_, _, force)) = last else { continue };
            let speed = dot3(slide, self.speed).abs().max(self.creep_speed);
            let viscous = self.friction * force / (speed * dt);
            for (row, a) in matrix.iter_mut().zip(slide).take(self.count) {
                for (cell, b) in row.iter_mut().zip(slide) {
                    *cell += viscous * a * b;
                }
            }
        }
    }

    /// Forces after a step.
    fn read(&mut self, hold: Hold) {
        self.torque = if let Hold::Torque(torque) = hold {
            torque
        } else {
            0.0
        };
        self.contacts.clear();
        self.memory.clear();
        for pusher in self.pushers.iter().filter(|p| p.force > 0.0) {
            match pusher.source {
                Source::Closing => self.torque += pusher.force,
                Source::Opening => self.torque -= pusher.force,
                Source::Stop => {}
                Source::Contact {
                    phalanx,
                    feature,
                    k,
                    back,
                    ..
                } => {
                    self.memory.push((phalanx, feature, pusher.force));
                    self.contacts.push(Contact {
                        phalanx,
                        k_m: k,
                        force_n: pusher.force,
                        back,
                    });
                }
            }
        }
    }

    /// Energy in springs, stops and contacts (not the cable), joule.
    pub fn energy(&self) -> f64 {
        let springs =
            (0..self.count).map(|i| 0.5 * self.spring[i] * (self.angle[i] - self.rest[i]).powi(2));
        let pushers = self
            .pushers
            .iter()
            .filter(|p| !matches!(p.source, Source::Closing | Source::Opening));
        springs.sum::<f64>()
            + pushers
                .map(|p| 0.5 * p.force * p.force / p.stiffness)
                .sum::<f64>()
    }
}

fn dot3(a: [f64; MAX], b: [f64; MAX]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Solves a symmetric positive definite system.
fn solve(m: &[[f64; MAX]; MAX], r: [f64; MAX]) -> [f64; MAX] {
    // L D L^T without square roots.
    let d0 = m[0][0];
    let l10 = m[1][0] / d0;
    let l20 = m[2][0] / d0;
    let d1 = m[1][1] - l10 * m[1][0];
    let l21 = (m[2][1] - l20 * m[1][0]) / d1;
    let d2 = m[2][2] - l20 * m[2][0] - l21 * l21 * d1;
    let y1 = r[1] - l10 * r[0];
    let y2 = r[2] - l20 * r[0] - l21 * y1;
    let z2 = y2 / d2;
    let z1 = y1 / d1 - l21 * z2;
    [r[0] / d0 - l10 * z1 - l20 * z2, z1, z2]
}

#[cfg(test)]
mod reference;
