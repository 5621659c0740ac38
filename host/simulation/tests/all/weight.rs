//! Fingers whose weight closes them: the worm holds them back, and an object takes the weight over before the motor feels it.
//! Simulated.

use palpate::sensing::Event;
use palpate_plant::{Engine, Grasp, Parameters, Shape, World};
use palpate_scenes::P70;
use palpate_simulation::Simulation;

/// Joint angle at which the pins are felt, radian, and their places, metre.
const THETA_1_RAD: f64 = 0.6;
const PINS_M: [f32; 2] = [0.021, 0.0525];
/// Places of contacts that are located afterwards, metre, and how far off one may be: without the elbow of joint 2's stop, and
/// without the weight along the path, some were told 3 to 9 mm too far out.
const PLACES_M: [f64; 2] = [0.035, 0.050];
const MOST_OFF_M: f64 = 0.0045;
/// 65 g over 0.16 m, four times what the scenes expect, kilogram per metre.
const HEAVY_KG_PER_M: f64 = 0.406;

/// The guided calibration of a drawn finger in a workshop; all of these ended in `stall` when the fall of the torque was taken
/// for a softer finger.
fn calibrate(engine: Engine, seed: u64) {
    let mut world = World::named("workshop").expect("a named world");
    world.engine = engine;
    let parameters = world.of("p70").expect("valid").randomised(seed);
    let mut simulation = Simulation::<P70>::new(&parameters, seed).expect("a plant");
    assert_eq!(simulation.prepare().unwrap().fault, None, "{seed}");
    let record = simulation.slow().sensing.sensor().friction().cloned();
    let asymmetry_nm = record.expect("recorded").asymmetry(0)[0];
    assert!(asymmetry_nm < -0.01, "{seed}: {asymmetry_nm} N m");
    for k_m in PINS_M {
        let outcome = simulation.calibrate(2, k_m, THETA_1_RAD).unwrap();
        let told = format!("{engine}, seed {seed}, {k_m} m: {:?}", outcome.events);
        assert_eq!(outcome.fault, None, "{told}");
        assert!(
            matches!(outcome.events.first(), Some((_, Event::Touch { .. }))),
            "{told}"
        );
    }
    assert!(simulation.calibration().contacts > 0, "{engine}, {seed}");
    for k_m in PLACES_M {
        locate(&mut simulation, k_m, &format!("{engine}, seed {seed}"));
    }
}

/// A contact that is felt when it begins and located.
fn locate(simulation: &mut Simulation<P70>, k_m: f64, finger: &str) {
    let grasp = Grasp::touching(2, k_m, THETA_1_RAD, Shape::Cylinder { diameter_m: 0.020 });
    let outcome = simulation.close(&grasp).unwrap();
    let told = format!("{finger}, {k_m} m: {:?}", outcome.events);
    let began_s = outcome.first_contact.expect("a contact").time_s;
    let touched_s = outcome.events.iter().find_map(|(_, event)| match *event {
        Event::Touch { time_us, .. } => Some(time_us as f64 * 1e-6),
        _ => None,
    });
    assert!(
        touched_s.is_some_and(|touched_s| touched_s > began_s),
        "{told}"
    );
    let located = outcome
        .events
        .iter()
        .rev()
        .find_map(|(_, event)| match *event {
            Event::Located {
                phalanx: 2,
                k_m,
                sigma_m,
                ..
            } => Some([k_m, sigma_m].map(f64::from)),
            _ => None,
        });
    let [found_m, sigma_m] = located.unwrap_or_else(|| panic!("{told}"));
    let off_m = (found_m - k_m).abs();
    assert!(off_m < MOST_OFF_M && off_m < 3.0 * sigma_m, "{told}");
    assert_eq!(simulation.open().unwrap().fault, None, "{told}");
}

/// Where the weight opens the finger, its cable takes the load up only as it leaves the opening stop; a record with that in it made
/// closings feel contacts too early. Where the weight closes it, the motor's torque falls while an object takes the weight over, by more
/// than the fit of a contact explains; pins were refused for that.
#[test]
fn a_heavy_finger_is_calibrated_and_locates_however_it_hangs() {
    for (mounting_deg, seed) in [(-90.0, 7001), (-90.0, 7002), (90.0, 7001), (90.0, 7002)] {
        let finger = format!("mounted at {mounting_deg} degrees, seed {seed}");
        let mut parameters = Parameters::of("p70").expect("valid");
        parameters.mechanism.linear_density_kg_per_m = HEAVY_KG_PER_M;
        parameters.mechanism.gravity_m_per_s2 = 9.81;
        parameters.mechanism.mounting_deg = mounting_deg;
        let mut simulation = Simulation::<P70>::new(&parameters, seed).expect("a plant");
        assert_eq!(simulation.prepare().unwrap().fault, None, "{finger}");
        for k_m in PINS_M {
            let outcome = simulation.calibrate(2, k_m, THETA_1_RAD).unwrap();
            let is_taken = |(_, event): &(u64, Event)| matches!(event, Event::Calibrated { .. });
            let told = format!("{finger}, pin at {k_m} m: {:?}", outcome.events);
            assert!(outcome.events.iter().any(is_taken), "{told}");
            assert_eq!(outcome.fault, None, "{told}");
        }
        for k_m in PLACES_M {
            locate(&mut simulation, k_m, &finger);
        }
    }
}

#[test]
fn pins_are_felt_by_fingers_that_their_weight_closes() {
    for seed in [3003, 3004, 3006, 3008] {
        calibrate(Engine::Plant, seed);
    }
}

#[cfg(feature = "mujoco")]
#[test]
fn pins_are_felt_in_the_other_engine_too() {
    calibrate(Engine::Mujoco, 3004);
}
