//! Files that follow a finger from rest over the first contact to a finite step: `preshape`, `kc`, `contact`.

use crate::equilibrium::{Contact, Linear, arms, free, pressed};
use crate::finger::{Finger, hessian};
use crate::linear::Vector;
use crate::real::Real;
use crate::table::Row;
use crate::value::{Values, joint_names};

/// Posture at contact. Without a spring at joint 1 its angle is an input, and the other joints rest.
///
/// # Panics
/// There is no such posture.
#[must_use]
pub fn posture(row: &Row, finger: &Finger, torque: &Real) -> Vector {
    let mut near = finger.rest.clone();
    if finger.springs[0].is_zero() {
        near[0] = row.real("th1");
    }
    free(finger, torque, &near).expect("a posture of the free finger")
}

/// Tangent stiffness of the free finger.
fn tangent(finger: &Finger, torque: &Real, theta: &[Real]) -> Real {
    let compliance = Linear::at(finger, torque, theta).free_compliance();
    Real::one() / compliance.expect("a stable finger")
}

/// `preshape_*`.
#[must_use]
pub fn preshape(row: &Row) -> Values {
    let finger = row.finger();
    let torque = row.real("T_a");
    let theta = posture(row, &finger, &torque);
    let turned = finger.theta_a(&theta) - finger.theta_a(&finger.rest);
    let tangent = tangent(&finger, &torque, &theta);
    let global = if torque.is_zero() {
        tangent.clone()
    } else {
        &torque / &turned
    };
    let transmission = Linear::at(&finger, &torque, &theta).row;
    let mut values = Values::new();
    values.joints("th", "", &theta);
    values.number("dtheta_a", &turned);
    values.number("K_a", &global);
    values.number("K_tangent", &tangent);
    values.transmission(&transmission);
    values
}

/// `kc_*`.
///
/// # Panics
/// The finger has no posture at this torque, or the contact none of its motion.
#[must_use]
pub fn stiffness(row: &Row) -> Values {
    let finger = row.finger();
    let torque = row.real("T_c");
    let theta = posture(row, &finger, &torque);
    let (phalanx, k) = (row.phalanx("phal"), row.real("k"));
    let linear = Linear::at(&finger, &torque, &theta);
    let held = linear
        .held(&arms(&finger, &theta, phalanx, &k))
        .expect("a contact");
    let curvature = hessian(&theta, |theta| finger.theta_a(theta));
    let mut values = Values::new();
    values.joints("th", "", &theta);
    values.transmission(&linear.row);
    for i in 1..finger.joints() {
        for j in i..finger.joints() {
            values.number(
                &format!("g{}{}", i + 1, j + 1),
                &(&torque * &curvature[i][j]),
            );
        }
    }
    values.number("C", &held.compliance);
    values.number("K_c", &(Real::one() / &held.compliance));
    match finger.springs[0].is_zero() {
        true => values.absent("C_free"),
        false => values.number(
            "C_free",
            &linear.free_compliance().expect("a stable finger"),
        ),
    }
    values.number("df_dT", &held.press);
    for (name, motion) in joint_names("dth", "_dT").zip(&held.motion) {
        values.number(&name, motion);
    }
    // Where a contact on phalanx 2 of two would leave the finger rigid, (27).
    let x2 = &linear.row[1];
    let reach = &finger.lengths[0] * theta[1].sin_cos().1;
    values.number("e2", &(reach * x2 / (Real::one() - x2)));
    values
}

/// A contact at the end of the free motion, and how far the torque rises then: the inputs of a row.
pub(crate) struct FirstContact {
    pub finger: Finger,
    /// Torque at contact.
    pub torque: Real,
    /// By how much the torque rises.
    pub rise: Real,
    /// Posture at contact.
    pub theta: Vector,
    pub phalanx: usize,
    /// Place on the phalanx.
    pub k: Real,
    pub contact: Contact,
}

impl FirstContact {
    pub(crate) fn of(row: &Row) -> Self {
        let finger = row.finger();
        let torque = row.real("T_c");
        let theta = posture(row, &finger, &torque);
        let (phalanx, k) = (row.phalanx("phal"), row.real("k"));
        let contact = Contact {
            phalanx,
            point: finger.point(&theta, phalanx, &k),
        };
        Self {
            finger,
            torque,
            rise: row.real("dT"),
            theta,
            phalanx,
            k,
            contact,
        }
    }
}

/// `contact_*`.
///
/// # Panics
/// The finger has no posture at this torque, or leaves the contact.
#[must_use]
pub fn step(row: &Row) -> Values {
    let FirstContact {
        finger,
        torque,
        rise,
        theta,
        phalanx,
        k,
        contact,
    } = FirstContact::of(row);
    let after = |rise: &Real| {
        pressed(&finger, &torque, rise, &contact, &theta).expect("a posture after the step")
    };
    let (whole, half) = (after(&rise), after(&(&rise * Real::from(0.5))));
    let start = finger.theta_a(&theta);
    let whole_turn = finger.theta_a(&whole.theta) - &start;
    let half_turn = finger.theta_a(&half.theta) - &start;
    let held = Linear::at(&finger, &torque, &theta)
        .held(&arms(&finger, &theta, phalanx, &k))
        .expect("a contact");
    let mut values = Values::new();
    values.joints("th", "", &theta);
    values.joints("th", "_after", &whole.theta);
    values.number(
        "k_after",
        &finger.seen_from(&whole.theta, phalanx, &contact.point).0,
    );
    values.number("f", &whole.force);
    values.number("dtheta_a", &whole_turn);
    values.number("dtheta_a_half", &half_turn);
    values.number("K_secant", &(&rise / &whole_turn));
    values.number("K_c", &(Real::one() / &held.compliance));
    values.number("df_dT_at_contact", &held.press);
    values
}
