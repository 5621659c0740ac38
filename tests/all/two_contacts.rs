//! A second contact: honest deviations of its place, and the forces that statics still tells with two phalanges.

use palpate::finger::{
    ActuatedFinger, Contact, Finger, Free, HoldsTwice, Mechanics, Mounting, NoSecondContact,
    Parameters, SecondMeasured, Tendon,
};
use palpate::scene::Scene;
use palpate_scenes::{P70, Tendon3};

/// A measurement of a finger without friction.
const FRICTIONLESS: SecondMeasured = SecondMeasured {
    rise_nm: 0.0,
    torque_nm: 0.0,
    later_nm: 0.0,
    turned_rad: 0.0,
    turned_sigma_rad: 0.0,
    compliance_rad_per_nm: 0.0,
    compliance_sigma_rad_per_nm: 0.0,
    first_sigma_m: 0.0,
    friction: [0.0; 2],
    half_thickness_m: 0.006,
    leverage_sigma: 0.0,
};

/// Deviates of a normal distribution: sums of twelve uniform ones.
struct Noise(u64);

impl Noise {
    fn deviate(&mut self) -> f32 {
        let uniform = |_| {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..12).map(uniform).sum::<f32>() - 6.0
    }
}

/// The place found from noisy measurements is off by what its deviation says.
#[test]
fn deviations_of_a_second_place_are_honest() {
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let (torque, rise) = (0.03, 0.02);
    let at = finger
        .free_at_torque(torque, &finger.rest())
        .expect("a posture");
    let mut noise = Noise(1);
    for (first, phalanx, k) in [(2, 3, 0.012), (2, 3, 0.030), (1, 3, 0.020), (3, 2, 0.010)] {
        let contact = |k_m| Contact {
            phalanx: first,
            k_m,
            radius_m: 0.006,
        };
        let k_first = if first == 3 { 0.012 } else { 0.030 };
        let mut path = finger.path(&at, torque, contact(k_first)).expect("presses");
        finger.follow(&mut path, rise).expect("stays");
        let pressed = finger.pressed(&path).expect("stable");
        assert!(pressed.second_presses(phalanx, k), "{first} {phalanx}");
        let truth = pressed.second_compliance(phalanx, k).expect("a place");
        let sigma = 0.01 * truth;
        let first_sigma = 0.3e-3;
        let (mut squares, mut count) = (0.0, 0);
        for _ in 0..200 {
            let measured = SecondMeasured {
                rise_nm: rise,
                compliance_rad_per_nm: truth + sigma * noise.deviate(),
                compliance_sigma_rad_per_nm: sigma,
                first_sigma_m: first_sigma,
                ..FRICTIONLESS
            };
            let felt = contact(k_first + first_sigma * noise.deviate());
            let places = finger
                .second_places(&at, torque, felt, &measured)
                .expect("a posture");
            let nearest = places
                .iter()
                .filter(|found| found.place.phalanx == phalanx)
                .map(|found| (found.place.k_m - k) / found.sigma_m)
                .min_by(|a, b| a.abs().total_cmp(&b.abs()));
            if let Some(z) = nearest {
                squares += z * z;
                count += 1;
            }
        }
        let rms = (squares / count as f32).sqrt();
        println!(
            "first on {first}, second on {phalanx} at {k} m: {count} of 200 placed, rms of error over deviation {rms:.2}"
        );
        // After phalanx 3 phalanx 2 hardly approaches anything: often no place is as stiff as measured, and the deviation,
        // as wide as the farther of two solutions, is on the safe side.
        let (placed, least) = if first == 3 { (100, 0.0) } else { (195, 0.8) };
        assert!(count >= placed, "first on {first}: {count} placed");
        assert!((least..1.25).contains(&rms), "first on {first}: {rms}");
    }
}

/// A second contact where the place does not matter has one stiffness and no place.
#[test]
fn unobservable_pairs_have_no_place() {
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let at = finger
        .free_at_torque(0.03, &finger.rest())
        .expect("a posture");
    for (first, second) in [(1, 2), (2, 1), (3, 1)] {
        let contact = Contact {
            phalanx: first,
            k_m: 0.030,
            radius_m: 0.0,
        };
        let mut path = finger.path(&at, 0.03, contact).expect("presses");
        finger.follow(&mut path, 0.01).expect("stays");
        let pressed = finger.pressed(&path).expect("stable");
        let [near, far] = [0.01, 0.04].map(|k| pressed.second_compliance(second, k));
        assert!(
            near.is_some() && near == far,
            "{first} then {second}: {near:?} {far:?}"
        );
        let places = pressed.second_places(near.expect("a value"));
        assert!(
            places.iter().all(|place| place.phalanx != second),
            "{places:?}"
        );
        assert_eq!(pressed.second_compliance(first, 0.01), None);
    }
}

/// With both phalanges of the prototype touching, the moments agree with forces from (1) at any places.
#[test]
fn moments_of_two_contacts_agree_with_the_forces() {
    let finger = P70::MECHANISM;
    let at = finger.configuration([0.6, 0.5]).expect("within its stops");
    let torque = 0.2;
    let gear = palpate::finger::Transmission::factors(finger.transmission(), &at).expect("closes");
    let tau = finger
        .equivalent_torques_nm(&gear, &at, torque)
        .expect("finite");
    for places in [[0.05, 0.02], [0.08, 0.06]] {
        let [f1, f2] = finger
            .contact_forces_n(&at, places, tau)
            .expect("off the joints");
        let held = finger
            .held_by_both(&at, torque, Some(places[1]))
            .expect("finite");
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5 * torque;
        assert!(near(held.distal_moment_nm, f2 * places[1]), "{held:?}");
        assert!(
            held.distal_force_n
                .is_some_and(|f| (f - f2).abs() < 1e-4 * f2.abs()),
            "{held:?}"
        );
        assert!(
            held.proximal_moment_nm
                .is_some_and(|m| near(m, f1 * places[0])),
            "{held:?} {f1}"
        );
    }
    let unknown = finger.held_by_both(&at, torque, None).expect("finite");
    assert_eq!(
        (unknown.distal_force_n, unknown.proximal_moment_nm),
        (None, None)
    );
    assert_eq!(finger.held_by_both(&at, torque, Some(0.071)), None);
    assert_eq!(finger.held_by_both(&at, f32::NAN, None), None);
}

/// Two actuators of a fully actuated finger place a contact with the deviation they claim; none is told without one.
#[test]
fn actuators_together_place_a_contact() {
    let finger = ActuatedFinger::new(Parameters {
        lengths_m: [0.060, 0.045, 0.030],
        stiffness_nm_per_rad: [0.4, 0.3, 0.2],
        rest_rad: [0.0; 3],
        range_rad: [[-0.5, 2.0]; 3],
    })
    .expect("in range");
    let at = finger.free_at_torques([0.2, 0.15, 0.1]).expect("a posture");
    let free = finger.expected_k_a().map(|k| 1.0 / k);
    assert_eq!(finger.locate(&at, free, free.map(|c| 0.01 * c)), None);
    assert_eq!(finger.locate(&at, [f32::NAN; 3], free), None);
    let mut noise = Noise(2);
    for (phalanx, k) in [(2, 0.02), (3, 0.02), (3, 0.027)] {
        let truth = finger
            .contact_compliance(&at, phalanx, k)
            .expect("on the finger");
        let sigma = free.map(|c| 0.003 * c);
        let mut squares = 0.0;
        for _ in 0..200 {
            let measured = core::array::from_fn(|j| truth[j] + sigma[j] * noise.deviate());
            let place = finger.locate(&at, measured, sigma).expect("a contact");
            assert_eq!(place.phalanx, phalanx);
            let z = (place.k_m.expect("a place") - k) / place.sigma_m;
            squares += z * z;
        }
        let rms = (squares / 200.0).sqrt();
        println!("phalanx {phalanx} at {k} m: rms of error over deviation {rms:.2}");
        assert!((0.8..1.25).contains(&rms), "{rms}");
    }
    let blocked = finger
        .contact_compliance(&at, 1, 0.03)
        .expect("on the finger");
    let place = finger
        .locate(&at, blocked, free.map(|c| 0.01 * c))
        .expect("a contact");
    assert_eq!((place.phalanx, place.k_m), (1, None));
    let without = Parameters {
        stiffness_nm_per_rad: [0.0, 0.3, 0.2],
        ..*finger.parameters()
    };
    assert!(ActuatedFinger::new(without).is_err());
    let _: Finger<3, Tendon<3>> = Finger::new(without, [0.01; 4]).expect("one motor needs none");
}

/// What sensing asks of three phalanges: the phalanx and the place behind a well-known stiffness, the distal moment that belongs
/// to it, and no answer where two phalanges would do.
#[test]
fn the_second_phalanx_is_named_where_the_stiffness_tells() {
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let (torque, rise) = (0.03, 0.02);
    let configuration = finger
        .free_at_torque(torque, &finger.rest())
        .expect("a posture");
    let at = Free {
        configuration,
        torque_nm: torque,
    };
    let on = |phalanx: u8, radius_m: f32| {
        let first = Contact {
            phalanx,
            k_m: 0.030,
            radius_m,
        };
        let mut path = finger.path(&configuration, torque, first).expect("presses");
        finger.follow(&mut path, rise).expect("stays");
        (first, finger.pressed(&path).expect("stable"))
    };
    // One cylinder touches phalanges 2 and 3: as far from the joint between them on either.
    let (mut first, mut pressed) = on(2, 0.05);
    for _ in 0..8 {
        let near_m = 0.0675 - pressed.k_now_m;
        (first, pressed) = on(2, near_m / (0.5 * pressed.joints_rad[2]).tan());
    }
    let truth_m = 0.0675 - pressed.k_now_m;
    let truth = pressed.second_compliance(3, truth_m).expect("a place");
    let measured = |compliance: f32, share: f32| SecondMeasured {
        rise_nm: rise,
        torque_nm: torque + rise,
        compliance_rad_per_nm: compliance,
        compliance_sigma_rad_per_nm: share * compliance,
        first_sigma_m: 0.1e-3,
        ..FRICTIONLESS
    };
    let found = finger
        .second_contact(&at, first, &measured(truth, 0.005))
        .expect("a second contact");
    assert_eq!(found.phalanx, 3);
    assert!(
        (found.k_m - truth_m).abs() < 2.0 * found.sigma_m,
        "{found:?}"
    );
    // Where it began nothing presses yet; later the distal contact does.
    let begun = finger.held_forces(&found, torque + rise);
    let later = finger.held_forces(&found, torque + rise + 0.01);
    assert!(begun.distal_moment_nm.abs() < 1e-4, "{begun:?}");
    assert!(
        later.distal_moment_nm > 1e-4 && later.distal_force_n > 0.0,
        "{later:?}"
    );
    // Phalanx 1 recedes from whatever would touch it.
    let without_place = pressed.second_compliance(1, 0.04).expect("stable");
    assert!(!pressed.second_presses(1, 0.04));
    let other = finger.second_contact(&at, first, &measured(without_place, 0.005));
    assert!(other.is_ok_and(|found| found.phalanx == 3));
    // After phalanx 1 phalanx 2 does not: it has no place.
    let (proximal, held) = on(1, 0.006);
    let without_place = held.second_compliance(2, 0.04).expect("stable");
    let other = finger
        .second_contact(&at, proximal, &measured(without_place, 0.005))
        .expect("a second contact");
    assert!(other.phalanx == 2 && other.k_m.is_nan(), "{other:?}");
    // Where two phalanges would do, neither is named.
    let vague = finger.second_contact(&at, proximal, &measured(without_place, 30.0));
    assert_eq!(vague, Err(NoSecondContact::Unexplained));
}

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

    /// Compliance of a finger that two contacts with friction hold.
    pub(super) fn compliance(
        pressed: &palpate::finger::Pressed<3>,
        (phalanx, k_m): (usize, f64),
        friction: f64,
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
        let turning = |senses: [f64; 2]| {
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
            right.fixed_rows_mut::<3>(0).copy_from(&x);
            let solved = matrix.lu().solve(&right).expect("a finger that moves");
            let turned: Vector3<f64> = solved.fixed_rows::<3>(0).into();
            turned
        };
        let free = turning([0.0; 2]);
        let senses = contacts.each_ref().map(|[_, rub]| rub.dot(&free).signum());
        x.dot(&turning(senses))
    }
}

/// With friction the finger is stiffer, and a place that takes it into account is nearer to the truth.
#[test]
fn friction_is_taken_off_a_second_place() {
    let finger = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let (torque, rise) = (0.03, 0.02);
    let at = finger.free_at_torque(torque, &finger.rest()).expect("free");
    let (mut with, mut without, mut count) = (0.0f64, 0.0f64, 0.0);
    for first_m in [0.025, 0.030, 0.035] {
        let first = Contact {
            phalanx: 2,
            k_m: first_m,
            radius_m: 0.006,
        };
        let mut path = finger.path(&at, torque, first).expect("presses");
        finger.follow(&mut path, rise).expect("stays");
        let pressed = finger.pressed(&path).expect("stable");
        for truth_m in [0.022, 0.027, 0.032] {
            let frictionless = f64::from(
                pressed
                    .second_compliance(3, truth_m as f32)
                    .expect("a place"),
            );
            let none = rubbing::compliance(&pressed, (3, truth_m), 0.0);
            assert!(
                (none / frictionless - 1.0).abs() < 1e-3,
                "{none} {frictionless}"
            );
            let compliance = rubbing::compliance(&pressed, (3, truth_m), 0.1);
            assert!(compliance < frictionless, "{compliance} {frictionless}");
            let places = |friction: f32| {
                let measured = SecondMeasured {
                    rise_nm: rise,
                    compliance_rad_per_nm: compliance as f32,
                    compliance_sigma_rad_per_nm: 0.01 * compliance as f32,
                    friction: [friction, 0.5 * friction],
                    ..FRICTIONLESS
                };
                let found = finger.second_places(&at, torque, first, &measured);
                let off = |found: &palpate::finger::SecondPlace| {
                    (
                        f64::from(found.place.k_m) - truth_m,
                        f64::from(found.sigma_m),
                    )
                };
                (found
                    .expect("a posture")
                    .iter()
                    .filter(|found| found.place.phalanx == 3)
                    .map(off))
                .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            };
            println!(
                "{first_m} {truth_m}: {frictionless:.4} {compliance:.4} {:?} {:?}",
                places(0.1),
                places(0.0)
            );
            let (Some((taken, sigma_m)), Some((left, _))) = (places(0.1), places(0.0)) else {
                continue;
            };
            assert!(
                taken.abs() < 2.0 * sigma_m,
                "{first_m} {truth_m}: {taken} {sigma_m}"
            );
            with += taken.abs();
            without += left.abs();
            count += 1.0;
        }
    }
    println!(
        "off by {:.2} mm, without friction {:.2} mm",
        1e3 * with / count,
        1e3 * without / count
    );
    assert!(count >= 5.0 && with < 0.4 * without);
}

/// Two contacts some way on, by the full equations in f64: the finger rolls on both sides of one cylinder.
mod rolling {
    use nalgebra::{Matrix5, Vector3, Vector5};

    pub(super) const LENGTHS_M: [f64; 3] = [0.090, 0.0675, 0.045];
    const SPRING: f64 = 0.1;
    /// x of pulleys of 9, 7.2, 5.4 and 3.6 mm: products of their ratios.
    const X: [f64; 3] = [1.0, 7.2 / 9.0, 7.2 / 9.0 * 3.6 / 5.4];

    /// Distance of a centre from the axis of a phalanx, along it from its joint, and the arms of a force there.
    fn seen(rad: &[f64; 3], phalanx: usize, centre: [f64; 2]) -> (f64, f64, Vector3<f64>) {
        let (mut joint, mut angle) = ([0.0; 2], 0.0);
        for (index, (length, turn)) in LENGTHS_M.iter().zip(rad).enumerate() {
            angle += turn;
            if index + 1 == phalanx {
                break;
            }
            joint = [
                joint[0] + length * f64::cos(angle),
                joint[1] + length * f64::sin(angle),
            ];
        }
        let off = [centre[0] - joint[0], centre[1] - joint[1]];
        let (sin, cos) = angle.sin_cos();
        let along = off[0] * cos + off[1] * sin;
        let across = -off[0] * sin + off[1] * cos;
        // What the distance loses with each joint's angle.
        let (mut arms, mut base, mut below) = (Vector3::zeros(), [0.0; 2], 0.0);
        for joint in 0..phalanx {
            arms[joint] = (centre[0] - base[0]) * cos + (centre[1] - base[1]) * sin;
            below += rad[joint];
            base = [
                base[0] + LENGTHS_M[joint] * f64::cos(below),
                base[1] + LENGTHS_M[joint] * f64::sin(below),
            ];
        }
        (across, along, arms)
    }

    /// Where a cylinder lies that touches a phalanx in a posture, its centre so far along it and across.
    pub(super) fn centre(rad: &[f64; 3], phalanx: usize, along: f64, across: f64) -> [f64; 2] {
        let (mut joint, mut angle) = ([0.0; 2], 0.0);
        for index in 0..phalanx {
            angle += rad[index];
            if index + 1 < phalanx {
                joint = [
                    joint[0] + LENGTHS_M[index] * f64::cos(angle),
                    joint[1] + LENGTHS_M[index] * f64::sin(angle),
                ];
            }
        }
        let (sin, cos) = angle.sin_cos();
        [
            joint[0] + along * cos - across * sin,
            joint[1] + along * sin + across * cos,
        ]
    }

    /// Posture, forces and places on two phalanges whose axes stay at distances from centres, at a torque: Newton's method with
    /// numerical derivatives of the arms.
    pub(super) fn posture(
        torque: f64,
        rest: &[f64; 3],
        contacts: [(usize, [f64; 2], f64); 2],
        near: [f64; 3],
    ) -> ([f64; 3], [f64; 2], [f64; 2]) {
        let residual = |at: &Vector5<f64>| {
            let rad = [at[0], at[1], at[2]];
            let mut balance = Vector3::from(X) * torque;
            for joint in 0..3 {
                balance[joint] -= SPRING * (rad[joint] - rest[joint]);
            }
            let mut gaps = [0.0; 2];
            for (index, (phalanx, centre, off)) in contacts.iter().enumerate() {
                let (across, _, arms) = seen(&rad, *phalanx, *centre);
                balance -= arms * at[3 + index];
                gaps[index] = across - off;
            }
            Vector5::new(balance[0], balance[1], balance[2], gaps[0], gaps[1])
        };
        let mut at = Vector5::new(near[0], near[1], near[2], 0.0, 0.0);
        for _ in 0..30 {
            let value = residual(&at);
            let mut slope = Matrix5::zeros();
            for column in 0..5 {
                let step = 1e-6;
                let (mut up, mut down) = (at, at);
                up[column] += step;
                down[column] -= step;
                let change = (residual(&up) - residual(&down)) / (2.0 * step);
                slope.set_column(column, &change);
            }
            at -= slope.lu().solve(&value).expect("a finger that moves");
        }
        let rad = [at[0], at[1], at[2]];
        let places = contacts.map(|(phalanx, centre, _)| seen(&rad, phalanx, centre).1);
        (rad, [at[3], at[4]], places)
    }

    pub(super) fn input(rad: &[f64; 3]) -> f64 {
        rad.iter().zip(X).map(|(rad, x)| rad * x).sum()
    }
}

/// Some way after a second contact posture, places and compliance are those of the full equations, on a thick cylinder that
/// touches both phalanges.
#[test]
fn the_finger_some_way_after_a_second_contact_is_that_of_the_full_equations() {
    let finger = Tendon3::MECHANISM;
    let torque = 0.03f32;
    let at = finger.free_at_torque(torque, &finger.rest()).expect("free");
    let mut checked = 0;
    for (first_m, rise) in [(0.040f32, 0.02f32), (0.045, 0.03), (0.050, 0.02)] {
        let off_m = 0.030f32;
        let first = Contact {
            phalanx: 2,
            k_m: first_m,
            radius_m: off_m,
        };
        let mut path = finger.path(&at, torque, first).expect("presses");
        finger.follow(&mut path, rise).expect("stays");
        let pressed = finger.pressed(&path).expect("stable");
        let rad = pressed.joints_rad.map(f64::from);
        let second_m = f64::from(0.0675 - pressed.k_now_m);
        // As thick as such places make it.
        let half = (0.5 * rad[2]).tan();
        let off = second_m / half;
        let centres = [
            rolling::centre(&rad, 2, f64::from(pressed.k_now_m), off),
            rolling::centre(&rad, 3, second_m, off),
        ];
        let contacts = [(2, centres[0], off), (3, centres[1], off)];
        let rest = finger.rest().rad().map(f64::from);
        let begun = f64::from(torque + rise);
        let solve = |torque: f64| rolling::posture(torque, &rest, contacts, rad);
        let there = solve(begun + 0.02);
        let slope = (rolling::input(&solve(begun + 0.0201).0)
            - rolling::input(&solve(begun + 0.0199).0))
            / 0.0002;
        let turned = rolling::input(&there.0) - rolling::input(&rad);
        let measured = SecondMeasured {
            rise_nm: rise,
            torque_nm: torque + rise,
            later_nm: 0.02,
            turned_rad: turned as f32,
            ..FRICTIONLESS
        };
        let Some((on, k_m)) = finger.turned_on(&pressed, 3, second_m as f32, &measured) else {
            continue;
        };
        let compliance = on.second_compliance(3, k_m).expect("a place");
        let joints = on.joints_rad.map(f64::from);
        println!(
            "{first_m}: joints {joints:?} {:?}, places {} {} {:?}, compliance {compliance} {slope}, at once {:?}",
            there.0,
            on.k_now_m,
            k_m,
            there.2,
            pressed.second_compliance(3, second_m as f32)
        );
        for (a, b) in joints.iter().zip(there.0) {
            assert!((a - b).abs() < 1e-3, "{joints:?} {:?}", there.0);
        }
        assert!(
            (f64::from(k_m) - there.2[1]).abs() < 2e-4,
            "{k_m} {:?}",
            there.2
        );
        assert!(
            (f64::from(compliance) / slope - 1.0).abs() < 0.03,
            "{compliance} {slope}"
        );
        checked += 1;
    }
    assert!(checked >= 2, "{checked}");
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
        let on = |radius_m: f32| {
            let first = Contact {
                phalanx: 2,
                k_m: first_m,
                radius_m,
            };
            let mut path = finger.path(&configuration, torque, first).expect("presses");
            finger.follow(&mut path, rise).expect("stays");
            (first, finger.pressed(&path).expect("stable"))
        };
        let (mut first, mut pressed) = on(0.05);
        for _ in 0..8 {
            let near_m = 0.0675 - pressed.k_now_m;
            (first, pressed) = on(near_m / (0.5 * pressed.joints_rad[2]).tan());
        }
        let truth_m = 0.0675 - pressed.k_now_m;
        for friction in [0.0f64, 0.1, 0.2] {
            // The finger sticks for 12 mN m per 0.1, then gives way, rubbed by the full equations.
            let moves = later - 0.12 * friction as f32;
            let at_once = rubbing::compliance(&pressed, (3, f64::from(truth_m)), friction) as f32;
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
            let compliance = rubbing::compliance(&there, (3, f64::from(k_m)), friction) as f32;
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
