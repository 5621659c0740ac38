//! Properties of any finger: forward then inverse, scaling, monotony, energy, an independent contact with radius.

mod inverse;
mod path;
mod setup;

use crate::finger_support::{direct, linkage2, linkage3, tendon2, tendon3, within};
use inverse::{monotone, round_trip, step_round_trip};
use palpate::finger::{Contact, Finger, Mechanics, Parameters, Tendon};
use palpate::sensing::location::places;
use palpate::sensing::{Cable, NoJointSensor, Rigid, SeriesElement, Side};
use path::{derivatives, energy, touches};
use proptest::prelude::*;
use setup::preshaped;

fn contact_on(phalanges: u8) -> impl Strategy<Value = Contact> {
    (
        2..=phalanges,
        within(0.05, 0.95),
        prop_oneof![Just(0.0f32), within(0.02, 0.4)],
    )
        .prop_map(|(phalanx, k_m, radius_m)| Contact {
            phalanx,
            k_m,
            radius_m,
        })
}

macro_rules! properties {
    ($($module:ident: $finger:expr, $phalanges:expr;)*) => { $(mod $module {
        use super::*;
        proptest! {
            #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

            #[test]
            fn forward_then_inverse(f in $finger, share in within(0.0, 0.5), phalanx in 2..=$phalanges, at in within(0.02, 0.98)) {
                round_trip(&f, share, phalanx, at)?;
            }

            #[test]
            fn compliance_is_monotone_on_either_side(f in $finger, share in within(0.0, 0.5), phalanx in 2..=$phalanges) {
                monotone(&f, share, phalanx)?;
            }

            #[test]
            fn work_becomes_spring_energy(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                energy(&f, share, contact, 0.3)?;
            }

            #[test]
            fn the_cylinder_stays_where_it_is(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                touches(&f, share, contact)?;
            }

            #[test]
            fn derivatives_are_limits_of_differences(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                derivatives(&f, share, contact)?;
            }

            #[test]
            fn a_step_is_located(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                step_round_trip(&f, share, contact)?;
            }
        }
    })* };
}

properties! {
    two_tendon: tendon2(), 2u8;
    two_linkage: linkage2(), 2u8;
    three_tendon: tendon3(), 3u8;
    three_linkage: linkage3(), 3u8;
    two_direct: direct::<2>(), 2u8;
    three_direct: direct::<3>(), 3u8;
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Lengths in other units and springs in other units give the same finger.
    #[test]
    fn units_do_not_matter(f in linkage2(), share in within(0.0, 0.5), at in within(0.1, 0.9), metre in -9i32..9, newton in -5i32..5) {
        let (metre, torque_unit) = (2.0f32.powi(metre), 4.0f32.powi(newton));
        let p = *f.parameters();
        let levers = f.transmission().stages()[0].levers();
        let scaled = palpate::finger::Levers {
            driving_m: levers.driving_m * metre,
            coupler_m: levers.coupler_m * metre,
            driven_m: levers.driven_m * metre,
            ..levers
        };
        let other = Finger::<2, palpate::finger::Linkage<1>>::new(
            Parameters {
                lengths_m: p.lengths_m.map(|l| l * metre),
                stiffness_nm_per_rad: p.stiffness_nm_per_rad.map(|k| k * torque_unit),
                ..p
            },
            [scaled],
        ).expect("the same finger in other units");
        let (here, torque) = preshaped(&f, share)?;
        let (there, torque_there) = preshaped(&other, share)?;
        let k = at * p.lengths_m[1];
        let c = f.contact_compliance(&here, torque, 2, k).expect("stable");
        let c_there = other.contact_compliance(&there, torque_there, 2, k * metre).expect("stable");
        // Powers of two change no digit, nor do powers of four under the root.
        prop_assert_eq!(c, c_there * torque_unit);
        let places = f.locate(&here, torque, c);
        let places_there = other.locate(&there, torque_there, c_there);
        prop_assert_eq!(places.class(), places_there.class());
        for (a, b) in places.candidates().iter().zip(places_there.candidates()) {
            prop_assert_eq!(a.k_m * metre, b.k_m);
        }
    }

    /// The free finger found by its input angle is the one found by its torque.
    #[test]
    fn angle_and_torque_agree(f in linkage3(), share in within(0.0, 0.5)) {
        let (at, torque) = preshaped(&f, share)?;
        let free = f.free_at_angle(f.input_angle_rad(&at), &f.rest()).expect("a posture it just had");
        let scale = f.parameters().stiffness_nm_per_rad[2];
        prop_assert!((free.torque_nm - torque).abs() <= 3e-6 * scale, "{} {torque}", free.torque_nm);
    }

    /// A cable in series is taken off, and theta_2's sign leaves the right side of e_2.
    #[test]
    fn cable_and_joint_sensor(f in tendon2(), at in within(0.05, 0.95), stiffness in within(0.5, 50.0)) {
        let posture = f.rest();
        let k = at * f.parameters().lengths_m[1];
        let cable = Cable::new(stiffness).expect("in range");
        let c = f.contact_compliance(&posture, 0.0, 2, k).expect("stable");
        let peak = f.stiffest_m(&posture, 0.0, 2).unwrap_or(f32::INFINITY);
        if c < 1e-4 * cable.compliance_rad_per_nm() {
            return Err(TestCaseError::reject("the cable is all that is measured"));
        }
        let change_rad = if k > peak { -0.01 } else { 0.01 };
        let side = Some(Side::of(change_rad, 0.003));
        let answer = places(&f, &posture, 0.0, c + cable.compliance_rad_per_nm(), &cable, side);
        prop_assert_eq!(answer.candidates().len(), 1);
        let found = answer.candidates()[0];
        prop_assert_eq!(found.beyond_stiffest, k > peak);
        prop_assert!((found.k_m - k).abs() <= 2e-2 * f.parameters().lengths_m[1], "{} {k}", found.k_m);
        let measured = c + cable.compliance_rad_per_nm();
        let unclear = places(&f, &posture, 0.0, measured, &cable, Some(Side::of(change_rad, 0.02)));
        let without = places(&f, &posture, 0.0, measured, &cable, None);
        prop_assert!(found.phalanx == 2 && unclear.candidates().contains(&found));
        prop_assert_eq!(unclear.candidates(), without.candidates());
        prop_assert_eq!(core::mem::size_of_val(&(Rigid, NoJointSensor)), 0);
    }
}

/// Table I of the paper: K_a = 0.519630 for its three-phalanx tendon finger (7).
#[test]
fn the_papers_k_a() {
    let rest = [core::f32::consts::FRAC_PI_6; 3];
    let finger = Finger::<3, Tendon<3>>::new(
        Parameters {
            lengths_m: [1.0, 0.75, 0.5],
            stiffness_nm_per_rad: [1.0; 3],
            rest_rad: rest,
            range_rad: [[0.0, 3.0]; 3],
        },
        [0.1, 0.08, 0.06, 0.04],
    )
    .expect("Table I");
    let free = finger
        .free_at_angle(2.5, &finger.rest())
        .expect("within its stops");
    let k_a = finger.expected_k_a(&free).expect("it has springs");
    assert!((k_a - 0.519_630).abs() < 1e-6, "{k_a}");
}
