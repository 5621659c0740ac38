//! The finger some way after a second contact: there the slope is measured, because at once friction may hold the finger
//! (docs/SECOND_CONTACTS.md#sticking).

use super::rubbed::Rubbed;
use super::statics::{contact_arms, rubbing_arms};
use super::two_contacts::cross;
use super::{BaseJoint, Configuration, Finger, JointStep, Pressed, SecondMeasured, Transmission};
use crate::numeric::{Bounded, Rotation, dot};

/// Pieces of the way, over each of which the motion that the contacts leave is that at its middle.
const PIECES: u8 = 2;
/// A joint turns by no more, radian (chosen): where the contacts leave hardly a motion of the input link the way in the joints
/// has no bound.
const MOST_RAD: f32 = 0.5;
/// Farthest that an object's centre lies from the axes of the phalanges, metre (chosen): one of 0.3 m across.
const MOST_OFF_M: f32 = 0.15;
/// What friction and way leave of the compliance, as a share of that at the instant of the second contact, at most (chosen).
const MOST_LEFT: f32 = 10.0;

/// Two contacts in a posture: indices of the phalanges, places, and how far the object's centre lies from their axes.
#[derive(Clone, Copy, Debug)]
struct Held {
    tips: [usize; 2],
    k_m: [f32; 2],
    off_m: f32,
}

impl Held {
    fn arms(&self, lengths_m: &[f32; 3], turn: &[Rotation; 3]) -> [[f32; 3]; 2] {
        let [first, second] = self.tips;
        let [k_first_m, k_second_m] = self.k_m;
        [
            contact_arms(lengths_m, turn, first, k_first_m),
            contact_arms(lengths_m, turn, second, k_second_m),
        ]
    }

    /// By how much each place moves away from its joint with each joint's angle.
    fn slides(&self, lengths_m: &[f32; 3], turn: &[Rotation; 3]) -> [[f32; 3]; 2] {
        self.tips
            .map(|tip| rubbing_arms(lengths_m, turn, tip, self.off_m))
    }
}

/// Forces of two contacts that balance torques of the joints, as far as they can; newton.
fn forces(arms: &[[f32; 3]; 2], torques: &[f32; 3]) -> [f32; 2] {
    let [a, b] = arms;
    let by = [dot(a, torques), dot(b, torques)];
    let [aa, ab, bb] = [dot(a, a), dot(a, b), dot(b, b)];
    let size = aa * bb - ab * ab;
    [
        (bb * by[0] - ab * by[1]) / size,
        (aa * by[1] - ab * by[0]) / size,
    ]
}

/// f P, what a contact adds to the joints' stiffness: arms m and n share what the smaller of them slides by.
fn added(force_n: f32, slides: &[f32; 3], tip: usize) -> [[f32; 3]; 3] {
    core::array::from_fn(|m| {
        core::array::from_fn(|n| {
            let loads = m <= tip && n <= tip;
            let by = slides.get(m.min(n)).copied().unwrap_or(0.0);
            if loads { force_n * by } else { 0.0 }
        })
    })
}

impl Pressed<3> {
    /// Of two phalanges side by side: how far the first contact is from the joint between them, metre, and the tangent of half
    /// that joint's angle. A cylinder that touches both is as far from that joint on one as on the other, and its centre that
    /// distance over the tangent from their axes.
    pub(super) fn between_joint(&self, phalanx: u8) -> Option<[f32; 2]> {
        let first = self.contact.phalanx;
        let is_beside = first.abs_diff(phalanx) == 1;
        let joint = usize::from(first.max(phalanx)).checked_sub(1)?;
        let turn = self.turn.get(joint).filter(|_| is_beside)?;
        let half = turn.sin / (1.0 + turn.cos);
        let near_m = if first < phalanx {
            self.lengths_m.get(joint.checked_sub(1)?)? - self.k_now_m
        } else {
            self.k_now_m
        };
        (half > 0.0 && near_m > 0.0).then_some([near_m, half])
    }

    /// Distance of a second contact beside the first from the joint between them, metre.
    pub(super) fn near_joint(&self, phalanx: u8, k_m: f32) -> f32 {
        if phalanx > self.contact.phalanx {
            return k_m;
        }
        let index = usize::from(phalanx).saturating_sub(1);
        self.lengths_m.get(index).map_or(k_m, |length| length - k_m)
    }

    /// Distance of the object's centre from the phalanges' axes, metre: that of a cylinder which touches both, where they are side by side.
    pub(super) fn off_m(&self, phalanx: u8, k_m: f32) -> f32 {
        let least_m = self.contact.radius_m;
        self.between_joint(phalanx)
            .map_or(least_m, |[near_m, half]| {
                let near_m = 0.5 * (near_m + self.near_joint(phalanx, k_m));
                (near_m / half).at_least(least_m).at_most(MOST_OFF_M)
            })
    }

    /// Centre's distance from the axes of a cylinder that touches the phalanx beside the first contact's, as that contact has it,
    /// metre.
    pub(super) fn round_m(&self, phalanx: u8) -> Option<f32> {
        let [near_m, half] = self.between_joint(phalanx)?;
        Some(
            (near_m / half)
                .at_least(self.contact.radius_m)
                .at_most(MOST_OFF_M),
        )
    }
}

impl<T: Transmission<3>, B: BaseJoint> Finger<3, T, B> {
    /// The finger after the input link has turned on with a second contact at `k_m` on a phalanx, and where that is by then:
    /// posture, places and forces of both contacts. The contacts' forces are those without friction. `None` where the contacts
    /// leave no motion.
    pub fn turned_on(
        &self,
        pressed: &Pressed<3>,
        phalanx: u8,
        k_m: f32,
        measured: &SecondMeasured,
    ) -> Option<(Pressed<3>, f32)> {
        let index = |phalanx: u8| usize::from(phalanx).checked_sub(1).filter(|tip| *tip < 3);
        let first = pressed.contact.phalanx;
        let lengths_m = &self.parameters.lengths_m;
        let mut held = Held {
            tips: [index(first)?, index(phalanx)?],
            k_m: [pressed.k_now_m, k_m],
            off_m: pressed.off_m(phalanx, k_m),
        };
        let from = Configuration::of(pressed.joints_rad)?;
        let mut at = from;
        let piece_rad = measured.turned_rad / f32::from(PIECES);
        for _ in 0..PIECES {
            let step = |middle: &Configuration<3>, held: &Held, way_rad: f32| {
                let [a, b] = held.arms(lengths_m, &middle.turn());
                let v = cross(&a, &b);
                let lever = dot(&self.transmission.factors(middle)?.x, &v);
                let turned = v.map(|v| way_rad * v / lever);
                (turned.iter().all(|rad| rad.abs() < MOST_RAD)).then_some(turned)
            };
            let moved = |at: &Configuration<3>, held: &Held, turned: &[f32; 3]| {
                let slides = held.slides(lengths_m, &at.turn());
                let [a, b] = slides.map(|slide| dot(&slide, turned));
                let [k_a, k_b] = held.k_m;
                let to = at.advanced(&JointStep::of(*turned));
                (
                    to,
                    Held {
                        k_m: [k_a + a, k_b + b],
                        ..*held
                    },
                )
            };
            let half = step(&at, &held, 0.5 * piece_rad)?;
            let (middle, held_there) = moved(&at, &held, &half);
            let whole = step(&middle, &held_there, piece_rad)?;
            // The places move by what they do in the middle.
            let slides = held_there.slides(lengths_m, &middle.turn());
            let [k_a, k_b] = held.k_m;
            let [a, b] = slides.map(|slide| dot(&slide, &whole));
            held.k_m = [k_a + a, k_b + b];
            at = at.advanced(&JointStep::of(whole));
        }
        let gear = self.transmission.factors(&at)?;
        let gear_before = self.transmission.factors(&from)?;
        let before_nm = measured.torque_nm;
        let torque_nm = before_nm + measured.later_nm;
        let torques = self.equivalent_torques_nm(&gear, &at, torque_nm)?;
        let arms = held.arms(lengths_m, &at.turn());
        let [slides_a, slides_b] = held.slides(lengths_m, &at.turn());
        let [force_a, force_b] = forces(&arms, &torques);
        let [tip_a, tip_b] = held.tips;
        let before = added(
            pressed.force_n,
            &rubbing_arms(lengths_m, &pressed.turn, tip_a, held.off_m),
            tip_a,
        );
        let (by_a, by_b) = (
            added(force_a, &slides_a, tip_a),
            added(force_b, &slides_b, tip_b),
        );
        // H = K - T W + f P, from what it was when the second contact began.
        let mut stiffness = pressed.stiffness_nm_per_rad;
        for (m, row) in stiffness.iter_mut().enumerate() {
            for (n, h) in row.iter_mut().enumerate() {
                *h += before_nm * gear_before.w[m][n] - torque_nm * gear.w[m][n] - before[m][n]
                    + by_a[m][n]
                    + by_b[m][n];
            }
        }
        let [k_a, k_b] = held.k_m;
        let [arms_m, _] = arms;
        let turned = Pressed {
            k_now_m: k_a,
            force_n: force_a,
            joints_rad: at.rad(),
            x: gear.x,
            stiffness_nm_per_rad: stiffness,
            arms_m,
            turn: at.turn(),
            ..*pressed
        };
        Some((turned, k_b))
    }

    /// The compliance that a second contact at `k_m` on a phalanx shows where it was measured: some way after it, and rubbed.
    pub(super) fn shown(
        &self,
        pressed: &Pressed<3>,
        phalanx: u8,
        k_m: f32,
        measured: &SecondMeasured,
    ) -> Option<Rubbed> {
        let at_once = pressed.rubbed(phalanx, k_m, measured)?;
        if measured.turned_rad <= 0.0 {
            return Some(at_once);
        }
        let instant = pressed.second_compliance(phalanx, k_m)?;
        let Some((there, k_there_m)) = self.turned_on(pressed, phalanx, k_m, measured) else {
            return Some(at_once);
        };
        let rubbed = there.rubbed(phalanx, k_there_m, measured)?;
        let left = rubbed.compliance / instant;
        let is_known = left > 0.0 && left < MOST_LEFT;
        Some(if is_known {
            Rubbed { left, ..rubbed }
        } else {
            at_once
        })
    }
}
