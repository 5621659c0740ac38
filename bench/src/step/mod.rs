//! Tasks `k2_2p_step` and `k2_3p_step`: the same places from a finite step of torque after contact, which the secant
//! stiffness gives with a bias (docs/MECHANICS.md#finite-torque-step). Fingers with four-bars, as the default scene's.

mod one_unknown;

use crate::candidate::{Candidate, NOWHERE, Roots, on_phalanx};
use palpate::finger::{
    Assembly, Candidate as Place, Configuration, Contact, Finger, Inverse, Levers, Linkage,
    Mechanics, Parameters, Transmission,
};
use palpate::sensing::location::Rigid;
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

/// Two phalanges, one four-bar.
pub type TwoRow = Row<2, 1>;
/// Three phalanges, two four-bars.
pub type ThreeRow = Row<3, 2>;

/// A row made ready: what a firmware has at hand when the step is over.
#[derive(Clone, Copy, Debug)]
pub struct ContactStep<F: Mechanics> {
    finger: F,
    at: F::Configuration,
    phalanx: u8,
    length: f32,
    step: Rise,
}

/// A finger with four-bars, made ready.
pub type Ready<const N: usize, const S: usize> = ContactStep<Finger<N, Linkage<S>>>;

/// Makes a row ready; nothing where the library refuses it. Not inlined: its frame need not lie under the candidates.
#[inline(never)]
pub fn ready<const N: usize, const S: usize>(row: &Row<N, S>) -> Option<Ready<N, S>>
where
    Linkage<S>: Transmission<N, Design = [Levers; S]>,
    Finger<N, Linkage<S>>: Mechanics<Configuration = Configuration<N>>,
{
    let parameters = Parameters {
        lengths_m: row.l,
        stiffness_nm_per_rad: row.stiffness,
        rest_rad: row.rest_rad,
        range_rad: row.range_rad,
    };
    let finger = Finger::<N, Linkage<S>>::new(parameters, row.levers()).ok()?;
    let near = finger.configuration(row.theta_rad).ok()?;
    Some(ContactStep {
        at: finger.free_at_torque(row.rise.torque, &near)?,
        finger,
        phalanx: row.phalanx,
        length: row.length(),
        step: row.rise,
    })
}

/// Two phalanges.
pub const TWO: &[Candidate<Ready<2, 1>, Roots>] = &[
    Candidate::used(
        "finite_step_one_unknown",
        one_unknown::places,
        "no part of the firmware, which fits the whole curve: the cheapest answer to one step of torque without the secant's bias",
    ),
    Candidate::rival("finite_step", finite),
    Candidate::rival("finite_step_all_places", all_places),
    Candidate::rival("secant_closed", secant_closed),
    Candidate::rival("secant_bisection", secant_bisected),
    Candidate::rival("two_step_extrapolation", extrapolated),
];

/// Three phalanges.
pub const THREE: &[Candidate<Ready<3, 2>, Roots>] = &[
    Candidate::rival("finite_step", finite),
    Candidate::used(
        "finite_step_all_places",
        all_places,
        "sensing::step::places, which the firmware does not call (it fits the whole curve): the only method that finds every place of these rows",
    ),
    Candidate::rival("secant_closed", secant_closed),
    Candidate::rival("secant_bisection", secant_bisected),
    Candidate::rival("two_step_extrapolation", extrapolated),
];

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
}

impl<F: Mechanics> ContactStep<F> {
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
}

// What any finger can be asked; each of the tasks has its own copies, timed apart.

/// The secant taken for the tangent, in closed form.
#[inline(never)]
fn secant_closed<F: Mechanics>(input: &ContactStep<F>) -> Roots {
    let compliance = input.step.rotation_rad / input.step.rise;
    input.tangent(|finger, at, torque| finger.locate_closed(at, torque, compliance))
}

/// The same by bisection: the paper's way.
#[inline(never)]
fn secant_bisected<F: Mechanics>(input: &ContactStep<F>) -> Roots {
    let compliance = input.step.rotation_rad / input.step.rise;
    input.tangent(|finger, at, torque| finger.locate(at, torque, compliance))
}

/// The secants of half the step and of the whole, extrapolated to no step.
#[inline(never)]
fn extrapolated<F: Mechanics>(input: &ContactStep<F>) -> Roots {
    let rotation = 4.0 * input.step.half_rotation_rad - input.step.rotation_rad;
    let compliance = rotation / input.step.rise;
    input.tangent(|finger, at, torque| finger.locate_closed(at, torque, compliance))
}

/// The finite step solved from each place that the secant gives.
#[inline(never)]
fn finite<F: Mechanics>(input: &ContactStep<F>) -> Roots {
    let Rise {
        torque,
        rise,
        rotation_rad,
        ..
    } = input.step;
    secant_closed(input).map(|k_m| {
        let contact = Contact {
            phalanx: input.phalanx,
            k_m,
            radius_m: 0.0,
        };
        input
            .finger
            .path(&input.at, torque, contact)
            .and_then(|guess| input.finger.place(&guess, rise, rotation_rad))
            .map_or(f32::NAN, |(k, _)| k)
    })
}

/// Every place that explains the finite step, from several starts on each phalanx.
#[inline(never)]
fn all_places<F: Mechanics>(input: &ContactStep<F>) -> Roots {
    let measured = Measured {
        rise_nm: input.step.rise,
        rotation_rad: input.step.rotation_rad,
        radius_m: 0.0,
    };
    let found = step::places(
        &input.finger,
        &input.at,
        input.step.torque,
        &measured,
        &Rigid,
        None,
    );
    input.roots(&found)
}
