//! Two phalanges.

use super::{Row, Step};
use crate::candidate::{Candidate, Roots};
use crate::two::library::kept;
use palpate::finger::{Finger, Linkage, Parameters, TorqueStep};

/// A row of the file.
pub type TwoRow = Row<2, 1>;

/// A row made ready.
pub type Ready = Step<Finger<2, Linkage<1>>>;

/// Makes a row ready; nothing where the library refuses it. Not inlined: its frame need not lie under the candidates.
#[inline(never)]
pub fn ready(row: &TwoRow) -> Option<Ready> {
    let parameters = Parameters {
        lengths_m: row.l,
        stiffness_nm_per_rad: row.stiffness,
        rest_rad: row.rest_rad,
        range_rad: row.range_rad,
    };
    let finger = Finger::new(parameters, row.levers()).ok()?;
    let near = finger.configuration(row.theta_rad).ok()?;
    row.ready(finger, &near)
}

/// The candidates.
pub const CANDIDATES: &[Candidate<Ready, Roots>] = &[
    Candidate {
        name: "finite_step_one_unknown",
        run: one_unknown,
        chosen: Some(
            "Finger::places_from_step, the library's answer to one step of torque: free of the secant's bias, a tenth of the general path's cost. The firmware asks it nothing: it fits the whole curve",
        ),
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

/// One equation for the change of joint 2, a point contact.
#[inline(never)]
fn one_unknown(input: &Ready) -> Roots {
    let rise = TorqueStep {
        torque_nm: input.step.rise,
        rotation_rad: input.step.rotation_rad,
    };
    kept(
        input
            .finger
            .places_from_step(&input.at, input.step.torque, &rise),
        input.length,
    )
}

/// The secant taken for the tangent, in closed form.
#[inline(never)]
fn secant(input: &Ready) -> Roots {
    input.secant()
}

/// The same by bisection: the paper's way.
#[inline(never)]
fn bisected(input: &Ready) -> Roots {
    input.bisected()
}

/// The secants of half the step and of the whole, extrapolated to no step.
#[inline(never)]
fn extrapolated(input: &Ready) -> Roots {
    input.extrapolated()
}

/// The finite step solved from each place that the secant gives.
#[inline(never)]
fn finite_step(input: &Ready) -> Roots {
    input.finite()
}

/// Every place that explains the finite step, from several starts on each phalanx.
#[inline(never)]
fn all_places(input: &Ready) -> Roots {
    input.all_places()
}
