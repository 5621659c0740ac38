//! A finger that touches with two phalanges: which one the second is, where, and the forces as far as statics determines them
//! (docs/SECOND_CONTACTS.md#two-contacts). The questions are the same for two and three phalanges ([`HoldsTwice`]).

use super::statics::rubbing_arms;
use super::{
    BaseJoint, Configuration, Contact, Finger, Free, JointStep, MAX_PHALANGES, Mechanics, Path,
    Pressed, SecondMeasured, SecondWeights, Transmission,
};
use crate::numeric::{Bounded, dot, exp};
use core::fmt::Debug;

/// Nearer than this to the closing stop of a joint, radian, a stiffer finger stands at the stop: two deviations of the posture, which is off
/// by 0.054 in the 13 single contacts of `tendon3` that end there.
const STOP_MARGIN_RAD: f32 = 0.1;
/// One over the variance of the logarithm of the share of the torque that acts along the path of the first contact (chosen): friction
/// takes more or less of it than its mean.
const TAKEN_WEIGHT: f32 = 1.0;
/// Points of that path until the logarithm is found, and how much it may change from one to the next.
const POINTS: u8 = 4;
const MOST_STEP: f32 = 0.7;
/// Odds from which on a phalanx is named (chosen).
const DECISIVE_ODDS: f32 = 4.0;
/// Deviation of a place, as a share of the phalanx, above which none is told: it is hardly less than that of any place (0.29).
pub(crate) const VAGUE: f32 = 0.25;

/// The finger when a second contact begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoContacts<C> {
    /// The first contact, where it is by now; `k_m` is NaN where that is too vague.
    pub first: Contact,
    /// Phalanx of the second contact.
    pub phalanx: u8,
    /// Its distance from the phalanx's joint, metre; NaN where the stiffness does not depend on it.
    pub k_m: f32,
    /// Standard deviation of `k_m`; NaN as that.
    pub sigma_m: f32,
    /// Posture then.
    pub configuration: C,
    /// Torque at the input link then, newton metre.
    pub torque_nm: f32,
    /// Change of the joints' angles for a unit of torque from then on, radian per newton metre: zero with two phalanges.
    pub turning_per_nm: [f32; MAX_PHALANGES],
    /// Distance of the object's centre from the axes of the phalanges, metre.
    pub off_m: f32,
}

/// What statics determines of two contacts, at one torque. NaN where it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldForces {
    /// f k of the contact on the last phalanx about its own joint, newton metre.
    pub distal_moment_nm: f32,
    /// Its force, newton: needs its place.
    pub distal_force_n: f32,
    /// Of a two-phalanx finger, f k of the proximal contact about joint 1, newton metre: needs the distal place.
    pub proximal_moment_nm: f32,
}

impl HeldForces {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self {
        distal_moment_nm: f32::NAN,
        distal_force_n: f32::NAN,
        proximal_moment_nm: f32::NAN,
    };

    /// With springs that are so many times as stiff.
    #[must_use]
    pub fn scaled(self, by: f32) -> Self {
        Self {
            distal_moment_nm: by * self.distal_moment_nm,
            distal_force_n: by * self.distal_force_n,
            proximal_moment_nm: by * self.proximal_moment_nm,
        }
    }
}

/// What is kept between the steps of weighing where a second contact may be.
#[derive(Clone, Copy, Debug)]
pub struct Weighing<C> {
    /// What the finger is asked: the free posture in which the first contact was made, that contact, and what was measured.
    pub asked: Option<(Free<C>, Contact, SecondMeasured)>,
    /// What the steps so far found.
    pub weights: SecondWeights,
    /// How many they were.
    pub step: u8,
}

impl<C> Default for Weighing<C> {
    fn default() -> Self {
        Self {
            asked: None,
            weights: SecondWeights::default(),
            step: 0,
        }
    }
}

/// [`Weighing`], or nothing where there is nothing to weigh.
pub trait Weighs<C>: Clone + Debug + Default {
    /// What is kept, if anything.
    fn kept(&mut self) -> Option<&mut Weighing<C>>;
}

impl<C> Weighs<C> for () {
    fn kept(&mut self) -> Option<&mut Weighing<C>> {
        None
    }
}

impl<C: Copy + Debug> Weighs<C> for Weighing<C> {
    fn kept(&mut self) -> Option<&mut Self> {
        Some(self)
    }
}

/// Why a stiffer finger is not told as two contacts in a posture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoSecondContact {
    /// A joint stands at its closing stop: that is what makes it stiffer.
    AtStop,
    /// The first contact leads to no posture at that torque, or nothing on the finger is so stiff.
    Unexplained,
}

/// What sensing asks of a finger that touches with two phalanges.
pub trait HoldsTwice: Mechanics {
    /// Whether the curve of a contact on phalanx 1 is a straight line ([`Transmission::CONSTANT`]).
    const STRAIGHT: bool;

    /// What is kept between the steps of weighing: [`Weighing`], or nothing.
    type Weighing: Weighs<Self::Configuration>;

    /// Weighs where a second contact may be by the stiffness that it leaves, one step a call: begin with step 0 and default weights. The
    /// first contact was made in the free posture `at`. False where there is no further step.
    fn weigh_second(
        &self,
        _at: &Free<Self::Configuration>,
        _first: Contact,
        _measured: &SecondMeasured,
        _step: u8,
        _weights: &mut SecondWeights,
    ) -> bool {
        false
    }

    /// Phalanx and place of a second contact that was weighed.
    ///
    /// # Errors
    /// Why there are no two contacts in a posture.
    fn weighed_second(
        &self,
        at: &Free<Self::Configuration>,
        first: Contact,
        measured: &SecondMeasured,
        weights: &SecondWeights,
    ) -> Result<TwoContacts<Self::Configuration>, NoSecondContact>;

    /// Both at once.
    ///
    /// # Errors
    /// As [`weighed_second`](Self::weighed_second).
    fn second_contact(
        &self,
        at: &Free<Self::Configuration>,
        first: Contact,
        measured: &SecondMeasured,
    ) -> Result<TwoContacts<Self::Configuration>, NoSecondContact> {
        let (mut weights, mut step) = (SecondWeights::default(), 0);
        while self.weigh_second(at, first, measured, step, &mut weights) {
            step += 1;
        }
        self.weighed_second(at, first, measured, &weights)
    }

    /// Forces at a torque, when the input link has turned by `way_rad` since the second contact, radian, the cable's twist not counted.
    fn held_forces(
        &self,
        held: &TwoContacts<Self::Configuration>,
        torque_nm: f32,
        way_rad: f32,
    ) -> HeldForces;
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// The finger on its first contact when the second one begins.
    // Not inlined: called from several places.
    #[inline(never)]
    pub(super) fn pressed_on(
        &self,
        at: &Free<Configuration<N>>,
        first: Contact,
        measured: &SecondMeasured,
    ) -> Result<(Pressed<N>, Configuration<N>), NoSecondContact> {
        let led = || {
            let mut path = self.start(&at.configuration, at.torque_nm, first)?;
            let [friction, _] = measured.friction;
            if measured.joint_loss[0] > 0.0 {
                Self::loses(&mut path);
            }
            self.rubs(&mut path, friction, measured.half_thickness_m)?;
            self.follow_measured(&mut path, measured)?;
            path.slip();
            let pressed = self.pressed(&path)?;
            Some((pressed, Configuration::of(pressed.joints_rad)?))
        };
        let (pressed, configuration) = led().ok_or(NoSecondContact::Unexplained)?;
        let ranges = self.parameters.range_rad.iter();
        let mut beyond_first = pressed.joints_rad.iter().zip(ranges).skip(1);
        if beyond_first.any(|(rad, [_, stop_rad])| *rad > stop_rad - STOP_MARGIN_RAD) {
            return Err(NoSecondContact::AtStop);
        }
        Ok((pressed, configuration))
    }

    /// Follows the path of the first contact to the second, to the likeliest point by rotation and torque: on an object that stands
    /// the posture follows from the rotation, whatever friction takes of the torque, but where the finger hardly turns any more the
    /// torque knows better.
    fn follow_measured(&self, path: &mut Path<N, B>, measured: &SecondMeasured) -> Option<()> {
        let (mut rise_nm, mut taken, mut led) = (measured.rise_nm, 0.0, None);
        for _ in 0..POINTS {
            let mut step = -MOST_STEP;
            if let Some(point) = self.continue_to(path, rise_nm) {
                let off =
                    (measured.rotation_rad - point.rotation_rad) / measured.rotation_sigma_rad;
                // In units of the deviation, and by the logarithm of the share.
                let slope = point.compliance_rad_per_nm * rise_nm / measured.rotation_sigma_rad;
                step = (slope * off - taken * TAKEN_WEIGHT) / (slope * slope + TAKEN_WEIGHT);
                led = Some(());
            } else if led.is_some() {
                // Off the phalanx: the last point is the best there is.
                break;
            }
            taken += step.at_least(-MOST_STEP).at_most(MOST_STEP);
            rise_nm = measured.rise_nm * exp(taken);
        }
        led
    }
}

impl<T: Transmission<2>, B: BaseJoint> HoldsTwice for Finger<2, T, B> {
    const STRAIGHT: bool = T::CONSTANT;

    /// Two phalanges hold each other, wherever the second contact is.
    type Weighing = ();

    fn weighed_second(
        &self,
        at: &Free<Configuration<2>>,
        first: Contact,
        measured: &SecondMeasured,
        _: &SecondWeights,
    ) -> Result<TwoContacts<Configuration<2>>, NoSecondContact> {
        let (pressed, configuration) = self.pressed_on(at, first, measured)?;
        Ok(TwoContacts {
            first: Contact {
                k_m: pressed.k_now_m,
                ..first
            },
            phalanx: if first.phalanx == 1 { 2 } else { 1 },
            k_m: f32::NAN,
            sigma_m: f32::NAN,
            configuration,
            torque_nm: at.torque_nm + measured.rise_nm,
            turning_per_nm: [0.0; MAX_PHALANGES],
            off_m: first.radius_m,
        })
    }

    fn held_forces(
        &self,
        held: &TwoContacts<Configuration<2>>,
        torque_nm: f32,
        _: f32,
    ) -> HeldForces {
        let distal = (held.first.phalanx == 2).then_some(held.first.k_m);
        let known = self.held_by_both(&held.configuration, torque_nm, distal);
        known.map_or(HeldForces::UNKNOWN, |known| HeldForces {
            distal_moment_nm: known.distal_moment_nm,
            distal_force_n: known.distal_force_n.unwrap_or(f32::NAN),
            proximal_moment_nm: known.proximal_moment_nm.unwrap_or(f32::NAN),
        })
    }
}

impl<T: Transmission<3>, B: BaseJoint> HoldsTwice for Finger<3, T, B> {
    const STRAIGHT: bool = T::CONSTANT;

    type Weighing = Weighing<Configuration<3>>;

    fn weigh_second(
        &self,
        at: &Free<Configuration<3>>,
        first: Contact,
        measured: &SecondMeasured,
        step: u8,
        weights: &mut SecondWeights,
    ) -> bool {
        self.weigh_step(at, first, measured, step, weights)
    }

    /// The phalanges compete by how likely what was measured is with a contact anywhere on each.
    fn weighed_second(
        &self,
        at: &Free<Configuration<3>>,
        first: Contact,
        measured: &SecondMeasured,
        weights: &SecondWeights,
    ) -> Result<TwoContacts<Configuration<3>>, NoSecondContact> {
        let (pressed, configuration) = self.pressed_on(at, first, measured)?;
        let [best, next] = weights.ordered();
        if best.likely < DECISIVE_ODDS * next.likely {
            // Either would do: that is no answer.
            return Err(NoSecondContact::Unexplained);
        }
        let (likely, phalanx) = (best.likely, best.phalanx);
        let length_m = self.phalanx_length_m(phalanx).unwrap_or(f32::MAX);
        let [mut k_m, mut sigma_m] = best.place(length_m);
        // A first place that is as vague gives no second one, whose deviation would be too small, and no force.
        let first_length_m = self.phalanx_length_m(first.phalanx).unwrap_or(0.0);
        let is_first_known = measured.first_sigma_m <= VAGUE * first_length_m;
        let is_sharp = k_m.is_finite() && sigma_m <= VAGUE * length_m;
        if !(is_first_known && is_sharp && pressed.tells_place(phalanx)) {
            (k_m, sigma_m) = (f32::NAN, f32::NAN);
        }
        // Where the place does not matter any place leaves the same motion; one that is not known may be the middle.
        let k_any_m = match self.phalanx_length_m(phalanx) {
            Some(length_m) if k_m.is_nan() => 0.5 * length_m,
            _ => k_m,
        };
        let turning_per_nm =
            (pressed.between(phalanx, k_any_m)).and_then(|motion| motion.turning_per_nm());
        let turning_per_nm = turning_per_nm
            .filter(|_| likely > 0.0)
            .ok_or(NoSecondContact::Unexplained)?;
        Ok(TwoContacts {
            first: Contact {
                k_m: if is_first_known {
                    pressed.k_now_m
                } else {
                    f32::NAN
                },
                ..first
            },
            phalanx,
            k_m,
            sigma_m,
            configuration,
            torque_nm: at.torque_nm + measured.rise_nm,
            turning_per_nm,
            off_m: pressed.off_m(phalanx, k_any_m),
        })
    }

    fn held_forces(
        &self,
        held: &TwoContacts<Configuration<3>>,
        torque_nm: f32,
        way_rad: f32,
    ) -> HeldForces {
        let distal_k_m = if held.first.phalanx == 3 {
            held.first.k_m
        } else if held.phalanx == 3 {
            held.k_m
        } else {
            return HeldForces::UNKNOWN;
        };
        // Derive the motion from the way of the input link, because the compliance falls on the way; the compliance at the second contact
        // bounds it.
        let gear = self.transmission.factors(&held.configuration);
        let turned_rad = gear.map_or(0.0, |gear| dot(&gear.x, &held.turning_per_nm));
        let rise_nm = (way_rad / turned_rad).at_most(torque_nm - held.torque_nm);
        let turned = held.turning_per_nm.map(|turning| turning * rise_nm);
        // The contact rolls along the phalanx.
        let half = JointStep::of(turned.map(|turned| 0.5 * turned));
        let middle = held.configuration.advanced(&half).turn();
        let slides = rubbing_arms(&self.parameters.lengths_m, &middle, 2, held.off_m);
        let distal_k_m = distal_k_m + dot(&slides, &turned);
        let at = held.configuration.advanced(&JointStep::of(turned));
        let torques = (self.transmission.factors(&at))
            .and_then(|gear| self.equivalent_torques_nm(&gear, &at, torque_nm));
        torques.map_or(HeldForces::UNKNOWN, |[_, _, tau_3]| HeldForces {
            distal_moment_nm: tau_3,
            distal_force_n: tau_3 / distal_k_m,
            proximal_moment_nm: f32::NAN,
        })
    }
}
