//! Every public function with numbers that make no sense: an error, `None`, or a finite value; never a panic, never NaN.

use crate::finger_support::{linkage2, linkage3, return2, tendon2, tendon3};
use palpate::finger::{
    Assembly, BaseJoint, Configuration, Contact, Finger, Free, HoldsTwice, Levers, Linkage,
    Mechanics, Parameters, ReturnCable, SecondMeasured, Springless, Tendon, ThreeJointContact,
    Transmission, TwoJointContact,
};
use palpate::sensing::Side;
use palpate::sensing::location::{Cable, Rigid, places};
use palpate::sensing::second::{BlockNoise, SecondContact};
use palpate::sensing::step;
use proptest::prelude::*;

/// Any bit pattern, with those that hurt more often than chance would have them.
fn any_number() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![
        3 => any::<u32>().prop_map(f32::from_bits),
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE,
            1e-45, -1e-45, 1e-30, 1e30, 1e19, 0.5, core::f32::consts::FRAC_PI_2, core::f32::consts::PI,
        ]),
        2 => (-2000i16..2000).prop_map(|i| f32::from(i) * 1e-3),
    ]
}

fn check(value: Option<f32>) -> Result<(), TestCaseError> {
    prop_assert!(value.is_none_or(f32::is_finite), "{value:?}");
    Ok(())
}

/// The whole of [`Mechanics`] and what stands on it, with five numbers in every place.
fn abuse<const N: usize, T, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    n: [f32; 5],
    phalanx: u8,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T, B>: Mechanics<Configuration = Configuration<N>>,
{
    let [torque, other, k_m, radius_m, angle] = n;
    let rest = finger.rest();
    let mut postures = vec![rest];
    if let Some(free) = finger.free_at_angle(angle, &rest) {
        check(Some(free.torque_nm))?;
        check(finger.expected_k_a(&free))?;
        postures.push(free.configuration);
    }
    postures.extend(finger.free_at_torque(torque, &rest));
    let mut rad = rest.rad();
    rad[N - 1] = angle;
    postures.extend(finger.configuration(rad).ok());
    for at in &postures {
        check(Some(finger.input_angle_rad(at)))?;
        prop_assert!(at.rad().iter().all(|a| a.is_finite()));
        check(finger.joint_rad(at, phalanx))?;
        check(finger.phalanx_length_m(phalanx))?;
        check(finger.expected_k_a(&Free {
            configuration: *at,
            torque_nm: torque,
        }))?;
        check(finger.free_compliance(at, torque))?;
        check(finger.proximal_compliance(at, torque))?;
        check(finger.contact_compliance(at, torque, phalanx, k_m))?;
        check(finger.stiffest_m(at, torque, phalanx))?;
        let cable = Cable::new(radius_m);
        let side = Some(Side::of(angle, other));
        let answers = [
            finger.locate(at, torque, other),
            finger.locate_closed(at, torque, other),
            places(finger, at, torque, other, &Rigid, side),
        ];
        let with_cable = cable.map(|cable| places(finger, at, torque, other, &cable, None));
        for answer in answers.iter().chain(&with_cable) {
            for c in answer.candidates() {
                let length = finger
                    .phalanx_length_m(c.phalanx)
                    .expect("a candidate lies on a phalanx");
                prop_assert!(c.k_m > 0.0 && c.k_m <= length, "{c:?}");
            }
        }
        if let Some(mut path) = finger.path(
            at,
            torque,
            Contact {
                phalanx,
                k_m,
                radius_m,
            },
        ) {
            let mut rubbed = path.clone();
            finger.rub(&mut rubbed, other, radius_m);
            let mut soft = path.clone();
            finger.soften(&mut soft, other);
            finger.rub(&mut soft, angle, radius_m);
            for path in [&mut path, &mut rubbed, &mut soft] {
                for rise in [other, 1e-3, angle] {
                    if let Some(joint) = finger.joint_2(path) {
                        prop_assert!(joint.rad.is_finite() && joint.by_k_rad_per_m.is_finite());
                        prop_assert!(
                            joint.by_torque_rad_per_nm.is_finite()
                                && joint.by_friction_rad.is_finite()
                        );
                    }
                    if let Some(p) = finger.follow(path, rise) {
                        let numbers = [
                            p.rotation_rad,
                            p.compliance_rad_per_nm,
                            p.k_now_m,
                            p.force_n,
                        ];
                        prop_assert!(
                            numbers.iter().chain(&p.joints_rad).all(|x| x.is_finite()),
                            "{p:?}"
                        );
                    }
                }
            }
            if let Some((k, _)) = finger.place(&path, other, angle) {
                check(Some(k))?;
            }
        }
        let measured = step::Measured {
            rise_nm: other,
            rotation_rad: angle,
            radius_m,
        };
        for c in step::places(finger, at, torque, &measured, &Rigid, None) {
            let length = finger
                .phalanx_length_m(c.phalanx)
                .expect("a candidate lies on a phalanx");
            prop_assert!(c.k_m > 0.0 && c.k_m <= length, "{c:?}");
        }
        if let Some(gear) = finger.transmission().factors(at) {
            prop_assert!(
                gear.x
                    .iter()
                    .chain(gear.w.iter().flatten())
                    .all(|x| x.is_finite())
            );
            if let Some(tau) = finger.equivalent_torques_nm(&gear, at, torque) {
                prop_assert!(tau.iter().all(|t| t.is_finite()));
                let force = finger.contact_forces_n(at, [k_m; N], tau);
                prop_assert!(force.is_none_or(|f| f.iter().all(|f| f.is_finite())));
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn two_phalanges_with_tendon(f in tendon2(), n in prop::array::uniform5(any_number()), phalanx in 0u8..5) {
        abuse(&f, n, phalanx)?;
    }

    #[test]
    fn two_phalanges_with_linkage(f in linkage2(), n in prop::array::uniform5(any_number()), phalanx in 0u8..5) {
        abuse(&f, n, phalanx)?;
    }

    #[test]
    fn three_phalanges_with_tendon(f in tendon3(), n in prop::array::uniform5(any_number()), phalanx in 0u8..5) {
        abuse(&f, n, phalanx)?;
    }

    #[test]
    fn three_phalanges_with_linkage(f in linkage3(), n in prop::array::uniform5(any_number()), phalanx in 0u8..5) {
        abuse(&f, n, phalanx)?;
    }

    #[test]
    fn two_phalanges_with_return_cable(
        f in return2(),
        n in prop::array::uniform5(any_number()),
        phalanx in 0u8..5,
        cable in prop::array::uniform3(any_number()),
    ) {
        abuse(&f, n, phalanx)?;
        let [torque, other, k_m, length_m, angle] = n;
        if let Some(free) = f.free_at_angle(angle, &f.rest())
            && let Some(contact) = f.stopped_contact(&free.configuration, torque)
        {
            prop_assert!(!contact.break_away_nm(k_m).is_nan() || !(torque + k_m).is_finite());
            check(contact.place_m(other, length_m))?;
        }
        let [ratio, torque_nm, stiffness_nm_per_rad] = cable;
        let other = ReturnCable { ratio, torque_nm, stiffness_nm_per_rad };
        match Finger::returned(*f.parameters(), [0.1, 0.05], other) {
            Ok(finger) => abuse(&finger, n, phalanx)?,
            Err(error) => prop_assert!(!(error.value >= error.min && error.value <= error.max), "{error}"),
        }
        let sprung = Parameters { stiffness_nm_per_rad: [0.0, 1.0], ..*f.parameters() };
        let sprung = Finger::<2, Tendon<2>, Springless>::constant(sprung, [0.1, 0.05]).expect("in range");
        if let Ok(finger) = sprung.preloaded(torque_nm) {
            abuse(&finger, n, phalanx)?;
        }
    }

    /// Whatever is built, was within its ranges; whatever was not, is named.
    #[test]
    fn construction(n in prop::array::uniform8(any_number()), m in prop::array::uniform6(any_number())) {
        let two = Parameters {
            lengths_m: [n[0], n[1]],
            stiffness_nm_per_rad: [n[2], n[3]],
            rest_rad: [n[4], n[5]],
            range_rad: [[n[6], n[7]], [m[0], m[1]]],
        };
        let levers = Levers { driving_m: m[2], coupler_m: m[3], driven_m: m[4], offset_rad: m[5], assembly: Assembly::Counterclockwise };
        let built = Finger::<2, Linkage<1>>::new(two, [levers]);
        if let Err(error) = built {
            let inside = error.value >= error.min && error.value <= error.max;
            prop_assert!(!inside, "{error}");
        } else if let Ok(finger) = built {
            abuse(&finger, [m[0], n[0], n[1], n[2], n[4]], 2)?;
        }
        if let Ok(finger) = Finger::<2, Tendon<2>>::new(two, [m[2], m[3]]) {
            prop_assert!(n[0] > 0.0 && n[3] > 0.0);
            abuse(&finger, [m[0], n[0], n[1], n[2], n[4]], 2)?;
        }
    }

    /// The reduced problems by themselves.
    #[test]
    fn reduced_problems(n in prop::array::uniform8(any_number()), c in any_number(), length in any_number()) {
        let pair = TwoJointContact { c_m: n[0], x2: n[1], k1: n[2], h22: n[3] };
        let triple = ThreeJointContact { d1_m: n[0], d2_m: n[1], x2: n[2], x3: n[3], k1: n[4], h22: n[5], h23: n[6], h33: n[7] };
        for roots in [pair.closed(c), pair.bisected(c, length), triple.closed(c), triple.bisected(c, length)] {
            check(roots.near_m)?;
            check(roots.far_m)?;
        }
        check(pair.compliance(c))?;
        check(pair.proximal())?;
        check(pair.stiffest_m())?;
        check(triple.compliance(c))?;
        check(triple.stiffest_m())?;
        check(Cable::new(c).ok().map(|cable| palpate::sensing::location::SeriesElement::compliance_rad_per_nm(&cable)))?;
    }
}

/// A second contact from any measurement, on any first one.
fn abuse_twice<const N: usize, T: Transmission<N>, B: BaseJoint>(
    finger: &Finger<N, T, B>,
    n: &[f32],
    phalanx: u8,
) -> Result<(), TestCaseError>
where
    Finger<N, T, B>: HoldsTwice<Configuration = Configuration<N>>,
{
    let at = |i: usize| n[i % n.len()];
    let measured = SecondMeasured {
        rise_nm: at(0),
        rotation_rad: at(1),
        rotation_sigma_rad: at(2),
        torque_nm: at(3),
        later_nm: at(4),
        turned_rad: at(5),
        turned_sigma_rad: at(6),
        compliance_rad_per_nm: at(7),
        compliance_sigma_rad_per_nm: at(8),
        first_sigma_m: at(9),
        friction: [at(10), at(11)],
        half_thickness_m: at(12),
        leverage_sigma: at(13),
        joint_friction_nm: [at(14), at(15)],
        joint_loss: [at(16), at(17)],
    };
    let first = Contact {
        phalanx,
        k_m: at(18),
        radius_m: at(19),
    };
    let Some(free) = finger.free_at_torque(0.02, &finger.rest()) else {
        return Ok(());
    };
    // As they are, and with what lets a path begin, so that the rest is reached.
    let sane = SecondMeasured {
        rise_nm: 0.02,
        friction: [0.1, 0.1],
        half_thickness_m: 0.006,
        ..measured
    };
    let there = Contact {
        phalanx: 2,
        k_m: 0.02,
        radius_m: 0.01,
    };
    for (first, measured) in [(first, measured), (there, sane)] {
        let free = Free {
            configuration: free,
            torque_nm: 0.02,
        };
        if let Ok(held) = finger.second_contact(&free, first, &measured) {
            prop_assert!(held.configuration.rad().iter().all(|a| a.is_finite()));
            prop_assert!(held.turning_per_nm.iter().all(|a| a.is_finite()));
            prop_assert!(held.k_m.is_nan() == held.sigma_m.is_nan(), "{held:?}");
            let _ = finger.held_forces(&held, at(3), at(2));
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn second_contacts(
        n in prop::collection::vec(any_number(), 20),
        phalanx in 0u8..5,
        (three, linked, two) in (tendon3(), linkage3(), tendon2()),
    ) {
        abuse_twice(&three, &n, phalanx)?;
        abuse_twice(&linked, &n, phalanx)?;
        abuse_twice(&two, &n, phalanx)?;
    }

    /// Blocks, noise and the onset of a search: what is told is finite.
    #[test]
    fn corners(
        points in prop::collection::vec((any_number(), any_number()), 1..120),
        noise in any_number(),
        walk in any_number(),
        turn in any_number(),
        error in any_number(),
        onset in any_number(),
        moves_on in any::<bool>(),
    ) {
        let noise = BlockNoise {
            white_nm2: noise,
            walk_nm2: walk,
            worm_turn_rad: turn,
            worm_error_rad: error,
        };
        let mut search = SecondContact::default();
        search.begin(onset, onset, 0.01);
        for (theta, torque) in points {
            if let Some(change) = search.push(theta, torque, &noise, moves_on) {
                prop_assert!(change.theta_a_rad.is_finite() && change.torque_nm.is_finite(), "{change:?}");
            }
            search.look_straight(&noise);
        }
        if let Some(change) = search.take_straight() {
            prop_assert!(change.theta_a_rad.is_finite() && change.torque_nm.is_finite(), "{change:?}");
        }
    }
}
