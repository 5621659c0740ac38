//! Tasks `k2_2p_step` and `k2_2p_step_tendon`: the same place from a finite step of torque after contact, which the secant
//! stiffness tells with a bias (MATH 7). Fingers with one four-bar, and with a tendon.

use crate::candidate::{Candidate, NOWHERE, Roots, on_phalanx};
use palpate::finger::{
    Assembly, Candidate as Place, Configuration, Contact, Finger, Levers, Linkage, Mechanics,
    Parameters, Tendon,
};
use palpate::sensing::location::{NoJointSensor, Rigid};
use palpate::sensing::step::{self, Measured};

/// A row of the files: a finger with two phalanges, its posture at contact, a step of torque.
#[derive(Clone, Copy, Debug)]
pub struct Row<D> {
    /// Lengths.
    pub l: [f32; 2],
    /// Stiffness of the springs.
    pub stiffness: [f32; 2],
    /// Rest angles, radian.
    pub rest_rad: [f32; 2],
    /// Angles at contact, radian.
    pub theta_rad: [f32; 2],
    /// Radii of the pulleys, or a, b, c, psi and the mode of the four-bar.
    pub design: D,
    /// Torque at contact.
    pub torque: f32,
    /// Rise of torque after contact.
    pub rise: f32,
    /// Rotation of the input link during the rise, radian.
    pub rotation_rad: f32,
    /// Rotation during its first half, radian.
    pub half_rotation_rad: f32,
}

/// Levers of a four-bar: a, b, c, psi, mode.
pub type FourBar = [f32; 5];
/// Radii r_1, r_2 of the pulleys.
pub type Pulleys = [f32; 2];

/// A row made ready: what a firmware has at hand when the step is over.
#[derive(Clone, Copy, Debug)]
pub struct Step<T> {
    finger: Finger<2, T>,
    at: Configuration<2>,
    torque: f32,
    rise: f32,
    rotation_rad: f32,
    half_rotation_rad: f32,
}

fn parameters<D>(row: &Row<D>) -> Parameters<2> {
    // Wide enough for any posture of the file.
    let range = |i: usize| {
        [
            row.theta_rad[i].min(row.rest_rad[i]) - 0.01,
            row.theta_rad[i] + 0.3,
        ]
    };
    Parameters {
        lengths_m: row.l,
        stiffness_nm_per_rad: row.stiffness,
        rest_rad: row.rest_rad,
        range_rad: [range(0), range(1)],
    }
}

fn ready<T, D>(row: &Row<D>, finger: Finger<2, T>) -> Option<Step<T>>
where
    T: Copy + palpate::finger::Transmission<2>,
    Finger<2, T>: Mechanics<Configuration = Configuration<2>>,
{
    let near = finger.configuration(row.theta_rad).ok()?;
    Some(Step {
        at: finger.free_at_torque(row.torque, &near)?,
        finger,
        torque: row.torque,
        rise: row.rise,
        rotation_rad: row.rotation_rad,
        half_rotation_rad: row.half_rotation_rad,
    })
}

/// A finger with a four-bar; nothing where the library refuses the row.
pub fn linkage(row: &Row<FourBar>) -> Option<Step<Linkage<1>>> {
    let [driving_m, coupler_m, driven_m, offset_rad, mode] = row.design;
    let levers = Levers {
        driving_m,
        coupler_m,
        driven_m,
        offset_rad,
        assembly: if mode > 0.0 {
            Assembly::Counterclockwise
        } else {
            Assembly::Clockwise
        },
    };
    ready(row, Finger::new(parameters(row), [levers]).ok()?)
}

/// A finger with a tendon; nothing where the library refuses the row.
pub fn tendon(row: &Row<Pulleys>) -> Option<Step<Tendon<2>>> {
    ready(row, Finger::new(parameters(row), row.design).ok()?)
}

fn roots(places: &[Place], length: f32) -> Roots {
    let mut roots = NOWHERE;
    for place in places.iter().filter(|place| place.phalanx == 2) {
        roots = [roots[1], on_phalanx(place.k_m, length)];
    }
    roots
}

macro_rules! candidates {
    ($module:ident, $transmission:ty) => {
        /// The candidates for one transmission.
        pub mod $module {
            use super::*;

            type Input = Step<$transmission>;

            /// The candidates.
            pub const CANDIDATES: &[Candidate<Input, Roots>] = &[
                Candidate {
                    name: "finite_step",
                    run: finite_step,
                    chosen: None,
                },
                Candidate {
                    name: "finite_step_all_places",
                    run: all_places,
                    chosen: None,
                },
                Candidate {
                    name: "secant_closed",
                    run: secant,
                    chosen: None,
                },
                Candidate {
                    name: "secant_bisection",
                    run: bisected,
                    chosen: None,
                },
                Candidate {
                    name: "two_step_extrapolation",
                    run: extrapolated,
                    chosen: None,
                },
            ];

            fn closed(input: &Input, compliance: f32) -> Roots {
                let found = input
                    .finger
                    .locate_closed(&input.at, input.torque, compliance);
                roots(found.candidates(), input.finger.parameters().lengths_m[1])
            }

            /// The secant taken for the tangent, in closed form.
            #[inline(never)]
            fn secant(input: &Input) -> Roots {
                closed(input, input.rotation_rad / input.rise)
            }

            /// The same by bisection: the paper's way.
            #[inline(never)]
            fn bisected(input: &Input) -> Roots {
                let compliance = input.rotation_rad / input.rise;
                let found = input.finger.locate(&input.at, input.torque, compliance);
                roots(found.candidates(), input.finger.parameters().lengths_m[1])
            }

            /// The secants of half the step and of the whole, extrapolated to no step.
            #[inline(never)]
            fn extrapolated(input: &Input) -> Roots {
                let rotation = 4.0 * input.half_rotation_rad - input.rotation_rad;
                closed(input, rotation / input.rise)
            }

            /// The finite step solved from each place that the secant gives.
            #[inline(never)]
            fn finite_step(input: &Input) -> Roots {
                secant(input).map(|k_m| {
                    let contact = Contact {
                        phalanx: 2,
                        k_m,
                        radius_m: 0.0,
                    };
                    input
                        .finger
                        .path(&input.at, input.torque, contact)
                        .and_then(|guess| {
                            input.finger.place(&guess, input.rise, input.rotation_rad)
                        })
                        .map_or(f32::NAN, |(k, _)| k)
                })
            }

            /// Every place that explains the finite step, from several starts on each phalanx.
            #[inline(never)]
            fn all_places(input: &Input) -> Roots {
                let measured = Measured {
                    rise_nm: input.rise,
                    rotation_rad: input.rotation_rad,
                    radius_m: 0.0,
                };
                let found = step::places(
                    &input.finger,
                    &input.at,
                    input.torque,
                    &measured,
                    &Rigid,
                    &NoJointSensor,
                );
                roots(&found, input.finger.parameters().lengths_m[1])
            }
        }
    };
}

candidates!(by_linkage, Linkage<1>);
candidates!(by_tendon, Tendon<2>);
