//! Tasks `k2_2p_step` and `k2_3p_step`: the same places from a finite step of torque after contact, which the secant
//! stiffness tells with a bias (docs/MECHANICS.md#finite-torque-step). Fingers with four-bars, as the default scene's.

pub mod three;
pub mod two;

use crate::candidate::{NOWHERE, Roots, on_phalanx};
use palpate::finger::{Assembly, Candidate as Place, Contact, Inverse, Levers, Mechanics};
use palpate::sensing::location::{NoJointSensor, Rigid};
use palpate::sensing::step::{self, Measured};

/// A row of the files: a finger of N phalanges with S four-bars, its posture at contact, a step of torque.
#[derive(Clone, Copy, Debug)]
pub struct Row<const N: usize, const S: usize> {
    /// Phalanx in contact.
    pub phalanx: u8,
    /// Lengths.
    pub l: [f32; N],
    /// Stiffness of the springs.
    pub stiffness: [f32; N],
    /// Rest angles, radian.
    pub rest_rad: [f32; N],
    /// Angles at contact, radian.
    pub theta_rad: [f32; N],
    /// Least and greatest angle of each joint that the row shows, radian.
    pub range_rad: [[f32; 2]; N],
    /// a, b, c, psi and the mode of each four-bar.
    pub design: [[f32; 5]; S],
    /// The step.
    pub rise: Rise,
}

/// A step of torque after contact.
#[derive(Clone, Copy, Debug)]
pub struct Rise {
    /// Torque at contact.
    pub torque: f32,
    /// Rise of torque after contact.
    pub rise: f32,
    /// Rotation of the input link during the rise, radian.
    pub rotation_rad: f32,
    /// Rotation during its first half, radian.
    pub half_rotation_rad: f32,
}

/// A row made ready: what a firmware has at hand when the step is over.
#[derive(Clone, Copy, Debug)]
pub struct Step<F: Mechanics> {
    finger: F,
    at: F::Configuration,
    phalanx: u8,
    length: f32,
    step: Rise,
}

impl<const N: usize, const S: usize> Row<N, S> {
    /// Length of the phalanx in contact.
    pub fn length(&self) -> f32 {
        usize::from(self.phalanx)
            .checked_sub(1)
            .and_then(|at| self.l.get(at))
            .map_or(f32::NAN, |length| *length)
    }

    fn levers(&self) -> [Levers; S] {
        self.design.map(
            |[driving_m, coupler_m, driven_m, offset_rad, mode]| Levers {
                driving_m,
                coupler_m,
                driven_m,
                offset_rad,
                assembly: if mode > 0.0 {
                    Assembly::Counterclockwise
                } else {
                    Assembly::Clockwise
                },
            },
        )
    }

    fn ready<F: Mechanics>(&self, finger: F, near: &F::Configuration) -> Option<Step<F>> {
        Some(Step {
            at: finger.free_at_torque(self.rise.torque, near)?,
            finger,
            phalanx: self.phalanx,
            length: self.length(),
            step: self.rise,
        })
    }
}

// What any finger can be asked; each of the tasks has its own copies, timed apart.
impl<F: Mechanics> Step<F> {
    #[inline(always)]
    fn roots(&self, places: &[Place]) -> Roots {
        let mut roots = NOWHERE;
        for place in places.iter().filter(|place| place.phalanx == self.phalanx) {
            roots = [roots[1], on_phalanx(place.k_m, self.length)];
        }
        roots
    }

    #[inline(always)]
    fn tangent(&self, locate: impl Fn(&F, &F::Configuration, f32) -> Inverse) -> Roots {
        self.roots(locate(&self.finger, &self.at, self.step.torque).candidates())
    }

    /// The secant taken for the tangent, in closed form.
    #[inline(always)]
    fn secant(&self) -> Roots {
        let compliance = self.step.rotation_rad / self.step.rise;
        self.tangent(|finger, at, torque| finger.locate_closed(at, torque, compliance))
    }

    /// The same by bisection: the paper's way.
    #[inline(always)]
    fn bisected(&self) -> Roots {
        let compliance = self.step.rotation_rad / self.step.rise;
        self.tangent(|finger, at, torque| finger.locate(at, torque, compliance))
    }

    /// The secants of half the step and of the whole, extrapolated to no step.
    #[inline(always)]
    fn extrapolated(&self) -> Roots {
        let rotation = 4.0 * self.step.half_rotation_rad - self.step.rotation_rad;
        let compliance = rotation / self.step.rise;
        self.tangent(|finger, at, torque| finger.locate_closed(at, torque, compliance))
    }

    /// The finite step solved from each place that the secant gives.
    #[inline(always)]
    fn finite(&self) -> Roots {
        let mut roots = self.secant();
        for root in &mut roots {
            let contact = Contact {
                phalanx: self.phalanx,
                k_m: *root,
                radius_m: 0.0,
            };
            *root = self
                .finger
                .path(&self.at, self.step.torque, contact)
                .and_then(|guess| {
                    self.finger
                        .place(&guess, self.step.rise, self.step.rotation_rad)
                })
                .map_or(f32::NAN, |(k, _)| k);
        }
        roots
    }

    /// Every place that explains the finite step, from several starts on each phalanx.
    #[inline(always)]
    fn all_places(&self) -> Roots {
        let measured = Measured {
            rise_nm: self.step.rise,
            rotation_rad: self.step.rotation_rad,
            radius_m: 0.0,
        };
        let found = step::places(
            &self.finger,
            &self.at,
            self.step.torque,
            &measured,
            &Rigid,
            &NoJointSensor,
        );
        self.roots(&found)
    }
}
