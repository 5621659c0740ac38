//! Fingers built at compile time, and types that state whether joint 1 has a spring.

use core::hint::black_box;
use palpate::finger::{
    AnyBase, Contact, Direct, Finger, Levers, Linkage, Mechanics, Mounting, Parameter, Parameters,
    Springless,
};
use palpate::scene::Scene;
use palpate_scenes::{Direct2, Linkage3, P70, Tendon2, Tendon3};

fn levers<const STAGES: usize>(linkage: &Linkage<STAGES>) -> [Levers; STAGES] {
    linkage.stages().map(|stage| stage.levers())
}

/// How the scenes hang.
const HUNG: Mounting = Mounting {
    gravity_rad: -core::f32::consts::FRAC_PI_2,
    share: 1.0,
};

fn weights_n<const N: usize>(masses_kg: [f64; N]) -> [f32; N] {
    masses_kg.map(|mass_kg| (9.81 * mass_kg) as f32)
}

/// The compiler's arithmetic gives the very numbers that a program gets.
#[test]
fn the_compiler_builds_what_a_program_builds() {
    let p70 = P70::MECHANISM;
    assert_eq!(
        black_box(Finger::<2, Linkage<1>, Springless>::constant)(
            black_box(*p70.parameters()),
            levers(p70.transmission())
        ),
        Ok(p70)
    );
    let linkage3 = Linkage3::MECHANISM;
    assert_eq!(
        Finger::new(
            black_box(*linkage3.parameters()),
            levers(linkage3.transmission())
        )
        .and_then(|finger| finger.weighted(black_box(weights_n([0.009, 0.00675, 0.0045])), HUNG)),
        Ok(linkage3)
    );
    let direct2 = Direct2::MECHANISM;
    assert_eq!(
        black_box(Finger::<2, Direct<2>, Springless>::constant)(
            black_box(*direct2.parameters()),
            ()
        ),
        Ok(direct2)
    );
    let (tendon2, tendon3) = (Tendon2::MECHANISM, Tendon3::MECHANISM);
    assert_eq!(
        Finger::new(black_box(*tendon2.parameters()), [0.009, 0.0072])
            .and_then(|finger| finger.weighted(black_box(weights_n([0.009, 0.00675])), HUNG)),
        Ok(tendon2)
    );
    assert_eq!(
        Finger::new(
            black_box(*tendon3.parameters()),
            [0.009, 0.0072, 0.0054, 0.0036]
        )
        .and_then(|finger| finger.weighted(black_box(weights_n([0.009, 0.00675, 0.0045])), HUNG)),
        Ok(tendon3)
    );
}

/// A type that says there is no spring takes none, and no other limit is forgotten.
#[test]
fn a_spring_that_the_type_denies_is_refused() {
    let parameters = *P70::MECHANISM.parameters();
    let design = levers(P70::MECHANISM.transmission());
    let build = |change: fn(&mut Parameters<2>)| {
        let mut parameters = parameters;
        change(&mut parameters);
        Finger::<2, Linkage<1>, Springless>::constant(parameters, design)
            .expect_err("out of range")
            .parameter
    };
    for spring in [
        |p: &mut Parameters<2>| p.stiffness_nm_per_rad[0] = 0.1,
        |p: &mut Parameters<2>| p.stiffness_nm_per_rad[0] = -1e-9,
        |p: &mut Parameters<2>| p.stiffness_nm_per_rad[0] = f32::NAN,
    ] {
        assert_eq!(build(spring), Parameter::Stiffness { joint: 1 });
    }
    assert_eq!(
        build(|p| p.stiffness_nm_per_rad[1] = 0.0),
        Parameter::Stiffness { joint: 2 }
    );
    assert_eq!(
        build(|p| p.lengths_m[0] = 0.2),
        Parameter::Closure { stage: 1 }
    );
    assert!(Finger::<2, Linkage<1>, AnyBase>::constant(parameters, design).is_ok());
}

/// Knowing before that K_1 is 0 leaves equations out, and changes no answer.
#[test]
fn what_the_type_says_changes_no_answer() {
    let known = P70::MECHANISM;
    let asked: Finger<2, Linkage<1>> =
        Finger::new(*known.parameters(), levers(known.transmission())).expect("P70");
    let rest = known.rest();
    for step in 0..30 {
        let angle = 0.05 * step as f32;
        let free = known.free_at_angle(angle, &rest).expect("it follows");
        assert_eq!(asked.free_at_angle(angle, &rest), Some(free));
        assert_eq!(asked.expected_k_a(&free), known.expected_k_a(&free));
        let at = known
            .configuration([0.03 * step as f32, 0.06 * step as f32])
            .expect("between its stops");
        for torque in [0.0, 0.02] {
            assert_eq!(
                asked.free_compliance(&at, torque),
                known.free_compliance(&at, torque)
            );
            assert_eq!(
                asked.free_at_torque(torque, &at),
                known.free_at_torque(torque, &at)
            );
            for compliance in [0.01, 0.3, 2.0, 20.0] {
                let place = known.locate_closed(&at, torque, compliance);
                assert_eq!(asked.locate_closed(&at, torque, compliance), place);
            }
        }
        let contact = Contact {
            phalanx: 2,
            k_m: 0.002 + 0.002 * step as f32,
            radius_m: 0.01,
        };
        let paths = (
            known.path(&rest, 0.0, contact),
            asked.path(&rest, 0.0, contact),
        );
        let (mut known_path, mut asked_path) = (paths.0.expect("presses"), paths.1.expect("too"));
        for rise in [0.01, 0.03] {
            let point = known.follow(&mut known_path, rise);
            assert!(point.is_some());
            assert_eq!(asked.follow(&mut asked_path, rise), point);
        }
    }
}
