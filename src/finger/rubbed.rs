//! What friction takes of a finger's motion between two contacts (docs/SECOND_CONTACTS.md#friction-of-the-contacts).

use super::statics::{contact_arms, rubbing_arms};
use super::two_contacts::cross;
use super::{Pressed, SecondMeasured};
use crate::numeric::{Bounded, dot, sqrt};

/// Least share of the frictionless compliance that friction leaves (chosen): at 0 the finger would not move.
pub(super) const LEAST_LEFT: f32 = 0.1;
/// Largest share of the work that is carried to joints beyond the first (chosen): beyond, nothing is known of the place.
const MOST_CARRIED: f32 = 100.0;

/// A compliance that a second contact at some place would show, radian per newton metre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rubbed {
    /// Share of the frictionless compliance that friction leaves, 0 to 1.
    pub(super) left: f32,
    /// Compliance with friction.
    pub(super) compliance: f32,
    /// Standard deviation of a measured one from it: of the measurement, of the coefficient of friction and of the leverage.
    pub(super) sigma: f32,
}

/// Friction of the joints whose sense of turning a second contact reverses.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TurningBack {
    /// Twice the sum of these joints' rotations per rotation of the input link. Multiplied by the friction of a joint it is the
    /// torque through which the finger sticks.
    pub(super) turned: f32,
    /// Twice the share of the input torque's work that is carried to these joints. Multiplied by the share lost on the way and by the
    /// torque it adds to the torque through which the finger sticks.
    pub(super) share: f32,
}

/// What a second contact leaves of a finger's motion.
pub(super) struct Motion {
    /// Indices of the phalanges that touch, the first contact's first.
    tips: [usize; 2],
    /// Their arms.
    arms: [[f32; 3]; 2],
    /// The joints can turn along this alone.
    v: [f32; 3],
    /// What the springs take then: H v.
    pushed: [f32; 3],
    /// What the input link turns then: x . v.
    lever: f32,
}

impl Motion {
    /// How far along `v` the joints turn with the torque.
    fn rate(&self) -> f32 {
        self.lever / dot(&self.pushed, &self.v)
    }

    /// How the joints turn with the torque, radian per newton metre.
    pub(super) fn turning_per_nm(&self) -> Option<[f32; 3]> {
        let rate = self.rate();
        rate.is_finite().then(|| self.v.map(|v| rate * v))
    }
}

impl Pressed<3> {
    /// The motion that a second contact at `k_m` on a phalanx leaves: along v = p_a x p_b.
    pub(super) fn between(&self, phalanx: u8, k_m: f32) -> Option<Motion> {
        let index = |phalanx: u8| usize::from(phalanx).checked_sub(1);
        let tips = [index(self.contact.phalanx)?, index(phalanx)?];
        let second = contact_arms(&self.lengths_m, &self.turn, tips[1], k_m);
        let v = cross(&self.arms_m, &second);
        Some(Motion {
            tips,
            arms: [self.arms_m, second],
            v,
            pushed: self.stiffness_nm_per_rad.map(|row| dot(&row, &v)),
            lever: dot(&self.x, &v),
        })
    }

    /// The compliance that a second contact at `k_m` on a phalanx would show.
    pub(super) fn rubbed(
        &self,
        phalanx: u8,
        k_m: f32,
        measured: &SecondMeasured,
    ) -> Option<Rubbed> {
        let free = self.second_compliance(phalanx, k_m)?;
        let motion = self.between(phalanx, k_m)?;
        let share = self.rubbed_share(&motion, measured.half_thickness_m)?;
        let [mean, deviation] = measured.friction;
        let [loss, loss_deviation] = measured.joint_loss;
        let carried = self.carried(&motion);
        let left = (1.0 - mean * share - loss * carried).at_least(LEAST_LEFT);
        // The lever enters twice, as torque and as rotation.
        let spread = [
            measured.compliance_sigma_rad_per_nm,
            free * share * deviation,
            free * carried * loss_deviation,
            2.0 * free * left * measured.leverage_sigma * carried,
        ];
        Some(Rubbed {
            left,
            compliance: free * left,
            sigma: sqrt(dot(&spread, &spread)),
        })
    }

    /// Share of the torque's work that contact friction with a coefficient of 1 takes while two contacts hold: along the motion v
    /// that they leave, each slides by s . v under a force that grows with the torque. Forces that act already when the second
    /// contact is made, and turn back where the sliding does, are left out.
    pub(super) fn rubbed_share(&self, motion: &Motion, half_thickness_m: f32) -> Option<f32> {
        let &Motion {
            tips,
            arms,
            v,
            pushed,
            lever,
        } = motion;
        let (rate, size) = (motion.rate(), dot(&v, &v));
        // What the springs leave of the torque is borne by the contacts: x - H dtheta/dT = p_a df_a/dT + p_b df_b/dT.
        let borne: [f32; 3] = core::array::from_fn(|i| self.x[i] - rate * pushed[i]);
        let by = arms.map(|arm| dot(&arm, &borne));
        let products = [
            dot(&arms[0], &arms[0]),
            dot(&arms[0], &arms[1]),
            dot(&arms[1], &arms[1]),
        ];
        let growth = [
            (products[2] * by[0] - products[1] * by[1]) / size,
            (products[0] * by[1] - products[1] * by[0]) / size,
        ];
        let mut work = 0.0;
        for (tip, growth) in tips.into_iter().zip(growth) {
            let slides = dot(
                &rubbing_arms(&self.lengths_m, &self.turn, tip, half_thickness_m),
                &v,
            );
            work += slides.abs() * growth.at_least(0.0);
        }
        let share = work / lever.abs();
        share.is_finite().then_some(share)
    }

    /// Share of the input torque's work that is carried to joints beyond the first, whether they close or open. More than 1 where the
    /// terms of x . v cancel: the finger is nearly rigid there. Multiplied by the share lost on the way it is the share that the compliance
    /// loses; multiplied by the doubt about each factor it is the doubt about x . v (x_1 = 1 is exact).
    pub(super) fn carried(&self, &Motion { v, lever, .. }: &Motion) -> f32 {
        let [_, x2, x3] = self.x;
        (((x2 * v[1]).abs() + (x3 * v[2]).abs()) / lever.abs()).at_most(MOST_CARRIED)
    }

    /// Finds the joints whose sense of turning the second contact reverses: what rubs there has to be overcome twice.
    pub(super) fn turning_back(&self, &Motion { v, lever, .. }: &Motion) -> Option<TurningBack> {
        let mut back = TurningBack::default();
        for (joint, (v, x)) in v.into_iter().zip(self.x).enumerate() {
            let after = v / lever;
            if self.tangent_per_nm[joint] * after < 0.0 {
                back.turned += 2.0 * after.abs();
                // What joint 1 gets is carried by nothing.
                if joint > 0 {
                    back.share += 2.0 * (x * after).abs();
                }
            }
        }
        (back.turned.is_finite() && back.share.is_finite()).then_some(back)
    }

    /// Torque through which contact friction with a coefficient of 1 holds the finger at first: where the first contact's sliding
    /// turns back, its force has to be overcome twice. That of the second one grows from nothing.
    pub(super) fn stick_nm(&self, motion: &Motion, half_thickness_m: f32) -> Option<f32> {
        let &Motion { tips, v, lever, .. } = motion;
        let [first, _] = tips;
        let arms = rubbing_arms(&self.lengths_m, &self.turn, first, half_thickness_m);
        let (before, after) = (dot(&arms, &self.tangent_per_nm), dot(&arms, &v) / lever);
        let turns_back = before * after < 0.0;
        let stick = if turns_back {
            2.0 * self.force_n.at_least(0.0) * after.abs()
        } else {
            0.0
        };
        stick.is_finite().then_some(stick)
    }
}
