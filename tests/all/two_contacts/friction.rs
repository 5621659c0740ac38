//! A second contact of a finger that rubs and sticks, and whose pulleys take some of the tension.

use super::{FRICTIONLESS, pressed_on, pressed_on_both};
use palpate::finger::{
    Configuration, Contact, Free, HoldsTwice, Mechanics, Mounting, Pressed, SecondMeasured,
};
use palpate::scene::Scene;
use palpate_scenes::Tendon3;

/// Contact friction by the full equations: unknown are the growth of both forces and the turning of the joints.
mod rubbing {
    use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

    const HALF_M: f64 = 0.006;

    /// Moment arms of a contact's force and of a force along its phalanx towards the joint, from the joints' angles.
    fn arms(lengths_m: [f64; 3], rad: [f64; 3], phalanx: usize, k_m: f64) -> [Vector3<f64>; 2] {
        let (mut press, mut rub) = (Vector3::zeros(), Vector3::zeros());
        for joint in 0..phalanx {
            (press[joint], rub[joint]) = (k_m, HALF_M);
            for below in joint..phalanx - 1 {
                let bend: f64 = rad[below + 1..phalanx].iter().sum();
                press[joint] += lengths_m[below] * bend.cos();
                rub[joint] -= lengths_m[below] * bend.sin();
            }
        }
        [press, rub]
    }

    /// Compliance of a finger that two contacts with friction hold. A pulley takes a share of the torque that is carried to a joint
    /// in the sense in which it turns.
    pub(super) fn compliance(
        pressed: &palpate::finger::Pressed<3>,
        (phalanx, k_m): (usize, f64),
        friction: f64,
        loss: f64,
    ) -> f64 {
        let lengths_m = [0.090, 0.0675, 0.045];
        let rad = pressed.joints_rad.map(f64::from);
        let first = usize::from(pressed.contact.phalanx);
        let contacts = [
            arms(lengths_m, rad, first, f64::from(pressed.k_now_m)),
            arms(lengths_m, rad, phalanx, k_m),
        ];
        let x = Vector3::from(pressed.x.map(f64::from));
        let h =
            Matrix3::from_fn(|row, column| f64::from(pressed.stiffness_nm_per_rad[row][column]));
        let turning = |senses: [f64; 2], carried: Vector3<f64>| {
            let mut matrix = SMatrix::<f64, 5, 5>::zeros();
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&h);
            for (at, ([press, rub], sense)) in contacts.iter().zip(senses).enumerate() {
                let force = press + friction * sense * rub;
                matrix.fixed_view_mut::<3, 1>(0, 3 + at).copy_from(&force);
                matrix
                    .fixed_view_mut::<1, 3>(3 + at, 0)
                    .copy_from(&press.transpose());
            }
            let mut right = SVector::<f64, 5>::zeros();
            right.fixed_rows_mut::<3>(0).copy_from(&carried);
            let solved = matrix.lu().solve(&right).expect("a finger that moves");
            let turned: Vector3<f64> = solved.fixed_rows::<3>(0).into();
            turned
        };
        let free = turning([0.0; 2], x);
        let senses = contacts.each_ref().map(|[_, rub]| rub.dot(&free).signum());
        let arrives = |turned: f64| 1.0 - loss * turned.signum();
        let carried = Vector3::from_fn(|joint, _| match joint {
            0 => x[0],
            _ => x[joint] * arrives(free[joint]),
        });
        x.dot(&turning(senses, carried))
    }
}

/// Torque at which phalanx 2 is touched, and the rise until phalanx 3 is, newton metre.
const TORQUE_NM: f32 = 0.03;
const RISE_NM: f32 = 0.02;

/// The level finger, its posture at the first contact, and that contact with the posture at the second.
struct Grip {
    finger: super::Three,
    at: Configuration<3>,
    first: Contact,
    pressed: Pressed<3>,
}

impl Grip {
    /// How far from the truth a contact on phalanx 3 is told that shows a compliance, with its deviation, metre; `None` where no
    /// place there is as stiff. `measured` says what is known of friction and losses.
    fn off_m(&self, truth_m: f64, compliance: f32, measured: SecondMeasured) -> Option<(f64, f64)> {
        let measured = SecondMeasured {
            rise_nm: RISE_NM,
            compliance_rad_per_nm: compliance,
            compliance_sigma_rad_per_nm: 0.01 * compliance,
            ..measured
        };
        let found = (self.finger).second_places(&self.at, TORQUE_NM, self.first, &measured);
        (found.expect("a posture").iter())
            .filter(|found| found.place.phalanx == 3)
            .map(|found| {
                let off_m = f64::from(found.place.k_m) - truth_m;
                (off_m, f64::from(found.sigma_m))
            })
            .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
    }
}

/// Goes through places of both contacts: `off_m` tells how far from the truth the second one is placed by who knows what rubs,
/// and by who does not. Prints the means over those that have a place, and returns them with their number.
fn compared(off_m: impl Fn(&Grip, f64) -> Option<[f64; 2]>) -> (u32, [f64; 2]) {
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let at = (finger.free_at_torque(TORQUE_NM, &finger.rest())).expect("free");
    let (mut count, mut sums) = (0, [0.0; 2]);
    for first_m in [0.025, 0.030, 0.035] {
        let first = Contact {
            phalanx: 2,
            k_m: first_m,
            radius_m: 0.006,
        };
        let pressed = pressed_on(&finger, &at, TORQUE_NM, first, RISE_NM);
        let grip = Grip {
            finger,
            at,
            first,
            pressed,
        };
        for truth_m in [0.022, 0.027, 0.032] {
            if let Some(off_m) = off_m(&grip, truth_m) {
                count += 1;
                for (sum, off_m) in sums.iter_mut().zip(off_m) {
                    *sum += off_m.abs();
                }
            }
        }
    }
    let means_m = sums.map(|sum| sum / f64::from(count));
    let [with, without] = means_m.map(|m| 1e3 * m);
    println!("{count} off by {with:.2} mm, by {without:.2} mm without it");
    (count, means_m)
}

/// With friction the finger is stiffer, and a place that takes it into account is nearer to the truth.
#[test]
fn friction_is_taken_off_a_second_place() {
    let (count, [with, without]) = compared(|grip, truth_m| {
        let frictionless = f64::from(
            (grip.pressed)
                .second_compliance(3, truth_m as f32)
                .expect("a place"),
        );
        let none = rubbing::compliance(&grip.pressed, (3, truth_m), 0.0, 0.0);
        assert!(
            (none / frictionless - 1.0).abs() < 1e-3,
            "{none} {frictionless}"
        );
        let compliance = rubbing::compliance(&grip.pressed, (3, truth_m), 0.1, 0.0);
        assert!(compliance < frictionless, "{compliance} {frictionless}");
        let told = |friction: f32| {
            let measured = SecondMeasured {
                friction: [friction, 0.5 * friction],
                ..FRICTIONLESS
            };
            grip.off_m(truth_m, compliance as f32, measured)
        };
        let ((taken, sigma_m), (left, _)) = (told(0.1)?, told(0.0)?);
        assert!(taken.abs() < 2.0 * sigma_m, "{truth_m}: {taken} {sigma_m}");
        Some([taken, left])
    });
    assert!(count >= 5 && with < 0.4 * without);
}

/// A pulley takes some of the torque, whether its joint closes or opens: the finger is stiffer, and a place that takes it into account
/// is nearer to the truth.
#[test]
fn what_pulleys_take_is_taken_off_a_second_place() {
    let (count, [with, without]) = compared(|grip, truth_m| {
        let compliance = rubbing::compliance(&grip.pressed, (3, truth_m), 0.0, 0.03) as f32;
        let told = |loss: f32| {
            let measured = SecondMeasured {
                joint_loss: [loss, 0.0],
                ..FRICTIONLESS
            };
            grip.off_m(truth_m, compliance, measured)
        };
        let ((taken, _), (left, _)) = (told(0.03)?, told(0.0)?);
        Some([taken, left])
    });
    assert!(count >= 5 && with < 0.3 * without);
}

/// The posture at the second contact is that of a first contact that rubs. Where something else takes of the torque, or adds to it, the
/// posture follows from how far the input link has turned.
#[test]
fn the_posture_at_a_second_contact_is_that_of_a_finger_that_rubs() {
    let finger = Tendon3::MECHANISM;
    let (torque, rise) = (0.03f32, 0.08f32);
    let configuration = finger.free_at_torque(torque, &finger.rest()).expect("free");
    let free = Free {
        configuration,
        torque_nm: torque,
    };
    let mut worst = [0.0f32; 4];
    for (k_m, friction) in [
        (0.02, 0.1),
        (0.02, 0.3),
        (0.035, 0.1),
        (0.035, 0.3),
        (0.05, 0.2),
    ] {
        let first = Contact {
            phalanx: 2,
            k_m,
            radius_m: 0.01,
        };
        let mut path = finger
            .path(&free.configuration, torque, first)
            .expect("it presses");
        finger.rub(&mut path, friction, 0.006).expect("stable");
        let point = finger.follow(&mut path, rise).expect("it stays");
        let truth_rad = finger.pressed(&path).expect("stable").joints_rad;
        let off_rad = |mean: f32, share: f32, rotation_sigma_rad: f32| {
            let measured = SecondMeasured {
                rise_nm: share * rise,
                torque_nm: torque + share * rise,
                rotation_rad: point.rotation_rad,
                rotation_sigma_rad,
                friction: [mean, 0.1],
                compliance_rad_per_nm: 1.0,
                compliance_sigma_rad_per_nm: 1.0,
                ..FRICTIONLESS
            };
            let held = finger
                .second_contact(&free, first, &measured)
                .expect("it holds");
            let off = held.configuration.rad().into_iter().zip(truth_rad);
            off.fold(0.0f32, |most, (told, truth)| most.max((told - truth).abs()))
        };
        let found = [
            off_rad(friction, 1.0, f32::INFINITY),
            off_rad(0.0, 1.0, f32::INFINITY),
            off_rad(friction, 1.2, 0.005),
            off_rad(friction, 1.2, f32::INFINITY),
        ];
        println!("{k_m} m, friction {friction}: {found:?}");
        for (worst, found) in worst.iter_mut().zip(found) {
            *worst = worst.max(found);
        }
    }
    let [known, unaware, by_rotation, by_torque] = worst;
    assert!(known < 1e-5 && unaware > 0.05, "{known} {unaware}");
    assert!(
        by_rotation < 1e-3 && by_torque > 0.05,
        "{by_rotation} {by_torque}"
    );
}

/// Sticking and rubbing that the finger's user does not know place a second contact no farther off than its deviation says, and
/// much nearer than the slope at the corner, where the finger sticks, would.
#[test]
fn a_finger_that_sticks_at_first_is_placed_by_what_follows() {
    let finger = Tendon3::MECHANISM;
    let (torque, rise, later) = (0.03f32, 0.03, 0.04f32);
    let configuration = finger.free_at_torque(torque, &finger.rest()).expect("free");
    let at = Free {
        configuration,
        torque_nm: torque,
    };
    let (mut worst, mut count) = (0.0f32, 0);
    for first_m in [0.038f32, 0.042, 0.046] {
        let (first, pressed) = pressed_on_both(&finger, &configuration, torque, first_m, rise);
        let truth_m = 0.0675 - pressed.k_now_m;
        for friction in [0.0f64, 0.1, 0.2] {
            // The finger sticks for 12 mN m per 0.1, then gives way, rubbed by the full equations.
            let moves = later - 0.12 * friction as f32;
            let at_once =
                rubbing::compliance(&pressed, (3, f64::from(truth_m)), friction, 0.0) as f32;
            let measured = SecondMeasured {
                rise_nm: rise,
                torque_nm: torque + rise,
                later_nm: later,
                turned_rad: 0.9 * at_once * moves,
                ..FRICTIONLESS
            };
            let (there, k_m) = finger
                .turned_on(&pressed, 3, truth_m, &measured)
                .expect("a posture");
            let compliance = rubbing::compliance(&there, (3, f64::from(k_m)), friction, 0.0) as f32;
            let measured = SecondMeasured {
                turned_rad: 0.5 * moves * (at_once + compliance),
                turned_sigma_rad: 0.0035,
                compliance_rad_per_nm: compliance,
                compliance_sigma_rad_per_nm: 0.05 * compliance,
                first_sigma_m: 1.5e-3,
                friction: [0.1, 0.1],
                ..measured
            };
            let found = finger.second_contact(&at, first, &measured).expect("one");
            println!(
                "{first_m} {friction}: {truth_m} {} {}",
                found.k_m, found.sigma_m
            );
            assert_eq!(found.phalanx, 3);
            worst = worst.max(((found.k_m - truth_m) / found.sigma_m).abs());
            count += 1;
        }
    }
    assert!(count == 9 && worst < 2.0, "{worst}");
}
