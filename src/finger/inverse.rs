//! From a compliance to all places that explain it (docs/MECHANICS.md#contact-stiffness and
//! docs/MECHANICS.md#observability).

use super::chain::{ChainContact, StiffnessRoot};
use super::quadratic::QuadraticContact;
use super::return_cable::ReturnedContact;
use super::three_joint::ThreeJointContact;
use super::two_joint::{Roots, TwoJointContact};
use super::{BaseJoint, Candidate, Class, Configuration, Finger, Inverse, Transmission};
use crate::numeric::Rotation;

/// How near to the proximal compliance counts as proximal: what is left of f32 behind the gear near a dead point, and
/// far below any measurement.
const PROXIMAL_SHARE: f32 = 1e-4;
/// A place nearer to its joint than this share of the phalanx is a contact on the joint, when the compliance is proximal.
const ON_JOINT_SHARE: f32 = 1e-3;

/// Share of a compliance that rounding may change where it is a sum of two.
const ROUNDING: f32 = 2.4e-7;

/// Geometry and stiffness of a finger in one posture, as the inverse needs them.
#[derive(Clone, Copy, Debug)]
pub struct PostureStiffness<const N: usize> {
    pub(crate) lengths: [f32; N],
    pub(crate) turn: [Rotation; N],
    pub(crate) x: [f32; N],
    pub(crate) h: [[f32; N]; N],
}

/// How the roots of a compliance are found. A type, so that a program carries only the solver that it calls.
pub trait Solver {
    /// Roots on phalanx 2, the third joint eliminated.
    fn two_joint(contact: &TwoJointContact, compliance: f32, length_m: f32) -> Roots;
    /// Roots on phalanx 3.
    fn three_joint(contact: &ThreeJointContact, compliance: f32, length_m: f32) -> Roots;
    /// Roots on a phalanx of a longer finger.
    fn chain<const N: usize>(contact: &ChainContact<N>, compliance: f32, length_m: f32) -> Roots;
    /// Roots on a phalanx of a finger under its weight.
    fn weighted(contact: &impl QuadraticContact, compliance: f32, length_m: f32) -> Roots;
    /// Roots on phalanx 2 of a finger that a return cable opens.
    fn returned(contact: &ReturnedContact, compliance: f32, length_m: f32) -> Roots;
}

/// 24 halvings a root: what the firmware runs.
pub(crate) struct Bisection;

impl Solver for Bisection {
    fn two_joint(contact: &TwoJointContact, compliance: f32, length_m: f32) -> Roots {
        contact.bisected(compliance, length_m)
    }

    fn three_joint(contact: &ThreeJointContact, compliance: f32, length_m: f32) -> Roots {
        contact.bisected(compliance, length_m)
    }

    fn chain<const N: usize>(contact: &ChainContact<N>, compliance: f32, length_m: f32) -> Roots {
        contact.bisected(compliance, length_m)
    }

    fn weighted(contact: &impl QuadraticContact, compliance: f32, length_m: f32) -> Roots {
        contact.bisected(compliance, length_m)
    }

    fn returned(contact: &ReturnedContact, compliance: f32, length_m: f32) -> Roots {
        contact.bisected(compliance, length_m)
    }
}

/// Stable closed forms: the check of the bisection in tests and in the report.
pub(crate) struct ClosedForm;

impl Solver for ClosedForm {
    fn two_joint(contact: &TwoJointContact, compliance: f32, _: f32) -> Roots {
        contact.closed(compliance)
    }

    fn three_joint(contact: &ThreeJointContact, compliance: f32, _: f32) -> Roots {
        contact.closed(compliance)
    }

    fn chain<const N: usize>(contact: &ChainContact<N>, compliance: f32, _: f32) -> Roots {
        contact.closed(compliance)
    }

    fn weighted(contact: &impl QuadraticContact, compliance: f32, _: f32) -> Roots {
        contact.closed(compliance)
    }

    fn returned(contact: &ReturnedContact, compliance: f32, _: f32) -> Roots {
        contact.closed(compliance)
    }
}

/// The statics that differ with the number of phalanges.
pub trait ContactStatics {
    /// The springs hold the finger: H is positive on what a contact leaves free.
    fn stable(&self) -> bool;
    /// Compliance with a contact anywhere on phalanx 1.
    fn proximal(&self) -> Option<f32>;
    /// Compliance with a contact at `k_m` on a phalanx (18).
    fn compliance(&self, phalanx: u8, k_m: f32) -> Option<f32>;
    /// Stiffest place of a phalanx: e_2 (27) and its counterparts.
    fn stiffest_m(&self, phalanx: u8) -> Option<f32>;
    /// Roots of a compliance on a phalanx.
    fn roots<S: Solver>(&self, phalanx: u8, compliance: f32) -> Roots;
}

impl PostureStiffness<2> {
    fn pair(&self) -> TwoJointContact {
        let ([l1, _], [_, theta_2], [_, x2], [[k1, _], [_, h22]]) =
            (self.lengths, self.turn, self.x, self.h);
        TwoJointContact {
            c_m: l1 * theta_2.cos,
            x2,
            k1,
            h22,
        }
    }
}

impl ContactStatics for PostureStiffness<2> {
    fn stable(&self) -> bool {
        self.pair().h22 > 0.0
    }

    fn proximal(&self) -> Option<f32> {
        self.pair().proximal()
    }

    fn compliance(&self, phalanx: u8, k_m: f32) -> Option<f32> {
        match phalanx {
            1 => self.proximal(),
            2 => self.pair().compliance(k_m),
            _ => None,
        }
    }

    fn stiffest_m(&self, phalanx: u8) -> Option<f32> {
        if phalanx == 2 {
            self.pair().stiffest_m()
        } else {
            None
        }
    }

    fn roots<S: Solver>(&self, phalanx: u8, compliance: f32) -> Roots {
        match phalanx {
            2 => S::two_joint(&self.pair(), compliance, self.lengths[1]),
            _ => Roots::default(),
        }
    }
}

impl PostureStiffness<3> {
    /// Contact on phalanx 2: joint 3 gives way freely. Eliminated, it leaves a pair and adds its own compliance.
    fn pair(&self) -> (TwoJointContact, f32) {
        let ([l1, ..], [_, theta_2, _], [_, x2, x3]) = (self.lengths, self.turn, self.x);
        let [[k1, ..], [_, h22, h23], [.., h33]] = self.h;
        let share = h23 / h33;
        let pair = TwoJointContact {
            c_m: l1 * theta_2.cos,
            x2: x2 - share * x3,
            k1,
            h22: h22 - share * h23,
        };
        (pair, x3 * (x3 / h33))
    }

    fn triple(&self) -> ThreeJointContact {
        let ([l1, l2, _], [_, theta_2, theta_3], [_, x2, x3]) = (self.lengths, self.turn, self.x);
        let [[k1, ..], [_, h22, h23], [.., h33]] = self.h;
        let d2_m = l2 * theta_3.cos;
        ThreeJointContact {
            d1_m: l1 * theta_2.then(theta_3).cos + d2_m,
            d2_m,
            x2,
            x3,
            k1,
            h22,
            h23,
            h33,
        }
    }
}

impl ContactStatics for PostureStiffness<3> {
    fn stable(&self) -> bool {
        let triple = self.triple();
        triple.h33 > 0.0 && triple.determinant() > 0.0
    }

    fn proximal(&self) -> Option<f32> {
        let (pair, tip) = self.pair();
        Some(pair.proximal()? + tip)
    }

    fn compliance(&self, phalanx: u8, k_m: f32) -> Option<f32> {
        match phalanx {
            1 => self.proximal(),
            2 => {
                let (pair, tip) = self.pair();
                Some(pair.compliance(k_m)? + tip)
            }
            3 => self.triple().compliance(k_m),
            _ => None,
        }
    }

    fn stiffest_m(&self, phalanx: u8) -> Option<f32> {
        match phalanx {
            2 => self.pair().0.stiffest_m(),
            3 => self.triple().stiffest_m(),
            _ => None,
        }
    }

    fn roots<S: Solver>(&self, phalanx: u8, compliance: f32) -> Roots {
        match phalanx {
            2 => {
                let (pair, tip) = self.pair();
                let own = without_tip(compliance, tip);
                S::two_joint(&pair, own, self.lengths[1])
            }
            3 => S::three_joint(&self.triple(), compliance, self.lengths[2]),
            _ => Roots::default(),
        }
    }
}

/// What remains of a compliance without that of the joints beyond the contact. At the stiffest place all compliance is
/// theirs, and rounding decides on which side of it.
pub(super) fn without_tip(compliance: f32, tip: f32) -> f32 {
    let own = compliance - tip;
    if own < 0.0 && own >= -ROUNDING * tip {
        0.0
    } else {
        own
    }
}

/// The statics of fingers of more than three phalanges.
macro_rules! long_fingers {
    ($($phalanges:literal)*) => { $(
        impl ContactStatics for PostureStiffness<$phalanges> {
            fn stable(&self) -> bool {
                StiffnessRoot::<$phalanges>::of(&self.h).is_some()
            }

            fn proximal(&self) -> Option<f32> {
                Some(StiffnessRoot::<$phalanges>::of(&self.h)?.compliance(self.x)).filter(|c| c.is_finite())
            }

            fn compliance(&self, phalanx: u8, k_m: f32) -> Option<f32> {
                if phalanx == 1 {
                    return self.proximal();
                }
                let contact = self.chain(phalanx)?;
                Some(contact.compliance(k_m)? + contact.beyond())
            }

            fn stiffest_m(&self, phalanx: u8) -> Option<f32> {
                self.chain(phalanx)?.stiffest_m()
            }

            fn roots<S: Solver>(&self, phalanx: u8, compliance: f32) -> Roots {
                let (Some(contact), Some(length_m)) = (
                    self.chain(phalanx),
                    self.lengths.get(usize::from(phalanx).wrapping_sub(1)),
                ) else {
                    return Roots::default();
                };
                let own = without_tip(compliance, contact.beyond());
                S::chain(&contact, own, *length_m)
            }
        }
    )* };
}

long_fingers!(4 5 6);

impl<const N: usize> PostureStiffness<N> {
    fn chain(&self, phalanx: u8) -> Option<ChainContact<N>> {
        ChainContact::on(self, &StiffnessRoot::of(&self.h)?, phalanx)
    }
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B>
where
    PostureStiffness<N>: ContactStatics,
{
    /// The finger in a posture held by a torque; `None` where that is not a stable equilibrium of its springs.
    pub(crate) fn held(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
    ) -> Option<PostureStiffness<N>> {
        let gear = self.transmission.factors(at)?;
        let h = self.hessian(at, &gear, torque_nm);
        let held = PostureStiffness {
            lengths: self.parameters.lengths_m,
            turn: at.turn(),
            x: gear.x,
            h,
        };
        (h.iter().flatten().all(|x| x.is_finite()) && held.stable()).then_some(held)
    }

    /// See [`super::Mechanics::locate`].
    pub(crate) fn places<S: Solver>(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
        compliance: f32,
    ) -> Inverse {
        let invalid = || Inverse::of(heapless::Vec::new(), Class::Invalid);
        if let (Some(contact), Some(length_m)) =
            (self.returned_contact(at), self.parameters.lengths_m.get(1))
        {
            return match self.lifted(at, contact) {
                Some(lifted) => lifted.places::<S>(compliance, *length_m),
                None => contact.places::<S>(compliance, *length_m),
            };
        }
        let Some(held) = self.held(at, torque_nm) else {
            return invalid();
        };
        let Some(proximal) = held.proximal() else {
            return invalid();
        };
        if !(compliance >= 0.0 && compliance.is_finite()) {
            return invalid();
        }
        let on_joint =
            B::FIRST_TOUCHING == 1 && (compliance - proximal).abs() <= PROXIMAL_SHARE * proximal;
        // Without a spring at joint 1 nothing is softer than the free finger.
        if self
            .free(at, torque_nm)
            .is_some_and(|free| compliance > free)
        {
            return Inverse::of(heapless::Vec::new(), Class::TooSoft);
        }
        let mut candidates = heapless::Vec::new();
        for (phalanx, length) in (1u8..).zip(self.parameters.lengths_m).skip(1) {
            let roots = self.roots_on::<S>(&held, phalanx, compliance, length);
            let far = roots.far_m.filter(|far| roots.near_m != Some(*far));
            for (root, beyond_stiffest) in [(roots.near_m, false), (far, true)] {
                let least = if on_joint {
                    ON_JOINT_SHARE * length
                } else {
                    0.0
                };
                if let Some(k_m) = root.filter(|k| *k > least && *k <= length) {
                    // Two roots on each phalanx but the first: the list is as long.
                    let _ = candidates.push(Candidate {
                        phalanx,
                        k_m,
                        beyond_stiffest,
                    });
                }
            }
        }
        if on_joint {
            return Inverse::proximal(candidates);
        }
        Inverse::of(
            candidates,
            if compliance > proximal {
                Class::Gap
            } else {
                Class::TooStiff
            },
        )
    }
}
