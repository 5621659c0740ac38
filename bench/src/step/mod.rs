//! Task `k2_2p_step`: the same place from a finite step of torque after contact, which the secant stiffness tells with a bias
//! (MATH 7). Fingers with a four-bar, as the default scene's.

use crate::candidate::{Candidate, NOWHERE, Roots, on_phalanx};
use crate::two::library::kept;
use palpate::finger::{
    Assembly, Candidate as Place, Configuration, Contact, Finger, Levers, Linkage, Mechanics,
    Parameters, Rise,
};
use palpate::sensing::location::{NoJointSensor, Rigid};
use palpate::sensing::step::{self, Measured};

/// A row of the files: a finger with two phalanges, its posture at contact, a step of torque.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Lengths.
    pub l: [f32; 2],
    /// Stiffness of the springs.
    pub stiffness: [f32; 2],
    /// Rest angles, radian.
    pub rest_rad: [f32; 2],
    /// Angles at contact, radian.
    pub theta_rad: [f32; 2],
    /// a, b, c, psi and the mode of the four-bar.
    pub design: [f32; 5],
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
pub struct Step {
    finger: Finger<2, Linkage<1>>,
    at: Configuration<2>,
    torque: f32,
    rise: f32,
    rotation_rad: f32,
    half_rotation_rad: f32,
}

fn parameters(row: &Row) -> Parameters<2> {
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

/// Makes a row ready; nothing where the library refuses it.
pub fn ready(row: &Row) -> Option<Step> {
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
    let finger = Finger::<2, Linkage<1>>::new(parameters(row), [levers]).ok()?;
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

fn roots(places: &[Place], length: f32) -> Roots {
    let mut roots = NOWHERE;
    for place in places.iter().filter(|place| place.phalanx == 2) {
        roots = [roots[1], on_phalanx(place.k_m, length)];
    }
    roots
}

/// The candidates.
pub const CANDIDATES: &[Candidate<Step, Roots>] = &[
    Candidate {
        name: "finite_step_one_unknown",
        run: one_unknown,
        chosen: None,
    },
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

fn closed(input: &Step, compliance: f32) -> Roots {
    let found = input
        .finger
        .locate_closed(&input.at, input.torque, compliance);
    roots(found.candidates(), input.finger.parameters().lengths_m[1])
}

/// The secant taken for the tangent, in closed form.
#[inline(never)]
fn secant(input: &Step) -> Roots {
    closed(input, input.rotation_rad / input.rise)
}

/// The same by bisection: the paper's way.
#[inline(never)]
fn bisected(input: &Step) -> Roots {
    let compliance = input.rotation_rad / input.rise;
    let found = input.finger.locate(&input.at, input.torque, compliance);
    roots(found.candidates(), input.finger.parameters().lengths_m[1])
}

/// The secants of half the step and of the whole, extrapolated to no step.
#[inline(never)]
fn extrapolated(input: &Step) -> Roots {
    let rotation = 4.0 * input.half_rotation_rad - input.rotation_rad;
    closed(input, rotation / input.rise)
}

/// One equation for the change of joint 2, a point contact.
#[inline(never)]
fn one_unknown(input: &Step) -> Roots {
    let rise = Rise {
        torque_nm: input.rise,
        rotation_rad: input.rotation_rad,
    };
    kept(
        input
            .finger
            .places_from_step(&input.at, input.torque, &rise),
        input.finger.parameters().lengths_m[1],
    )
}

/// The finite step solved from each place that the secant gives.
#[inline(never)]
fn finite_step(input: &Step) -> Roots {
    secant(input).map(|k_m| {
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: 0.0,
        };
        input
            .finger
            .path(&input.at, input.torque, contact)
            .and_then(|guess| input.finger.place(&guess, input.rise, input.rotation_rad))
            .map_or(f32::NAN, |(k, _)| k)
    })
}

/// Every place that explains the finite step, from several starts on each phalanx.
#[inline(never)]
fn all_places(input: &Step) -> Roots {
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
