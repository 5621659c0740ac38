//! The finger some way after a second contact.

use super::{FRICTIONLESS, pressed_on};
use palpate::finger::{Contact, Mechanics, SecondMeasured};
use palpate::scene::Scene;
use palpate_scenes::Tendon3;

/// Two contacts some way on, by the full equations in f64: the finger rolls on both sides of one cylinder.
mod rolling {
    use nalgebra::{Matrix5, Vector3, Vector5};

    const LENGTHS_M: [f64; 3] = [0.090, 0.0675, 0.045];
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
        let pressed = pressed_on(&finger, &at, torque, first, rise);
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
