//! Files about more than one contact or more than one motor: `second`, `actuated`.

use crate::equilibrium::{Linear, arms, pressed};
use crate::finger::{Finger, hessian};
use crate::forward::FirstContact;
use crate::linear::{Vector, border, dot, solve};
use crate::real::Real;
use crate::table::Row;
use crate::value::Values;

/// `second_*`: after a first contact and a rise of the torque, a second one.
///
/// The stiffness is the Hessian of the potential less the first force times that of the gap to a point fixed in space:
/// how the contact slides is in it. Both gaps' gradients border it.
///
/// # Panics
/// The finger has no posture at this torque, or leaves the contact.
#[must_use]
pub fn second(row: &Row) -> Values {
    let first = FirstContact::of(row);
    let (finger, theta, contact) = (first.finger, first.theta, first.contact);
    let after = pressed(&finger, &first.torque, &first.rise, &contact, &theta).expect("a posture");
    let at = &after.theta;
    let now = &first.torque + &first.rise;
    let mut linear = Linear::at(&finger, &now, at);
    let gap = |theta: &[Real]| finger.seen_from(theta, first.phalanx, &contact.point).1;
    let curvature = hessian(at, gap);
    for (line, curved) in linear.stiffness.iter_mut().zip(&curvature) {
        for (entry, curved) in line.iter_mut().zip(curved) {
            *entry = &*entry - &after.force * curved;
        }
    }
    let place = finger.seen_from(at, first.phalanx, &contact.point).0;
    let pressing = arms(&finger, at, first.phalanx, &place);
    let alone = linear.held(&pressing).expect("a contact");
    let next = arms(&finger, at, row.phalanx("phal_b"), &row.real("k_b"));
    let both = bordered_by_two(&linear, &pressing, &next);
    let mut values = Values::new();
    values.joints("th", "", &theta);
    values.joints("th", "_after", at);
    values.number("k_after", &place);
    values.number("f", &after.force);
    values.number("C_first", &alone.compliance);
    values.number("C_second", &both.0);
    values.number("df_b_dT", &both.1);
    values
}

/// Compliance with two contacts, and how the second one's force grows with the torque.
fn bordered_by_two(linear: &Linear, first: &[Real], next: &[Real]) -> (Real, Real) {
    let mut further = next.to_vec();
    further.push(Real::zero());
    let matrix = border(&border(&linear.stiffness, first), &further);
    let mut right = linear.row.clone();
    right.extend([Real::zero(), Real::zero()]);
    let (motion, _) = solve(matrix, right).expect("two contacts of three joints");
    let force = motion[motion.len() - 1].clone();
    (dot(&linear.row, &motion[..linear.row.len()]), force)
}

/// `actuated_*`: a motor at every joint.
///
/// # Panics
/// The contact has no motion.
#[must_use]
pub fn actuated(row: &Row) -> Values {
    let read = |prefix: &str, suffix: &str| -> Vector {
        let names = (1..).map(|joint| format!("{prefix}{joint}{suffix}"));
        names
            .take_while(|name| row.has(name))
            .map(|name| row.real(&name))
            .collect()
    };
    let finger = Finger {
        lengths: read("l", ""),
        springs: read("K", ""),
        rest: read("th", "0"),
        stages: Vec::new(),
    };
    let torques = read("t", "");
    let theta: Vector = (finger.rest.iter().zip(&torques))
        .zip(&finger.springs)
        .map(|((rest, torque), spring)| rest + torque / spring)
        .collect();
    let energy = |theta: &[Real]| finger.potential(&Real::zero(), theta);
    let arms = arms(&finger, &theta, row.phalanx("phal"), &row.real("k"));
    let mut values = Values::new();
    values.joints("th", "", &theta);
    let compliances: Vector = (0..finger.joints())
        .map(|motor| {
            let mut row = vec![Real::zero(); finger.joints()];
            row[motor] = Real::one();
            let linear = Linear {
                row,
                stiffness: hessian(&theta, energy),
            };
            linear.held(&arms).expect("a contact").compliance
        })
        .collect();
    values.joints("C", "", &compliances);
    values
}
