//! A contact on a finger under its weight: K_c (18) where the weight couples every joint to the first (docs/FINGERS.md#weight).
//!
//! With the root R of the whole stiffness, H = R R^T, compliances are those of whitened vectors: C = |x|^2 - (p . x)^2 / |p|^2, by
//! Lagrange's identity a quotient of two sums of squares, each a quadratic in the contact's place.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::chain::StiffnessRoot;
use super::inverse::{ContactStatics, PostureStiffness, Solver, without_tip};
use super::quadratic::{Quadratic, QuadraticContact};
use super::return_cable::{ReturnedContact, explained};
use super::statics::contact_arms;
use super::{BaseJoint, Class, Configuration, Finger, Inverse, Roots, Transmission};
use crate::numeric::{Bounded, dot};
use core::array::from_fn;

/// The stiffness problem of a contact on one phalanx, the joints beyond it eliminated.
#[derive(Clone, Copy, Debug)]
pub struct WeightedContact<const N: usize> {
    /// R^-1 p at k = 0, and by what it changes with k.
    arms: [[f32; N]; 2],
    /// R^-1 x over the joints up to the contact.
    row: [f32; N],
    /// What the joints beyond the contact give way.
    beyond: f32,
}

impl<const N: usize> WeightedContact<N> {
    /// The contact on a phalanx, 2 for the second; `None` where springs and weight do not hold the finger.
    pub(super) fn on(held: &PostureStiffness<N>, phalanx: u8) -> Option<Self> {
        let tip = usize::from(phalanx).checked_sub(1)?;
        if tip == 0 || tip >= N {
            return None;
        }
        let root = StiffnessRoot::<N, 0>::of(&held.h)?;
        let d = contact_arms(&held.lengths, &held.turn, tip, 0.0);
        let loaded = from_fn(|m| if m <= tip { 1.0 } else { 0.0 });
        let mut row = root.whitened(held.x);
        let mut beyond = 0.0;
        for m in tip + 1..N {
            beyond += row[m] * row[m];
            row[m] = 0.0;
        }
        Some(Self {
            arms: [root.whitened(d), root.whitened(loaded)],
            row,
            beyond,
        })
    }

    /// What the joints beyond the contact add to the compliance.
    pub(super) fn beyond(&self) -> f32 {
        self.beyond
    }

    /// R^-1 p at some k.
    fn at(&self, k: f32) -> [f32; N] {
        let [d, one] = &self.arms;
        from_fn(|m| d[m] + k * one[m])
    }

    /// (u x row) . (v x row), over all pairs of joints.
    fn crossed(&self, u: &[f32; N], v: &[f32; N]) -> f32 {
        let w = &self.row;
        let mut sum = 0.0;
        for i in 0..N {
            for j in i + 1..N {
                sum += (u[i] * w[j] - u[j] * w[i]) * (v[i] * w[j] - v[j] * w[i]);
            }
        }
        sum
    }
}

impl<const N: usize> QuadraticContact for WeightedContact<N> {
    fn softness(&self, k: f32) -> f32 {
        let arms = self.at(k);
        self.crossed(&arms, &arms)
    }

    fn energy(&self, k: f32) -> f32 {
        let arms = self.at(k);
        dot(&arms, &arms)
    }

    fn pressing(&self) -> [f32; 2] {
        self.arms.map(|arms| dot(&arms, &self.row))
    }

    fn slope(&self) -> (f32, f32) {
        let ([d, one], w) = (&self.arms, &self.row);
        let (x0, x1) = (dot(d, w), dot(one, w));
        let (d0, d1, d2) = (dot(d, d), dot(d, one), dot(one, one));
        (x1 * d0 - x0 * d1, x1 * d1 - x0 * d2)
    }

    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let (u, one) = (self.at(about), &self.arms[1]);
        [
            self.crossed(&u, &u) - compliance * dot(&u, &u),
            self.crossed(&u, one) - compliance * dot(&u, one),
            self.crossed(one, one) - compliance * dot(one, one),
        ]
    }
}

/// The same for a finger that a return cable opens, once joint 2 has left its stop. The cable alone has no root: along the motion
/// that the contact leaves, (k, -(k + c)), both stretch the cable and lift the weight.
#[derive(Clone, Copy, Debug)]
pub struct WeightedReturn {
    pub(super) contact: ReturnedContact,
    /// What lifting the links adds to the stiffness: phalanx 1, and phalanx 2, newton metre per radian.
    pub(super) links: [f32; 2],
}

impl WeightedReturn {
    /// See [`super::Mechanics::locate`].
    pub(super) fn places<S: Solver>(&self, compliance: f32, length_m: f32) -> Inverse {
        let Some(proximal) = self.compliance(0.0).filter(|_| compliance >= 0.0) else {
            return Inverse::of(heapless::Vec::new(), Class::Invalid);
        };
        let root = S::weighted(self, compliance, length_m).near_m;
        // Free it turns joint 1 alone, and lifts both links.
        let free = self.contact.cable.stiffness_nm_per_rad + self.links[0] + self.links[1];
        explained(compliance, root, length_m, proximal, free)
    }
}

impl QuadraticContact for WeightedReturn {
    /// The lever's square where joint 2 leaves its stop.
    fn softness(&self, k: f32) -> f32 {
        let lever = self.contact.lever(k).at_least(0.0);
        lever * lever
    }

    fn energy(&self, k: f32) -> f32 {
        let (cable, [first, second]) = (self.contact.return_lever(k), self.links);
        let c = self.contact.c_m;
        self.contact.cable.stiffness_nm_per_rad * cable * cable + first * k * k + second * c * c
    }

    fn pressing(&self) -> [f32; 2] {
        // Below e_2 alone.
        [self.contact.lever(0.0), self.contact.x2 - 1.0]
    }

    fn slope(&self) -> (f32, f32) {
        let [at_joint, along] = self.pressing();
        (at_joint, along)
    }

    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let ReturnedContact { c_m: c, x2, cable } = self.contact;
        let (lever, by_k) = (self.contact.lever(about), x2 - 1.0);
        let (back, back_by_k) = (self.contact.return_lever(about), cable.ratio - 1.0);
        let (stiffness, [first, second]) = (cable.stiffness_nm_per_rad, self.links);
        let energy = [
            stiffness * back * back + first * about * about + second * c * c,
            stiffness * back * back_by_k + first * about,
            stiffness * back_by_k * back_by_k + first,
        ];
        [
            lever * lever - compliance * energy[0],
            lever * by_k - compliance * energy[1],
            by_k * by_k - compliance * energy[2],
        ]
    }
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B>
where
    PostureStiffness<N>: ContactStatics,
{
    /// See [`super::Mechanics::contact_compliance`].
    pub(crate) fn compliance_at(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
        phalanx: u8,
        k_m: f32,
    ) -> Option<f32> {
        if let Some(contact) = self.returned_contact(at) {
            return match (phalanx, self.lifted(at, contact)) {
                (1, _) => self.returned_proximal(at, &contact),
                (2, Some(lifted)) => lifted.compliance(k_m),
                (2, None) => contact.compliance(k_m),
                _ => None,
            };
        }
        let held = self.held(at, torque_nm)?;
        if B::WEIGHS && phalanx > 1 {
            let contact = WeightedContact::on(&held, phalanx)?;
            return Some(contact.compliance(k_m)? + contact.beyond());
        }
        held.compliance(phalanx, k_m)
    }

    /// See [`super::Mechanics::proximal_compliance`].
    pub(crate) fn proximal_at(&self, at: &Configuration<N>, torque_nm: f32) -> Option<f32> {
        match self.returned_contact(at) {
            Some(contact) => self.returned_proximal(at, &contact),
            None => self.held(at, torque_nm)?.proximal(),
        }
    }

    /// See [`super::Mechanics::stiffest_m`].
    pub(crate) fn stiffest_at(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
        phalanx: u8,
    ) -> Option<f32> {
        if let Some(contact) = self.returned_contact(at) {
            return contact.stiffest_m().filter(|_| phalanx == 2);
        }
        let held = self.held(at, torque_nm)?;
        if B::WEIGHS {
            return WeightedContact::on(&held, phalanx)?.stiffest_m();
        }
        held.stiffest_m(phalanx)
    }

    /// Roots of a compliance on a phalanx.
    pub(super) fn roots_on<S: Solver>(
        &self,
        held: &PostureStiffness<N>,
        phalanx: u8,
        compliance: f32,
        length_m: f32,
    ) -> Roots {
        if !B::WEIGHS {
            return held.roots::<S>(phalanx, compliance);
        }
        WeightedContact::on(held, phalanx).map_or(Roots::default(), |contact| {
            let own = without_tip(compliance, contact.beyond());
            S::weighted(&contact, own, length_m)
        })
    }
}
