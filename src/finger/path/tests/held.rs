//! Linear responses of the finger held by the contact, against the same equations with the contact force as an unknown, in f64.

use super::{closed, followed, light};
use crate::finger::path::linearization::Linearization;
use crate::finger::path::response::Responses;
use crate::finger::{Contact, Direct, Finger, Mechanics, Parameters};
use crate::scene::{Scene, Tendon2, Tendon3};
use nalgebra::{DMatrix, DVector};

/// Solves `H delta + p F = t` and `p . delta - a F = g` in f64 for the joints' changes and, last, the contact force.
fn exact<const N: usize>(local: &Linearization<N>, torques: [f64; N], gap: f64) -> DVector<f64> {
    let held = DMatrix::from_fn(N + 1, N + 1, |row, column| match (row < N, column < N) {
        (true, true) => f64::from(local.stiffness[row][column]),
        (true, false) => f64::from(local.pressing[row]),
        (false, true) => f64::from(local.arms[column]),
        (false, false) => -f64::from(local.give),
    });
    let side = DVector::from_iterator(N + 1, torques.into_iter().chain([gap]));
    held.lu().solve(&side).expect("held by the object")
}

/// Compliance h of the finger at the contact without the object, dimensionless; `None` where the finger alone is singular.
fn own<const N: usize>(local: &Linearization<N>) -> Option<f64> {
    let stiffness = DMatrix::from_fn(N, N, |row, column| f64::from(local.stiffness[row][column]));
    let pressing = DVector::from_iterator(N, local.pressing.map(f64::from));
    let turned = stiffness.lu().solve(&pressing)?;
    Some(
        turned
            .iter()
            .zip(local.arms)
            .map(|(x, arm)| x * f64::from(arm))
            .sum(),
    )
}

/// A finger of three phalanges with a motor at each joint.
fn finger([a, b, c]: [f32; 3]) -> Finger<3, Direct<3>> {
    let parameters = Parameters {
        lengths_m: [a, b, c],
        stiffness_nm_per_rad: [1.0, 0.3 + 0.5 * c, 0.2 + 0.5 * a],
        rest_rad: [0.2, 0.3 * b, 0.5 * c],
        range_rad: [[0.0, 3.0]; 3],
    };
    Finger::new(parameters, ()).expect("in range")
}

/// Returns the larger relative error of two answers at a point: the tangent, and the rotation's derivative by the place. Both are
/// relative to the largest change of a joint.
fn off(local: &Linearization<3>, force: f32) -> f64 {
    let Responses { by_k, tangent, .. } = local.responses(force).expect("held");
    let along = exact(local, local.driving.map(f64::from), 0.0);
    let turns = tangent.delta.iter().zip(&along);
    let off = turns.map(|(told, turns)| (f64::from(*told) - turns).abs());
    let by_torque = off.fold(0.0, f64::max) / along.rows(0, 3).amax();
    let load = (local.loaded).map(|arm| f64::from(-force * local.phi.cos * arm));
    let answer = exact(local, load, f64::from(-local.phi.sin));
    let turned: f64 = (local.x.iter().zip(&answer))
        .map(|(x, turned)| f64::from(*x) * turned)
        .sum();
    let by_place = (f64::from(by_k) - turned).abs() / answer.rows(0, 3).amax();
    by_torque.max(by_place)
}

/// A formulation with a spring of stiffness 1 across the contact is singular at h = -1 and loses digits near it: 1e-4. The largest errors
/// that are left lie at the ends of paths, where even the object hardly keeps the finger stable.
#[test]
fn a_finger_that_the_object_alone_keeps_stable_costs_no_digits() {
    let (mut points, mut unstable, mut near) = (0, 0, 0);
    for shape in 0..27u8 {
        let lengths_m = [shape % 3, shape / 3 % 3, shape / 9].map(|n| 0.5 + 0.4 * f32::from(n));
        let finger = finger(lengths_m);
        let free = closed(&finger, 0.3);
        for (phalanx, share) in [(2u8, 0.3f32), (2, 0.9), (3, 0.2), (3, 0.5), (3, 0.9)] {
            for (radius_m, give) in [(0.0, 0.0), (0.1, 0.0), (0.3, 0.0), (0.1, 0.05)] {
                let contact = Contact {
                    phalanx,
                    k_m: share * lengths_m[usize::from(phalanx) - 1],
                    radius_m,
                };
                let path = Mechanics::path(&finger, &free.configuration, free.torque_nm, contact);
                let Some(mut path) = path else { continue };
                if finger.soften(&mut path, give).is_none() {
                    continue;
                }
                for step in 1..400u16 {
                    if finger.follow(&mut path, f32::from(step) * 0.01).is_none() {
                        break;
                    }
                    let (at, rise) = (&path.last.at, path.last.rise);
                    let local =
                        (path.start.local(&finger.transmission, at, rise)).expect("a point");
                    let off = off(&local, at.force);
                    let h = own(&local).unwrap_or(f64::INFINITY);
                    points += 1;
                    unstable += u32::from(h < 0.0);
                    let is_near = (h + 1.0).abs() < 0.05;
                    near += u32::from(is_near);
                    let most = if is_near { 5e-7 } else { 3e-5 };
                    assert!(off < most, "{lengths_m:?} {contact:?} {rise}: {off:e}");
                }
            }
        }
    }
    assert!(
        points > 50_000 && unstable > 1_000 && near >= 5,
        "{points} {unstable} {near}"
    );
}

/// However much a contact rubs, what losses leave of its slide goes on: a finger does not turn back by friction.
#[test]
fn friction_that_holds_a_lossy_finger_turns_it_no_way_back() {
    for (torque_nm, k_m) in [(0.1, 0.0608), (0.1, 0.0405), (0.08, 0.0608), (0.05, 0.0405)] {
        let finger = light(Tendon2::MECHANISM);
        let free = finger.preshape(torque_nm, &finger.rest()).unwrap();
        let contact = Contact {
            phalanx: 2,
            k_m,
            radius_m: 0.011,
        };
        for friction in [0.0, 0.06, 0.1, 0.25, 0.6] {
            let mut path = finger.path(&free, torque_nm, contact).unwrap();
            finger.lose(&mut path);
            finger.rub(&mut path, friction, 0.006).unwrap();
            let point = followed(&finger, &mut path, 0.05).unwrap();
            let [turned, softness] = [point.rotation_rad, point.compliance_rad_per_nm];
            assert!(
                turned > 0.0 && softness > 0.0,
                "{torque_nm} {k_m} {friction}: {turned} {softness}"
            );
        }
    }
}

/// While a pulley keeps joint 2 of `tendon3` from turning back the changes of its joints have other signs than later: what bearing friction
/// does to the rotation is the same before and after.
#[test]
fn what_bearings_take_does_not_jump_where_a_pulley_gives_way() {
    let finger = Tendon3::MECHANISM;
    let free = finger
        .free_at_angle(1.8, &finger.rest())
        .expect("a free finger");
    let contact = Contact {
        phalanx: 3,
        k_m: 0.0135,
        radius_m: 0.014,
    };
    let path = Mechanics::path(&finger, &free.configuration, free.torque_nm, contact);
    let mut path = path.expect("a path");
    finger.lose(&mut path);
    let mut before = None;
    let mut signs = [false; 2];
    for step in 1..=60u8 {
        let rise_nm = 0.5e-3 * f32::from(step);
        let point = finger.follow(&mut path, rise_nm).expect("a point");
        signs[usize::from(point.joints_rad[1] < 0.0)] = true;
        let now = point.rotation_by_joint_friction_rad_per_nm;
        let change = before.map_or(0.0, |before: f32| now / before - 1.0);
        assert!(
            change.abs() < 0.02,
            "{rise_nm}: {now}, a change of {change}"
        );
        before = Some(now);
    }
    assert_eq!(signs, [true; 2], "it gives way");
}
