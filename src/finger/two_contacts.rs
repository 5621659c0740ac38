//! A second contact after the first: its place on three phalanges, and what statics still tells with two
//! (docs/SECOND_CONTACTS.md#two-contacts).

// Indices are those of the vectors in the equations.
#![allow(clippy::needless_range_loop)]

use super::mechanics::Candidates;
use super::quadratic::{Quadratic, QuadraticContact};
use super::statics::contact_arms;
use super::{
    BaseJoint, Candidate, Configuration, Contact, Finger, Mechanics, Pressed, Transmission,
};
use crate::numeric::{Bounded, dot, sqrt};
use core::array::from_fn;

/// Corrections of a place for what friction takes there.
const CORRECTIONS: u8 = 3;

/// A second contact, told from the stiffness that the motor feels after it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SecondPlace {
    /// Where it is.
    pub place: Candidate,
    /// Standard deviation of its distance from the joint, metre.
    pub sigma_m: f32,
}

/// What was measured of a second contact, with standard deviations; torques and angles are those of the input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondMeasured {
    /// Torque from the first contact to the second, newton metre, >= 0.
    pub rise_nm: f32,
    /// Rotation of the input link from the first contact to the second, without the cable's twist, radian.
    pub rotation_rad: f32,
    /// Deviation of that, radian, > 0; infinite where the torque alone is known.
    pub rotation_sigma_rad: f32,
    /// Torque at the second contact, newton metre.
    pub torque_nm: f32,
    /// How much farther the torque has risen where the compliance was measured, newton metre, >= 0.
    pub later_nm: f32,
    /// And the input link turned, without the cable's twist, radian, >= 0.
    pub turned_rad: f32,
    /// Deviation of that, > 0 where the torque has risen.
    pub turned_sigma_rad: f32,
    /// Compliance of the finger there, without the cable's, radian per newton metre, >= 0.
    pub compliance_rad_per_nm: f32,
    /// Deviation of the compliance, >= 0.
    pub compliance_sigma_rad_per_nm: f32,
    /// Deviation of the first contact's place, metre, >= 0.
    pub first_sigma_m: f32,
    /// Coefficient of friction of both contacts: mean and deviation, >= 0.
    pub friction: [f32; 2],
    /// Half the thickness of a phalanx, metre: its surface rubs so far from its axis.
    pub half_thickness_m: f32,
    /// Deviation of the finger's leverage, as a share, >= 0.
    pub leverage_sigma: f32,
    /// Friction of each joint, newton metre: mean and deviation, >= 0.
    pub joint_friction_nm: [f32; 2],
    /// Share of the torque carried to each joint beyond the first that is lost there: mean and deviation, >= 0.
    pub joint_loss: [f32; 2],
}

/// The stiffness problem of a second contact on one phalanx: C = (x . v)^2 / (v^T H v) along v = p_a x p_b, linear in k.
struct SecondContact {
    /// v at k = 0, and by what it changes with k.
    motion: [[f32; 3]; 2],
    /// x . v, as `motion`.
    lever: [f32; 2],
    h: [[f32; 3]; 3],
    /// Rate at which the phalanx closes in on the place while only the first contact holds, as `motion`.
    approach: [f32; 2],
}

pub(super) fn cross(a: &[f32; 3], b: &[f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

impl SecondContact {
    /// On a phalanx, 1 for the first; `None` where the place does not change the stiffness: on phalanx 1, and on phalanx 2
    /// after phalanx 1.
    fn on(pressed: &Pressed<3>, phalanx: u8) -> Option<Self> {
        if !pressed.tells_place(phalanx) {
            return None;
        }
        let tip = usize::from(phalanx) - 1;
        let d = contact_arms(&pressed.lengths_m, &pressed.turn, tip, 0.0);
        let loaded = from_fn(|m| if m <= tip { 1.0 } else { 0.0 });
        // The sizes of arms cancel: only the direction of p_a counts.
        let size = sqrt(dot(&pressed.arms_m, &pressed.arms_m));
        let p = pressed.arms_m.map(|arm| arm / size);
        let motion = [cross(&p, &d), cross(&p, &loaded)];
        Some(Self {
            lever: [dot(&pressed.x, &motion[0]), dot(&pressed.x, &motion[1])],
            motion,
            h: pressed.stiffness_nm_per_rad,
            approach: [
                dot(&pressed.tangent_per_nm, &d),
                dot(&pressed.tangent_per_nm, &loaded),
            ],
        })
    }

    fn at(&self, k: f32) -> [f32; 3] {
        let [v0, v1] = &self.motion;
        [v0[0] + k * v1[0], v0[1] + k * v1[1], v0[2] + k * v1[2]]
    }

    /// u^T H v.
    fn form(&self, u: &[f32; 3], v: &[f32; 3]) -> f32 {
        let mut sum = 0.0;
        for i in 0..3 {
            sum += u[i] * dot(&self.h[i], v);
        }
        sum
    }

    /// dC/dk.
    fn compliance_by_k(&self, k: f32) -> f32 {
        let v = self.at(k);
        let (lever, energy) = (self.lever[0] + k * self.lever[1], self.form(&v, &v));
        let share = lever / energy;
        2.0 * share * (self.lever[1] - share * self.form(&v, &self.motion[1]))
    }
}

impl QuadraticContact for SecondContact {
    fn softness(&self, k: f32) -> f32 {
        let lever = self.lever[0] + k * self.lever[1];
        lever * lever
    }

    fn energy(&self, k: f32) -> f32 {
        let v = self.at(k);
        self.form(&v, &v)
    }

    /// The second contact presses where the phalanx came nearer while only the first held.
    fn pressing(&self) -> [f32; 2] {
        self.approach
    }

    /// C has its minimum where x . v vanishes and its maximum where the phalanx does not approach.
    fn slope(&self) -> (f32, f32) {
        let ([s0, s1], [v0, v1]) = (self.lever, &self.motion);
        let (e0, e1, e2) = (self.form(v0, v0), self.form(v0, v1), self.form(v1, v1));
        // dC/dk = 2 (s0 + s1 k) (r0 + r1 k) / energy^2, and r is a multiple of the approach.
        let [r0, r1] = [s1 * e0 - s0 * e1, s1 * e1 - s0 * e2];
        let [a0, a1] = self.approach;
        let sense = if r0 * a0 + r1 * a1 > 0.0 { -1.0 } else { 1.0 };
        (sense * s0, sense * s1)
    }

    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let (v, v1) = (self.at(about), &self.motion[1]);
        let (s, s1) = (self.lever[0] + about * self.lever[1], self.lever[1]);
        [
            s * s - compliance * self.form(&v, &v),
            s * s1 - compliance * self.form(&v, v1),
            s1 * s1 - compliance * self.form(v1, v1),
        ]
    }
}

impl Pressed<3> {
    /// Whether the compliance depends on where a second contact on a phalanx is.
    pub(super) fn tells_place(&self, phalanx: u8) -> bool {
        matches!((self.contact.phalanx, phalanx), (1 | 2, 3) | (3, 2))
    }

    /// Compliance of the input link with a second contact at `k_m` on another phalanx, at the instant of that contact,
    /// radian per newton metre; `None` on a phalanx that the finger does not have or that is in contact already.
    pub fn second_compliance(&self, phalanx: u8, k_m: f32) -> Option<f32> {
        let first = self.contact.phalanx;
        if phalanx == first || !(1..=3).contains(&phalanx) {
            return None;
        }
        match SecondContact::on(self, phalanx) {
            Some(contact) => contact.compliance(k_m),
            // Joints 1 and 2 stand still, or 1 and the motion that the contact on phalanx 3 leaves.
            None => {
                let joint_1 = [1.0, 0.0, 0.0];
                let [p, mut other] = [self.arms_m, joint_1];
                if phalanx == 2 {
                    other = [0.0, 1.0, 0.0];
                }
                let p = if first == 1 { joint_1 } else { p };
                let v = cross(&p, &other);
                let (lever, mut energy) = (dot(&self.x, &v), 0.0);
                for i in 0..3 {
                    energy += v[i] * dot(&self.stiffness_nm_per_rad[i], &v);
                }
                let compliance = lever * (lever / energy);
                (compliance.is_finite() && energy > 0.0).then_some(compliance)
            }
        }
    }

    /// Whether the finger presses on an object at `k_m` on another phalanx as it closes on: the phalanx came nearer to it
    /// while the first contact alone held.
    pub fn second_presses(&self, phalanx: u8, k_m: f32) -> bool {
        let Some(tip) = usize::from(phalanx).checked_sub(1).filter(|tip| *tip < 3) else {
            return false;
        };
        let arms = contact_arms(&self.lengths_m, &self.turn, tip, k_m);
        phalanx != self.contact.phalanx && dot(&arms, &self.tangent_per_nm) > 0.0
    }

    /// Places of a second contact that explain a compliance, by bisection on the phalanges where the place matters.
    pub fn second_places(&self, compliance_rad_per_nm: f32) -> Candidates {
        self.places(compliance_rad_per_nm, |contact, compliance, length_m| {
            contact.bisected(compliance, length_m)
        })
    }

    /// The same in closed form: checks [`Self::second_places`] in tests.
    pub fn second_places_closed(&self, compliance_rad_per_nm: f32) -> Candidates {
        self.places(compliance_rad_per_nm, |contact, compliance, _| {
            contact.closed(compliance)
        })
    }

    fn places(
        &self,
        compliance: f32,
        solve: impl Fn(&SecondContact, f32, f32) -> super::Roots,
    ) -> Candidates {
        let mut found = Candidates::new();
        for (phalanx, length_m) in (1u8..).zip(self.lengths_m) {
            let Some(contact) = SecondContact::on(self, phalanx) else {
                continue;
            };
            let roots = solve(&contact, compliance, length_m);
            for (root, beyond_stiffest) in [(roots.near_m, false), (roots.far_m, true)] {
                if let Some(k_m) = root.filter(|k| *k > 0.0 && *k <= length_m) {
                    // Two a phalanx: the list holds them.
                    let _ = found.push(Candidate {
                        phalanx,
                        k_m,
                        beyond_stiffest,
                    });
                }
            }
        }
        found
    }
}

impl<T: Transmission<3>, B: BaseJoint> Finger<3, T, B> {
    /// Places of a second contact with their deviations. The first one was made at `torque_nm` in the free posture `at`.
    ///
    /// The posture is that of the first contact without friction after the rise of torque; the rotation is not asked.
    /// The deviation contains that of the compliance, of friction and leverage, and that of the first contact's place, which moves
    /// posture and force too. `None` where the first contact leads to no posture at the second; an empty list where no place is as stiff.
    ///
    /// ```
    /// use palpate::finger::{Contact, Finger, Mechanics, Parameters, SecondMeasured, Tendon};
    ///
    /// let finger: Finger<3, Tendon<3>> = Finger::new(
    ///     Parameters {
    ///         lengths_m: [0.090, 0.0675, 0.045],
    ///         stiffness_nm_per_rad: [0.1; 3],
    ///         rest_rad: [0.5; 3],
    ///         range_rad: [[-0.5, 2.0]; 3],
    ///     },
    ///     [0.009, 0.0072, 0.0054, 0.0036],
    /// )?;
    /// let at = finger.free_at_torque(0.02, &finger.rest()).expect("a posture");
    /// let first = Contact { phalanx: 2, k_m: 0.03, radius_m: 0.006 };
    /// // The same finger, felt: 10 mN m later something touches phalanx 3 at 25 mm.
    /// let mut path = finger.path(&at, 0.02, first).expect("it presses");
    /// finger.follow(&mut path, 0.010).expect("it stays");
    /// let pressed = finger.pressed(&path).expect("a posture");
    /// let compliance = pressed.second_compliance(3, 0.025).expect("a place");
    /// let measured = SecondMeasured {
    ///     rise_nm: 0.010,
    ///     rotation_rad: 0.0,
    ///     rotation_sigma_rad: f32::INFINITY,
    ///     torque_nm: 0.030,
    ///     later_nm: 0.0,
    ///     turned_rad: 0.0,
    ///     turned_sigma_rad: 0.0,
    ///     compliance_rad_per_nm: compliance,
    ///     compliance_sigma_rad_per_nm: 0.02 * compliance,
    ///     first_sigma_m: 0.5e-3,
    ///     friction: [0.0; 2],
    ///     half_thickness_m: 0.006,
    ///     leverage_sigma: 0.0,
    ///     joint_friction_nm: [0.0; 2],
    ///     joint_loss: [0.0; 2],
    /// };
    /// let places = finger.second_places(&at, 0.02, first, &measured).expect("a posture");
    /// assert!(places.iter().any(|p| p.place.phalanx == 3 && (p.place.k_m - 0.025).abs() < 1e-5));
    /// # Ok::<(), palpate::finger::ConfigError>(())
    /// ```
    pub fn second_places(
        &self,
        at: &Configuration<3>,
        torque_nm: f32,
        first: Contact,
        measured: &SecondMeasured,
    ) -> Option<heapless::Vec<SecondPlace, { super::mechanics::MOST_CANDIDATES }>> {
        let pressed = |k_m: f32| -> Option<Pressed<3>> {
            let mut path = self.path(at, torque_nm, Contact { k_m, ..first })?;
            self.follow(&mut path, measured.rise_nm)?;
            self.pressed(&path)
        };
        let compliance = measured.compliance_rad_per_nm;
        let here = pressed(first.k_m)?;
        let same = |pressed: &Pressed<3>, compliance: f32, place: &Candidate| {
            let is_same = |there: &Candidate| {
                there.phalanx == place.phalanx && there.beyond_stiffest == place.beyond_stiffest
            };
            pressed.second_places(compliance).into_iter().find(is_same)
        };
        // One deviation to either side, or as far as the phalanx goes.
        let beside = [-1.0, 1.0].map(|side| pressed(first.k_m + side * measured.first_sigma_m));
        let mut found = heapless::Vec::new();
        for mut place in here.second_places(compliance) {
            let Some(contact) = SecondContact::on(&here, place.phalanx) else {
                continue;
            };
            let rubbed_at =
                |place: &Candidate| self.shown(&here, place.phalanx, place.k_m, measured);
            let Some(mut rubbed) = rubbed_at(&place) else {
                continue;
            };
            // What friction takes depends on the place, so the place is sought again a few times.
            for _ in 0..CORRECTIONS {
                let nearer = same(&here, compliance / rubbed.left, &place);
                let Some((nearer, there)) = nearer.and_then(|at| Some((at, rubbed_at(&at)?)))
                else {
                    break;
                };
                (place, rubbed) = (nearer, there);
            }
            let slope = rubbed.left * contact.compliance_by_k(place.k_m);
            let mut sigma_m = rubbed.sigma / slope.abs();
            if measured.first_sigma_m > 0.0 {
                // The farther of the two: near the stiffest place one may have no solution.
                let mut moved_m = 0.0f32;
                for beside in beside.iter().flatten() {
                    if let Some(there) = same(beside, compliance / rubbed.left, &place) {
                        moved_m = moved_m.at_least((there.k_m - place.k_m).abs());
                    }
                }
                sigma_m = sqrt(sigma_m * sigma_m + moved_m * moved_m);
            }
            // As many as there are places.
            let _ = found.push(SecondPlace { place, sigma_m });
        }
        Some(found)
    }
}

/// Contact forces of a two-phalanx finger that touches with both phalanges, as far as statics determines them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoContactForces {
    /// f_2 k_2, moment of the distal contact about joint 2, newton metre: known whatever the places are.
    pub distal_moment_nm: f32,
    /// Force of the distal contact, newton: its place gives it, else not below `distal_moment_nm` / l_2.
    pub distal_force_n: Option<f32>,
    /// f_1 k_1, moment of the proximal contact about joint 1, newton metre; known with the distal contact's place. The
    /// proximal force is at least this over l_1.
    pub proximal_moment_nm: Option<f32>,
}

impl<T: Transmission<2>, B: BaseJoint> Finger<2, T, B> {
    /// What is known of the forces while both phalanges touch. The finger is rigid then but for its cable: posture and
    /// transmission stay as they were at the second contact, and the torque alone changes.
    ///
    /// `at` is the posture at the second contact, `torque_nm` the torque now, and `distal_k_m` the place on the distal
    /// phalanx where the first contact told it. `None` where a value is not finite or the place is not on the phalanx.
    pub fn held_by_both(
        &self,
        at: &Configuration<2>,
        torque_nm: f32,
        distal_k_m: Option<f32>,
    ) -> Option<TwoContactForces> {
        let gear = self.transmission.factors(at)?;
        let [tau_1, tau_2] = self.equivalent_torques_nm(&gear, at, torque_nm)?;
        let [l1, l2] = self.parameters.lengths_m;
        if distal_k_m.is_some_and(|k| !(k > 0.0 && k <= l2)) {
            return None;
        }
        let [_, theta_2] = at.turn();
        let distal_force_n = distal_k_m.map(|k| tau_2 / k);
        Some(TwoContactForces {
            distal_moment_nm: tau_2,
            distal_force_n,
            proximal_moment_nm: distal_force_n.map(|f| tau_1 - tau_2 - f * l1 * theta_2.cos),
        })
    }
}
