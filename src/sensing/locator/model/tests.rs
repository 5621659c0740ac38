use super::*;
use crate::scene::{Linkage3, P70, P70Preloaded, Scene, Tendon2};
use crate::sensing::Cable;
use crate::sensing::locator::tests::prior;

/// A weight that opens the finger and one that closes it: torque and its derivative by the angle.
const WEIGHTS: [[f32; 2]; 2] = [[0.008, -0.011], [-0.012, 0.006]];

/// A point of a curve at a measured angle.
fn point_at(angle_rad: f32, drivetrain: &Drivetrain) -> Point {
    Point {
        counts: angle_rad / drivetrain.rad_per_count,
        blocks: 1,
        ..Point::EMPTY
    }
}

/// What is predicted at one angle, with the free finger of the onset's angle.
fn predicted<F: Mechanics>(
    finger: &F,
    drivetrain: &Drivetrain,
    values: &Values,
    (hold, weight): (Hold, [f32; 2]),
    point: &Point,
) -> Prediction {
    // As the fit has it: by the calibration, whatever the unknowns are.
    let twist = 0.7 / 0.95;
    let mut onset = finger.free_at_angle(values[ONSET], &finger.rest()).unwrap();
    for _ in 0..20 {
        let angle_rad = values[ONSET] - twist * onset.torque_nm;
        onset = finger
            .free_at_angle(angle_rad, &onset.configuration)
            .unwrap();
    }
    let prior = Prior { weight, ..prior() };
    let mut model =
        Model::<F, Cable>::new(finger, (0.0, drivetrain), values, &prior, hold, &onset).unwrap();
    // As near to the prediction as the measured value of a curve is.
    let mut found = NOTHING;
    for _ in 0..4 {
        let near = Point {
            excess_nm: found.excess_nm,
            ..*point
        };
        model.before_nm = [found.excess_nm; 2];
        found = model.next(finger, &near).unwrap();
    }
    found
}

fn check<F: Mechanics>(
    finger: &F,
    drivetrain: &Drivetrain,
    onset_rad: f32,
    (phalanx, k_m, weight): (u8, f32, [f32; 2]),
    within: f32,
) {
    let mut values = [0.0; UNKNOWNS];
    values[K] = k_m;
    values[ONSET] = onset_rad;
    values[FRICTION] = 0.1;
    values[FACTOR] = 0.95;
    values[JOINT] = 1e-4;
    values[CABLE] = 0.7;
    values[BEND] = 0.2;
    let mut steps = vec![2e-4, 1e-3, 0.01, 0.005, 1e-4, 0.01, 0.02];
    if fits_loss::<F, Cable>() {
        values[LOSS] = 0.04;
        steps.push(0.01);
    }
    for (past_rad, late_nm) in [(0.05, 0.0), (0.12, 0.02)] {
        let point = Point {
            late_nm,
            free_nm: finger
                .free_at_angle(onset_rad + past_rad, &finger.rest())
                .map_or(0.0, |free| free.torque_nm),
            ..point_at(onset_rad + past_rad, drivetrain)
        };
        let hold = Hold::Contact {
            phalanx,
            radius_m: 0.014,
        };
        let held = (hold, weight);
        let here = predicted(finger, drivetrain, &values, held, &point);
        for (unknown, &step) in steps.iter().enumerate() {
            let beside = |sign: f32| {
                let mut moved = values;
                moved[unknown] += sign * step;
                predicted(finger, drivetrain, &moved, held, &point).excess_nm
            };
            let difference = (beside(1.0) - beside(-1.0)) / (2.0 * step);
            let slope = here.slopes[unknown];
            // Both in newton metre for a step.
            let off_nm = (slope - difference).abs() * step;
            let size_nm = difference.abs() * step;
            assert!(
                off_nm <= within * size_nm + 2e-6,
                "{phalanx} {k_m} {past_rad} unknown {unknown}: {slope} {difference}"
            );
        }
    }
}

#[test]
fn derivatives_agree_with_differences() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    for k_m in [0.01, 0.03, 0.05] {
        check(&finger, &drivetrain, 0.8, (2, k_m, [0.0; 2]), 0.06);
        for weight in WEIGHTS {
            check(&finger, &drivetrain, 0.8, (2, k_m, weight), 0.06);
        }
    }
    // With springs the onset moves the posture and the free finger's torque too.
    let finger = Tendon2::MECHANISM;
    let rest_rad = finger.input_angle_rad(&finger.rest());
    let drivetrain = Tendon2::drivetrain(&finger);
    for k_m in [0.015, 0.03] {
        check(
            &finger,
            &drivetrain,
            rest_rad + 0.4,
            (2, k_m, [0.0; 2]),
            0.15,
        );
    }
    let finger = Linkage3::MECHANISM;
    let rest_rad = finger.input_angle_rad(&finger.rest());
    let drivetrain = Linkage3::drivetrain(&finger);
    for place in [(2, 0.03, [0.0; 2]), (3, 0.02, [0.0; 2])] {
        check(&finger, &drivetrain, rest_rad + 0.3, place, 0.15);
    }
}

/// A contact that has slid to the tip of a finger whose springs take torque before the contact, too.
#[test]
fn beyond_the_end_of_a_path_the_force_goes_on_as_it_rose() {
    let finger = Tendon2::MECHANISM;
    let drivetrain = Tendon2::drivetrain(&finger);
    let onset_rad = finger.input_angle_rad(&finger.rest()) + 0.6;
    let onset = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    assert!(onset.torque_nm > 0.02, "{}", onset.torque_nm);
    let length_m = finger.phalanx_length_m(2).unwrap();
    let mut values = [0.0; UNKNOWNS];
    values[ONSET] = onset_rad;
    values[FACTOR] = 1.0;
    for share in [0.9, 0.95, 0.98] {
        values[K] = share * length_m;
        let hold = Hold::Contact {
            phalanx: 2,
            radius_m: 0.014,
        };
        let mut model =
            Model::<_, Cable>::new(&finger, (0.0, &drivetrain), &values, &prior(), hold, &onset)
                .unwrap();
        let mut told = Vec::new();
        let mut excess_nm = 0.0;
        for i in 1..400 {
            let past_rad = 1e-3 * i as f32;
            let point = Point {
                excess_nm,
                free_nm: onset.torque_nm,
                ..point_at(onset_rad + past_rad, &drivetrain)
            };
            let predicted_nm = model.next(&finger, &point).unwrap().excess_nm;
            told.push((excess_nm, model.force_n(), model.ended));
            // As the path has it, and from its end on steadily.
            excess_nm = if model.ended {
                excess_nm + 8e-4
            } else {
                predicted_nm
            };
        }
        let end = told.iter().position(|(_, _, ended)| *ended).unwrap();
        assert!(end > 0 && end < 200, "{share}: {end}");
        let (rise_nm, force_n, _) = told[end - 1];
        let (all_nm, last_n, _) = told[told.len() - 1];
        // Without force at the onset, the force is about in proportion to the rise.
        let expected_n = force_n * all_nm / rise_nm;
        assert!(
            (last_n / expected_n - 1.0).abs() < 0.15,
            "{share}: {force_n} N at {rise_nm}, {last_n} N at {all_nm}, not {expected_n}"
        );
    }
}

/// Unknowns of a contact on phalanx 2 whose joints take a torque, newton metre.
fn held(onset_rad: f32, k_m: f32, factor: f32, joint_nm: f32) -> (Values, Hold) {
    let mut values = [0.0; UNKNOWNS];
    values[K] = k_m;
    values[ONSET] = onset_rad;
    values[FACTOR] = factor;
    values[JOINT] = joint_nm;
    values[CABLE] = 0.7;
    let hold = Hold::Contact {
        phalanx: 2,
        radius_m: 0.006,
    };
    (values, hold)
}

/// Checks that preload holds joint 2 at its stop: only the cable gives way until the torque lifts the joint off the stop.
#[test]
fn preload_makes_an_elbow() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let onset_rad = 0.8;
    let onset = finger.free_at_angle(onset_rad, &finger.rest()).unwrap();
    let (values, hold) = held(onset_rad, 0.045, 1.0, 2e-3);
    let mut model =
        Model::<_, Cable>::new(&finger, (0.0, &drivetrain), &values, &prior(), hold, &onset)
            .unwrap();
    let (mut excess_nm, mut lifted_rad) = (0.0, None);
    for step in 1..100 {
        let past_rad = 1e-3 * step as f32;
        let point = Point {
            excess_nm,
            ..point_at(onset_rad + past_rad, &drivetrain)
        };
        let found = model.next(&finger, &point).unwrap();
        let rise_nm = found.excess_nm - excess_nm;
        excess_nm = found.excess_nm;
        if found.slopes[K] == 0.0 {
            assert_eq!(lifted_rad, None, "no second time: {past_rad}");
            // The bound is the least rise to which a path is followed.
            assert!(
                (excess_nm - past_rad / values[CABLE]).abs() < LEAST_RISE_NM,
                "{past_rad}: {excess_nm}"
            );
        } else {
            lifted_rad.get_or_insert(past_rad);
            // Softer than the cable alone, and without a jump.
            assert!(
                rise_nm > 0.0 && rise_nm < 1.1e-3 / values[CABLE],
                "{past_rad}: {rise_nm}"
            );
        }
    }
    // The torque at which joint 2 is lifted is several times the preload: most of the torque presses on the object.
    let lifted_nm = lifted_rad.unwrap() / values[CABLE];
    assert!(
        lifted_nm > 2.0 * values[JOINT] && lifted_nm < 20.0 * values[JOINT],
        "{lifted_nm}"
    );
}

/// Checks the point in which a contact without a cable begins against the mean of a step and a ramp, and its derivative by the onset
/// against differences.
#[test]
fn a_step_at_the_onset_is_averaged_over_its_point() {
    let (slope, step_nm, half_rad) = (0.4f32, 0.006f32, 0.004f32);
    let begun = |past_rad: f32| {
        let mut slopes = [0.0; UNKNOWNS];
        (slopes[ONSET], slopes[JOINT]) = (-slope, 5.0);
        let mut prediction = Prediction {
            excess_nm: step_nm + slope * past_rad,
            slopes,
            variance_nm2: 0.0,
        };
        prediction.begin_with_step(past_rad, half_rad);
        prediction
    };
    for past_rad in [-0.0039f32, -0.002, 0.0, 0.001, 0.0039] {
        let from = past_rad - half_rad;
        let parts = (0..1000).map(|i| {
            let at_rad = from + 2.0 * half_rad * (i as f32 + 0.5) / 1000.0;
            if at_rad < 0.0 {
                0.0
            } else {
                step_nm + slope * at_rad
            }
        });
        let mean_nm = parts.sum::<f32>() / 1000.0;
        let prediction = begun(past_rad);
        assert!((prediction.excess_nm - mean_nm).abs() < 2e-3 * step_nm);
        let (later, earlier) = (begun(past_rad - 1e-4), begun(past_rad + 1e-4));
        let difference = (later.excess_nm - earlier.excess_nm) / 2e-4;
        assert!((prediction.slopes[ONSET] / difference - 1.0).abs() < 1e-2);
        assert!((prediction.slopes[JOINT] - 2.5 * (past_rad / half_rad + 1.0)).abs() < 1e-4);
    }
}

/// What a point measures is a mean: where the finger breaks away within it, of a stiff and of a soft line. Value and derivatives against the
/// mean over narrow points.
#[test]
fn a_point_in_which_the_finger_breaks_away_is_the_mean_over_its_way() {
    const PARTS: usize = 201;
    let finger = P70Preloaded::MECHANISM;
    let drivetrain = P70Preloaded::drivetrain(&finger);
    let onset_rad = 0.8;
    let (values, hold) = held(onset_rad, 0.03, 0.95, 1e-3);
    let told = |past_rad: f32, width_rad: f32| {
        let point = Point {
            width_counts: width_rad / drivetrain.rad_per_count,
            ..point_at(onset_rad + past_rad, &drivetrain)
        };
        predicted(&finger, &drivetrain, &values, (hold, [0.0; 2]), &point)
    };
    let breaks_rad = (1..200)
        .map(|step| 1e-3 * step as f32)
        .find(|past_rad| told(*past_rad, 0.0).slopes[K] != 0.0)
        .expect("it breaks away");
    let width_rad = 0.01;
    assert!(breaks_rad > width_rad, "{breaks_rad}");
    let (mut bent, mut most_nm) = (0, 0.0f32);
    for step in -6..=6 {
        let past_rad = breaks_rad + 1e-3 * step as f32;
        let parts = (0..PARTS).map(|part| {
            told(
                past_rad + width_rad * ((part as f32 + 0.5) / PARTS as f32 - 0.5),
                0.0,
            )
        });
        let (mut mean_nm, mut by_k, mut by_joint) = (0.0, 0.0, 0.0);
        for part in parts {
            mean_nm += part.excess_nm / PARTS as f32;
            by_k += part.slopes[K] / PARTS as f32;
            by_joint += part.slopes[JOINT] / PARTS as f32;
        }
        let wide = told(past_rad, width_rad);
        let [middle, soft] = [told(past_rad, 0.0), told(breaks_rad + width_rad, 0.0)];
        most_nm = most_nm.max((middle.excess_nm - mean_nm).abs());
        bent += usize::from((middle.excess_nm - mean_nm).abs() > 1e-4);
        assert!(
            (wide.excess_nm - mean_nm).abs() < 3e-5,
            "{step}: {} {mean_nm}, in the middle {}",
            wide.excess_nm,
            middle.excess_nm
        );
        for (told, mean, whole) in [
            (wide.slopes[K], by_k, soft.slopes[K]),
            (wide.slopes[JOINT], by_joint, soft.slopes[JOINT]),
        ] {
            assert!(
                (told - mean).abs() < 0.1 * whole.abs(),
                "{step}: {told} {mean}"
            );
        }
    }
    // Without the mean a point would be off by several times its noise.
    assert!(bent > 4 && most_nm > 5e-4, "{bent} {most_nm}");
}
