//! Fingers whose weight is stated, against positions and energies in f64: every derivative by differences.

mod energy;

use energy::{Energy, Stage};
use nalgebra::DVector;
use palpate::finger::{Contact, Finger, Mechanics, Mounting, Parameter, Parameters, Tendon};
use palpate::scene::Scene;
use palpate_scenes::{Hidden3, Linkage3, P70, Return2, Tendon2, Tendon3};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Mountings, radian, and weights over those of the scenes: as in the world `harsh` at most.
const GRAVITY_RAD: [f64; 5] = [-1.57, -0.4, 0.7, 1.8, 3.1];
const SHARES: [f64; 2] = [1.0, 3.0];

fn tendon(ratios: &[f64]) -> Vec<Stage> {
    ratios.iter().copied().map(Stage::Tendon).collect()
}

fn linkage3() -> Vec<Stage> {
    let stage = |a, b, c| Stage::Linkage([a, b, c, 2.0], -1.0);
    vec![stage(0.0585, 0.1035, 0.0297), stage(0.045, 0.0774, 0.0225)]
}

/// Largest errors of what the library says of a finger: torque of the free finger, newton metre; angles of its joints, radian;
/// compliance at contact, rotation, force and compliance of a path, as shares.
#[derive(Debug, Default)]
struct Errors {
    torque_nm: f64,
    joints_rad: f64,
    at_contact: f64,
    rotation: f64,
    force: f64,
    along: f64,
    contacts: u32,
}

impl Errors {
    fn grow(worst: &mut f64, error: f64) {
        assert!(error.is_finite());
        *worst = worst.max(error.abs());
    }

    fn compare<F: Mechanics>(&mut self, heavy: &F, energy: &Energy, closed: f32) {
        let rest = heavy.rest();
        let theta_a = heavy.input_angle_rad(&rest) + closed;
        let free = heavy.free_at_angle(theta_a, &rest).expect("a posture");
        let (theta, torque) = energy.free(theta_a.into());
        Self::grow(&mut self.torque_nm, f64::from(free.torque_nm) - torque);
        for joint in 0..F::PHALANGES {
            let told = heavy
                .joint_rad(&free.configuration, joint as u8 + 1)
                .expect("a joint");
            Self::grow(&mut self.joints_rad, f64::from(told) - theta[joint]);
        }
        for phalanx in 2..=F::PHALANGES as u8 {
            let length = f64::from(heavy.phalanx_length_m(phalanx).expect("a phalanx"));
            for share in [0.15, 0.5, 0.8] {
                self.contact(
                    heavy,
                    energy,
                    (&free.configuration, free.torque_nm),
                    (&theta, torque),
                    (phalanx, share * length),
                );
            }
        }
    }

    fn contact<F: Mechanics>(
        &mut self,
        heavy: &F,
        energy: &Energy,
        (at, torque_nm): (&F::Configuration, f32),
        (theta, torque): (&DVector<f64>, f64),
        (phalanx, k): (u8, f64),
    ) {
        let index = usize::from(phalanx) - 1;
        let k_m = k as f32;
        let contact = Contact {
            phalanx,
            k_m,
            radius_m: 0.0,
        };
        let expected = energy.compliance(theta, torque, index, k);
        let told = heavy
            .contact_compliance(at, torque_nm, phalanx, k_m)
            .expect("stable");
        // As a share of the finger's own: near the stiffest place nothing is left of the other.
        let own = heavy.proximal_compliance(at, torque_nm).expect("stable");
        Self::grow(
            &mut self.at_contact,
            (f64::from(told) - expected) / f64::from(own),
        );
        // The place leads back, where the finger presses.
        let Some(mut path) = heavy.path(at, torque_nm, contact) else {
            return;
        };
        // A weight that tips the finger over on its tip leaves no order of places.
        let tip_m = heavy.phalanx_length_m(phalanx).expect("a phalanx");
        if heavy
            .contact_compliance(at, torque_nm, phalanx, tip_m)
            .is_none()
        {
            return;
        }
        for inverse in [
            heavy.locate(at, torque_nm, told),
            heavy.locate_closed(at, torque_nm, told),
        ] {
            let found = inverse
                .candidates()
                .iter()
                .any(|place| place.phalanx == phalanx && (place.k_m - k_m).abs() < 2e-3 * k_m);
            assert!(found, "{phalanx} {k_m} {told}: {inverse:?}");
        }
        for rise in [0.02, 0.1] {
            let Some(point) = heavy.follow(&mut path, rise as f32) else {
                continue;
            };
            // Still held at its stop by a return cable.
            if point.rotation_rad <= 0.0 {
                continue;
            }
            let [rotation, force, compliance] = energy.pressed(theta, index, k, [torque, rise]);
            Self::grow(
                &mut self.rotation,
                f64::from(point.rotation_rad) / rotation - 1.0,
            );
            Self::grow(&mut self.force, f64::from(point.force_n) / force - 1.0);
            Self::grow(
                &mut self.along,
                (f64::from(point.compliance_rad_per_nm) - compliance) / f64::from(own),
            );
            self.contacts += 1;
        }
    }
}

#[test]
fn postures_stiffness_and_paths_are_those_of_the_energy() {
    let (mut sprung, mut returned) = (Errors::default(), Errors::default());
    for gravity_rad in GRAVITY_RAD {
        for share in SHARES {
            let hangs = (gravity_rad, share);
            let mounting = Mounting {
                gravity_rad: gravity_rad as f32,
                share: share as f32,
            };
            for closed in [0.1, 0.5] {
                macro_rules! compare {
                    ($scene:ident, $stages:expr) => {{
                        let finger = $scene::MECHANISM.mounted(mounting);
                        let energy = Energy::of(finger.parameters(), $stages, hangs);
                        sprung.compare(&finger, &energy, closed);
                    }};
                }
                compare!(Tendon2, tendon(&[0.8]));
                compare!(Tendon3, tendon(&[0.8, 2.0 / 3.0]));
                compare!(Hidden3, tendon(&[1.0, 5.0 / 9.0]));
                compare!(Linkage3, linkage3());
                let finger = Return2::MECHANISM.mounted(mounting);
                let mut energy = Energy::of(finger.parameters(), tendon(&[0.5]), hangs);
                energy.cable = Some(([0.010, 0.010], 3.5, 200.0));
                returned.compare(&finger, &energy, closed);
            }
        }
    }
    println!("springs: {sprung:?}\nreturn cable: {returned:?}");
    assert!(sprung.contacts > 300 && returned.contacts > 20);
    for errors in [&sprung, &returned] {
        assert!(
            errors.torque_nm < 1e-6 && errors.joints_rad < 1e-5,
            "{errors:?}"
        );
        assert!(
            errors.at_contact < 1e-4 && errors.along < 1e-3,
            "{errors:?}"
        );
        assert!(errors.rotation < 1e-3 && errors.force < 1e-3, "{errors:?}");
    }
}

/// What a scene does not state, it does not have; and in a level plane a stated weight does nothing.
#[test]
fn in_a_level_plane_it_is_the_finger_without_weight() {
    let level = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let without: Finger<3, Tendon<3>> =
        Finger::new(*level.parameters(), [0.009, 0.0072, 0.0054, 0.0036]).expect("tendon3");
    let rest = level.rest();
    for closed in [0.1, 0.6] {
        let theta_a = level.input_angle_rad(&rest) + closed;
        let [one, other] = [
            level.free_at_angle(theta_a, &rest).expect("a posture"),
            without.free_at_angle(theta_a, &rest).expect("a posture"),
        ];
        assert_eq!(one, other);
        assert_eq!(level.expected_k_a(&one), without.expected_k_a(&one));
        for (phalanx, k_m) in [(2u8, 0.02), (3, 0.02)] {
            let [heavy, light] = [
                level.contact_compliance(&one.configuration, one.torque_nm, phalanx, k_m),
                without.contact_compliance(&one.configuration, one.torque_nm, phalanx, k_m),
            ]
            .map(|compliance| compliance.expect("stable"));
            assert!((heavy / light - 1.0).abs() < 1e-4, "{heavy} {light}");
        }
    }
    let p70 = P70::MECHANISM;
    let hung = Mounting {
        gravity_rad: 1.0,
        share: 1.0,
    };
    assert_eq!(p70.mounted(hung), p70);
    const { assert!(!<<P70 as Scene>::Finger as Mechanics>::WEIGHS) };
}

/// K_a' (7) is the secant from the torque that holds the finger at rest: weight alone is no stiffness.
#[test]
fn a_free_closing_has_the_stiffness_of_springs_and_weight() {
    for share in SHARES {
        let finger = Tendon3::MECHANISM.mounted(Mounting {
            gravity_rad: -1.57,
            share: share as f32,
        });
        let rest = finger.rest();
        let from = finger.input_angle_rad(&rest);
        let [first, last] = [0.0, 0.8].map(|closed| {
            finger
                .free_at_angle(from + closed, &rest)
                .expect("a posture")
        });
        let secant = (last.torque_nm - first.torque_nm) / 0.8;
        let told = finger.expected_k_a(&last).expect("stiff");
        assert!((told / secant - 1.0).abs() < 1e-4, "{told} {secant}");
        let tangent = 1.0
            / finger
                .free_compliance(&last.configuration, last.torque_nm)
                .expect("stiff");
        let step = 1e-2;
        let [less, more] = [0.8 - step, 0.8 + step].map(|closed| {
            finger
                .free_at_angle(from + closed, &rest)
                .expect("a posture")
                .torque_nm
        });
        let slope = (more - less) / (2.0 * step);
        assert!((tangent / slope - 1.0).abs() < 2e-3, "{tangent} {slope}");
        // And a torque leads back to its posture.
        let back = finger
            .free_at_torque(last.torque_nm, &rest)
            .expect("a posture");
        assert!((finger.input_angle_rad(&back) - from - 0.8).abs() < 1e-5);
    }
    let cable = Return2::MECHANISM.mounted(Mounting {
        gravity_rad: -1.57,
        share: 2.0,
    });
    let free = cable.free_at_angle(0.6, &cable.rest()).expect("a posture");
    let back = cable
        .free_at_torque(free.torque_nm, &cable.rest())
        .expect("a posture");
    assert!((cable.input_angle_rad(&back) - 0.6).abs() < 1e-5);
}

#[test]
fn a_weight_out_of_range_is_named() {
    let hung = Mounting {
        gravity_rad: 0.0,
        share: 1.0,
    };
    let parameters = *Tendon2::MECHANISM.parameters();
    let finger: Finger<2, Tendon<2>> = Finger::new(parameters, [0.009, 0.0072]).expect("tendon2");
    assert!(finger.weighted([0.0, 0.1], hung).is_ok());
    for bad in [-1e-9, f32::NAN, f32::INFINITY, 1.1e9] {
        let error = finger.weighted([0.1, bad], hung).expect_err("a weight");
        assert_eq!(error.parameter, Parameter::Weight { phalanx: 2 });
        assert_eq!((error.min, error.max), (0.0, 1e9));
    }
    for gravity_rad in [7.0, f32::NAN] {
        let error = finger
            .weighted(
                [0.1; 2],
                Mounting {
                    gravity_rad,
                    ..hung
                },
            )
            .expect_err("a direction");
        assert_eq!(error.parameter, Parameter::Gravity);
    }
    let springless = Parameters {
        stiffness_nm_per_rad: [0.0, 0.1],
        ..parameters
    };
    let finger: Finger<2, Tendon<2>> = Finger::new(springless, [0.009, 0.0072]).expect("a finger");
    let error = finger.weighted([0.1; 2], hung).expect_err("no spring");
    assert_eq!(error.parameter, Parameter::Stiffness { joint: 1 });
}

/// Everything that a finger answers, each finite or missing.
fn answers<F: Mechanics>(finger: &F, [angle, torque, k, rise]: [f32; 4]) -> Vec<f32> {
    let rest = finger.rest();
    let mut found = Vec::new();
    let free = finger.free_at_angle(angle, &rest);
    found.extend(free.iter().map(|free| free.torque_nm));
    found.extend(free.iter().filter_map(|free| finger.expected_k_a(free)));
    let at = finger.free_at_torque(torque, &rest);
    found.extend(at.iter().map(|at| finger.input_angle_rad(at)));
    let at = at.or(free.map(|free| free.configuration)).unwrap_or(rest);
    found.extend(finger.free_compliance(&at, torque));
    found.extend(finger.softest_compliance(&at, torque));
    for phalanx in 1..=F::PHALANGES as u8 {
        found.extend(finger.contact_compliance(&at, torque, phalanx, k));
        found.extend(finger.stiffest_m(&at, torque, phalanx));
        let contact = Contact {
            phalanx,
            k_m: k,
            radius_m: 0.01,
        };
        if let Some(mut path) = finger.path(&at, torque, contact)
            && let Some(point) = finger.follow(&mut path, rise)
        {
            found.extend([
                point.rotation_rad,
                point.compliance_rad_per_nm,
                point.force_n,
            ]);
            found.extend([point.rotation_by_k_rad_per_m, point.k_now_m]);
        }
    }
    for inverse in [
        finger.locate(&at, torque, rise),
        finger.locate_closed(&at, torque, rise),
    ] {
        found.extend(inverse.candidates().iter().map(|place| place.k_m));
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bits at all: nothing panics, and nothing comes out that is not finite.
    #[test]
    fn any_numbers_give_finite_answers_or_none(
        bits in prop::array::uniform6(any::<u32>()),
        usual in prop::array::uniform6(0u8..3),
        weights in prop::array::uniform3(any::<u32>()),
    ) {
        let plain = [1.0, -1.5, 0.8, 0.02, 0.03, 0.5];
        let mut values = [0.0; 6];
        for i in 0..6 {
            values[i] = if usual[i] > 0 { plain[i] } else { f32::from_bits(bits[i]) };
        }
        let [share, gravity_rad, angle, torque, k, rise] = values;
        let mounting = Mounting { gravity_rad, share };
        let inputs = [angle, torque, k, rise];
        let mut found = answers(&Tendon2::MECHANISM.mounted(mounting), inputs);
        found.extend(answers(&Linkage3::MECHANISM.mounted(mounting), inputs));
        found.extend(answers(&Return2::MECHANISM.mounted(mounting), inputs));
        let of = *Tendon3::MECHANISM.parameters();
        let finger: Finger<3, Tendon<3>> = Finger::new(of, [0.009, 0.0072, 0.0054, 0.0036]).expect("tendon3");
        if let Ok(finger) = finger.weighted(weights.map(f32::from_bits), mounting) {
            found.extend(answers(&finger, inputs));
        }
        prop_assert!(found.iter().all(|value| value.is_finite()), "{found:?}");
    }

    /// The torque about each joint is what the energy loses as it turns, and the stiffness what that torque loses.
    #[test]
    fn the_torque_is_the_energys_slope(
        gravity in 0.0..TAU,
        angles in prop::array::uniform3(-1.0f64..2.0),
    ) {
        let finger = Tendon3::MECHANISM.mounted(Mounting { gravity_rad: gravity as f32, share: 1.0 });
        let energy = Energy::of(finger.parameters(), tendon(&[0.8, 2.0 / 3.0]), (gravity, 1.0));
        let at = finger.configuration(angles.map(|angle| (angle.max(-0.5)) as f32)).expect("between its stops");
        let theta = DVector::from_iterator(3, at.rad().map(f64::from));
        let gear = palpate::finger::Transmission::factors(finger.transmission(), &at).expect("tendons");
        let told = finger.equivalent_torques_nm(&gear, &at, 0.03).expect("finite");
        let left = energy.left(&theta, 0.03);
        for joint in 0..3 {
            prop_assert!((f64::from(told[joint]) + left[joint]).abs() < 1e-6, "{told:?} {left}");
        }
    }
}
