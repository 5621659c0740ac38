//! Linear responses of the finger held by the contact.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::linearization::Linearization;
use super::newton::Unknown;
use crate::numeric::{Bounded, dot, solve_in_place};
use core::array::from_fn;

/// Most loads at a time.
const MOST: usize = 7;

/// What the finger held by the contact is loaded with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load<const N: usize> {
    /// Torques at the joints.
    pub(super) torques: [f32; N],
    /// Gap that is to be closed at the contact.
    pub(super) gap: f32,
}

/// How it gives way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response<const N: usize> {
    /// Changes of the joint angles.
    pub(super) delta: [f32; N],
    /// Change of the contact force.
    pub(super) force: f32,
}

/// All that a point of the path is asked for.
pub(super) struct Responses<const N: usize> {
    /// Newton's step.
    pub(super) step: Response<N>,
    /// Change along the path for a unit of input torque.
    pub(super) tangent: Response<N>,
    /// Derivative of the input link's rotation by the place of the contact at a given torque.
    pub(super) by_k: f32,
    /// The same by the coefficient of contact friction, with the change of the contact force.
    pub(super) by_friction: f32,
    pub(super) force_by_friction: f32,
    /// The same by a torque that opposes the turning of each joint but the first.
    pub(super) by_joint_friction: f32,
    /// The same by the logarithm of the share that is lost on the way to the joints.
    pub(super) by_loss: f32,
    /// The same by the compliance of the object.
    pub(super) by_give: f32,
}

impl<const N: usize> Linearization<N> {
    /// Solves for the changes of the joints and of the contact force F under each of some loads, [`MOST`] at most; answers beyond the
    /// number of loads mean nothing.
    ///
    /// Uses the contact, `arms . delta = gap + give F`, to eliminate the joint with the largest moment arm; F takes that joint's place
    /// among the unknowns. The system is then regular wherever the object holds the finger, also if joint 1 has no spring or the finger
    /// would be unstable without the object (docs/MECHANICS.md#soft-objects).
    #[inline(never)]
    fn respond(&self, loads: &[Load<N>]) -> Option<[Response<N>; MOST]> {
        let (mut given, mut arm) = (0, 0.0f32);
        for (m, other) in self.arms.iter().enumerate() {
            if other.abs() > arm.abs() {
                (given, arm) = (m, *other);
            }
        }
        let by_gap = 1.0 / arm;
        let follows = self.arms.map(|other| -other * by_gap);
        let (mut held, mut column) = (self.stiffness, [0.0; N]);
        for m in 0..N {
            let of_given = *held[m].get(given)?;
            for q in 0..N {
                held[m][q] += of_given * follows[q];
            }
            column[m] = of_given * by_gap;
            *held[m].get_mut(given)? = self.pressing[m] + column[m] * self.give;
        }
        let mut respond = [Response {
            delta: [0.0; N],
            force: 0.0,
        }; MOST];
        let mut sides = [[0.0; N]; MOST];
        for (side, load) in sides.iter_mut().zip(loads) {
            for m in 0..N {
                side[m] = load.torques[m] - column[m] * load.gap;
            }
        }
        if !solve_in_place(held, sides.get_mut(..loads.len())?) {
            return None;
        }
        for ((answer, load), solved) in respond.iter_mut().zip(loads).zip(sides) {
            answer.delta = solved;
            let joint = answer.delta.get_mut(given)?;
            answer.force = core::mem::take(joint);
            let gap = load.gap + self.give * answer.force;
            *answer.delta.get_mut(given)? = by_gap * gap + dot(&follows, &answer.delta);
        }
        Some(respond)
    }

    fn unbalanced(&self) -> Load<N> {
        Load {
            torques: self.torques,
            gap: self.gap,
        }
    }

    fn driven(&self) -> Load<N> {
        Load {
            torques: self.driving,
            gap: 0.0,
        }
    }

    /// Equilibrium and contact at a force, differentiated by the place of the contact: the change of its loaded arms, and of the gap.
    fn by_k(&self, force: f32) -> Load<N> {
        Load {
            torques: self.loaded.map(|loaded| -force * self.phi.cos * loaded),
            gap: -self.phi.sin,
        }
    }

    /// The same by the coefficient of contact friction.
    fn rubbed(&self, force: f32) -> Load<N> {
        Load {
            torques: self.rubbing.map(|arm| -force * arm),
            gap: 0.0,
        }
    }

    /// Equilibrium, differentiated by the torque that bearings take at each joint but the first.
    fn braked(&self) -> Load<N> {
        Load {
            torques: from_fn(|m| if m == 0 { 0.0 } else { self.braking[m] }),
            gap: 0.0,
        }
    }

    /// The same by the logarithm of the share that is lost on the way to the joints.
    fn lost(&self) -> Load<N> {
        Load {
            torques: self.lost,
            gap: 0.0,
        }
    }

    /// Newton's step at a given torque.
    pub(super) fn step(&self) -> Option<Response<N>> {
        let [step, ..] = self.respond(&[self.unbalanced()])?;
        Some(step)
    }

    /// Change along the path for a unit of input torque.
    pub(super) fn tangent(&self) -> Option<Response<N>> {
        let [tangent, ..] = self.respond(&[self.driven()])?;
        Some(tangent)
    }

    /// How far the phalanx slides on the object towards its joint for a unit of input torque without friction, and the least coefficient
    /// of friction that holds it where it is. For the tangent at contact, where there is no force yet.
    pub(super) fn sliding(&self, tangent: &Response<N>) -> Option<[f32; 2]> {
        let rubbed = Load {
            torques: self.rubbing,
            gap: 0.0,
        };
        let [answer, ..] = self.respond(&[rubbed])?;
        // Friction f in the sense s of sliding leaves the force F / (1 + s f answer.force), and takes s f times that of the answer off
        // the motion.
        let slide = dot(&self.rubbing, &tangent.delta);
        let taken = tangent.force * dot(&self.rubbing, &answer.delta) - slide * answer.force;
        let holding = slide.abs() / taken.at_least(f32::MIN_POSITIVE);
        Some([slide, holding])
    }

    /// Everything at a point, to whose force it belongs.
    pub(super) fn responses(&self, force: f32) -> Option<Responses<N>> {
        let by_k = self.by_k(force);
        let rubbed = self.rubbed(force);
        let braked = self.braked();
        let lost = self.lost();
        let closed = Load {
            torques: [0.0; N],
            gap: 1.0,
        };
        let [
            step,
            tangent,
            by_k,
            by_friction,
            by_joint_friction,
            by_loss,
            closing,
        ] = self.respond(&[
            self.unbalanced(),
            self.driven(),
            by_k,
            rubbed,
            braked,
            lost,
            closed,
        ])?;
        Some(Responses {
            step,
            tangent,
            by_k: dot(&self.x, &by_k.delta),
            by_friction: dot(&self.x, &by_friction.delta),
            force_by_friction: by_friction.force,
            by_joint_friction: dot(&self.x, &by_joint_friction.delta),
            by_loss: dot(&self.x, &by_loss.delta),
            by_give: force * dot(&self.x, &closing.delta),
        })
    }

    /// y^T H y for the tangent y, and what the object gives way: the compliance without friction. Unlike x^T y it keeps its digits near
    /// e_2, where y vanishes.
    pub(super) fn compliance(&self, Response { delta, force }: &Response<N>) -> f32 {
        let rows = self.stiffness.iter().zip(delta);
        let own: f32 = rows.map(|(row, y)| y * dot(row, delta)).sum();
        own + self.give * force * force
    }

    /// What the work of friction adds to it.
    pub(super) fn rubbed_compliance(&self, tangent: &Response<N>) -> f32 {
        self.friction * tangent.force * dot(&self.rubbing, &tangent.delta)
    }

    /// What is lost on the way to the joints adds to it.
    pub(super) fn lost_compliance(&self, tangent: &Response<N>) -> f32 {
        let mut lost = 0.0;
        for m in 1..N {
            lost += (self.x[m] - self.driving[m]) * tangent.delta[m];
        }
        lost
    }

    /// Changes of a joint, 0 for the first, for a unit of input torque, by the place of the contact, by the coefficient of friction and by a
    /// torque that opposes the turning of each joint but the first, the last three at a given torque. As [`Self::responses`], at a point to
    /// whose force it belongs.
    pub(super) fn joint_responses(&self, force: f32, joint: usize) -> Option<[f32; 4]> {
        let [by_torque, by_k, by_friction, by_joint_friction, ..] = self.respond(&[
            self.driven(),
            self.by_k(force),
            self.rubbed(force),
            self.braked(),
        ])?;
        let of = |response: Response<N>| response.delta.get(joint).copied();
        Some([
            of(by_torque)?,
            of(by_k)?,
            of(by_friction)?,
            of(by_joint_friction)?,
        ])
    }

    /// Newton's step with the place of the contact unknown and the rotation of the input link `missing` given.
    pub(super) fn place_response(&self, force: f32, missing: f32) -> Option<Unknown<N>> {
        let [mut step, by_k, ..] = self.respond(&[self.unbalanced(), self.by_k(force)])?;
        let k = (missing - dot(&self.x, &step.delta)) / dot(&self.x, &by_k.delta);
        for m in 0..N {
            step.delta[m] += k * by_k.delta[m];
        }
        Some(Unknown {
            delta: step.delta,
            force: step.force + k * by_k.force,
            k,
        })
    }
}
