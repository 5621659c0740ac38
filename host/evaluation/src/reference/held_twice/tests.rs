use super::super::finger::{Finger, hessian};
use super::super::support::{RIGID, opened};
use super::super::{Held, Press, Stage};
use super::*;
use nalgebra::DVector;

const SMOOTH: Rubs = Rubs {
    friction: 0.0,
    joint_nm: 0.0,
    loss: 0.0,
    uneven: [0.0; 2],
};

/// A linkage of two stages, as the scene `linkage3` has it, in metre.
fn linkage() -> Finger {
    let stage = |drive, coupler, driven| Stage::Linkage {
        drive,
        coupler,
        driven,
        offset_rad: 2.0,
        mode: -1.0,
    };
    Finger {
        lengths: vec![0.09, 0.0675, 0.045],
        springs: vec![0.1; 3],
        rest_rad: vec![0.3, 0.1, 0.1],
        stages: vec![stage(0.0585, 0.1035, 0.0297), stage(0.045, 0.0774, 0.0225)],
    }
}

/// The scene `tendon3`.
fn tendon() -> Finger {
    Finger {
        lengths: vec![0.09, 0.0675, 0.045],
        springs: vec![0.1; 3],
        rest_rad: vec![std::f64::consts::FRAC_PI_6; 3],
        stages: vec![
            Stage::Tendon { ratio: 0.8 },
            Stage::Tendon { ratio: 2.0 / 3.0 },
        ],
    }
}

fn touching(phalanx: usize, k_m: f64, radius_m: f64) -> Touching {
    Touching {
        phalanx,
        k_m,
        radius_m,
    }
}

/// With one contact: torque and force of the reference for first contacts, while the contact slides as it began to.
#[test]
fn with_one_contact_it_is_the_finger_that_is_held_once() {
    let drive = Drive {
        factor: 1.1,
        cable_rad_per_nm: 0.8,
        stiffening_per_nm: 0.3,
    };
    // On the last phalanx more friction holds the contact, which the other reference does not know.
    for (finger, phalanx, k_m, rubs) in [
        (tendon(), 2, 0.03, 0.2),
        (tendon(), 3, 0.03, 0.05),
        (linkage(), 2, 0.03, 0.2),
        (linkage(), 3, 0.02, 0.02),
    ] {
        for friction in [0.0, rubs] {
            let opened = opened(finger.clone());
            let onset_rad = 1.6;
            let press = Press {
                phalanx,
                k_m,
                radius_m: 0.02,
                half_thickness_m: 0.006,
                friction,
                joint_nm: 0.0,
                lost: 0.0,
                give_m_per_n: 0.0,
            };
            let once = Held::new(&opened, press, onset_rad, &drive).unwrap();
            let rubs = Rubs { friction, ..SMOOTH };
            let mut twice = HeldTwice::new(&opened, rubs, 0.006, drive, onset_rad).unwrap();
            assert!((twice.now().torque_nm - once.start().torque_nm).abs() < 1e-9);
            twice.touch(&touching(phalanx, k_m, 0.02));
            let mut near = once.start().clone();
            for step in 1..=12 {
                let angle_rad = onset_rad + 0.01 * f64::from(step);
                near = once.at(angle_rad, &drive, &near).unwrap();
                assert!(twice.close_to(angle_rad), "{phalanx} {k_m}: {step}");
                let now = twice.now();
                let off = now.torque_nm - near.torque_nm;
                let most = if friction > 0.0 { 5e-5 } else { 1e-8 };
                assert!(off.abs() < most, "{phalanx} {k_m} {friction}: {off:e}");
                let off = now.forces_n[0] - near.force_n;
                assert!(off.abs() < 0.02 * near.force_n, "{phalanx} {k_m}: {off:e}");
                assert_eq!(now.forces_n[1], 0.0);
            }
        }
    }
}

/// A first contact on phalanx 2, and a second one on phalanx 3 after 0.06 rad.
fn twice(opened: &Opened, rubs: Rubs, k_m: f64) -> HeldTwice<'_> {
    let mut held = HeldTwice::new(opened, rubs, 0.006, RIGID, 1.4).unwrap();
    held.touch(&touching(2, 0.04, 0.02));
    for step in 1..=6 {
        assert!(held.close_to(1.4 + 0.01 * f64::from(step)));
    }
    held.touch(&touching(3, k_m, 0.02));
    held
}

/// Without friction the compliance at the instant of the second contact is that of the motion which both leave:
/// (x . v)^2 / (v^T H v), with H from energies and distances alone (docs/SECOND_CONTACTS.md#two-contacts).
#[test]
fn at_the_second_contact_the_motion_that_is_left_gives_way() {
    for finger in [tendon(), linkage()] {
        for k_m in [0.01, 0.02, 0.03] {
            let opened = opened(finger.clone());
            let mut held = twice(&opened, SMOOTH, k_m);
            let at = *held.now();
            let theta = DVector::from_column_slice(&at.theta);
            let mut h = hessian(&theta, |theta| {
                finger.energy(theta) - at.torque_nm * finger.theta_a(theta)
            });
            let first = held.contacts[0].unwrap();
            let middle = (first.middle[0], first.middle[1]);
            h -= hessian(&theta, |theta| finger.distance(theta, 2, middle)) * at.forces_n[0];
            let [p, q] = held
                .contacts
                .map(|one| nalgebra::Vector3::from(held.seen(&one.unwrap(), &at.theta).normal));
            let v = p.cross(&q);
            let v = DVector::from_column_slice(v.as_slice());
            let (_, x) = held.transmission(&at.theta);
            let lever = v.dot(&DVector::from_column_slice(&x));
            let expected = lever * lever / v.dot(&(h * &v));
            assert!(held.close_to(at.angle_rad + 1e-4));
            let compliance = 1e-4 / (held.now().torque_nm - at.torque_nm);
            let error = compliance / expected - 1.0;
            assert!(error.abs() < 2e-3, "{k_m}: {compliance} {expected}");
        }
    }
}

/// Work of the motor over energy of the springs, after the second contact.
fn work_share(finger: Finger, rubs: Rubs) -> f64 {
    let opened = opened(finger);
    let mut held = twice(&opened, rubs, 0.02);
    let energy = |held: &HeldTwice| {
        let theta = DVector::from_column_slice(&held.now().theta);
        opened.finger.energy(&theta)
    };
    let (began, mut work) = (energy(&held), 0.0);
    let start_rad = held.now().angle_rad;
    for step in 1..=400 {
        let before = held.now().torque_nm;
        assert!(held.close_to(start_rad + 1e-4 * f64::from(step)), "{step}");
        work += 0.5e-4 * (held.now().torque_nm + before);
    }
    work / (energy(&held) - began)
}

#[test]
fn work_is_conserved_with_two_contacts_and_whatever_rubs_takes_its_share() {
    for finger in [tendon(), linkage()] {
        let share = work_share(finger.clone(), SMOOTH);
        assert!((share - 1.0).abs() < 1e-4, "{share}");
        let takes = |rubs: Rubs| work_share(finger.clone(), rubs) - share;
        let friction = takes(Rubs {
            friction: 0.1,
            ..SMOOTH
        });
        let joints = takes(Rubs {
            joint_nm: 1e-3,
            ..SMOOTH
        });
        let loss = takes(Rubs {
            loss: 0.03,
            ..SMOOTH
        });
        assert!(
            friction > 0.01 && joints > 1e-3 && loss > 5e-3,
            "{friction} {joints} {loss}"
        );
    }
}

/// What turns back sticks: after the second contact hardly anything moves until the torque has overcome friction twice.
#[test]
fn a_finger_that_turns_back_sticks_first() {
    let opened = opened(tendon());
    let rubs = Rubs {
        friction: 0.2,
        joint_nm: 1e-3,
        loss: 0.03,
        ..SMOOTH
    };
    let cable = Drive {
        cable_rad_per_nm: 0.8,
        ..RIGID
    };
    let mut held = HeldTwice::new(&opened, rubs, 0.006, cable, 1.4).unwrap();
    held.touch(&touching(2, 0.04, 0.02));
    for step in 1..=6 {
        assert!(held.close_to(1.4 + 0.01 * f64::from(step)));
    }
    held.touch(&touching(3, 0.02, 0.02));
    let slopes: Vec<f64> = (7..40)
        .map(|step| {
            let before = held.now().torque_nm;
            assert!(held.close_to(1.4 + 0.01 * f64::from(step)));
            (held.now().torque_nm - before) / 0.01
        })
        .collect();
    assert!(slopes[0] > 1.4 * slopes[2], "{slopes:?}");
    assert!(slopes.iter().all(|slope| *slope < 1.26), "{slopes:?}");
}

/// Posture, force and compliance at second contacts, from a model with 30 digits that only knows positions and energy
/// (docs/MECHANICS.md#reference-files).
#[test]
fn second_contacts_are_those_of_the_reference_files() {
    for (name, is_tendon) in [("second_3T", true), ("second_3L", false)] {
        let path = format!(
            "{}/../../tests/data/golden/{name}.csv",
            env!("CARGO_MANIFEST_DIR")
        );
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_path(path)
            .unwrap();
        let header = reader.headers().unwrap().clone();
        let mut rows = 0;
        for record in reader.records() {
            let record = record.unwrap();
            let of = |key: &str| -> f64 {
                let index = header.iter().position(|name| name == key).unwrap();
                record[index].parse().unwrap()
            };
            let three = |key: &str, after: &str| [1, 2, 3].map(|i| of(&format!("{key}{i}{after}")));
            let stage = |i: usize| {
                if is_tendon {
                    let ratio = of(&format!("r{}", 2 * i)) / of(&format!("r{}", 2 * i - 1));
                    return Stage::Tendon { ratio };
                }
                let [drive, coupler, driven, offset_rad, mode] =
                    ["a", "b", "c", "psi", "mode"].map(|key| of(&format!("{key}{i}")));
                Stage::Linkage {
                    drive,
                    coupler,
                    driven,
                    offset_rad,
                    mode,
                }
            };
            let finger = Finger {
                lengths: three("l", "").to_vec(),
                springs: three("K", "").to_vec(),
                rest_rad: three("th", "0").to_vec(),
                stages: vec![stage(1), stage(2)],
            };
            let opened = opened(finger);
            let angle = |theta: [f64; 3]| {
                (opened.finger).theta_a(&DVector::from_column_slice(theta.as_slice()))
            };
            let onset_rad = angle(three("th", ""));
            let mut held = HeldTwice::new(&opened, SMOOTH, 0.0, RIGID, onset_rad).unwrap();
            assert!((held.now().torque_nm - of("T_c")).abs() < 1e-6, "{name}");
            let phalanx = |key: &str| of(key) as usize;
            held.touch(&touching(phalanx("phal"), of("k"), 0.0));
            let way_rad = angle(three("th", "_after")) - onset_rad;
            for step in 1..=10 {
                assert!(held.close_to(onset_rad + 0.1 * f64::from(step) * way_rad));
            }
            let now = *held.now();
            let force = now.forces_n[0] / of("f") - 1.0;
            assert!(force.abs() < 1e-5, "{name} {rows}: {force:e}");
            held.touch(&touching(phalanx("phal_b"), of("k_b"), 0.0));
            // Where nothing but rounding would move, the compliance is none.
            if of("C_second") < 1e-3 * of("C_first") {
                continue;
            }
            let step_rad = 1e-5 * of("C_second");
            assert!(held.close_to(now.angle_rad + step_rad));
            let compliance = step_rad / (held.now().torque_nm - now.torque_nm);
            let error = compliance / of("C_second") - 1.0;
            assert!(error.abs() < 1e-3, "{name} {rows}: {error:e}");
            rows += 1;
        }
        println!("{name}: {rows}");
        assert!(rows >= 10, "{name}: {rows}");
    }
}
