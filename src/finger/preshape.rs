//! The free finger: preshaping (6) and its stiffness (7).

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::{BaseJoint, Configuration, Finger, Free, JointStep, Transmission, TransmissionFactors};
use crate::numeric::{Bounded, dot, solve};

/// Newton steps: from the last sample two are enough, from rest ten.
const STEPS: u8 = 24;
/// Largest change of a joint angle in one Newton step, radian: keeps a start far away on the branch it came from.
const STRIDE_RAD: f32 = 0.25;
/// A step this small, over one radian or the largest angle, is the rounding of the angles.
const SETTLED_SHARE: f32 = 3e-7;
/// A step this small may be rounding, if it no longer shrinks.
const NOISE_SHARE: f32 = 3e-5;

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// H = K - T_a W - dg/dtheta, the stiffness seen by the joints (docs/MECHANICS.md#transmission, docs/FINGERS.md#weight).
    pub(crate) fn hessian(
        &self,
        at: &Configuration<N>,
        gear: &TransmissionFactors<N>,
        torque_nm: f32,
    ) -> [[f32; N]; N] {
        let mut h = gear.w;
        for i in 0..N {
            for j in 0..N {
                h[i][j] *= -torque_nm;
            }
            h[i][i] += self.parameters.stiffness_nm_per_rad[i];
        }
        if let Some(cable) = self.base.return_cable() {
            let lever: [f32; N] = cable.factors();
            for i in 0..N {
                for j in 0..N {
                    h[i][j] += cable.stiffness_nm_per_rad * lever[i] * lever[j];
                }
            }
        }
        if let Some(weight) = self.base.weight() {
            let borne = weight.borne(at);
            for i in 0..N {
                for j in 0..N {
                    h[i][j] += borne[i.max(j)].along;
                }
            }
        }
        h
    }

    /// Change of the joint angles for residual torques and for a unit of input torque: H^-1 tau and H^-1 x. Without a
    /// spring joint 1 does not move.
    fn response(
        &self,
        at: &Configuration<N>,
        gear: &TransmissionFactors<N>,
        torque_nm: f32,
        tau: [f32; N],
    ) -> Option<[[f32; N]; 2]> {
        let (mut h, mut sides) = (self.hessian(at, gear, torque_nm), [tau, gear.x]);
        if self.springless() {
            h[0][0] = 1.0;
            sides[0][0] = 0.0;
            sides[1][0] = 0.0;
        }
        // One scale for matrix and right-hand sides: pivots compare as they should, and nothing over- or underflows.
        let scale = h.iter().flatten().fold(0.0f32, |m, x| x.abs().at_least(m));
        let mut answer = solve(
            h.map(|row| row.map(|x| x / scale)),
            sides.map(|side| side.map(|x| x / scale)),
        )?;
        // A unit of torque may move the finger far: only its direction is used then.
        answer
            .iter_mut()
            .flatten()
            .for_each(|x| *x = x.clamp(-1e12, 1e12));
        Some(answer)
    }

    /// Posture of the free finger under an input torque (6), by Newton's method from `near`; see
    /// [`super::Mechanics::free_at_torque`].
    pub(crate) fn preshape(
        &self,
        torque_nm: f32,
        near: &Configuration<N>,
    ) -> Option<Configuration<N>> {
        if !torque_nm.is_finite() || (self.springless() && torque_nm != 0.0) {
            return None;
        }
        if let Some(cable) = self.base.return_cable() {
            if B::WEIGHS {
                return self.turned_under_weight(torque_nm);
            }
            let more_nm = (torque_nm - cable.torque_nm).at_least(0.0);
            let mut rad = self.rest.rad();
            *rad.first_mut()? += more_nm / cable.stiffness_nm_per_rad;
            return Configuration::of(rad);
        }
        let (mut at, mut before) = (*near, f32::INFINITY);
        for _ in 0..STEPS {
            let gear = self.transmission.factors(&at)?;
            let tau = self.equivalent_torques_nm(&gear, &at, torque_nm)?;
            let [change, _] = self.response(&at, &gear, torque_nm, tau)?;
            let (next, largest, _) = stride(&at, change)?;
            if settled(&next, largest, &mut before) {
                // The last change by rotation: it is finer than the rounding of the angle that it is added to.
                let at = at.advanced(&JointStep::of(change));
                self.transmission.factors(&at)?;
                return Some(at);
            }
            at = next;
        }
        None
    }

    /// Posture and torque of the free finger at an input angle (6) with a share of the torque lost on the way to the joints beyond the
    /// first; see [`super::Mechanics::free_at_angle`] and [`super::Mechanics::closing_at_angle`].
    pub(crate) fn follow_angle(
        &self,
        theta_a_rad: f32,
        near: &Configuration<N>,
        loss: f32,
    ) -> Option<Free<Configuration<N>>> {
        if self.stands_at_stops() {
            let mut rad = self.rest.rad();
            rad[0] = 0.0;
            // Joints beyond the first stay at rest; the first takes what the input link turns.
            rad[0] = theta_a_rad - self.transmission.rotation_rad(&Configuration::of(rad)?);
            let torque_nm = (self.base.return_cable())
                .map_or(0.0, |cable| cable.torque_at(rad[0] - self.rest.rad()[0]));
            return Some(Free {
                configuration: Configuration::of(rad)?,
                torque_nm,
            });
        }
        let (mut at, mut before) = (*near, f32::INFINITY);
        let mut torque_nm = self.torque_held(&at)?;
        for _ in 0..STEPS {
            let gear = self.transmission.factors(&at)?;
            let arriving = arriving(&gear, torque_nm, loss);
            let tau = self.equivalent_torques_nm(&arriving, &at, torque_nm)?;
            let [change, per_torque] = self.response(&at, &arriving, torque_nm, tau)?;
            let missing = theta_a_rad - self.transmission.rotation_rad(&at);
            let compliance = dot(&gear.x, &per_torque);
            let more_nm = (missing - dot(&gear.x, &change)) / compliance;
            let mut both = change;
            for i in 0..N {
                both[i] += per_torque[i] * more_nm;
            }
            let held = compliance > 0.0 && more_nm.is_finite();
            if !held {
                return None;
            }
            let (next, largest, share) = stride(&at, both)?;
            at = next;
            torque_nm += more_nm * share;
            if settled(&at, largest, &mut before) {
                self.transmission.factors(&at)?;
                return torque_nm.is_finite().then_some(Free {
                    configuration: at,
                    torque_nm,
                });
            }
        }
        None
    }

    /// The same, joint 1 of a finger whose joints stand at their stops bearing the weight beside the return cable;
    /// [`Self::follow_angle`] has it elsewhere.
    #[inline]
    pub(crate) fn free_under_weight(
        &self,
        theta_a_rad: f32,
        near: &Configuration<N>,
        loss: f32,
    ) -> Option<Free<Configuration<N>>> {
        let free = self.follow_angle(theta_a_rad, near, loss)?;
        let torque_nm = match self.base.weight() {
            Some(weight) if self.stands_at_stops() => {
                free.torque_nm - weight.borne(&free.configuration)[0].across
            }
            _ => return Some(free),
        };
        torque_nm.is_finite().then_some(Free { torque_nm, ..free })
    }

    /// The torque that holds joint 1 where it is: x_1 = 1 makes it the spring's.
    fn torque_held(&self, at: &Configuration<N>) -> Option<f32> {
        let parameters = &self.parameters;
        let (k, now, rest) = (
            parameters.stiffness_nm_per_rad.first()?,
            *at.rad().first()?,
            parameters.rest_rad.first()?,
        );
        let borne_nm = (self.base.weight()).map_or(0.0, |weight| weight.borne(at)[0].across);
        Some(k * (now - rest) - borne_nm)
    }

    /// Where a return cable lets joint 1 turn from rest under a torque and the weight, joint 2 at its stop.
    fn turned_under_weight(&self, torque_nm: f32) -> Option<Configuration<N>> {
        let (mut at, mut before) = (self.rest, f32::INFINITY);
        let low = *self.rest.rad().first()?;
        for _ in 0..STEPS {
            let free = self.free_under_weight(self.transmission.rotation_rad(&at), &at, 0.0)?;
            let change = (torque_nm - free.torque_nm) * self.free(&at, torque_nm)?;
            let mut rad = at.rad();
            let turned = rad.first_mut()?;
            let from = *turned;
            *turned = (from + change.clamp(-STRIDE_RAD, STRIDE_RAD)).at_least(low);
            let largest = (*turned - from).abs();
            at = Configuration::of(rad)?;
            if settled(&at, largest, &mut before) {
                return Some(at);
            }
        }
        None
    }

    /// Expected global stiffness K_a' (7), the secant from rest; without torque its limit, the tangent.
    pub(crate) fn secant_stiffness(&self, free: &Free<Configuration<N>>) -> Option<f32> {
        if self.springless() {
            return Some(0.0);
        }
        let from_rest = self.rest.rad();
        let mut change = free.configuration.rad();
        for i in 0..N {
            change[i] -= from_rest[i];
        }
        let rotation = self
            .transmission
            .turned_rad(&self.rest, &JointStep::of(change))?;
        let mut from_nm = 0.0;
        if B::WEIGHS {
            let rest_rad = self.transmission.rotation_rad(&self.rest);
            from_nm = self.free_under_weight(rest_rad, &self.rest, 0.0)?.torque_nm;
            if let Some(cable) = self.base.return_cable() {
                // The stop bears the preload there.
                from_nm -= cable.torque_nm;
            }
        }
        let secant = (free.torque_nm - from_nm) / rotation;
        // Within a few roundings of rest the quotient has no digits: its limit has.
        if rotation.abs() > 1e-5 && secant.is_finite() {
            return Some(secant);
        }
        // A return cable's preload is borne by the stop at rest: there the secant has no limit.
        if self.base.return_cable().is_some() {
            return None;
        }
        let stiffness = 1.0 / self.free(&free.configuration, free.torque_nm)?;
        stiffness.is_finite().then_some(stiffness)
    }

    /// Tangent compliance without contact, C_free = x^T H^-1 x (docs/MECHANICS.md#preshaping).
    pub(crate) fn free(&self, at: &Configuration<N>, torque_nm: f32) -> Option<f32> {
        if self.springless() {
            return None;
        }
        if let Some(cable) = self.base.return_cable() {
            let mut stiffness = cable.stiffness_nm_per_rad;
            if let Some(weight) = self.base.weight() {
                stiffness += weight.borne(at)[0].along;
            }
            let compliance = 1.0 / stiffness;
            return (!B::WEIGHS || compliance > 0.0 && compliance.is_finite())
                .then_some(compliance);
        }
        let gear = self.transmission.factors(at)?;
        let [_, per_torque] = self.response(at, &gear, torque_nm, [0.0; N])?;
        let compliance = dot(&gear.x, &per_torque);
        (compliance.is_finite() && compliance > 0.0).then_some(compliance)
    }
}

/// Newton's method is done: its step is the rounding of the angles, or near that and no longer shrinking.
fn settled<const N: usize>(at: &Configuration<N>, largest: f32, before: &mut f32) -> bool {
    let scale = at.rad().iter().fold(1.0f32, |m, x| x.abs().at_least(m));
    let done = largest <= SETTLED_SHARE * scale
        || (largest <= NOISE_SHARE * scale && largest >= 0.5 * *before);
    *before = largest;
    done
}

/// The posture a change away, shortened to the stride; the size of the change, and the share of it that was taken.
fn stride<const N: usize>(
    at: &Configuration<N>,
    change: [f32; N],
) -> Option<(Configuration<N>, f32, f32)> {
    let largest = change.iter().fold(0.0f32, |m, x| x.abs().at_least(m));
    let share = if largest > STRIDE_RAD {
        STRIDE_RAD / largest
    } else {
        1.0
    };
    let mut rad = at.rad();
    for i in 0..N {
        rad[i] += change[i] * share;
    }
    Some((Configuration::of(rad)?, largest, share))
}

/// What of an input torque arrives at the joints of a finger that closes: less by the share that is lost on the way to those beyond the
/// first (docs/SENSING.md#losses-on-pulleys). A negative torque holds the finger back, and friction on the pulleys helps it.
fn arriving<const N: usize>(
    gear: &TransmissionFactors<N>,
    torque_nm: f32,
    loss: f32,
) -> TransmissionFactors<N> {
    let share = if torque_nm < 0.0 {
        1.0 + loss
    } else {
        1.0 - loss
    };
    let mut arriving = *gear;
    for x in arriving.x.iter_mut().skip(1) {
        *x *= share;
    }
    arriving
}
