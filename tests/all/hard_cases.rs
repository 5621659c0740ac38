//! Hard cases of the mechanics, in addition to the reference files: sliding off, dead points, folded fingers, flat curves.

use palpate::finger::{
    Assembly, Class, Configuration, Contact, Finger, FourBar, Levers, Linkage, Mechanics,
    Parameter, Parameters, PathPoint, Tendon,
};
use palpate::numeric::Rotation;

/// The plausible prototype: metre and newton metre, K_2 of 0.05 N m/rad, no spring at joint 1.
fn p70() -> Finger<2, Linkage<1>> {
    let parameters = Parameters {
        lengths_m: [0.09, 0.07],
        stiffness_nm_per_rad: [0.0, 0.05],
        rest_rad: [core::f32::consts::FRAC_PI_4, 0.0],
        range_rad: [[-0.2, 2.2], [-1.5, 2.0]],
    };
    Finger::new(parameters, [p70_levers()]).expect("it closes at every theta_2")
}

fn p70_levers() -> Levers {
    Levers {
        driving_m: 0.06,
        coupler_m: 0.104,
        driven_m: 0.03,
        offset_rad: 120.0f32.to_radians(),
        assembly: Assembly::Clockwise,
    }
}

fn tendon3(lengths_m: [f32; 3], rest: f32) -> Finger<3, Tendon<3>> {
    let parameters = Parameters {
        lengths_m,
        stiffness_nm_per_rad: [1.0; 3],
        rest_rad: [rest; 3],
        range_rad: [[-3.0, 3.0]; 3],
    };
    Finger::new(parameters, [0.1, 0.08, 0.06, 0.04]).expect("Table I")
}

/// docs/MECHANICS.md#prototype: the numbers of P70 at theta_2 = 0.
#[test]
fn p70_is_what_it_is_said_to_be() {
    let finger = p70();
    let at = finger.rest();
    let stage = finger.transmission().stages()[0];
    let ratio = stage.ratio(Rotation::NONE).expect("not a dead point");
    assert!(
        (ratio.first - 0.4577).abs() < 5e-5 && (ratio.second - 0.297).abs() < 5e-4,
        "{ratio:?}"
    );
    let h = stage.intersection_m(Rotation::NONE).expect("not parallel");
    let e2 = finger.stiffest_m(&at, 0.0, 2).expect("ahead of the joint");
    assert!(
        (h - 0.07596).abs() < 5e-6 && (e2 - h).abs() < 1e-7,
        "{h} {e2}"
    );
    for (k_mm, over_k2) in [
        (1.0, 5.0),
        (30.0, 23.2),
        (50.0, 98.9),
        (60.0, 300.0),
        (70.0, 2449.0),
    ] {
        let compliance = finger
            .contact_compliance(&at, 0.0, 2, 1e-3 * k_mm)
            .expect("a contact");
        let stiffness = 1.0 / (compliance * 0.05);
        assert!(
            (stiffness / over_k2 - 1.0).abs() < 0.011,
            "{k_mm} mm: {stiffness}, said to be {over_k2}"
        );
    }
    assert_eq!(
        finger.free_compliance(&at, 0.0),
        None,
        "nothing holds joint 1"
    );
}

/// Without a spring at joint 1 the free finger follows the motor without torque, and takes no torque.
#[test]
fn without_a_spring_joint_1_follows() {
    let finger = p70();
    let free = finger
        .free_at_angle(1.3, &finger.rest())
        .expect("it follows");
    assert_eq!(free.torque_nm, 0.0);
    assert!((finger.input_angle_rad(&free.configuration) - 1.3).abs() < 3e-7);
    assert_eq!(free.configuration.rad()[1], 0.0);
    assert_eq!(finger.expected_k_a(&free), Some(0.0));
    assert_eq!(finger.free_at_torque(0.01, &finger.rest()), None);
}

/// The path of a contact on phalanx 2, at a place and with a radius (metre), after a rise of the torque from none.
fn risen<const N: usize, F: Mechanics<Configuration = Configuration<N>>>(
    finger: &F,
    at: &Configuration<N>,
    (k_m, radius_m): (f32, f32),
    rise_nm: f32,
) -> PathPoint {
    let contact = Contact {
        phalanx: 2,
        k_m,
        radius_m,
    };
    let mut path = finger.path(at, 0.0, contact).expect("it presses");
    finger.follow(&mut path, rise_nm).expect("a small rise")
}

/// Follows a path in small rises until it is lost; the last point.
fn follow_to_the_end<const N: usize, F: Mechanics<Configuration = Configuration<N>>>(
    finger: &F,
    contact: Contact,
    rise_nm: f32,
) -> (u32, f32) {
    let mut path = finger
        .path(&finger.rest(), 0.0, contact)
        .expect("it presses");
    let (mut count, mut k_now) = (0, contact.k_m);
    for i in 1..=400u16 {
        let before = path.clone();
        match finger.follow(&mut path, rise_nm * f32::from(i)) {
            Some(point) => (count, k_now) = (count + 1, point.k_now_m),
            None => {
                assert_eq!(
                    format!("{before:?}"),
                    format!("{path:?}"),
                    "a lost path must stay where it was"
                );
                break;
            }
        }
    }
    (count, k_now)
}

/// A contact near the joint slides towards it and past it: the path ends there, it does not go on with k < 0.
#[test]
fn a_contact_that_slides_off_ends_the_path() {
    let finger = p70();
    let near_joint = Contact {
        phalanx: 2,
        k_m: 0.001,
        radius_m: 0.01,
    };
    let (count, k_now) = follow_to_the_end(&finger, near_joint, 2e-4);
    assert!((1..400).contains(&count) || k_now > 0.0, "{count} {k_now}");
    let near_tip = Contact {
        phalanx: 2,
        k_m: 0.0699,
        radius_m: 0.0,
    };
    let (_, k_now) = follow_to_the_end(&finger, near_tip, 0.05);
    assert!(k_now > 0.0 && k_now <= 0.07, "{k_now}");
    assert!(
        finger
            .path(
                &finger.rest(),
                0.0,
                Contact {
                    phalanx: 2,
                    k_m: 0.0701,
                    radius_m: 0.0
                }
            )
            .is_none()
    );
}

/// Either side of e_2 the compliance is the same; the inverse gives both, and the joint turns opposite ways.
#[test]
fn either_side_of_e2() {
    let mut parameters = *p70().parameters();
    parameters.lengths_m[1] = 0.09;
    let finger = Finger::<2, Linkage<1>>::new(parameters, [p70_levers()]).expect("a longer tip");
    let at = finger.rest();
    let e2 = finger.stiffest_m(&at, 0.0, 2).expect("on the phalanx");
    assert!(e2 < 0.09);
    for off in [1e-2, 1e-3, 1e-4, 1e-5] {
        for (k_m, opens) in [(e2 - off * 0.09, false), (e2 + off * 0.09, true)] {
            let compliance = finger
                .contact_compliance(&at, 0.0, 2, k_m)
                .expect("a contact");
            let answer = finger.locate(&at, 0.0, compliance);
            let nearest = answer
                .candidates()
                .iter()
                .map(|c| (c.k_m - k_m).abs())
                .fold(f32::INFINITY, f32::min);
            // k is told by the root of C: an ulp of e_2 is what remains.
            assert!(nearest <= 2e-6 * 0.09, "{off} {opens}: {answer:?}");
            assert_eq!(answer.class(), Class::AmbiguousSame);
            let point = risen(&finger, &at, (k_m, 0.0), 0.01);
            assert_eq!(point.joints_rad[1] < 0.0, opens, "{point:?}");
        }
    }
    // Rigid: C = 0 is e_2 itself.
    let rigid = finger.locate(&at, 0.0, 0.0);
    assert!(
        rigid
            .candidates()
            .iter()
            .all(|c| (c.k_m - e2).abs() <= 1e-8)
            && !rigid.candidates().is_empty()
    );
}

/// The oversized finger of Fig. 7: K_c peaks inside the phalanges, at 0.770 of phalanx 2 and 0.952 of phalanx 3.
#[test]
fn flat_stiffness_of_an_oversized_finger() {
    let finger = tendon3([0.5, 2.25, 3.0], core::f32::consts::FRAC_PI_6);
    let at = finger.rest();
    for (phalanx, share) in [(2u8, 0.770), (3, 0.952)] {
        let length = finger.phalanx_length_m(phalanx).expect("it has it");
        let peak = finger.stiffest_m(&at, 0.0, phalanx).expect("a peak") / length;
        assert!((peak - share).abs() < 6e-4, "phalanx {phalanx}: {peak}");
        // At the peak itself both solvers answer near it or not at all, and never elsewhere.
        let compliance = finger
            .contact_compliance(&at, 0.0, phalanx, peak * length)
            .expect("a contact");
        for answer in [
            finger.locate(&at, 0.0, compliance),
            finger.locate_closed(&at, 0.0, compliance),
        ] {
            for candidate in answer.candidates().iter().filter(|c| c.phalanx == phalanx) {
                assert!((candidate.k_m / length - peak).abs() < 2e-3, "{answer:?}");
            }
        }
    }
}

/// A path back through theta_2 = 90 degrees: phi stops being a parameter there, the path does not mind.
#[test]
fn a_path_through_a_right_angle() {
    let parameters = Parameters {
        lengths_m: [1.0, 0.75],
        stiffness_nm_per_rad: [1.0, 1.0],
        rest_rad: [0.3, 1.62],
        range_rad: [[-3.0, 3.0]; 2],
    };
    let finger = Finger::<2, Tendon<2>>::new(parameters, [0.1, 0.08]).expect("in range");
    let contact = Contact {
        phalanx: 2,
        k_m: 0.4,
        radius_m: 0.1,
    };
    let mut path = finger
        .path(&finger.rest(), 0.0, contact)
        .expect("it presses");
    let mut last = 0.0;
    // To where it is, twice: on a way of no length nothing can be foretold.
    for _ in 0..2 {
        let point = finger.follow(&mut path, 0.0).expect("the contact itself");
        assert_eq!((point.rotation_rad, point.force_n), (0.0, 0.0));
    }
    for i in 1..=40u8 {
        let point = finger
            .follow(&mut path, 0.02 * f32::from(i))
            .expect("the contact holds");
        assert!(point.rotation_rad > last);
        last = point.rotation_rad;
    }
    let mut at_once = finger
        .path(&finger.rest(), 0.0, contact)
        .expect("it presses");
    let point = finger
        .follow(&mut at_once, 0.8)
        .expect("the whole rise at once");
    assert!(
        (point.rotation_rad - last).abs() < 1e-5,
        "{} {last}",
        point.rotation_rad
    );
    let theta_2 = 1.62 + point.joints_rad[1];
    assert!(
        theta_2 < 1.56,
        "it went through the right angle, to {theta_2}"
    );
}

/// Near its dead points a four-bar is refused before f32 runs out of digits, and the link is named.
#[test]
fn dead_points_are_refused() {
    // Stretched at v = 0 with psi = 0: R = g + c = a + b.
    let levers = |b: f32| Levers {
        driving_m: 0.5,
        coupler_m: b,
        driven_m: 0.4,
        offset_rad: 0.0,
        assembly: Assembly::Clockwise,
    };
    let error = FourBar::build(2, 1.0, levers(0.9), [-0.5, 0.5]).expect_err("stretched");
    assert_eq!(error.parameter, Parameter::Closure { stage: 2 });
    assert!(
        error.value >= error.max && error.to_string().contains("linkage 2 does not close"),
        "{error}"
    );
    let near = FourBar::build(1, 1.0, levers(0.9001), [-0.5, 0.5]).expect("just within reach");
    let ratio = near
        .ratio(Rotation::NONE)
        .expect("near a dead point it is still finite");
    // The derivative by the angle itself, from F.
    let f = |v: f32| f64::from(near.lever(Rotation::by(v)).rad());
    let slope = (f(1e-3) - f(-1e-3)) / 2e-3;
    assert!(
        (f64::from(ratio.first) - slope).abs() < 1e-3 * (1.0 + slope.abs()),
        "{ratio:?} {slope}"
    );
}

/// Springs a million times apart.
#[test]
fn extreme_stiffness_ratios() {
    for (k1, k2) in [(1e-3, 1e3), (1e3, 1e-3)] {
        let parameters = Parameters {
            lengths_m: [1.0, 0.75],
            stiffness_nm_per_rad: [k1, k2],
            rest_rad: [0.5, 0.5],
            range_rad: [[-3.0, 3.0]; 2],
        };
        let finger = Finger::<2, Tendon<2>>::new(parameters, [0.1, 0.05]).expect("in range");
        let at = finger.rest();
        for share in [0.05, 0.5, 0.95] {
            let k_m = 0.75 * share;
            let c = finger
                .contact_compliance(&at, 0.0, 2, k_m)
                .expect("a contact");
            let answer = finger.locate(&at, 0.0, c);
            assert!(
                answer
                    .candidates()
                    .iter()
                    .any(|c| (c.k_m - k_m).abs() < 1e-5),
                "{k1} {k2} {share}: {answer:?}"
            );
            let point = risen(&finger, &at, (k_m, 0.05), 1e-3 * k1.min(k2));
            let tangent = c * 1e-3 * k1.min(k2);
            assert!(
                (point.rotation_rad / tangent - 1.0).abs() < 1e-2,
                "{k1} {k2} {share}: {point:?} {tangent:e}"
            );
        }
    }
}
