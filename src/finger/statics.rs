//! Statics of the whole finger: equivalent torques (5) and contact forces (1).

use super::quadratic::QuadraticContact;
use super::return_cable::ReturnedContact;
use super::weighted::WeightedReturn;
use super::{BaseJoint, Configuration, Finger, Transmission, TransmissionFactors};
use crate::numeric::{Rotation, dot};

/// Moment arms about every joint, metre, from the phalanx with index `tip` down to joint 1: `own_m` about the phalanx's own joint, and
/// what each length below adds by its angle against the phalanx; 0 about the joints beyond.
#[inline]
fn arms<const N: usize>(
    lengths_m: &[f32; N],
    turn: &[Rotation; N],
    tip: usize,
    own_m: f32,
    share: impl Fn(Rotation) -> f32,
) -> [f32; N] {
    let mut arms = [0.0; N];
    // The phalanx's angle against those below grows joint by joint.
    let (mut arm, mut bend) = (own_m, Rotation::NONE);
    for (m, (own, turn)) in arms.iter_mut().zip(turn).enumerate().rev() {
        if m > tip {
            continue;
        }
        *own = arm;
        if let Some(length) = m.checked_sub(1).and_then(|below| lengths_m.get(below)) {
            bend = bend.then(*turn);
            arm += length * share(bend);
        }
    }
    arms
}

/// p, the moment arms of a contact at `k_m` on the phalanx with index `tip`, 0 for the first (docs/MECHANICS.md#statics). Linear in k:
/// each arm up to the contact grows by 1 with it.
#[inline]
pub(super) fn contact_arms<const N: usize>(
    lengths_m: &[f32; N],
    turn: &[Rotation; N],
    tip: usize,
    k_m: f32,
) -> [f32; N] {
    arms(lengths_m, turn, tip, k_m, |bend| bend.cos)
}

/// Moment arms of a force of friction along the surface of the phalanx with index `tip`, towards its joint. Times the rates of the joints
/// they are the speed at which that surface slides.
pub(super) fn rubbing_arms<const N: usize>(
    lengths_m: &[f32; N],
    turn: &[Rotation; N],
    tip: usize,
    half_thickness_m: f32,
) -> [f32; N] {
    arms(lengths_m, turn, tip, half_thickness_m, |bend| -bend.sin)
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// A contact on phalanx 2 in a posture, of a finger that a return cable opens; `None` of any other.
    pub(crate) fn returned_contact(&self, at: &Configuration<N>) -> Option<ReturnedContact> {
        let cable = *self.base.return_cable()?;
        let (length, turn) = (self.parameters.lengths_m.first()?, at.turn());
        Some(ReturnedContact {
            c_m: length * turn.get(1)?.cos,
            x2: *self.transmission.factors(at)?.x.get(1)?,
            cable,
        })
    }

    /// Such a contact where the finger's weight is stated; `None` where it is not.
    pub(crate) fn lifted(
        &self,
        at: &Configuration<N>,
        contact: ReturnedContact,
    ) -> Option<WeightedReturn> {
        let pulls = self.base.weight()?.pulls(at);
        Some(WeightedReturn {
            contact,
            links: [pulls.first()?.along, pulls.get(1)?.along],
        })
    }

    /// Compliance with a contact anywhere on phalanx 1 of such a finger.
    pub(crate) fn returned_proximal(
        &self,
        at: &Configuration<N>,
        contact: &ReturnedContact,
    ) -> Option<f32> {
        match self.lifted(at, *contact) {
            Some(lifted) => lifted.compliance(0.0),
            None => contact.proximal(),
        }
    }

    /// Equivalent joint torques tau = x T_a - K (theta - theta_0) + g (5): what contacts have to balance, and stops. Newton metre.
    pub fn equivalent_torques_nm(
        &self,
        gear: &TransmissionFactors<N>,
        at: &Configuration<N>,
        torque_nm: f32,
    ) -> Option<[f32; N]> {
        let rad = at.rad();
        let mut tau = [0.0; N];
        for i in 0..N {
            let spring =
                self.parameters.stiffness_nm_per_rad[i] * (rad[i] - self.parameters.rest_rad[i]);
            tau[i] = gear.x[i] * torque_nm - spring;
        }
        if let Some(cable) = self.base.return_cable() {
            let lever = cable.factors();
            let turned: [f32; N] = core::array::from_fn(|i| rad[i] - self.parameters.rest_rad[i]);
            let pull_nm = cable.torque_at(dot(&lever, &turned));
            for i in 0..N {
                tau[i] -= lever[i] * pull_nm;
            }
        }
        if let Some(weight) = self.base.weight() {
            let borne = weight.borne(at);
            for i in 0..N {
                tau[i] += borne[i].across;
            }
        }
        tau.iter().all(|t| t.is_finite()).then_some(tau)
    }

    /// J^T, the moment arms of one contact on each phalanx, at distances `k_m`: row m, column i holds p_m of the contact
    /// on phalanx i (docs/MECHANICS.md#statics), metre; upper triangular.
    pub fn arms_m(&self, at: &Configuration<N>, k_m: [f32; N]) -> [[f32; N]; N] {
        let turn = at.turn();
        let mut arms = [[0.0; N]; N];
        for i in 0..N {
            let contact = contact_arms(&self.parameters.lengths_m, &turn, i, k_m[i]);
            for m in 0..N {
                arms[m][i] = contact[m];
            }
        }
        arms
    }

    /// Contact forces f = J^-T tau (1) of one contact on each phalanx, newton; a negative one would have to pull.
    ///
    /// By back substitution in the moment arms, which needs no beta and divides by each k once. `None` where a distance
    /// is 0 or anything is not finite.
    pub fn contact_forces_n(
        &self,
        at: &Configuration<N>,
        k_m: [f32; N],
        tau_nm: [f32; N],
    ) -> Option<[f32; N]> {
        let arms = self.arms_m(at, k_m);
        let mut force = [0.0; N];
        for m in (0..N).rev() {
            let mut tau = tau_nm[m];
            for i in m + 1..N {
                tau -= arms[m][i] * force[i];
            }
            force[m] = tau / k_m[m];
        }
        force.iter().all(|f| f.is_finite()).then_some(force)
    }
}
