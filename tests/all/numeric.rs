//! The numerical tools against f64; the bounds are those that their documentation states.

use palpate::numeric::{
    BISECTION_STEPS, Rotation, SIN_COS_MAX_RAD, atan2, bisect, constant_sqrt, sin_cos, solve, sqrt,
};
use proptest::prelude::*;

/// Numbers evenly spread over a range.
fn within(low: f32, high: f32) -> impl Strategy<Value = f32> + Clone {
    (0..=u16::MAX).prop_map(move |i| low + (high - low) * (f32::from(i) / f32::from(u16::MAX)))
}

/// Points over which an error is measured.
const POINTS: u32 = 2_000_000;

/// Largest of an error over evenly spread points.
fn worst(low: f64, high: f64, error: impl Fn(f32) -> f64) -> f64 {
    (0..=POINTS)
        .map(|i| error((low + (high - low) * f64::from(i) / f64::from(POINTS)) as f32))
        .fold(0.0, f64::max)
}

fn sin_cos_error(x: f32) -> f64 {
    let (sin, cos) = sin_cos(x);
    let exact = f64::from(x).sin_cos();
    (f64::from(sin) - exact.0)
        .abs()
        .max((f64::from(cos) - exact.1).abs())
}

#[test]
fn sin_cos_error_is_as_stated() {
    let limit = f64::from(SIN_COS_MAX_RAD);
    let (near, far) = (
        worst(-7.0, 7.0, sin_cos_error),
        worst(-limit, limit, sin_cos_error),
    );
    println!("sin_cos: {near:.2e} within +-7 rad, {far:.2e} within +-{limit} rad");
    assert!(near <= 4.75e-8 && far <= 4.75e-8, "{near:e} {far:e}");
    let relative = worst(
        -core::f64::consts::FRAC_PI_4,
        core::f64::consts::FRAC_PI_4,
        |x| {
            let exact = f64::from(x).sin();
            if x == 0.0 {
                f64::from(sin_cos(x).0.abs())
            } else {
                (f64::from(sin_cos(x).0) / exact - 1.0).abs()
            }
        },
    );
    println!("sin: {relative:.2e} relative within +-pi/4");
    assert!(relative <= 7.0e-8, "{relative:e}");
}

#[test]
fn sin_cos_is_nan_exactly_where_stated() {
    for x in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        SIN_COS_MAX_RAD * 1.0001,
    ] {
        assert!(sin_cos(x).0.is_nan() && sin_cos(x).1.is_nan(), "{x}");
    }
    for x in [
        SIN_COS_MAX_RAD,
        -SIN_COS_MAX_RAD,
        f32::MIN_POSITIVE,
        -0.0,
        1e-45,
    ] {
        assert!(sin_cos(x).0.is_finite() && sin_cos(x).1.is_finite(), "{x}");
    }
}

#[test]
fn atan2_error_is_as_stated() {
    let pi = core::f64::consts::PI;
    let round = worst(-pi, pi, |angle| {
        let (y, x) = (
            3.7 * f64::from(angle).sin() as f32,
            3.7 * f64::from(angle).cos() as f32,
        );
        let off = (f64::from(atan2(y, x)) - f64::from(y).atan2(x.into())).abs();
        // Either sign at the cut.
        off.min((off - 2.0 * pi).abs())
    });
    let small = worst(1e-9, 0.1, |y| {
        (f64::from(atan2(y, 1.0)) / f64::from(y).atan() - 1.0).abs()
    });
    println!("atan2: {round:.2e} rad over the circle, {small:.2e} relative below 0.1 rad");
    assert!(round <= 1.2e-7 && small <= 6.0e-8, "{round:e} {small:e}");
    for (y, x) in [
        (0.0, 0.0),
        (f32::NAN, 1.0),
        (1.0, f32::NAN),
        (f32::INFINITY, 1.0),
        (1.0, f32::INFINITY),
    ] {
        assert_eq!(atan2(y, x), 0.0, "{y} {x}");
    }
    assert!((f64::from(atan2(0.0, -1.0)) - pi).abs() < 1e-6);
    assert!((f64::from(atan2(1e-38, 1e-38)) - pi / 4.0).abs() < 1e-6);
    assert!((f64::from(atan2(-1e38, 1e38)) + pi / 4.0).abs() < 1e-6);
}

#[test]
fn sqrt_is_the_ieee_one() {
    for x in [0.0, 1.0, 2.0, 1e-45, f32::MAX, f32::INFINITY] {
        assert_eq!(sqrt(x), x.sqrt());
    }
    assert!(sqrt(-1.0).is_nan() && sqrt(f32::NAN).is_nan());
}

#[test]
fn the_root_for_constants_is_the_ieee_one_too() {
    // Every mantissa under an even and an odd exponent, and every exponent under some mantissas.
    for exponent in [127, 128] {
        for mantissa in 0..1 << 23 {
            let x = f32::from_bits(exponent << 23 | mantissa);
            assert_eq!(constant_sqrt(x), x.sqrt(), "{x:e}");
        }
    }
    for exponent in 1..255 {
        for mantissa in [0, 1, 0x35_04F3, 0x35_04F4, 0x7F_FFFE, 0x7F_FFFF] {
            let x = f32::from_bits(exponent << 23 | mantissa);
            assert_eq!(constant_sqrt(x), x.sqrt(), "{x:e}");
        }
    }
    for x in [0.0, -0.0, -1.0, 1e-45, f32::INFINITY, f32::NAN] {
        assert_eq!(constant_sqrt(x), 0.0);
    }
}

#[test]
fn bisection_finds_refuses_and_ends() {
    let root = bisect(0.0, 2.0, |x| x * x - 2.0).expect("the signs differ");
    assert!((root - core::f32::consts::SQRT_2).abs() <= 2e-7, "{root}");
    assert_eq!(bisect(0.0, 1.0, |x| x), Some(0.0));
    assert_eq!(bisect(-1.0, 0.0, |x| x), Some(0.0));
    assert_eq!(bisect(1.0, 2.0, |x| x), None);
    assert_eq!(bisect(f32::NAN, 2.0, |x| x), None);
    assert_eq!(bisect(0.0, 1.0, |_| f32::NAN), None);
    let mut asked = 0;
    let found = bisect(-f32::MAX / 4.0, f32::MAX / 4.0, |x| {
        asked += 1;
        if x < 1e-30 { -1.0 } else { 1.0 }
    });
    assert!(found.is_some() && asked <= BISECTION_STEPS + 2, "{asked}");
}

#[test]
fn a_singular_system_has_no_solution() {
    assert_eq!(solve([[1.0, 2.0], [2.0, 4.0]], [[1.0, 2.0]]), None);
    assert_eq!(solve([[f32::NAN, 2.0], [2.0, 4.0]], [[1.0, 2.0]]), None);
    assert_eq!(
        solve([[0.0, 1.0], [1.0, 0.0]], [[3.0, 4.0]]),
        Some([[4.0, 3.0]])
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn solve_satisfies_its_equations(a in prop::array::uniform3(prop::array::uniform3(within(-1.0, 1.0))),
                                     b in prop::array::uniform3(within(-1.0, 1.0))) {
        if let Some([x]) = solve(a, [b]) {
            let size = x.iter().fold(1.0f32, |m, v| m.max(v.abs()));
            for (row, b) in a.iter().zip(b) {
                let left: f32 = row.iter().zip(x).map(|(a, x)| a * x).sum();
                // Pivoted elimination: the residual is rounding of the largest term, growth of at most 4.
                prop_assert!((left - b).abs() <= 4e-6 * size, "{left} {b} {size}");
            }
        }
    }

    #[test]
    fn turns_compose_as_angles_add(a in within(-3.0, 3.0), b in within(-3.0, 3.0)) {
        let sum = Rotation::by(a).then(Rotation::by(b));
        prop_assert!((f64::from(sum.cos) - (f64::from(a) + f64::from(b)).cos()).abs() < 3e-7);
        prop_assert!((f64::from(sum.sin) - (f64::from(a) + f64::from(b)).sin()).abs() < 3e-7);
        prop_assert!((Rotation::by(a).rad() - a).abs() < 4e-7);
        prop_assert!((Rotation::by(a).twice().sin - Rotation::by(2.0 * a).sin).abs() < 4e-7);
        prop_assert!(Rotation::by(a).then(Rotation::by(a).back()).sin.abs() < 2e-7);
    }

    #[test]
    fn nothing_panics_or_invents_numbers(y in any::<u32>(), x in any::<u32>()) {
        let (y, x) = (f32::from_bits(y), f32::from_bits(x));
        prop_assert!(atan2(y, x).is_finite());
        let (sin, cos) = sin_cos(x);
        prop_assert!(sin.is_nan() == cos.is_nan() && (sin.is_nan() || (sin.abs() <= 1.0 && cos.abs() <= 1.0)));
        prop_assert!(bisect(y, x, |v| v - 1.0).is_none_or(f32::is_finite));
        if let Some([[a, b]]) = solve([[y, x], [x, 1.0]], [[1.0, y]]) {
            prop_assert!(a.is_finite() && b.is_finite());
        }
        // It does solve what can be.
        let tilted = sin_cos(x).0;
        if tilted.is_finite() {
            prop_assert!(solve([[2.0, tilted], [tilted, 2.0]], [[1.0, 0.0]]).is_some());
        }
    }
}
