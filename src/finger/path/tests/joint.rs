//! Joint 2 along a contact path, and its derivatives against differences.

use super::{closed, followed, light};
use crate::finger::{BaseJoint, Configuration, Contact, Finger, Mechanics, Path, Transmission};
use crate::scene::{Linkage3, P70, Scene, Tendon2, Tendon3};

const HALF_THICKNESS_M: f32 = 0.006;
const RISE_NM: f32 = 0.05;

/// The number of points at which all of the friction acts: where less holds the contact, its derivatives mean nothing.
fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    name: &str,
) -> u32
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
{
    let free = closed(finger, 0.7);
    let length_m = finger.parameters.lengths_m[N - 1];
    let path = |k_m: f32, friction: f32, rise_nm: f32| {
        let contact = Contact {
            phalanx: N as u8,
            k_m,
            radius_m: 0.01,
        };
        let mut path = Mechanics::path(finger, &free.configuration, free.torque_nm, contact)
            .unwrap_or_else(|| panic!("{name}: {contact:?}"));
        (finger.rub(&mut path, friction, HALF_THICKNESS_M)).expect("a stable finger");
        let end = followed(finger, &mut path, rise_nm).expect("a contact that stays");
        let joint = finger.joint_2(&path).expect("a joint");
        assert_eq!(joint.rad, end.joints_rad[1], "{name}");
        (joint, path.start.friction < friction)
    };
    let rad = |k_m, friction, rise_nm| path(k_m, friction, rise_nm).0.rad;
    let mut points = 0;
    for (share, friction) in [
        (0.2, 0.0),
        (0.5, 0.0),
        (0.2, 0.02),
        (0.35, 0.1),
        (0.6, 0.1),
        (0.8, 0.3),
    ] {
        let k_m = share * length_m;
        let (told, held) = path(k_m, friction, RISE_NM);
        if held {
            continue;
        }
        points += 1;
        let slope = |step: f32, at: &dyn Fn(f32) -> f32| (at(step) - at(-step)) / (2.0 * step);
        let by_k = slope(4e-4, &|k| rad(k_m + k, friction, RISE_NM));
        let by_friction = if friction == 0.0 {
            told.by_friction_rad
        } else {
            slope(0.01, &|more| rad(k_m, friction + more, RISE_NM))
        };
        let by_torque = slope(2e-3, &|more| rad(k_m, friction, RISE_NM + more));
        for (what, told, expected) in [
            ("k", told.by_k_rad_per_m, by_k),
            ("friction", told.by_friction_rad, by_friction),
            ("torque", told.by_torque_rad_per_nm, by_torque),
        ] {
            let off = (told - expected).abs() / expected.abs();
            assert!(
                off < 0.02,
                "{name} {share} {friction}, by {what}: {told} {expected}"
            );
        }
    }
    points
}

#[test]
fn derivatives_of_joint_2_are_those_of_the_path() {
    let points = [
        check(&P70::MECHANISM, "p70"),
        check(&light(Tendon2::MECHANISM), "tendon2"),
        check(&light(Tendon3::MECHANISM), "tendon3"),
        check(&light(Linkage3::MECHANISM), "linkage3"),
        check(&Tendon2::MECHANISM, "heavy tendon2"),
    ];
    // A little friction holds the last phalanx of tendon3.
    assert_eq!(points, [6, 6, 2, 5, 6]);
}

/// A weight presses joint 2 of P70 on its stop. Below the torque that lifts it off the path leads back through the stop, and what the joint
/// takes counts the same way there as above: by it, and by differences.
#[test]
fn what_holds_a_joint_counts_alike_on_both_sides_of_break_away() {
    const JOINT_NM: f32 = 3e-3;
    let finger = P70::MECHANISM;
    let at = Configuration::of([0.7, 0.0]).expect("a posture");
    for (k_m, held_nm) in [(0.02, 0.0), (0.04, 6.7e-3), (0.055, 6.7e-3)] {
        let follow = |joint_nm: f32, rise_nm: f32| {
            let contact = Contact {
                phalanx: 2,
                k_m,
                radius_m: 0.016,
            };
            let path = Mechanics::path(&finger, &at, -0.025, contact);
            let mut path = path.expect("a contact that presses");
            finger.load(&mut path, [-0.025, 0.0], held_nm);
            finger.brake(&mut path, joint_nm);
            (finger.rub(&mut path, 0.3, HALF_THICKNESS_M)).expect("a stable finger");
            followed(&finger, &mut path, rise_nm).expect("a contact that stays")
        };
        let mut sides = [0; 2];
        for rise_nm in [0.005, 0.015, 0.03, 0.06, 0.1, 0.15] {
            let told = follow(JOINT_NM, rise_nm);
            sides[usize::from(told.joints_rad[1] > 0.0)] += 1;
            let step_nm = 2e-4;
            let [more, less] =
                [1.0, -1.0].map(|sign| follow(JOINT_NM + sign * step_nm, rise_nm).rotation_rad);
            let expected = (more - less) / (2.0 * step_nm);
            let off = told.rotation_by_joint_friction_rad_per_nm / expected - 1.0;
            assert!(
                expected < -0.1 && off.abs() < 0.02,
                "{k_m} {held_nm} {rise_nm}: {told:?}, {expected} by differences"
            );
        }
        assert!(sides[0] > 0 && sides[1] > 0, "{k_m} {held_nm}: {sides:?}");
    }
}
