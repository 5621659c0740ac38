//! A contact path on an object that gives way, against the balance of every joint and the object's own law in f64, and its derivatives
//! against differences.

use super::{arms, closed, derivatives, factors, followed, light, slope};
use crate::finger::{
    BaseJoint, Configuration, Contact, Finger, Free, Mechanics, PathPoint, Transmission,
};
use crate::scene::{Direct2, Hidden3, Linkage3, P70, Scene, Tendon2, Tendon3};

/// From nearly rigid to 50 N/m.
const COMPLIANCES: [f32; 4] = [1e-6, 3e-4, 2e-3, 2e-2];
const HALF_THICKNESS_M: f32 = 0.006;

/// The finger pressed by a contact on its last phalanx; `None` where that is lost on the way.
fn pressed<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    free: &Free<Configuration<N>>,
    contact: Contact,
    [give, friction]: [f32; 2],
    rise_nm: f32,
) -> Option<PathPoint>
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = crate::finger::Path<N, B>>,
{
    let mut path = Mechanics::path(finger, &free.configuration, free.torque_nm, contact)?;
    finger.soften(&mut path, give)?;
    if friction > 0.0 {
        finger.rub(&mut path, friction, HALF_THICKNESS_M)?;
        // Otherwise the contact is held, by as much friction as that needs.
        if path.start.friction < friction {
            return None;
        }
    }
    followed(finger, &mut path, rise_nm)
}

/// Distance of the centre of the object from the last phalanx's centre line, with the phalanx where `delta` has it and the centre where
/// it was at contact, metre.
fn distance<const N: usize>(
    lengths_m: &[f64; N],
    at_rad: &[f64; N],
    delta: &[f64; N],
    k_m: f64,
    radius_m: f64,
) -> f64 {
    let place = |angles: &[f64; N]| {
        let (mut tip, mut turned) = ([0.0f64; 2], 0.0f64);
        let mut last = tip;
        for (length, angle) in lengths_m.iter().zip(angles) {
            turned += angle;
            last = tip;
            tip = [
                tip[0] + length * turned.cos(),
                tip[1] + length * turned.sin(),
            ];
        }
        (last, turned)
    };
    let (joint, turned) = place(at_rad);
    let centre = [
        joint[0] + k_m * turned.cos() - radius_m * turned.sin(),
        joint[1] + k_m * turned.sin() + radius_m * turned.cos(),
    ];
    let now: [f64; N] = std::array::from_fn(|joint| at_rad[joint] + delta[joint]);
    let (joint, turned) = place(&now);
    (centre[1] - joint[1]) * turned.cos() - (centre[0] - joint[0]) * turned.sin()
}

/// Checks balance and the object's law; the number of points that were on the finger.
fn balance<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    theta_a_rad: f32,
) -> u32
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = crate::finger::Path<N, B>>,
{
    let rise_nm = 0.04;
    let lengths_m = finger.parameters.lengths_m.map(f64::from);
    let free = closed(finger, theta_a_rad);
    let at_rad = free.configuration.rad().map(f64::from);
    let x_before = factors(finger, &at_rad);
    let mut points = 0;
    for share in [0.2, 0.5, 0.9] {
        for radius_m in [0.0, 0.02] {
            let k_m = share * finger.parameters.lengths_m[N - 1];
            let contact = Contact {
                phalanx: N as u8,
                k_m,
                radius_m,
            };
            for give in COMPLIANCES {
                let Some(point) = pressed(finger, &free, contact, [give, 0.0], rise_nm) else {
                    continue;
                };
                points += 1;
                let delta: [f64; N] = std::array::from_fn(|joint| point.joints_rad[joint].into());
                let now: [f64; N] = std::array::from_fn(|joint| at_rad[joint] + delta[joint]);
                let x_now = factors(finger, &now);
                let force_n = f64::from(point.force_n);
                let p = arms(&lengths_m, &now, point.k_now_m.into());
                for joint in 0..N {
                    let (before_nm, rise_nm) = (f64::from(free.torque_nm), f64::from(rise_nm));
                    let driven = x_now[joint] * (before_nm + rise_nm) - x_before[joint] * before_nm;
                    let stiffness = f64::from(finger.parameters.stiffness_nm_per_rad[joint]);
                    let left = driven - stiffness * delta[joint] - force_n * p[joint];
                    assert!(
                        left.abs() < 2e-5 + 1e-3 * driven.abs(),
                        "joint {joint} of {N}, {share} {give}: {left} of {driven}"
                    );
                }
                let left_m = distance(
                    &lengths_m,
                    &at_rad,
                    &delta,
                    f64::from(k_m),
                    f64::from(radius_m),
                );
                let given_m = f64::from(radius_m) - left_m;
                let expected_m = f64::from(give) * force_n;
                assert!(
                    (given_m - expected_m).abs() < 3e-7 + 1e-4 * expected_m,
                    "{N}, {share} {give}: {given_m} for {expected_m}"
                );
            }
        }
    }
    points
}

#[test]
fn every_joint_is_balanced_and_the_object_gives_way_by_its_compliance() {
    let mut points = 0;
    for theta_a_rad in [0.3, 1.0] {
        points += balance(&P70::MECHANISM, theta_a_rad)
            + balance(&light(Tendon2::MECHANISM), theta_a_rad)
            + balance(&light(Tendon3::MECHANISM), theta_a_rad)
            + balance(&light(Linkage3::MECHANISM), theta_a_rad)
            + balance(&light(Hidden3::MECHANISM), theta_a_rad)
            + balance(&Direct2::MECHANISM, theta_a_rad);
    }
    assert!(points > 200, "{points}");
}

/// Derivatives by the object's compliance, place, radius and friction, and the compliance, against differences.
#[test]
fn derivatives_on_a_soft_object_are_those_of_the_path() {
    fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
        finger: &Finger<N, T, B>,
        name: &str,
        slides: u32,
    ) where
        Finger<N, T, B>:
            Mechanics<Configuration = Configuration<N>, Path = crate::finger::Path<N, B>>,
    {
        let free = closed(finger, 0.7);
        let contact = Contact {
            phalanx: N as u8,
            k_m: 0.35 * finger.parameters.lengths_m[N - 1],
            radius_m: 0.01,
        };
        let rise_nm = 0.05;
        let mut slid = 0;
        for give in [3e-4, 2e-3] {
            for friction in [0.0, 0.02] {
                let at = |contact: Contact, more: [f32; 2], rise_nm: f32| {
                    pressed(
                        finger,
                        &free,
                        contact,
                        [give + more[0], friction + more[1]],
                        rise_nm,
                    )
                    .unwrap_or_else(|| panic!("{name} {give} {friction}"))
                };
                if pressed(finger, &free, contact, [give, 1.3 * friction], rise_nm).is_none() {
                    continue;
                }
                slid += u32::from(friction > 0.0);
                let told = at(contact, [0.0; 2], rise_nm);
                let mut pairs = derivatives(contact, rise_nm, |contact, rise_nm| {
                    at(contact, [0.0; 2], rise_nm)
                });
                let beside = |more: [f32; 2]| at(contact, more, rise_nm);
                let small = 0.05 * give;
                let by_give = slope(beside([small, 0.0]), beside([-small, 0.0]), small);
                pairs.push(("give", told.rotation_by_give_rad_n_per_m, by_give));
                if friction > 0.0 {
                    let by_friction = slope(beside([0.0, 0.005]), beside([0.0, -0.005]), 0.005);
                    pairs.push(("friction", told.rotation_by_friction_rad, by_friction));
                }
                for (what, told, expected) in pairs {
                    let off = (told - expected).abs() / expected.abs();
                    assert!(
                        off < 0.02,
                        "{name} {give} {friction}, by {what}: {told} {expected}"
                    );
                }
            }
        }
        assert_eq!(slid, slides, "{name}");
    }
    check(&P70::MECHANISM, "p70", 2);
    check(&light(Tendon2::MECHANISM), "tendon2", 2);
    check(&light(Tendon3::MECHANISM), "tendon3", 1);
    check(&light(Linkage3::MECHANISM), "linkage3", 2);
    check(&light(Hidden3::MECHANISM), "hidden3", 2);
}

/// Nothing else enters a rigid object's path; what is no number is refused.
#[test]
fn an_object_of_no_compliance_is_rigid() {
    let finger = P70::MECHANISM;
    let free = closed(&finger, 0.7);
    let contact = Contact {
        phalanx: 2,
        k_m: 0.03,
        radius_m: 0.01,
    };
    let soft = pressed(&finger, &free, contact, [0.0; 2], 0.1).expect("presses");
    let mut path =
        Mechanics::path(&finger, &free.configuration, free.torque_nm, contact).expect("presses");
    assert_eq!(Some(soft), followed(&finger, &mut path, 0.1));
    for wrong in [f32::NAN, f32::INFINITY] {
        assert_eq!(pressed(&finger, &free, contact, [wrong, 0.0], 0.1), None);
    }
}
