//! A contact where the travel ends. Simulated.

use palpate::scene::Scene;
use palpate_plant::{Grasp, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Simulated, Simulation, Verdict};

/// 0.03 rad before the closing turns back there is way for a decision, and for hardly any curve.
#[test]
fn a_contact_where_the_travel_ends_is_a_contact() {
    let mut simulation = Simulation::<P70>::new(&P70::parameters().unwrap(), 3).unwrap();
    simulation.prepare().unwrap();
    let travel_rad = f64::from(P70::settings().travel_rad);
    for before_rad in [0.03, 0.06, 0.1] {
        for k_m in [0.02, 0.035, 0.05] {
            let mut simulation = simulation.clone();
            let grasp = Grasp::touching(
                2,
                k_m,
                travel_rad - before_rad,
                Shape::Cylinder { diameter_m: 0.01 },
            );
            let outcome = simulation.close(&grasp).unwrap();
            let told = format!("{before_rad} rad, {k_m} m: {:?}", outcome.events);
            assert_eq!(outcome.fault, None, "{told}");
            assert!(outcome.delay_s().is_some_and(|s| s > 0.0), "{told}");
            assert!(
                !matches!(outcome.verdict, Verdict::Free | Verdict::Unusual),
                "{told}"
            );
        }
    }
}
