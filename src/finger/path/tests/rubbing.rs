//! A contact path with contact friction and losses on the way to the joints, against the balance of every joint in f64, and its
//! derivatives against differences.

use super::{arms, closed, derivatives, factors, followed, light, slope};
use crate::finger::path::{Path, Start};
use crate::finger::{
    BaseJoint, Configuration, Contact, Finger, Free, Mechanics, Mounting, PathPoint, Transmission,
};
use crate::scene::{Hidden3, Linkage3, P70, Return2, Scene, Tendon2, Tendon3};
use std::vec::Vec;

const HALF_THICKNESS_M: f32 = 0.006;
const FRICTIONS: [f32; 3] = [0.1, 0.5, 0.9];

/// Torque of contact friction about every joint for a contact force of 1 N, newton metre: a force of `friction` along the last phalanx
/// on its surface, away from its joint.
fn pulled<const N: usize>(
    lengths_m: &[f64; N],
    angles_rad: &[f64; N],
    k_m: f64,
    friction: f64,
) -> [f64; N] {
    let (mut joints, mut tip, mut turned) = (Vec::new(), [0.0f64; 2], 0.0f64);
    for (length, angle) in lengths_m.iter().zip(angles_rad) {
        turned += angle;
        joints.push(tip);
        tip = [
            tip[0] + length * turned.cos(),
            tip[1] + length * turned.sin(),
        ];
    }
    let (along, palm) = ([turned.cos(), turned.sin()], [-turned.sin(), turned.cos()]);
    let last = joints[N - 1];
    let thick = f64::from(HALF_THICKNESS_M);
    let surface: [f64; 2] =
        std::array::from_fn(|axis| last[axis] + k_m * along[axis] + thick * palm[axis]);
    std::array::from_fn(|m| {
        let arm = [surface[0] - joints[m][0], surface[1] - joints[m][1]];
        friction * (arm[0] * along[1] - arm[1] * along[0])
    })
}

/// Presses the finger with a contact on its last phalanx. Returns the point, the friction that acts with its sense, and for each joint the
/// share of its torque that is lost; `None` where the path ends before.
fn pressed<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    free: &Free<Configuration<N>>,
    contact: Contact,
    friction: f32,
    rise_nm: f32,
) -> Option<(PathPoint, [f32; 2], [f64; N])>
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = crate::finger::Path<N, B>>,
{
    let mut path = Mechanics::path(finger, &free.configuration, free.torque_nm, contact)?;
    finger.lose(&mut path);
    finger.rub(&mut path, friction, HALF_THICKNESS_M)?;
    let point = followed(finger, &mut path, rise_nm)?;
    let Start {
        friction,
        slides,
        taken,
        ..
    } = path.start;
    Some((point, [friction, slides], taken.map(f64::from)))
}

/// Checks the balance of every joint; the number of points that were on the finger, with how many of them slid outwards and how many joints
/// turned in another sense than they began to.
fn balance<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    theta_a_rad: f32,
    rise_nm: f32,
) -> [u32; 3]
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = crate::finger::Path<N, B>>,
{
    let lengths_m = finger.parameters.lengths_m.map(f64::from);
    let free = closed(finger, theta_a_rad);
    let at_rad = free.configuration.rad().map(f64::from);
    let x_before = factors(finger, &at_rad);
    let mut counts = [0; 3];
    for share in [0.2, 0.5, 0.9] {
        let contact = Contact {
            phalanx: N as u8,
            k_m: share * finger.parameters.lengths_m[N - 1],
            radius_m: 0.0,
        };
        for friction in FRICTIONS {
            let Some((point, [acting, sense], taken)) =
                pressed(finger, &free, contact, friction, rise_nm)
            else {
                continue;
            };
            assert!(
                taken
                    .iter()
                    .all(|taken| [0.0, T::JOINT_LOSS[0].into()].contains(&taken.abs()))
            );
            if point.rotation_rad < 0.0 {
                continue; // a return cable or a pulley still holds it
            }
            let delta: [f64; N] = std::array::from_fn(|joint| point.joints_rad[joint].into());
            let now: [f64; N] = std::array::from_fn(|joint| at_rad[joint] + delta[joint]);
            let x_now = factors(finger, &now);
            let k_now_m = f64::from(point.k_now_m);
            let outwards = sense < 0.0;
            counts[0] += 1;
            counts[1] += u32::from(outwards);
            let p = arms(&lengths_m, &now, k_now_m);
            let rubbed = pulled(&lengths_m, &now, k_now_m, f64::from(sense * acting));
            for joint in 0..N {
                counts[2] +=
                    u32::from(delta[joint] * taken[joint] < -1e-3 * f64::from(T::JOINT_LOSS[0]));
                let (before_nm, rise_nm) = (f64::from(free.torque_nm), f64::from(rise_nm));
                let stiffness = f64::from(finger.parameters.stiffness_nm_per_rad[joint]);
                let sprung = x_before[joint] * before_nm + stiffness * delta[joint];
                let opened = finger.base.return_cable().map_or(sprung, |cable| {
                    let lever: [f64; N] = cable.factors().map(f64::from);
                    let taken: f64 = lever.iter().zip(delta).map(|(y, turned)| y * turned).sum();
                    lever[joint] * (before_nm + f64::from(cable.stiffness_nm_per_rad) * taken)
                });
                let lost_nm = taken[joint] * x_now[joint];
                // A pulley takes its share of all torque that a return cable holds against, of a spring's of the rise alone, and where the
                // joint turns back twice what it took of the free finger's.
                let lost_nm = match finger.base.return_cable() {
                    Some(_) => lost_nm * (before_nm + rise_nm),
                    None if taken[joint] < 0.0 => lost_nm * (2.0 * before_nm + rise_nm),
                    None => lost_nm * rise_nm,
                };
                let driven = x_now[joint] * (before_nm + rise_nm) - x_before[joint] * before_nm;
                let left = x_now[joint] * (before_nm + rise_nm) - lost_nm - opened
                    + f64::from(point.force_n) * (rubbed[joint] - p[joint]);
                assert!(
                    left.abs() < 2e-5 + 1e-3 * driven.abs(),
                    "joint {joint} of {N}, {share} {friction}: {left} of {driven}"
                );
            }
        }
    }
    counts
}

#[test]
fn every_joint_is_balanced_with_friction() {
    let mut counts = [0; 3];
    for theta_a_rad in [0.3, 1.0] {
        for [points, outwards, otherwise] in [
            balance(&P70::MECHANISM, theta_a_rad, 0.04),
            balance(&light(Tendon2::MECHANISM), theta_a_rad, 0.04),
            balance(&light(Tendon3::MECHANISM), theta_a_rad, 0.04),
            balance(&light(Linkage3::MECHANISM), theta_a_rad, 0.04),
            balance(
                &Return2::MECHANISM.mounted(Mounting::LEVEL),
                theta_a_rad,
                0.15,
            ),
        ] {
            counts = [
                counts[0] + points,
                counts[1] + outwards,
                counts[2] + otherwise,
            ];
        }
    }
    let [points, outwards, otherwise] = counts;
    println!(
        "{points} points, {outwards} slide outwards, {otherwise} joints turn otherwise than they began to"
    );
    assert!(otherwise < points / 10);
    assert!(
        points > 50 && outwards > 5 && outwards < points - 5,
        "{counts:?}"
    );
}

/// Derivatives by friction, place and radius, and the compliance, against differences.
#[test]
fn derivatives_with_friction_are_those_of_the_path() {
    fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
        finger: &Finger<N, T, B>,
        name: &str,
        rise_nm: f32,
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
        for friction in FRICTIONS {
            let at = |contact: Contact, friction: f32, rise_nm: f32| {
                pressed(finger, &free, contact, friction, rise_nm)
                    .map(|(point, ..)| point)
                    .unwrap_or_else(|| panic!("{name} {friction} {contact:?}"))
            };
            let (told, [acting, _], _) = pressed(finger, &free, contact, friction, rise_nm)
                .unwrap_or_else(|| panic!("{name} {friction}"));
            if acting < friction {
                // The contact stays where it is but for rolling, and what the path bends.
                let moved_m = (told.k_now_m - contact.k_m).abs();
                assert!(moved_m < 2e-3, "{name} {friction} {told:?}");
                continue;
            }
            let small = 0.01;
            let [more, less] = [small, -small].map(|step| at(contact, friction + step, rise_nm));
            let by_force = (more.force_n - less.force_n) / (2.0 * small);
            let by_friction = slope(more, less, small);
            let mut pairs = derivatives(contact, rise_nm, |contact, rise_nm| {
                at(contact, friction, rise_nm)
            });
            pairs.push(("friction", told.rotation_by_friction_rad, by_friction));
            pairs.push(("force", told.force_by_friction_n, by_force));
            for (what, told, expected) in pairs {
                let off = (told - expected).abs() / expected.abs();
                assert!(
                    off < 0.02,
                    "{name} {friction}, by {what}: {told} {expected}"
                );
            }
        }
    }
    check(&P70::MECHANISM, "p70", 0.05);
    check(&light(Tendon2::MECHANISM), "tendon2", 0.05);
    check(&light(Tendon3::MECHANISM), "tendon3", 0.05);
    check(&light(Linkage3::MECHANISM), "linkage3", 0.05);
    // Under their weight.
    check(&Tendon2::MECHANISM, "heavy tendon2", 0.05);
    check(&Linkage3::MECHANISM, "heavy linkage3", 0.05);
    // Beyond break-away.
    check(
        &Return2::MECHANISM.mounted(Mounting::LEVEL),
        "return2",
        0.16,
    );
}

/// Begins a path from a contact on the last phalanx of a closed finger that loses some times the usual share on the way to the joints.
fn lossy<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    [share, radius_m]: [f32; 2],
    times: f32,
) -> Path<N, B>
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
{
    let free = closed(finger, 0.7);
    let contact = Contact {
        phalanx: N as u8,
        k_m: share * finger.parameters.lengths_m[N - 1],
        radius_m,
    };
    let mut path = Mechanics::path(finger, &free.configuration, free.torque_nm, contact).unwrap();
    finger.lose(&mut path);
    path.start.taken = path.start.taken.map(|taken| times * taken);
    path
}

/// The same with none of it and with the usual share, of the rise of the torque alone, as of a finger that is held at a stop.
fn lossless_and_lossy<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    contact: [f32; 2],
) -> [Path<N, B>; 2]
where
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
{
    [0.0, 1.0].map(|times| {
        let mut path = lossy(finger, contact, times);
        path.start.back = [0.0; N];
        path
    })
}

/// Compares the derivative by what is lost with the compliance of the same finger without losses, at once, where both are in one posture.
#[test]
fn the_derivative_by_losses_is_what_they_change() {
    fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
        finger: &Finger<N, T, B>,
        name: &str,
    ) -> [f32; 2]
    where
        Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
    {
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for share in [0.2, 0.4, 0.6, 0.8] {
            let [lossless, lossy] = lossless_and_lossy(finger, [share, 0.0])
                .map(|mut path| followed(finger, &mut path, 1e-4).unwrap());
            let [was, is] = [lossless, lossy].map(|point| point.compliance_rad_per_nm);
            let [loss, _] = T::JOINT_LOSS;
            let changed = (is - was) / was;
            let told = loss * lossy.compliance_by_loss_rad_per_nm / is;
            // What is left out is the square of it, and the path's rounding.
            let left = 2.0 * told * told + 2e-3;
            assert!(
                (told - changed).abs() < left,
                "{name} {share}: {told} {changed}"
            );
            range = [range[0].min(told), range[1].max(told)];
        }
        range
    }
    let [least, most] = check(&light(Tendon2::MECHANISM), "tendon2");
    assert!(least < -0.05 && least < 1.5 * most, "{least} {most}");
    check(&light(Tendon3::MECHANISM), "tendon3");
    assert_eq!(check(&light(Linkage3::MECHANISM), "linkage3"), [0.0; 2]);
}

/// Compares the derivative of the rotation by what is lost with how far the same finger turns if it loses a tenth more or less. Where a
/// joint turns back, as on `tendon3`, the rotation is negative until it does.
#[test]
fn what_is_lost_of_a_rotation_is_its_derivative() {
    fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
        finger: &Finger<N, T, B>,
        name: &str,
    ) -> usize
    where
        Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
    {
        let [loss, _] = T::JOINT_LOSS;
        let mut held = 0;
        for (share, friction) in [(0.2, 0.0), (0.4, 0.0), (0.6, 0.0), (0.2, 0.3), (0.4, 0.3)] {
            let mut paths = [0.9, 1.0, 1.1].map(|times| lossy(finger, [share, 0.01], times));
            for path in &mut paths {
                finger.rub(path, friction, HALF_THICKNESS_M).unwrap();
            }
            // As much for all: what holds a contact differs with what is lost.
            let acts = paths[1].start.friction;
            for path in &mut paths {
                path.start.friction = acts;
            }
            for rise_nm in [1e-3, 2e-3, 0.01, 0.02, 0.04] {
                let [less, usual, more] = paths
                    .each_mut()
                    .map(|path| followed(finger, path, rise_nm).unwrap());
                let expected = slope(more, less, 0.1 * loss);
                let off = usual.rotation_by_loss_rad / expected - 1.0;
                assert!(
                    expected < 0.0 && off.abs() < 0.01,
                    "{name} {share} {friction} {rise_nm}: {off}"
                );
                held += usize::from(usual.rotation_rad < 0.0);
            }
        }
        held
    }
    assert_eq!(check(&light(Tendon2::MECHANISM), "tendon2"), 0);
    assert!(check(&light(Tendon3::MECHANISM), "tendon3") > 5);
    check(&light(Hidden3::MECHANISM), "hidden3");
}

/// Sums the compliance's derivative up over the torque, as a fit does for a finger that is held at a stop, and compares it with how much
/// farther the same finger turns without losses. They agree within a third: the finger that turns less is in another posture, where it is
/// softer or stiffer.
#[test]
fn what_is_lost_of_a_rotation_is_about_the_sum_of_its_derivative() {
    const STEP_NM: f32 = 2.5e-3;
    /// The largest ratio of the sum to the rotation that is lacking.
    fn check<const N: usize, T: Transmission<N>, B: BaseJoint>(
        finger: &Finger<N, T, B>,
        name: &str,
    ) -> f32
    where
        Finger<N, T, B>: Mechanics<Configuration = Configuration<N>, Path = Path<N, B>>,
    {
        let [loss, _] = T::JOINT_LOSS;
        let mut most = f32::NEG_INFINITY;
        for share in [0.2, 0.4, 0.6] {
            let [mut lossless, mut lossy] = lossless_and_lossy(finger, [share, 0.01]);
            let (mut lost_rad, mut before) = (0.0, None);
            for step in 1..=16 {
                let rise_nm = STEP_NM * step as f32;
                let [all, left] = [&mut lossless, &mut lossy]
                    .map(|path| followed(finger, path, rise_nm).unwrap());
                let now = left.compliance_by_loss_rad_per_nm;
                lost_rad += 0.5 * STEP_NM * (before.unwrap_or(now) + now);
                before = Some(now);
                let ratio = loss * lost_rad / (left.rotation_rad - all.rotation_rad);
                assert!(
                    (0.7..1.35).contains(&ratio),
                    "{name} {share} {rise_nm}: {ratio}"
                );
                most = most.max(ratio);
            }
        }
        most
    }
    let most = check(&light(Tendon2::MECHANISM), "tendon2");
    assert!(most > 1.1, "{most}");
    check(&light(Tendon3::MECHANISM), "tendon3");
}
