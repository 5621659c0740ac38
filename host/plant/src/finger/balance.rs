//! One implicit step: collects possible contacts, finds the active ones, and moves the joints into equilibrium.

use super::{Finger, Hold, MAX, Pose};
use crate::Contact;
use crate::object::{Body, dot};

/// Beyond this gap (metre or radian) no contact can occur within a step.
const FAR: f64 = 0.02;
/// Below this speed a joint with friction counts as sticking, radian per second.
const JOINT_CREEP_RAD_PER_S: f64 = 1e-4;

/// Something that pushes the joints along `gradient` with `stiffness * -gap` while `gap` is negative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pusher {
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

impl Pusher {
    /// Elastic energy, joule, without the cable's.
    pub fn energy(&self) -> f64 {
        match self.source {
            Source::Closing | Source::Opening => 0.0,
            Source::Stop | Source::Contact { .. } => 0.5 * self.force * self.force / self.stiffness,
        }
    }
}

impl Finger {
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

    fn collect(&mut self, body: &Body, pose: Option<&Pose>, hold: Hold) {
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
        for i in 0..self.count {
            let Some(held) = self.held[i] else { continue };
            let mut up = [0.0; MAX];
            up[i] = 1.0;
            let [low, high] = held.flanks.map(|flank| self.angle[i] - flank);
            self.push(low, up, held.stiffness, Source::Stop);
            self.push(-high, up.map(|u: f64| -u), held.stiffness, Source::Stop);
        }
        if self.stopped {
            self.push(theta_a - self.stops[0], x, stop, Source::Stop);
            self.push(self.stops[1] - theta_a, back, stop, Source::Stop);
        }
        for i in usize::from(self.runs_on)..self.count {
            let mut up = [0.0; MAX];
            let mut down = [0.0; MAX];
            (up[i], down[i]) = (1.0, -1.0);
            self.push(self.angle[i] - self.low[i], up, stop, Source::Stop);
            self.push(self.high[i] - self.angle[i], down, stop, Source::Stop);
        }
        let Some((joint, along)) = pose.filter(|_| *body != Body::Nothing) else {
            return;
        };
        let (half_thickness, stiffness) = (self.half_thickness, self.contact_stiffness);
        for i in self.hidden..self.count {
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
        let heavy = self.weight != [0.0; 2];
        let pose = (heavy || *body != Body::Nothing).then(|| self.pose());
        self.collect(body, pose.as_ref(), hold);
        let mut matrix = [[0.0; MAX]; MAX];
        let mut right = [0.0; MAX];
        for i in 0..MAX {
            let spring = self.springs_left * self.spring[i];
            matrix[i][i] = self.damping / dt + spring;
            right[i] = -spring * (self.angle[i] - self.rest[i]);
            if i >= self.count {
                (matrix[i][i], right[i]) = (1.0, 0.0);
            }
        }
        if let Some(cable) = self.returning {
            let torques = self.return_torques(self.angle);
            let stiffness = self.springs_left * cable.stiffness;
            for (i, row) in matrix.iter_mut().enumerate().take(self.count) {
                right[i] += torques[i];
                for (cell, pulley) in row.iter_mut().zip(cable.pulley).take(self.count) {
                    *cell += stiffness * cable.pulley[i] * pulley;
                }
            }
        }
        if let Some(pose) = pose.filter(|_| heavy) {
            right
                .iter_mut()
                .zip(self.weight_torques(&pose))
                .for_each(|(right, weight)| *right += weight);
        }
        self.rub_joints(&mut matrix, dt);
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
            // A step must not jump over a dead point of a linkage.
            let change = change[i].clamp(-0.05, 0.05);
            self.angle[i] += change;
            self.speed[i] = change / dt;
        }
        self.transmit();
        self.read(hold);
    }

    /// Coulomb friction of the joints, and of a tendon on their pulleys, as the viscous friction that would have given the right
    /// torque in the last step.
    fn rub_joints(&self, matrix: &mut [[f64; MAX]; MAX], dt: f64) {
        for (i, row) in matrix.iter_mut().enumerate().take(self.count) {
            let passed = if i == 0 { 0.0 } else { self.x[i] * self.torque };
            let torque = self.joint_friction + self.capstan_share * passed.abs();
            let speed = self.speed[i].abs().max(JOINT_CREEP_RAD_PER_S);
            row[i] += torque / (speed * dt);
        }
    }

    /// Coulomb friction as the viscous friction that would have given the right force in the last step.
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
