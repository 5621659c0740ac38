//! A motor at every joint, the others held by their worms behind springs: what joint 1's motor feels
//! (docs/FINGERS.md#one-motor-a-joint), against plane geometry in f64 and against the finger whose motors keep their torque.

use crate::finger_support::Noise;
use palpate::finger::{
    ActuatedFinger, Class, Contact, Direct, Finger, Mechanics, Parameters, Springless, Tendon,
};
use palpate::scene::Scene;
use palpate_scenes::Direct2;

const K_2: f64 = 0.2;
const LENGTHS: [f64; 2] = [0.09, 0.07];

fn parameters(base: f32) -> Parameters<2> {
    Parameters {
        lengths_m: LENGTHS.map(|length| length as f32),
        stiffness_nm_per_rad: [base, K_2 as f32],
        rest_rad: [0.0, 0.5],
        range_rad: [[-1.0, 3.0]; 2],
    }
}

fn finger() -> Finger<2, Direct<2>, Springless> {
    Finger::<2, Direct<2>, Springless>::constant(parameters(0.0), ()).expect("in range")
}

#[test]
fn every_place_has_its_compliance_and_the_inverse_finds_it() {
    let finger = finger();
    let at = finger.rest();
    let c = LENGTHS[0] * 0.5f64.cos();
    for step in 1..=70 {
        let k = 1e-3 * f64::from(step);
        let expected = (k / (k + c)).powi(2) / K_2;
        let compliance = finger
            .contact_compliance(&at, 0.0, 2, k as f32)
            .expect("on the phalanx");
        assert!((f64::from(compliance) / expected - 1.0).abs() < 1e-5);
        // The tip itself may round to beyond it.
        let asked = compliance * if step == 70 { 0.999_999 } else { 1.0 };
        for found in [
            finger.locate(&at, 0.0, asked),
            finger.locate_closed(&at, 0.0, asked),
        ] {
            assert_eq!(found.class(), Class::Unique, "{k}");
            let place = found.candidates()[0];
            assert_eq!(place.phalanx, 2);
            assert!((f64::from(place.k_m) - k).abs() < 1e-6, "{k}: {place:?}");
        }
    }
    // Nothing is softer than the tip, and phalanx 1 is rigid.
    let tip = finger.softest_compliance(&at, 0.0).expect("a place");
    assert_eq!(finger.contact_compliance(&at, 0.0, 2, 0.07), Some(tip));
    assert_eq!(finger.locate(&at, 0.0, 1.01 * tip).class(), Class::Gap);
    assert_eq!(finger.proximal_compliance(&at, 0.0), Some(0.0));
    assert_eq!(finger.locate(&at, 0.0, 0.0).class(), Class::Proximal);
    assert_eq!(finger.stiffest_m(&at, 0.0, 2), None);
}

/// Joint 1 without a spring of its own is the limit of a soft one, where the others keep their torque or their wheels alike.
#[test]
fn it_is_the_limit_of_actuators_that_keep_their_torque() {
    let actuated = ActuatedFinger::new(parameters(1e-4)).expect("in range");
    let (finger, at) = (finger(), finger().rest());
    for k_m in [0.01, 0.03, 0.05, 0.07] {
        let [expected, _] = actuated.contact_compliance(&at, 2, k_m).expect("on it");
        let found = finger.contact_compliance(&at, 0.0, 2, k_m).expect("on it");
        // The soft spring adds itself: K_1 C of 1e-4 at most.
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
}

/// The motor behind the other joint: softer next to the joint, and the product of both tells of the springs alone.
#[test]
fn the_two_motors_check_each_other() {
    let stiff = Parameters {
        stiffness_nm_per_rad: [0.4, 0.2],
        ..parameters(0.0)
    };
    let at = finger().rest();
    for k_m in [0.01f32, 0.035, 0.07] {
        // One keeps its wheel behind its spring, the other, softly sprung, is the one that turns.
        let turned = |joint: usize| {
            let mut soft = stiff;
            soft.stiffness_nm_per_rad[joint] *= 1e-5;
            let actuated = ActuatedFinger::new(soft).expect("in range");
            actuated.contact_compliance(&at, 2, k_m).expect("on it")[joint]
        };
        let product = turned(0) * turned(1);
        assert!((product * 0.4 * 0.2 - 1.0).abs() < 2e-3, "{k_m}: {product}");
    }
}

/// The path after contact with a point, from geometry and one equation: phalanx 2 turns about joint 2 until its line passes the
/// point again, and the moment about joint 2 is the spring's.
#[test]
fn the_path_is_that_of_plane_geometry() {
    let finger = finger();
    for (k, torque) in [(0.01, 0.1), (0.03, 0.3), (0.05, 0.3), (0.065, 0.2)] {
        let along = |angle: f64, length: f64| [length * angle.cos(), length * angle.sin()];
        let ([x1, y1], [x2, y2]) = (along(0.0, LENGTHS[0]), along(0.5, k));
        let point = [x1 + x2, y1 + y2];
        // Where joint 1 has turned to, all follows: joint 2 from the direction to the point, force from the spring.
        let state = |turned: f64| {
            let [x, y] = along(turned, LENGTHS[0]);
            let arm = [point[0] - x, point[1] - y];
            let (k_now, bent) = (arm[0].hypot(arm[1]), arm[1].atan2(arm[0]) - turned - 0.5);
            let force = -K_2 * bent / k_now;
            let moment = k_now + LENGTHS[0] * (0.5 + bent).cos();
            (force * moment, force, k_now, bent)
        };
        let (mut low, mut high) = (0.0, 1.2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if state(middle).0 < torque {
                low = middle;
            } else {
                high = middle;
            }
        }
        let (_, force, k_now, bent) = state(low);
        let contact = Contact {
            phalanx: 2,
            k_m: k as f32,
            radius_m: 0.0,
        };
        let mut path = finger
            .path(&finger.rest(), 0.0, contact)
            .expect("it presses");
        let found = finger.follow(&mut path, torque as f32).expect("it stays");
        for (found, expected) in [
            (found.rotation_rad, low),
            (found.force_n, force),
            (found.k_now_m, k_now),
            (found.joints_rad[1], bent),
        ] {
            assert!(
                (f64::from(found) / expected - 1.0).abs() < 2e-5,
                "{k}: {found} {expected}"
            );
        }
    }
}

#[test]
fn without_contact_joint_1_follows_and_joint_2_stands() {
    let finger = Direct2::MECHANISM;
    let rest = finger.rest();
    assert_eq!(finger.input_angle_rad(&rest), 0.0);
    let free = finger.free_at_angle(0.7, &rest).expect("a posture");
    assert_eq!(free.torque_nm, 0.0);
    assert_eq!(finger.joint_rad(&free.configuration, 1), Some(0.7));
    let held = finger.joint_rad(&rest, 2);
    assert_eq!(finger.joint_rad(&free.configuration, 2), held);
    assert_eq!(finger.expected_k_a(&free), Some(0.0));
}

/// Contact friction on a phalanx that is pushed open acts along the phalanx towards its joint, because the phalanx slides outwards on
/// the object: written out with the moments about both joints, for a phalanx with and without thickness.
#[test]
fn a_phalanx_that_is_pushed_open_rubs_the_other_way() {
    let finger = finger();
    let (k, torque, half_thickness) = (0.04, 0.2, 0.006);
    let along = |angle: f64, length: f64| [length * angle.cos(), length * angle.sin()];
    let ([x1, y1], [x2, y2]) = (along(0.0, LENGTHS[0]), along(0.5, k));
    let turned = |friction: f64, thickness: f64| {
        let torque_at = |turned: f64| {
            let [x, y] = along(turned, LENGTHS[0]);
            let arm = [x1 + x2 - x, y1 + y2 - y];
            let (k_now, bent) = (arm[0].hypot(arm[1]), arm[1].atan2(arm[0]) - turned - 0.5);
            let force = -K_2 * bent / (k_now - friction * thickness);
            let (sin, cos) = (0.5 + bent).sin_cos();
            let lever = LENGTHS[0] * (cos + friction * sin);
            force * (k_now - friction * thickness + lever)
        };
        // Beyond, friction lets the torque fall again.
        let (mut low, mut high) = (0.0, 0.4);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if torque_at(middle) < torque {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    let contact = Contact {
        phalanx: 2,
        k_m: k as f32,
        radius_m: 0.0,
    };
    for (friction, thickness) in [
        (0.0, 0.0),
        (0.0, half_thickness),
        (0.3, 0.0),
        (0.8, half_thickness),
    ] {
        let mut path = finger
            .path(&finger.rest(), 0.0, contact)
            .expect("it presses");
        finger
            .rub(&mut path, friction as f32, thickness as f32)
            .expect("finite");
        let found = finger.follow(&mut path, torque as f32).expect("it stays");
        let expected = turned(friction, thickness);
        let rotation = f64::from(found.rotation_rad);
        assert!(
            (rotation / expected - 1.0).abs() < 1e-5,
            "{rotation} {expected}"
        );
        let step = 1e-4;
        let by_friction = (turned(friction + step, thickness) - turned(friction - step, thickness))
            / (2.0 * step);
        assert!(by_friction < 0.0, "it stiffens: {by_friction}");
        let told = f64::from(found.rotation_by_friction_rad);
        assert!(
            (told / by_friction - 1.0).abs() < 1e-3,
            "{told} {by_friction}"
        );
    }
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
