//! The place of a contact from one finite step of torque, two phalanges (docs/MECHANICS.md#finite-torque-step): one
//! equation for one unknown, the change of joint 2.
//!
//! Unlike `Mechanics::place`, which follows any finger's contact on a cylinder, this takes the contact for a point
//! and needs a fraction of the time. Every quantity is a change since contact: nothing is lost by taking absolute angles or
//! torques apart.

use super::{Ready, Rise};
use crate::candidate::{Roots, on_phalanx};
use palpate::finger::{JointStep, Transmission, TwoJointContact};
use palpate::numeric::Rotation;

/// Newton steps; started from the secant's place, two or three are taken.
const STEPS: u8 = 8;
/// A change of the unknown this small, as a share of the rotations, leaves its square: their rounding.
const SETTLED_SHARE: f32 = 2e-4;

/// The places on phalanx 2 from where a contact point at rest explains the step. Each root of the secant, taken for the
/// tangent, starts one search: below e_2 and beyond. NaN where the search leaves the phalanx or does not settle.
#[inline(never)]
pub fn places(input: &Ready<2, 1>) -> Roots {
    let Some(factors) = input.finger.transmission().factors(&input.at) else {
        return [f32::NAN; 2];
    };
    let parameters = input.finger.parameters();
    let ([l1, _], [k1, k2]) = (parameters.lengths_m, parameters.stiffness_nm_per_rad);
    let ([_, theta_2], [_, x2], [_, [_, w22]]) = (input.at.turn(), factors.x, factors.w);
    let contact = TwoJointContact {
        c_m: l1 * theta_2.cos,
        x2,
        k1,
        h22: k2 - input.step.torque * w22,
    };
    let secant = contact.closed(input.step.rotation_rad / input.step.rise);
    [secant.near_m, secant.far_m].map(|start| {
        start
            .and_then(|start_m| place_near(input, &contact, w22, start_m))
            .unwrap_or(f32::NAN)
    })
}

fn place_near(input: &Ready<2, 1>, pair: &TwoJointContact, w22: f32, start_m: f32) -> Option<f32> {
    let (finger, at) = (&input.finger, &input.at);
    let Rise {
        torque,
        rise,
        rotation_rad,
        ..
    } = input.step;
    let parameters = finger.parameters();
    let ([l1, l2], [k1, k2]) = (parameters.lengths_m, parameters.stiffness_nm_per_rad);
    let ([_, theta_2], x2) = (at.turn(), pair.x2);
    // The tangent's answer for the start.
    let arm = start_m + pair.c_m;
    let energy = k1 * start_m * start_m + pair.h22 * arm * arm;
    let mut delta_2 = rise * arm * ((arm * x2 - start_m) / energy);
    for _ in 0..STEPS {
        let half_2 = Rotation::by(0.5 * delta_2);
        let step = JointStep {
            rad: [0.0, delta_2],
            half: [Rotation::NONE, half_2],
        };
        let (turned_rad, [_, x2_change]) = finger.transmission().changes(at, &step)?;
        let delta_1 = rotation_rad - turned_rad;
        let x2_now = x2 + x2_change;
        // Changes of the joints' torques: the contact force's, times its moment arms.
        let tau_1 = rise - k1 * delta_1;
        let tau_2 = x2_now * rise + x2_change * torque - k2 * delta_2;
        let half_1 = Rotation::by(0.5 * delta_1);
        let now = theta_2.then(half_2.twice());
        let sum = half_1.then(half_2).twice();
        // The contact point seen from joint 1 stays, and its force is normal to the phalanx.
        let (drop, lean) = (2.0 * half_1.sin, theta_2.then(half_1.back()));
        let residual = now.cos * tau_2 * sum.sin + (tau_1 - tau_2) * drop * lean.cos;
        let (tau_1_slope, tau_2_slope) = (k1 * x2_now, w22 * (torque + rise) - k2);
        let slope = (now.cos * tau_2_slope - now.sin * tau_2) * sum.sin
            + now.cos * tau_2 * sum.cos * (1.0 - x2_now)
            + (tau_1_slope - tau_2_slope) * drop * lean.cos
            - (tau_1 - tau_2) * x2_now * lean.then(half_1.back()).cos;
        let change = residual / slope;
        delta_2 -= change;
        if change.abs() <= SETTLED_SHARE * (delta_2.abs() + delta_1.abs()) {
            // So near that joint 1 follows in proportion, and the next step would change less than rounding.
            let half_1 = Rotation::by(0.5 * (delta_1 + x2_now * change));
            let half_2 = Rotation::by(0.5 * delta_2);
            let lean = theta_2.then(half_2.twice()).then(half_1);
            let k = -2.0 * l1 * half_1.sin * lean.cos / half_1.then(half_2).twice().sin;
            return Some(on_phalanx(k, l2));
        }
    }
    None
}
