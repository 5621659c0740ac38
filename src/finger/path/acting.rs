//! What acts on the finger along a contact path, besides its motor and its springs: set where the path begins.

use super::Path;
use crate::finger::{BaseJoint, Finger, Transmission};
use crate::numeric::Bounded;

/// Largest share of the friction that holds a contact which acts: the path keeps a motion larger than its rounding.
const HELD_SHARE: f32 = 0.99;

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// See [`crate::finger::Mechanics::load`].
    pub(crate) fn weigh(
        &self,
        path: &mut Path<N, B>,
        [weight_nm, per_rad]: [f32; 2],
        held_nm: f32,
    ) {
        let start = &mut path.start;
        let double = 2.0 / start.stiffness_scale;
        start.weight = [double * per_rad, -double * weight_nm];
        let held = held_nm / start.stiffness_scale;
        start.held.iter_mut().for_each(|joint| *joint += held);
    }

    /// See [`crate::finger::Mechanics::brake`].
    pub(crate) fn brakes(path: &mut Path<N, B>, torque_nm: f32) {
        let start = &mut path.start;
        let torque = torque_nm / start.stiffness_scale;
        if start.rubbed() > 0.0 {
            start.braked = torque;
            return;
        }
        for (held, sense) in start.held.iter_mut().zip(start.sense) {
            *held += sense * torque;
        }
    }

    /// See [`crate::finger::Mechanics::soften`].
    pub(crate) fn gives(&self, path: &mut Path<N, B>, compliance_m_per_n: f32) -> Option<()> {
        let Path { start, last } = path;
        start.give = compliance_m_per_n * start.give_scale();
        *last = self.begun(start, last.at.k)?;
        Some(())
    }

    /// See [`crate::finger::Mechanics::lose`].
    pub(crate) fn loses(path: &mut Path<N, B>) {
        let [loss, _] = T::JOINT_LOSS;
        if loss > 0.0 {
            let start = &mut path.start;
            for m in 1..N {
                start.taken[m] = loss;
                if start.sense[m] < 0.0 {
                    start.taken[m] = -loss;
                    if !B::HOLDS {
                        // A torque that held the finger back took nothing from the joint that its pulley could give up.
                        start.back[m] = 2.0 * start.torque.at_least(0.0);
                    }
                }
            }
        }
    }

    /// See [`crate::finger::Mechanics::rub`].
    pub(crate) fn rubs(
        &self,
        path: &mut Path<N, B>,
        friction: f32,
        half_thickness_m: f32,
    ) -> Option<()> {
        let Path { start, last } = path;
        start.half_thickness = half_thickness_m / start.length_scale;
        let local = start.local(&self.transmission, &last.at, last.rise)?;
        // Not the path's own tangent, which knows neither losses nor weight: friction would hold what hardly moves with them.
        let [slide, holding] = local.sliding(&local.tangent()?)?;
        if slide < 0.0 {
            start.slides = -1.0;
        }
        start.friction = friction.at_most(HELD_SHARE * holding);
        if B::HOLDS {
            *last = self.begun(start, last.at.k)?;
        }
        Some(())
    }
}
