//! Fingers of more than three phalanges: construction, and forward then inverse for random fingers of six.

use palpate::finger::{
    Assembly, Class, Contact, Finger, Levers, Linkage, Mechanics, Parameter, Parameters, Tendon,
};
use proptest::prelude::*;

const LEVERS: Levers = Levers {
    driving_m: 0.65,
    coupler_m: 1.14,
    driven_m: 0.32,
    offset_rad: 2.0,
    assembly: Assembly::Clockwise,
};

fn parameters<const N: usize>(springs: [f32; N]) -> Parameters<N> {
    Parameters {
        lengths_m: [1.0; N],
        stiffness_nm_per_rad: springs,
        rest_rad: [0.2; N],
        range_rad: [[-0.3, 0.9]; N],
    }
}

/// The compiler builds the longest linkage, and an error names the stage that does not close.
#[test]
fn a_stage_that_does_not_close_is_named() {
    const FINGER: Result<Finger<6, Linkage<5>>, palpate::finger::ConfigError> =
        Finger::<6, Linkage<5>>::constant(
            Parameters {
                lengths_m: [1.0; 6],
                stiffness_nm_per_rad: [1.0; 6],
                rest_rad: [0.2; 6],
                range_rad: [[-0.3, 0.9]; 6],
            },
            [LEVERS; 5],
        );
    assert_eq!(
        Finger::<6, Linkage<5>>::new(parameters([1.0; 6]), [LEVERS; 5]),
        FINGER
    );
    assert!(FINGER.is_ok(), "{FINGER:?}");
    for open in 0..5 {
        let mut design = [LEVERS; 5];
        design[open].coupler_m = 3.0;
        let error = Finger::<6, Linkage<5>>::new(parameters([1.0; 6]), design)
            .expect_err("a coupler that is too long");
        let stage = open as u8 + 1;
        assert_eq!(error.parameter, Parameter::Closure { stage });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// A place gives a compliance, and this compliance that place: on every phalanx but the first, by both solvers.
    #[test]
    fn forward_then_inverse(
        springs in prop::array::uniform6(4u8..20),
        ratios in prop::array::uniform5(55u8..95),
        is_springless: bool,
        torque in 0u8..50,
        phalanx in 2u8..=6,
        at in 5u8..95,
    ) {
        let mut springs = springs.map(|k| 0.1 * f32::from(k));
        let mut radii = [0.1; 10];
        for (pair, ratio) in radii.chunks_mut(2).zip(ratios) {
            pair[1] *= 0.01 * f32::from(ratio);
        }
        let mut torque = 0.01 * f32::from(torque);
        if is_springless {
            (springs[0], torque) = (0.0, 0.0);
        }
        let finger: Finger<6, Tendon<6>> = Finger::new(parameters(springs), radii).expect("in range");
        let posture = finger.free_at_torque(torque, &finger.rest()).expect("a posture");
        let k_m = 0.01 * f32::from(at);
        let contact = Contact { phalanx, k_m, radius_m: 0.0 };
        let Some(compliance) = finger.contact_compliance(&posture, torque, phalanx, k_m) else {
            return Err(TestCaseError::fail("every place has a compliance"));
        };
        let peak = finger.stiffest_m(&posture, torque, phalanx).unwrap_or(f32::INFINITY);
        // Around the stiffest place C has a smooth minimum: k is only as good as the root of the rounding there.
        let tolerance = if (k_m - peak).abs() < 0.1 { 0.05 } else { 2e-3 };
        let presses = finger.path(&posture, torque, contact).is_some();
        for answer in [
            finger.locate(&posture, torque, compliance),
            finger.locate_closed(&posture, torque, compliance),
        ] {
            let found = answer.candidates().iter().any(|c| c.phalanx == phalanx && (c.k_m - k_m).abs() <= tolerance);
            prop_assert!(found == presses || answer.class() == Class::Proximal, "{contact:?} {answer:?}");
            for candidate in answer.candidates() {
                let again = finger.contact_compliance(&posture, torque, candidate.phalanx, candidate.k_m);
                let proximal = finger.proximal_compliance(&posture, torque).expect("stable");
                prop_assert!(again.is_some_and(|c| (c - compliance).abs() <= 2e-5 * proximal), "{candidate:?}");
            }
        }
    }
}
