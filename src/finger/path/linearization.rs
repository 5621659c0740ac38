//! The finger a step after contact: its stiffness, the contact's moment arms, and what is unbalanced there.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::Start;
use super::newton::Unknown;
use crate::finger::{BaseJoint, JointStep, Transmission, TransmissionFactors, Weight};
use crate::numeric::{Bounded, Rotation, dot};

/// What holds a joint at its stop at least, as a share of the return cable's torque.
const BARELY_HELD: f32 = 1e-3;

/// The finger a step after contact, and what is unbalanced there.
pub(super) struct Linearization<const N: usize> {
    /// Transmission factors, and what of them arrives as torque.
    pub(super) x: [f32; N],
    pub(super) driving: [f32; N],
    /// What losses on the way to each joint have changed of its torque since contact: less than zero where it closes, more where it turns
    /// back.
    pub(super) lost: [f32; N],
    /// H + f dp/ddelta.
    pub(super) stiffness: [[f32; N]; N],
    /// Moment arms p of the contact.
    pub(super) arms: [f32; N],
    /// Moment arms of contact friction, for a coefficient of 1.
    pub(super) rubbing: [f32; N],
    /// Moment arms of the contact force with its friction.
    pub(super) pressing: [f32; N],
    /// Coefficient of contact friction.
    pub(super) friction: f32,
    /// Change of each joint's torque since contact per unit of friction in its bearings. In a finger whose joints turned before: 2 where a
    /// joint turns back or a pulley still keeps it from that, else 0. In one that stood at its stops: -1 where a joint closes, 1 where it opens.
    pub(super) braking: [f32; N],
    /// 1 for each joint that the contact has an arm about, 0 beyond.
    pub(super) loaded: [f32; N],
    /// Rotation of the phalanx in contact: its cosine is dp/dk of the loaded arms, its sine is what k shifts the gap by.
    pub(super) phi: Rotation,
    /// What is left of every joint's balance.
    pub(super) torques: [f32; N],
    /// Distance of the cylinder from the phalanx, the object's give taken off.
    pub(super) gap: f32,
    /// Compliance of the object.
    pub(super) give: f32,
    pub(super) k_now: f32,
}

impl<const N: usize, B: BaseJoint> Start<N, B> {
    /// Computes for each joint how much the weight's torque about it has changed since contact, and the derivative of that torque by
    /// the angle of the joint or of any joint nearer to the base (docs/SENSING.md#gravity).
    fn weight(&self, step: &JointStep<N>) -> [[f32; 2]; N] {
        let mut torques = if let Some(weight) = self.base.weight() {
            self.stated(weight, step)
        } else {
            self.told(step)
        };
        for j in (1..N).rev() {
            let [more, slope] = torques[j];
            torques[j - 1][0] += more;
            torques[j - 1][1] += slope;
        }
        torques
    }

    /// What each phalanx adds to that where its weight is stated.
    fn stated(&self, weight: &Weight, step: &JointStep<N>) -> [[f32; 2]; N] {
        let mut half = Rotation::NONE;
        let mut torques = [[0.0f32; 2]; N];
        for ((torque, pull), turn) in
            (torques.iter_mut().zip(weight.pulls(&self.from))).zip(step.half)
        {
            half = half.then(turn);
            let (turned, versine) = (half.twice(), 2.0 * half.sin * half.sin);
            let [along, across] = [pull.along, pull.across].map(|nm| nm / self.stiffness_scale);
            *torque = [
                -(across * versine + along * turned.sin),
                -(across * turned.sin + along * turned.cos),
            ];
        }
        torques
    }

    /// What the weight adds to what a return cable holds the joints at their stops with: it takes a part of the cable's torque about
    /// joint 1, which is the cable's about the others as well. A joint that it lifts off its stop is taken to be barely held there.
    fn weight_at_stop(&self, lever: &[f32; N], x: &[f32; N]) -> [f32; N] {
        let mut held = [0.0; N];
        if let Some(weight) = self.base.weight() {
            let borne = (weight.borne(&self.from)).map(|pull| pull.across / self.stiffness_scale);
            let (first, cable) = (borne[0], self.torque + borne[0]);
            for m in 1..N {
                let stop = (lever[m] - x[m]) * self.torque - BARELY_HELD * cable;
                held[m] = (borne[m] - lever[m] * first).at_most(stop);
            }
        }
        held
    }

    /// The same as [`Self::stated`] where the record tells the weight.
    fn told(&self, step: &JointStep<N>) -> [[f32; 2]; N] {
        let [along, across] = self.weight;
        let mut torques = [[0.0f32; 2]; N];
        let mut turned = Rotation::NONE;
        let mut beyond = 1.0;
        for j in 0..N {
            turned = turned.then(step.half[j].twice());
            let length = self.lengths[j];
            beyond -= length;
            let moment = length * (0.5 * length + beyond);
            torques[j] = [
                moment * (across * (turned.cos - 1.0) - along * turned.sin),
                -moment * (across * turned.sin + along * turned.cos),
            ];
        }
        torques
    }

    /// Everything about the finger at `at`, exactly as far from contact as the increments say.
    pub(super) fn local<T: Transmission<N>>(
        &self,
        transmission: &T,
        at: &Unknown<N>,
        rise: f32,
    ) -> Option<Linearization<N>> {
        let step = JointStep::of(at.delta);
        let now = self.from.advanced(&step);
        let TransmissionFactors { x, w } = transmission.factors(&now)?;
        let [loss, _] = T::JOINT_LOSS;
        let (mut driving, mut lost) = (x, [0.0; N]);
        if loss > 0.0 {
            for m in 0..N {
                let taken = self.taken[m] * x[m];
                driving[m] -= taken;
                lost[m] = -taken * (rise + self.back[m]);
            }
        }
        // Without a torque at contact nothing asks for it.
        let x_change = if self.torque == 0.0 {
            [0.0; N]
        } else {
            transmission.x_change(&self.from, &step)?
        };
        let torque = self.torque + rise;
        let (was, turn, i) = (self.from.turn(), now.turn(), usize::from(self.before));

        // Down from the contact: bend of phalanx i against phalanx j at contact and now, and half the rotation of j.
        let mut half = step
            .half
            .iter()
            .take(i + 1)
            .fold(Rotation::NONE, |sum, h| sum.then(*h));
        let phi = half.twice();
        let versine = 2.0 * half.sin * half.sin;
        let mut arms_sines = [(0.0f32, 0.0f32); N];
        let (mut bend_was, mut bend_now) = (Rotation::NONE, Rotation::NONE);
        let (mut arm, mut sine) = (0.0f32, 0.0f32);
        let mut shift = [0.0f32; 2];
        for j in (0..N).filter(|j| *j <= i).rev() {
            arms_sines[j] = (arm, sine);
            let Some(below) = j.checked_sub(1) else { break };
            half = half.then(step.half[j].back());
            bend_was = bend_was.then(was[j]);
            bend_now = bend_now.then(turn[j]);
            // The tip of phalanx j moves by a chord, perpendicular to its middle direction; frame of phalanx i at contact.
            let middle = bend_was.back().then(half);
            let chord = 2.0 * half.sin * self.lengths[below];
            shift[0] -= chord * middle.sin;
            shift[1] += chord * middle.cos;
            arm += self.lengths[below] * bend_now.cos;
            sine -= self.lengths[below] * bend_now.sin;
        }
        let rigid =
            -at.k * phi.sin - self.radius * versine + phi.sin * shift[0] - phi.cos * shift[1];
        let gap = rigid + self.give * at.force;
        let k_now = phi.cos * (at.k - shift[0]) + phi.sin * (self.radius - shift[1]);
        // A soft object gives way along the normal alone, so how the contact moves along the phalanx as a joint turns follows from
        // where the object's centre was at contact.
        let normal = self.radius + rigid;

        let (mut arms, mut rubbing, mut pressing) = ([0.0; N], [0.0; N], [0.0; N]);
        let mut loaded = [0.0; N];
        // The force of friction for a contact force of 1, towards the joint.
        let pulled = self.slides * self.friction;
        let mut stiffness = w;
        let mut torques = [0.0; N];
        let weight = self.weight(&step);
        for m in 0..N {
            for q in 0..N {
                stiffness[m][q] *= -torque;
                stiffness[m][q] -= weight[m.max(q)][1];
                if m <= i && q <= i {
                    // dp_m/ddelta_q: the height of the contact over the joint nearer to the base.
                    stiffness[m][q] += at.force * (normal + arms_sines[m.min(q)].1);
                    // A force along the phalanx turns with it: its arm about joint m changes with the joints beyond m alone.
                    if q > m {
                        stiffness[m][q] -= at.force * pulled * (arms_sines[m].0 - arms_sines[q].0);
                    }
                }
            }
            stiffness[m][m] += self.stiffness[m];
            if m <= i {
                arms[m] = k_now + arms_sines[m].0;
                rubbing[m] = self.slides * (arms_sines[m].1 + self.half_thickness);
                pressing[m] = arms[m] + self.friction * rubbing[m];
                loaded[m] = 1.0;
            }
            let mut driven = x[m] * rise + x_change[m] * self.torque;
            if loss > 0.0 {
                driven += lost[m];
            }
            let sprung = weight[m][0] - self.stiffness[m] * at.delta[m];
            torques[m] = driven + sprung - at.force * pressing[m];
            if m > 0 {
                torques[m] -= self.held[m];
            }
        }
        if let Some(cable) = self.base.return_cable() {
            // The stiffness scale is the cable's; the transmission factors do not change.
            let lever: [f32; N] = cable.factors();
            let stretched = dot(&lever, &at.delta);
            let weight = self.weight_at_stop(&lever, &driving);
            for m in 0..N {
                torques[m] += (driving[m] - lever[m]) * self.torque - lever[m] * stretched;
                if B::WEIGHS {
                    torques[m] += weight[m];
                }
                for q in 0..N {
                    stiffness[m][q] += lever[m] * lever[q];
                }
            }
        }
        Some(Linearization {
            x,
            driving,
            lost,
            stiffness,
            arms,
            rubbing,
            pressing,
            friction: self.friction,
            // Not by the sign of the change so far: while a pulley keeps a joint from turning back the path has the joint close on, and
            // below break-away the path has it turn the other way.
            braking: self.sense.map(|sense| self.rubbed() - sense),
            loaded,
            phi,
            torques,
            gap,
            give: self.give,
            k_now,
        })
    }
}

impl<const N: usize> Linearization<N> {
    /// Rise of the torque from contact with which joint 2 leaves the stop that a preload holds it at, and the contact force then,
    /// for a linearization at contact without force. None where it never does.
    pub(super) fn break_away(&self) -> Option<[f32; 2]> {
        // Joint 1 balances the contact; what is left over at joint 2 must overcome what holds it.
        let (first, second) = (self.pressing.first()?, self.pressing.get(1)?);
        let lever = self.driving.get(1)? * first - second;
        let held = -self.torques.get(1)?;
        let force = held / lever;
        (lever > 0.0 && held > 0.0 && force.is_finite()).then_some([force * first, force])
    }
}
