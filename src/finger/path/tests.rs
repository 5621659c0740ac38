//! A contact path under the finger's weight, against the balance of every joint with masses of their own, in f64.

mod held;
mod joint;
mod rubbing;
mod soft;

use crate::finger::{
    AnyBase, BaseJoint, Configuration, Contact, Finger, Free, Mechanics, PathPoint, Transmission,
};
use crate::scene::{Linkage3, P70, Scene, Tendon2};
use std::vec::Vec;

/// Slices into which a phalanx is cut.
const SLICES: usize = 200;

/// Torque of the weight about every joint, closing positive, newton metre, of even mass; angles from the first axis.
fn weight_torques<const N: usize>(
    lengths_m: &[f64; N],
    angles_rad: &[f64; N],
    per_m: [f64; 2],
) -> [f64; N] {
    let mut torques = [0.0; N];
    let (mut joints, mut tip, mut turned) = (Vec::new(), [0.0f64; 2], 0.0f64);
    for (length, angle) in lengths_m.iter().zip(angles_rad) {
        turned += angle;
        joints.push(tip);
        let along = [turned.cos(), turned.sin()];
        let slice = length / SLICES as f64;
        for n in 0..SLICES {
            let at = slice * (n as f64 + 0.5);
            for (torque, joint) in torques.iter_mut().zip(&joints) {
                let arm = [
                    tip[0] + at * along[0] - joint[0],
                    tip[1] + at * along[1] - joint[1],
                ];
                *torque += slice * (arm[0] * per_m[1] - arm[1] * per_m[0]);
            }
        }
        tip = [tip[0] + length * along[0], tip[1] + length * along[1]];
    }
    torques
}

/// Moment arms about the joints of a force across the last phalanx, metre.
fn arms<const N: usize>(lengths_m: &[f64; N], angles_rad: &[f64; N], k_m: f64) -> [f64; N] {
    let direction = |joint: usize| angles_rad[..=joint].iter().sum::<f64>();
    std::array::from_fn(|m| {
        let below = (m..N - 1).map(|j| lengths_m[j] * (direction(j) - direction(N - 1)).cos());
        k_m + below.sum::<f64>()
    })
}

/// Transmission factors by differences of the input angle.
fn factors<const N: usize, F>(finger: &F, angles_rad: &[f64; N]) -> [f64; N]
where
    F: Mechanics<Configuration = Configuration<N>>,
{
    std::array::from_fn(|joint| {
        let beside = |sign: f64| {
            let mut moved = angles_rad.map(|angle| angle as f32);
            moved[joint] += (sign * 0.01) as f32;
            let posture = Configuration::of(moved).expect("a posture");
            f64::from(finger.input_angle_rad(&posture))
        };
        (beside(1.0) - beside(-1.0)) / 0.02
    })
}

/// The free finger, closed by an angle of its input link from rest.
fn closed<F: Mechanics>(finger: &F, theta_a_rad: f32) -> Free<F::Configuration> {
    let rest = finger.rest();
    let at_rad = finger.input_angle_rad(&rest) + theta_a_rad;
    finger.free_at_angle(at_rad, &rest).expect("a posture")
}

/// A finger of a scene without the weight that the scene states.
fn light<const N: usize, T: Copy, B>(finger: Finger<N, T, B>) -> Finger<N, T> {
    let Finger {
        parameters,
        transmission,
        rest,
        ..
    } = finger;
    Finger {
        parameters,
        transmission,
        rest,
        base: AnyBase,
    }
}

/// Follows a path in eight parts.
fn followed<F: Mechanics>(finger: &F, path: &mut F::Path, rise_nm: f32) -> Option<PathPoint> {
    for part in 1..=8u8 {
        finger.follow(path, rise_nm * f32::from(part) / 8.0)?;
    }
    finger.follow(path, rise_nm)
}

/// Derivative of the rotation between two points a double step apart.
fn slope(more: PathPoint, less: PathPoint, step: f32) -> f32 {
    (more.rotation_rad - less.rotation_rad) / (2.0 * step)
}

/// Names, what a point tells and what differences show of the derivatives of the rotation by place and torque; `at` is the point
/// of a contact and a torque.
fn derivatives(
    contact: Contact,
    rise_nm: f32,
    at: impl Fn(Contact, f32) -> PathPoint,
) -> Vec<(&'static str, f32, f32)> {
    let (short, little) = (4e-4, 2e-3);
    let moved = |k: f32| {
        let moved = Contact {
            k_m: contact.k_m + k,
            ..contact
        };
        at(moved, rise_nm)
    };
    let told = at(contact, rise_nm);
    let by_k = slope(moved(short), moved(-short), short);
    let torques = [rise_nm + little, rise_nm - little];
    let [more, less] = torques.map(|rise_nm| at(contact, rise_nm));
    std::vec![
        ("k", told.rotation_by_k_rad_per_m, by_k),
        (
            "torque",
            told.compliance_rad_per_nm,
            slope(more, less, little)
        ),
    ]
}

fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    theta_1_rad: f32,
) where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = super::Path<N, B>>,
{
    let lengths_m = finger.parameters.lengths_m.map(f64::from);
    let length_m: f64 = lengths_m.iter().sum();
    // In line at contact, as the weight's torque assumes.
    let mut at_rad = [0.0; N];
    at_rad[0] = theta_1_rad;
    let at = Configuration::of(at_rad).expect("a posture");
    let x_before = factors(finger, &at_rad.map(f64::from));
    let contact = Contact {
        phalanx: N as u8,
        k_m: 0.6 * lengths_m[N - 1] as f32,
        radius_m: 0.0,
    };
    for contact_nm in [0.0, 0.02] {
        for (weight_nm, per_rad, held_nm) in [
            (0.012, -0.006, 0.0),
            (-0.015, 0.01, 0.0),
            (-0.015, 0.01, 0.001),
            (0.0, 0.02, 0.0),
        ] {
            let scale = 2.0 / (length_m * length_m);
            let per_m = [scale * per_rad, -scale * weight_nm];
            let mut path =
                Mechanics::path(finger, &at, contact_nm as f32, contact).expect("presses");
            finger.load(
                &mut path,
                [weight_nm as f32, per_rad as f32],
                held_nm as f32,
            );
            for rise_nm in [0.02, 0.05] {
                let point = finger.follow(&mut path, rise_nm as f32).expect("stays");
                let delta: [f64; N] = std::array::from_fn(|joint| point.joints_rad[joint].into());
                let now = std::array::from_fn(|joint| f64::from(at_rad[joint]) + delta[joint]);
                let x_now = factors(finger, &now);
                // Phalanx 1 lies along the first axis at contact.
                let before = weight_torques(&lengths_m, &[0.0; N], per_m);
                let after = weight_torques(&lengths_m, &delta, per_m);
                let p = arms(&lengths_m, &delta, point.k_now_m.into());
                for joint in 0..N {
                    let driven =
                        x_now[joint] * (contact_nm + rise_nm) - x_before[joint] * contact_nm;
                    let stiffness = f64::from(finger.parameters.stiffness_nm_per_rad[joint]);
                    let weighed = after[joint] - before[joint];
                    let held = if joint > 0 { held_nm } else { 0.0 };
                    let left = driven - stiffness * delta[joint] + weighed
                        - held
                        - f64::from(point.force_n) * p[joint];
                    assert!(
                        left.abs() < 1e-5 + 1e-3 * driven.abs(),
                        "joint {joint} of {N}, {weight_nm} {per_rad}: {left} of {driven}, weight {weighed}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_joint_is_balanced_under_weight() {
    check(&P70::MECHANISM, 0.7);
    check(&light(Tendon2::MECHANISM), 0.4);
    check(&light(Linkage3::MECHANISM), 0.4);
}

/// The compliance that a point tells is the slope of the rotation, weight included.
#[test]
fn compliance_under_weight_is_the_slope() {
    let finger = P70::MECHANISM;
    let at = Configuration::of([0.7, 0.0]).expect("a posture");
    let contact = Contact {
        phalanx: 2,
        k_m: 0.03,
        radius_m: 0.01,
    };
    for weight in [[0.012, -0.006], [-0.015, 0.01]] {
        let follow = |rise_nm: f32| {
            let mut path = Mechanics::path(&finger, &at, 0.0, contact).expect("presses");
            finger.load(&mut path, weight, 0.0);
            finger.follow(&mut path, rise_nm).expect("stays")
        };
        for rise_nm in [0.05, 0.15] {
            let step = 0.002;
            let slope = (follow(rise_nm + step).rotation_rad - follow(rise_nm - step).rotation_rad)
                / (2.0 * step);
            let told = follow(rise_nm).compliance_rad_per_nm;
            assert!(
                (told / slope - 1.0).abs() < 2e-3,
                "{rise_nm}: {told} {slope}"
            );
        }
    }
}
