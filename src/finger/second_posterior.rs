//! Where a second contact is, by how likely what was measured after it is with one at every place
//! (docs/SECOND_CONTACTS.md#posterior).
//!
//! Measured are the compliance some way after it, and how far the input link has turned until there: friction takes from both,
//! and the first contact's sliding, where it turns back, holds the finger for a while. The coefficient of friction and the first
//! contact's place are not known either: all three are summed over.

use super::rubbed::{LEAST_LEFT, Motion, TurningBack};
use super::{
    BaseJoint, Configuration, Contact, Finger, Free, Mechanics, Pressed, SecondMeasured,
    Transmission,
};
use crate::numeric::{Bounded, exp, sqrt};

/// Places along a phalanx.
const PLACES: u8 = 16;
/// Steps that these are spread over: all at once take longer than a sensing update may.
const PARTS: u8 = 2;
/// Steps for one phalanx and one place of the first contact: two find the posture, the others weigh the places.
const STEPS: u8 = 2 + PARTS;
/// Deviations of the coefficient of friction from its mean, with their weights: a normal distribution in steps of half a
/// deviation.
const FRICTIONS: [[f32; 2]; 8] = [
    [-1.5, 0.13],
    [-1.0, 0.24],
    [-0.5, 0.35],
    [0.0, 0.40],
    [0.5, 0.35],
    [1.0, 0.24],
    [1.5, 0.13],
    [2.0, 0.05],
];
/// The same of the first contact's place: five points of Gauss and Hermite.
const FIRSTS: [[f32; 2]; 5] = [
    [0.0, 0.533],
    [-1.356, 0.222],
    [1.356, 0.222],
    [-2.857, 0.0113],
    [2.857, 0.0113],
];
/// Deviation of two places' distances from the joint between them, as a share: objects are roundish (chosen).
const ROUND_SHARE: f32 = 0.15;
/// And of the first place's deviation, as a share, what the five points do not cover (chosen).
const FIRST_SHARE: f32 = 0.6;
/// Density of a normal variable at its mean, in units of its deviation.
const NORMAL_PEAK: f32 = 0.399;
/// A difference of neighbouring places counts as uniform.
const UNIFORM: f32 = 0.289;
/// What is measured after one contact in ten is off three times as far (chosen): the drive may go over to holding meanwhile, or
/// another contact follow. The share, and that variance.
const BAD_SHARE: f32 = 0.1;
const BAD_SIGMAS: f32 = 3.0;
const BAD: f32 = BAD_SIGMAS * BAD_SIGMAS;
/// Squares of deviations beyond which nothing is likely, nor less.
const HOPELESS: f32 = 60.0;

/// How likely what was measured is with a second contact on one phalanx, and where it is then.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Along {
    pub(super) phalanx: u8,
    /// Mean of the likelihood over the places, not normalised.
    pub(super) likely: f32,
    /// Sums of place and its square, weighted by that.
    k_m: f32,
    squares_m2: f32,
}

/// How likely each of the other phalanges is to be the second in contact, being summed up.
#[derive(Clone, Copy, Debug, Default)]
pub struct SecondWeights {
    along: [Along; 2],
    /// The finger on one place of the first contact, if it can be reached.
    there: Option<Pressed<3>>,
}

impl SecondWeights {
    /// The likelier phalanx, and the other.
    pub(super) fn ordered(&self) -> [Along; 2] {
        let [one, other] = self.along;
        if one.likely > other.likely {
            [one, other]
        } else {
            [other, one]
        }
    }
}

impl Along {
    fn add(&mut self, k_m: f32, likely: f32) {
        self.likely += likely;
        self.k_m += likely * k_m;
        self.squares_m2 += likely * k_m * k_m;
    }

    /// Mean and standard deviation of the place, metre.
    pub(super) fn place(&self, length_m: f32) -> [f32; 2] {
        let mean = self.k_m / self.likely;
        let variance = (self.squares_m2 / self.likely - mean * mean).at_least(0.0);
        let spacing = UNIFORM * length_m / f32::from(PLACES);
        [mean, sqrt(variance + spacing * spacing)]
    }
}

/// What a second contact at one place shows in one posture.
#[derive(Clone, Copy, Debug)]
struct Shown {
    /// Compliance without friction, radian per newton metre.
    compliance: f32,
    /// Share that contact friction with a coefficient of 1 takes of it.
    taken: f32,
    /// Share of the work that is carried to joints beyond the first.
    carried: f32,
}

/// What a second contact at one place would show.
#[derive(Clone, Copy, Debug)]
struct Expected {
    at_once: Shown,
    /// Where it was measured.
    there: Shown,
    /// Torque through which the finger sticks.
    stick_nm: f32,
    /// Joints that turn back.
    back: TurningBack,
}

impl<T: Transmission<3>, B: BaseJoint> Finger<3, T, B> {
    fn expected(
        &self,
        pressed: &Pressed<3>,
        phalanx: u8,
        k_m: f32,
        measured: &SecondMeasured,
    ) -> Option<Expected> {
        let half_m = measured.half_thickness_m;
        let motion = pressed.between(phalanx, k_m)?;
        let at_once = pressed.shown(&motion, phalanx, k_m, half_m)?;
        let there = (self.turned_on(pressed, phalanx, k_m, measured)).and_then(|(there, k_m)| {
            let motion = there.between(phalanx, k_m)?;
            there.shown(&motion, phalanx, k_m, half_m)
        });
        Some(Expected {
            at_once,
            there: there.unwrap_or(at_once),
            stick_nm: pressed.stick_nm(&motion, half_m)?,
            back: pressed.turning_back(&motion)?,
        })
    }

    /// Adds how likely the measurement is with a contact on a part of a phalanx.
    fn add_along(
        &self,
        along: &mut Along,
        part: u8,
        pressed: &Pressed<3>,
        weight: f32,
        measured: &SecondMeasured,
    ) {
        let phalanx = along.phalanx;
        let length_m = self.phalanx_length_m(phalanx).unwrap_or(0.0);
        let has_place = pressed.tells_place(phalanx);
        let places = if has_place { PLACES } else { 1 };
        let in_part = places.div_ceil(PARTS);
        let (first, end) = (part * in_part, ((part + 1) * in_part).min(places));
        let k_at_m = |place: u8| (f32::from(place) + 0.5) / f32::from(places) * length_m;
        let expected_at = |k_m: f32| {
            (pressed.second_presses(phalanx, k_m))
                .then(|| self.expected(pressed, phalanx, k_m, measured))
                .flatten()
        };
        let mut before = (first.checked_sub(1))
            .filter(|_| first < end)
            .and_then(|place| expected_at(k_at_m(place)))
            .map(|expected| expected.there.compliance);
        for place in first..end {
            let k_m = k_at_m(place);
            let expected = expected_at(k_m);
            if let Some(expected) = expected {
                let compliance = expected.there.compliance;
                let step = UNIFORM * (compliance - before.unwrap_or(compliance));
                let likely =
                    expected.likely(step, measured) * pressed.as_round(phalanx, k_m, measured);
                along.add(k_m, weight * likely / f32::from(places));
            }
            before = expected.map(|expected| expected.there.compliance);
        }
    }

    /// See [`HoldsTwice::weigh_second`](super::HoldsTwice::weigh_second): for each other phalanx and each place of the first contact the
    /// posture, the same on a cylinder that touches both, and the parts of the phalanx.
    pub(super) fn weigh_step(
        &self,
        at: &Free<Configuration<3>>,
        first: Contact,
        measured: &SecondMeasured,
        step: u8,
        weights: &mut SecondWeights,
    ) -> bool {
        let (step, whole) = (step % STEPS, usize::from(step / STEPS));
        let (index, of_first) = (whole % 2, whole / 2);
        let others = match first.phalanx {
            1 => [2, 3],
            2 => [1, 3],
            _ => [1, 2],
        };
        let (Some([deviations, weight]), Some(along), Some(&phalanx)) = (
            FIRSTS.get(of_first),
            weights.along.get_mut(index),
            others.get(index),
        ) else {
            return false;
        };
        along.phalanx = phalanx;
        if *deviations != 0.0 && measured.first_sigma_m <= 0.0 {
            return false;
        }
        let there = &mut weights.there;
        if step == 0 {
            *there = None;
        }
        let radius_m = match (step, &there) {
            (0, _) => Some(first.radius_m),
            // One cylinder touches both: how thick it is follows.
            (1, Some(there)) => there.round_m(phalanx),
            (2.., Some(there)) => {
                self.add_along(along, step - 2, there, *weight, measured);
                None
            }
            // Off the phalanx, or not to be reached: nothing is added.
            _ => None,
        };
        if let Some(radius_m) = radius_m {
            let first = Contact {
                k_m: first.k_m + deviations * measured.first_sigma_m,
                radius_m,
                ..first
            };
            if let Ok((pressed, _)) = self.pressed_on(at, first, measured) {
                *there = Some(pressed);
            }
        }
        // After the last step, too: what was found is asked for in an update of its own.
        true
    }
}

impl Pressed<3> {
    /// Computes what a second contact at `k_m` shows in this posture along the motion that it leaves.
    // Not inlined: called from two places.
    #[inline(never)]
    fn shown(
        &self,
        motion: &Motion,
        phalanx: u8,
        k_m: f32,
        half_thickness_m: f32,
    ) -> Option<Shown> {
        Some(Shown {
            compliance: self.second_compliance(phalanx, k_m)?,
            taken: self.rubbed_share(motion, half_thickness_m)?,
            carried: self.carried(motion),
        })
    }

    /// How likely a place is on a roundish object: on a cylinder both contacts are as far from the joint between their phalanges.
    /// Mean 1 over places far and near; 1 for phalanges that do not meet.
    // Inlined as well.
    #[inline(always)]
    fn as_round(&self, phalanx: u8, k_m: f32, measured: &SecondMeasured) -> f32 {
        let Some([near_m, _]) = self
            .between_joint(phalanx)
            .filter(|_| self.tells_place(phalanx))
        else {
            return 1.0;
        };
        let length_m = (self.lengths_m.get(usize::from(phalanx).saturating_sub(1))).copied();
        let (uneven, unsure) = (ROUND_SHARE * near_m, FIRST_SHARE * measured.first_sigma_m);
        let sigma_m = sqrt(uneven * uneven + unsure * unsure);
        let off = (self.near_joint(phalanx, k_m) - near_m) / sigma_m;
        let peak = NORMAL_PEAK * length_m.unwrap_or(sigma_m) / sigma_m;
        peak * exp(-0.5 * (off * off).at_most(HOPELESS))
    }
}

impl Expected {
    /// Probability density of the measurement; `step` is what the compliance changes by from place to place.
    // Inlined: it is called in one place.
    #[inline(always)]
    fn likely(&self, step: f32, measured: &SecondMeasured) -> f32 {
        let [mean, deviation] = measured.friction;
        let Self {
            at_once,
            there,
            back,
            ..
        } = self;
        let [joint_nm, joint_sigma_nm] = measured.joint_friction_nm;
        let [loss, loss_sigma] = measured.joint_loss;
        let carried_nm = back.share * measured.torque_nm;
        let held_nm = joint_nm * back.turned + loss * carried_nm;
        let held_sigma_nm = {
            let (of_joints, of_losses) = (joint_sigma_nm * back.turned, loss_sigma * carried_nm);
            sqrt(of_joints * of_joints + of_losses * of_losses)
        };
        let mut sum = 0.0;
        for [deviations, weight] in FRICTIONS {
            let friction = mean + deviations * deviation;
            // There is none below zero.
            if friction < 0.0 {
                continue;
            }
            let left = |of: &Shown| {
                let share = 1.0 - friction * of.taken - loss * of.carried;
                of.compliance * share.at_least(LEAST_LEFT)
            };
            let compliance = left(there);
            let moves_nm = (measured.later_nm - friction * self.stick_nm - held_nm).at_least(0.0);
            let mean = 0.5 * (left(at_once) + compliance);
            let turned = moves_nm * mean;
            // The lever enters twice, as torque and as rotation.
            let lever = 2.0 * measured.leverage_sigma * at_once.carried;
            let lost = loss_sigma * there.carried;
            let unsure = lever * lever + lost * lost;
            let variance = |own: f32, expected: f32| own * own + unsure * expected * expected;
            let of_compliance =
                variance(measured.compliance_sigma_rad_per_nm, compliance) + step * step;
            let off = measured.compliance_rad_per_nm - compliance;
            let mut squares = off * off / of_compliance;
            let (mut scale, mut bad_share) = (of_compliance, BAD_SHARE / BAD_SIGMAS);
            if measured.later_nm > 0.0 {
                let held = held_sigma_nm * mean;
                let of_turned = variance(measured.turned_sigma_rad, turned) + held * held;
                let off = measured.turned_rad - turned;
                squares += off * off / of_turned;
                scale *= of_turned;
                bad_share /= BAD_SIGMAS;
            }
            let squares = 0.5 * squares.at_most(HOPELESS);
            let likely = exp(-squares) + bad_share * exp(-squares / BAD);
            sum += weight * likely / sqrt(scale.at_least(f32::MIN_POSITIVE));
        }
        sum
    }
}
