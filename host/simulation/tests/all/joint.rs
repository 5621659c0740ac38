//! Use of the optional sensor of joint 2: `tendon2` closed far has its stiffest place e_2 on the phalanx, and one
//! curve then fits two places. Simulated.

use palpate::sensing::{HallSensor, JointSensor, NotLocated, Side};
use palpate_plant::{Grasp, Shape};
use palpate_scenes::{Tendon2, Tendon2Hall};
use palpate_simulation::{Outcome, Simulated, Simulation, Verdict};

/// A finger that has been calibrated on the stop and on two pins.
fn calibrated<S: Simulated>() -> Simulation<S> {
    let mut simulation = Simulation::<S>::new(&S::parameters().unwrap(), 1).unwrap();
    simulation.prepare().unwrap();
    for k_m in [0.020, 0.045] {
        simulation.calibrate(2, k_m, 0.8).unwrap();
    }
    simulation
}

fn close<S: Simulated>(simulation: &mut Simulation<S>, theta_1_deg: f64, k_m: f64) -> Outcome {
    let cylinder = Shape::Cylinder { diameter_m: 0.01 };
    let grasp = Grasp::touching(2, k_m, theta_1_deg.to_radians(), cylinder);
    simulation.close(&grasp).unwrap()
}

/// Angle of joint 1 in degree and place in metre of contacts on both sides of e_2, most of which the motor alone cannot tell
/// from one on the other side.
const CONTACTS: [(f64, f64, Side); 6] = [
    (93.0, 0.040, Side::Below),
    (94.0, 0.040, Side::Below),
    (95.0, 0.020, Side::Below),
    (96.0, 0.030, Side::Below),
    (98.0, 0.020, Side::Below),
    (97.0, 0.065, Side::Beyond),
];

/// e_2 = l_1 cos(theta_2) x_2 / (1 - x_2), x_2 = 0.8, at the true posture of the first contact.
fn e_2_m(outcome: &Outcome) -> f64 {
    4.0 * 0.09 * outcome.first_contact.unwrap().joint_rad[1].cos()
}

#[test]
fn without_the_sensor_places_on_both_sides_of_e_2_fit() {
    let simulation = calibrated::<Tendon2>();
    let mut beyond = 0;
    let mut undecided = 0;
    for (theta_1_deg, k_m, side) in CONTACTS {
        let outcome = close(&mut simulation.clone(), theta_1_deg, k_m);
        let e_2_m = e_2_m(&outcome);
        assert_eq!(k_m > e_2_m, side == Side::Beyond, "{k_m}: e_2 {e_2_m}");
        if let Verdict::Ambiguous {
            k_m: places,
            sigma_m,
            ..
        } = outcome.verdict
        {
            undecided += 1;
            beyond += usize::from(side == Side::Beyond);
            let case = format!("{k_m} m at {theta_1_deg} degree: {places:?} {sigma_m:?}");
            let near = |i: usize| (places[i] - k_m).abs() < 3.0 * sigma_m[i];
            assert!(near(0) || near(1), "{case}");
            let [low, high] = [places[0].min(places[1]), places[0].max(places[1])];
            assert!(low < e_2_m && e_2_m < high, "{case}: e_2 {e_2_m}");
        }
        // Joint 2 is near 90 degrees, where the stiffness hardly depends on the place: saying so is right as well.
        if let Verdict::NotLocated(NotLocated::Unobservable) = outcome.verdict {
            undecided += 1;
            beyond += usize::from(side == Side::Beyond);
        }
    }
    assert!(undecided >= 4 && beyond >= 1, "{undecided}, {beyond}");
}

#[test]
fn with_the_sensor_the_right_side_is_told() {
    let simulation = calibrated::<Tendon2Hall>();
    let mut located = 0;
    for (theta_1_deg, k_m, side) in CONTACTS {
        let mut simulation = simulation.clone();
        let outcome = close(&mut simulation, theta_1_deg, k_m);
        let case = format!("{k_m} m at {theta_1_deg} degree: {:?}", outcome.verdict);
        let change = simulation.slow().sensing.joint_change();
        let (place, sigma_m) = match outcome.verdict {
            Verdict::Located { k_m, sigma_m, .. } => (k_m, sigma_m),
            // Contact friction may hold joint 2, which then tells nothing.
            Verdict::NotLocated(NotLocated::Unobservable) => continue,
            _ => panic!("{case}"),
        };
        located += 1;
        assert!((place - k_m).abs() < 2.0 * sigma_m, "{case}");
        let e_2_m = e_2_m(&outcome);
        assert_eq!(place > e_2_m, side == Side::Beyond, "{case}: e_2 {e_2_m}");
        assert_eq!(HallSensor::side(change), Some(side), "{case}: {change:?}");
    }
    assert!(located >= 4, "{located}");
}

/// A wire that has come off reads zero volt, which the joint cannot have: contacts are judged as if there were no sensor.
#[test]
fn a_broken_wire_takes_the_sensor_away_and_no_more() {
    let mut broken = Tendon2Hall::parameters().unwrap();
    broken.hall.zero_v = 0.0;
    broken.hall.sensitivity_v_per_rad = 0.0;
    let mut seeing = Simulation::<Tendon2Hall>::new(&broken, 1).unwrap();
    let mut blind = Simulation::<Tendon2>::new(&Tendon2::parameters().unwrap(), 1).unwrap();
    seeing.prepare().unwrap();
    blind.prepare().unwrap();
    let told = close(&mut seeing, 95.0, 0.030);
    assert_eq!(HallSensor::rad(seeing.slow().sensing.joint_change()), None);
    assert!(
        matches!(
            told.verdict,
            Verdict::Ambiguous { .. } | Verdict::NotLocated(NotLocated::Unobservable)
        ),
        "{told:?}"
    );
    assert_eq!(told.verdict, close(&mut blind, 95.0, 0.030).verdict);
}
