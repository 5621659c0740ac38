//! What the optional sensor of joint 2 is for: `tendon2` closed far has its stiffest place e_2 on the phalanx, and one
//! curve then fits two places. Simulated.

use palpate::scene::{Tendon2, Tendon2Hall};
use palpate::sensing::{Hall, JointSensor, Side};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_rig::{Outcome, Rig, Simulated, Verdict};

/// A finger that has been calibrated on the stop and on two pins.
fn calibrated<S: Simulated>() -> Rig<S> {
    let mut rig = Rig::<S>::new(&Parameters::default(), 1).unwrap();
    rig.prepare().unwrap();
    rig.press().unwrap();
    for k_m in [0.020, 0.045] {
        rig.calibrate(2, k_m, 0.8).unwrap();
    }
    rig
}

fn close<S: Simulated>(rig: &mut Rig<S>, theta_1_deg: f64, k_m: f64) -> Outcome {
    let cylinder = Shape::Cylinder { diameter_m: 0.01 };
    let grasp = Grasp::touching(2, k_m, theta_1_deg.to_radians(), cylinder);
    rig.close(&grasp).unwrap()
}

/// Angle of joint 1 in degree and place in metre of contacts on both sides of e_2, which the motor alone cannot tell apart.
const CONTACTS: [(f64, f64, Side); 6] = [
    (93.0, 0.040, Side::Below),
    (94.0, 0.040, Side::Below),
    (95.0, 0.030, Side::Below),
    (96.0, 0.030, Side::Below),
    (98.0, 0.020, Side::Below),
    (97.0, 0.065, Side::Beyond),
];

#[test]
fn a_hall_sensor_tells_the_sides_of_e_2_apart() {
    let (blind, seeing) = (calibrated::<Tendon2>(), calibrated::<Tendon2Hall>());
    for (theta_1_deg, k_m, side) in CONTACTS {
        let case = format!("{k_m} m at {theta_1_deg} degree");
        // The truth: e_2 = l_1 cos(theta_2) x_2 / (1 - x_2) with x_2 = 0.8.
        let outcome = close(&mut blind.clone(), theta_1_deg, k_m);
        let first = outcome.first_contact.unwrap();
        let e_2_m = 4.0 * 0.09 * first.joint_rad[1].cos();
        assert_eq!(k_m > e_2_m, side == Side::Beyond, "{case}: e_2 {e_2_m}");
        let Verdict::Ambiguous {
            k_m: places,
            sigma_m,
            ..
        } = outcome.verdict
        else {
            panic!("{case}: {:?}", outcome.verdict);
        };
        let is_near = |i: usize| (places[i] - k_m).abs() < 3.0 * sigma_m[i];
        assert!(is_near(0) || is_near(1), "{case}: {places:?} {sigma_m:?}");
        assert!(
            places.iter().any(|&place| place < e_2_m) && places.iter().any(|&place| place > e_2_m),
            "{case}: {places:?}"
        );

        let mut rig = seeing.clone();
        let outcome = close(&mut rig, theta_1_deg, k_m);
        let Verdict::Located {
            k_m: place,
            sigma_m,
            ..
        } = outcome.verdict
        else {
            panic!("{case}: {:?}", outcome.verdict);
        };
        assert!((place - k_m).abs() < 2.0 * sigma_m, "{case}: {place}");
        let change = rig.slow().sense.joint_change();
        assert_eq!(Hall::side(change), Some(side), "{case}: {change:?}");
    }
}

/// A wire that has come off reads zero volt, which the joint cannot have: contacts are judged as if there were no sensor.
#[test]
fn a_broken_wire_takes_the_sensor_away_and_no_more() {
    let mut broken = Parameters::default();
    broken.hall.zero_v = 0.0;
    broken.hall.sensitivity_v_per_rad = 0.0;
    let mut seeing = Rig::<Tendon2Hall>::new(&broken, 1).unwrap();
    let mut blind = Rig::<Tendon2>::new(&broken, 1).unwrap();
    seeing.prepare().unwrap();
    blind.prepare().unwrap();
    let told = close(&mut seeing, 95.0, 0.030);
    assert_eq!(Hall::rad(seeing.slow().sense.joint_change()), None);
    assert!(
        matches!(told.verdict, Verdict::Ambiguous { .. }),
        "{told:?}"
    );
    assert_eq!(told.verdict, close(&mut blind, 95.0, 0.030).verdict);
}
