//! The model: the excess torque that a hypothesis predicts at the measured angles, with its derivatives.
//!
//! The measured angle is almost without noise, so the torque is predicted from it and not the other way round. With y the
//! excess of the nominal torque over that of the free finger, F the free finger's torque and T = f y + F,
//!
//! angle = o + rotation(T - T_c; k, R) + c ((T - T_c) / f + g L - s B)
//!
//! holds along the contact path, o, T_c being angle and torque at the onset, c the cable's twist for a nominal torque, g the
//! share of it that creeps, L the torque delayed by the creep's time constant, s the cable's stiffening and B the decrease of the
//! twist per unit of s, zero at the torque at which c is given. The path is followed to a torque near the solution (the previous
//! prediction plus the measured increment) and corrected by its slope there. Before the onset y is zero. Where losses on the way to the
//! joints are fitted, the rotation is that of the path, which has the expected share, plus what is lost more times its derivative by
//! the share, or of a finger that is held at a stop the integral of the compliance's.

mod prediction;

use super::prior::{
    BEND, CABLE, FACTOR, FRICTION, GIVE, JOINT, K, LOSS, ONSET, Of, Prior, UNKNOWNS, Values,
    fits_loss,
};
use crate::finger::{Contact, Free, JointPoint, Mechanics, PathPoint};
use crate::numeric::{Bounded, clamp};
use crate::sensing::calibration::MIDDLE_NM;
use crate::sensing::curve::Point;
use crate::sensing::normal::Unknowns;
use crate::sensing::{Drivetrain, SeriesElement};
use core::marker::PhantomData;
use prediction::{NOTHING, Prediction};

/// Smallest torque rise to which a path is followed, newton metre: its derivatives vanish at the onset.
const LEAST_RISE_NM: f32 = 5e-4;
/// Largest distance of the path's end from the measured torque, as a share of it and in newton metre.
const STRAY_SHARE: f32 = 0.5;
const STRAY_NM: f32 = 0.02;
/// Standard deviation of a measured angle from any model, radian: four counts of the encoder's periodic error, and as much again.
const ANGLE_SIGMA_RAD: f32 = 4e-5;
/// Error of a prediction beyond the end of the path, as a share of the distance from it.
const BEYOND_SHARE: f32 = 0.2;
/// Error of a force there, as a share of what the torque would add.
const BEYOND_FORCE: f32 = 0.5;

/// Newton's method ends after a step below this share of the torque.
const ARRIVED_SHARE: f32 = 1e-3;

/// What holds the input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hold {
    /// A contact on a phalanx, k in physical values.
    Contact { phalanx: u8, radius_m: f32 },
    /// A contact on the proximal phalanx, without a place.
    Proximal,
    /// The closing stop.
    Stop,
}

/// Prediction along one curve. It borrows nothing, because a pass over a curve is interrupted between points.
#[derive(Clone, Debug)]
pub(super) struct Model<F: Mechanics, X> {
    values: Values,
    origin_rad: f32,
    rad_per_count: f32,
    creep: f32,
    /// None while the cable alone gives way.
    path: Option<F::Path>,
    contact_nm: f32,
    /// Derivative of `contact_nm` by the measured angle of the onset.
    contact_by_onset: f32,
    /// Measured and predicted excess at the previous point.
    before_nm: [f32; 2],
    /// The last point of the path.
    last: PathPoint,
    last_torque_nm: f32,
    /// Integral over the torque of the compliance's derivative by what is lost on the way to the joints, radian; only of a finger that is
    /// held at a stop.
    lost_rad: f32,
    /// Torque of the last prediction.
    torque_nm: f32,
    ended: bool,
    series: PhantomData<X>,
}

impl<F: Mechanics, X: SeriesElement> Model<F, X> {
    /// The model of a hypothesis; None where there is no such contact. `onset` is the free finger there.
    pub(super) fn new(
        finger: &F,
        (origin_rad, drivetrain): (f32, &Drivetrain),
        values: &Values,
        prior: &Prior<X>,
        hold: Hold,
        onset: &Free<F::Configuration>,
    ) -> Option<Self> {
        let contact = match hold {
            Hold::Contact { phalanx, radius_m } => Some(Contact {
                phalanx,
                k_m: values[K],
                radius_m,
            }),
            Hold::Proximal => Some(Contact {
                phalanx: 1,
                k_m: 0.5 * finger.phalanx_length_m(1)?,
                radius_m: 0.0,
            }),
            Hold::Stop => None,
        };
        let at = &onset.configuration;
        let path = match contact {
            Some(contact) => {
                let mut path = finger.path(at, onset.torque_nm, contact)?;
                finger.load(&mut path, prior.weight, prior.held_nm);
                if X::OBJECT_GIVES {
                    finger.soften(&mut path, values[GIVE])?;
                }
                finger.lose(&mut path);
                finger.brake(&mut path, values[JOINT]);
                finger.rub(&mut path, values[FRICTION], prior.half_thickness_m)?;
                Some(path)
            }
            None => None,
        };
        let twist = if X::FLEXIBLE {
            values[CABLE] / values[FACTOR]
        } else {
            0.0
        };
        let contact_by_onset = finger
            .free_compliance(at, onset.torque_nm)
            .map_or(0.0, |free| 1.0 / (free + twist));
        Some(Self {
            values: *values,
            origin_rad,
            rad_per_count: drivetrain.rad_per_count,
            creep: drivetrain.creep,
            path,
            contact_nm: onset.torque_nm,
            contact_by_onset,
            before_nm: [0.0; 2],
            last: PathPoint::default(),
            last_torque_nm: 0.0,
            lost_rad: 0.0,
            torque_nm: 0.0,
            ended: false,
            series: PhantomData,
        })
    }

    /// Whether the contact has slid off its phalanx.
    pub(super) fn has_ended(&self) -> bool {
        self.ended
    }

    /// The end of the path so far.
    pub(super) fn end(&self) -> &PathPoint {
        &self.last
    }

    /// The next point, by rising angle.
    pub(super) fn next(&mut self, finger: &F, point: &Point) -> Option<Prediction> {
        let angle_rad = self.origin_rad + point.counts * self.rad_per_count;
        let past_rad = angle_rad - self.values[ONSET];
        let half_rad = 0.5 * point.width_counts * self.rad_per_count;
        // Before the contact.
        if past_rad <= -half_rad {
            self.before_nm = [point.excess_nm, 0.0];
            return Some(NOTHING);
        }
        let [measured_nm, predicted_nm] = self.before_nm;
        let stray_nm = STRAY_SHARE * point.excess_nm.abs() + STRAY_NM;
        let near_nm = (predicted_nm + point.excess_nm - measured_nm)
            .at_least(point.excess_nm - stray_nm)
            .at_most(point.excess_nm + stray_nm);
        let mut prediction = self.on_path(finger, past_rad, near_nm, point)?;
        self.before_nm = [point.excess_nm, prediction.excess_nm];
        if !X::FLEXIBLE && past_rad < half_rad {
            prediction.begin_with_step(past_rad, half_rad);
            self.before_nm[1] = prediction.excess_nm;
            return Some(prediction);
        }
        // Part of the point may lie before the contact: take the mean of a ramp over it. With a cable the torque always grows from 0.
        let steepness = prediction.steepness(half_rad);
        let share = 0.5 * (1.0 + prediction.excess_nm / steepness);
        if share < 1.0 {
            let share = share.at_least(0.0);
            prediction.excess_nm = steepness * share * share;
            for slope in &mut prediction.slopes {
                *slope *= share;
            }
            self.before_nm[1] = prediction.excess_nm;
        }
        Some(prediction)
    }

    /// The contact path at an angle beyond the onset; `near_nm` is an approximation of the result.
    fn on_path(
        &mut self,
        finger: &F,
        past_rad: f32,
        near_nm: f32,
        point: &Point,
    ) -> Option<Prediction> {
        let values = &self.values;
        let factor = values[FACTOR];
        let least_nm = self.contact_nm + LEAST_RISE_NM;
        let mut torque_nm = (factor * near_nm + point.free_nm).at_least(least_nm);
        self.torque_nm = torque_nm;
        if let Some(path) = &mut self.path
            && !self.ended
        {
            match finger.follow(path, torque_nm - self.contact_nm) {
                Some(last) => {
                    if fits_loss::<F, X>() && F::HOLDS {
                        let from_nm = self.last_torque_nm.at_least(self.contact_nm);
                        let [by_loss, now] =
                            [&self.last, &last].map(|point| point.compliance_by_loss_rad_per_nm);
                        let mean = if self.last_torque_nm > 0.0 {
                            0.5 * (by_loss + now)
                        } else {
                            now
                        };
                        self.lost_rad += mean * (torque_nm - from_nm);
                    }
                    self.last = last;
                    self.last_torque_nm = torque_nm;
                }
                // The contact has slid to the tip: the curve is continued with its last slope. One whose joints have not turned has none.
                None if self.last.rotation_rad > 0.0 => self.ended = true,
                None => return None,
            }
        }
        let mut variance_nm2 = 0.0;
        if self.ended {
            let beyond_nm = BEYOND_SHARE * (torque_nm - self.last_torque_nm) / factor;
            variance_nm2 = beyond_nm * beyond_nm;
            torque_nm = self.last_torque_nm;
            self.torque_nm = factor * point.excess_nm + point.free_nm; // it may fall
        }
        let at = &self.last;
        let mut rotation_rad = at.rotation_rad;
        let mut compliance = at.compliance_rad_per_nm;
        if fits_loss::<F, X>() {
            // What is lost beyond the share that the path takes off.
            let more = values[LOSS] - F::JOINT_LOSS[0];
            rotation_rad += more * self.lost_rad();
            compliance = (compliance + more * at.compliance_by_loss_rad_per_nm).at_least(0.0);
        }
        let held_nm = (torque_nm - self.contact_nm) / factor;
        let (mut twisting_nm, mut cable, mut bent_nm2) = (0.0, 0.0, 0.0);
        if X::FLEXIBLE {
            // Nominal torque about the one at which the cable's twist is given.
            let about_nm = torque_nm / factor - MIDDLE_NM;
            bent_nm2 = held_nm * (about_nm - 0.5 * held_nm);
            twisting_nm = held_nm - values[BEND] * bent_nm2 + self.creep * point.late_nm;
            cable = values[CABLE] * (1.0 - values[BEND] * about_nm);
        }
        let near_nm = (torque_nm - point.free_nm) / factor;
        let missing_rad = past_rad - values[CABLE] * twisting_nm;
        // What holds the joints, at their stops or against turning back, holds the finger until a break-away torque, and below it only the
        // cable twists. Test for that: assume that the cable takes the whole angle, and ask whether the finger would turn at the torque
        // which that needs.
        let own = factor * compliance;
        let (mut gives, mut bent_nm) = (1.0, 0.0);
        if X::FLEXIBLE && cable > 0.0 {
            let turns_rad = rotation_rad + own * (missing_rad / cable);
            // Predict the mean over the point's way, which is what was measured: that of two straight lines where the finger breaks away
            // within it (docs/SENSING.md#torque-that-holds-the-joints). Leave out a way before the onset, and as much at the other end.
            let half_rad = 0.5 * point.width_counts * self.rad_per_count;
            let half_rad = half_rad.at_most(past_rad).at_least(0.0);
            // Fingers without a break-away torque of their own leave the stop in their first, narrow points.
            let half_rad = if F::HOLDS { half_rad } else { 0.0 };
            let way_rad = own * half_rad + f32::MIN_POSITIVE;
            let moves = clamp(0.5 + 0.5 * turns_rad * cable / way_rad, 0.0, 1.0);
            let both = own + cable;
            gives = moves * cable / (moves * cable + (1.0 - moves) * both);
            bent_nm = moves * (1.0 - moves) * way_rad / (cable * both);
        }
        let compliance = gives * compliance;
        // Radian per newton metre of excess.
        let slope = factor * compliance + cable;
        let excess_nm = near_nm + (missing_rad - gives * rotation_rad) / slope - bent_nm;
        let angle_nm = ANGLE_SIGMA_RAD / slope;
        variance_nm2 += angle_nm * angle_nm;
        let mut slopes = [0.0; UNKNOWNS];
        slopes[K] = gives * at.rotation_by_k_rad_per_m;
        slopes[ONSET] = 1.0 - self.contact_by_onset * (compliance + cable / factor);
        slopes[FRICTION] = gives * at.rotation_by_friction_rad;
        slopes[JOINT] = gives * at.rotation_by_joint_friction_rad_per_nm;
        slopes[FACTOR] =
            compliance * excess_nm - cable * (point.free_nm - self.contact_nm) / (factor * factor);
        slopes[CABLE] = twisting_nm;
        slopes[BEND] = -values[CABLE] * bent_nm2;
        if X::OBJECT_GIVES {
            slopes[GIVE] = gives * at.rotation_by_give_rad_n_per_m;
        }
        if fits_loss::<F, X>() {
            slopes[LOSS] = gives * self.lost_rad();
        }
        for slope_of in slopes
            .iter_mut()
            .take(const { UNKNOWNS - Of::<F, X>::MISSING })
        {
            *slope_of /= -slope;
        }
        excess_nm.is_finite().then_some(Prediction {
            excess_nm,
            slopes,
            variance_nm2,
        })
    }

    /// Derivative of the rotation by what is lost on the way to the joints, radian.
    fn lost_rad(&self) -> f32 {
        if F::HOLDS {
            self.lost_rad
        } else {
            self.last.rotation_by_loss_rad
        }
    }

    /// Joint 2 at the end of the path, with its change since the onset at a torque near to the one there and the friction of the joints;
    /// none without a contact. A contact that has slid off its phalanx turns the joint no further, and a finger that is held not at all.
    pub(super) fn joint_2(&self, finger: &F, torque_nm: f32) -> Option<JointPoint> {
        let mut joint = finger.joint_2(self.path.as_ref()?)?;
        if self.last.rotation_rad < 0.0 {
            return Some(JointPoint {
                at_contact_rad: joint.at_contact_rad,
                ..JointPoint::default()
            });
        }
        if self.ended {
            joint.by_torque_rad_per_nm = 0.0;
        }
        // No point of the curve may have reached the path.
        let followed_nm = self.last_torque_nm.at_least(self.contact_nm);
        joint.rad += joint.by_torque_rad_per_nm * (torque_nm - followed_nm);
        Some(joint)
    }

    /// Derivative of the torque at the onset by the measured angle there.
    pub(super) fn contact_by_onset(&self) -> f32 {
        self.contact_by_onset
    }

    /// Contact force at the end of the path, newton.
    pub(super) fn force_n(&self) -> f32 {
        self.last.force_n * self.share()
    }

    /// Its derivative by the coefficient of contact friction, newton.
    pub(super) fn force_by_friction_n(&self) -> f32 {
        self.last.force_by_friction_n * self.share()
    }

    /// Error of the force, newton: beyond the end of the path the contact may stay at the tip, with a force that grows with the
    /// torque, or slide over it.
    pub(super) fn force_sigma_n(&self) -> f32 {
        BEYOND_FORCE * self.last.force_n * (self.share() - 1.0).at_least(0.0)
    }

    /// Rise of the torque since the onset over that at the end of the path: a contact begins without force whatever torque
    /// holds the free finger.
    fn share(&self) -> f32 {
        let rise_nm = self.torque_nm - self.contact_nm;
        (rise_nm / (self.last_torque_nm - self.contact_nm)).at_least(0.0)
    }

    /// Follows the path to a measured angle after the last point: the end is where the finger is then.
    pub(super) fn follow_to(&mut self, finger: &F, angle_rad: f32, last: &Point) -> Option<()> {
        let past_rad = angle_rad - self.values[ONSET];
        let [measured_nm, predicted_nm] = self.before_nm;
        let mut near_nm = predicted_nm + last.excess_nm - measured_nm;
        for _ in 0..5 {
            let before_nm = near_nm;
            near_nm = self.on_path(finger, past_rad, near_nm, last)?.excess_nm;
            // Newton's method: the next step is about the square of this one.
            if (near_nm - before_nm).abs() <= ARRIVED_SHARE * near_nm {
                break;
            }
        }
        Some(())
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests;
