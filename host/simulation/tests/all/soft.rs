//! Objects on springs: the default scene tells how stiff they are, and its places are true; one that takes them to be rigid is misled. Pins
//! stay fixed. Simulated: the ideal world with springs of 0.25 to 3 N/mm.

use palpate::sensing::{NotLocated, Relative};
use palpate_plant::{Engine, Grasp, Object, ObjectMount, Shape, World};
use palpate_scenes::{P70, P70Grasp};
use palpate_simulation::places::{PIN_SHARES, summary};
use palpate_simulation::soft_objects::{LEVELS, Score, finger};
use palpate_simulation::{Simulated, Simulation, Verdict};

const GRASPS: usize = 8;

fn felt<S: Simulated>(engine: Engine) -> Vec<Score> {
    let mut world = World::named("ideal").expect("a world");
    world.engine = engine;
    finger::<S>(&world, 7, GRASPS).expect("closes")
}

fn check(engine: Engine) {
    let (soft, rigid) = (felt::<P70>(engine), felt::<P70Grasp>(engine));
    for ((level, soft), rigid) in LEVELS.iter().zip(&soft).zip(&rigid) {
        let ([error, within], [off, honest]) = (summary(&soft.places), summary(&soft.compliances));
        println!(
            "{level:?}: {:.2} % {within:.0} %, {:.2} mm/N {honest:.0} %, rigid {:.2} %",
            100.0 * error,
            1e3 * off,
            100.0 * summary(&rigid.places)[0]
        );
        assert!(soft.closings >= 6 && soft.elsewhere == 0, "{soft:?}");
        assert!(soft.places.len() as u32 + 1 >= soft.closings, "{soft:?}");
        assert!(
            error < 0.02 && within >= 85.0,
            "{level:?}: {:?}",
            soft.places
        );
        assert!(honest >= 85.0, "{level:?}: {:?}", soft.compliances);
        let told = soft.clear as usize;
        match level {
            // A rigid object is not said to be soft.
            None => assert!(told <= 1, "{:?}", soft.compliances),
            Some(stiffness) if *stiffness <= 500.0 => {
                assert_eq!(told, soft.compliances.len(), "{:?}", soft.compliances);
            }
            Some(_) => {}
        }
    }
    // Who takes the softest to be rigid is misled.
    let [misled, _] = summary(&rigid[LEVELS.len() - 1].places);
    assert!(misled > 0.04, "{misled}");
}

#[test]
fn stiffness_and_place_of_objects_on_springs_are_true() {
    check(Engine::Plant);
}

#[cfg(feature = "mujoco")]
#[test]
fn stiffness_and_place_are_true_in_the_other_engine() {
    check(Engine::Mujoco);
}

/// The firmware without the option has nothing to tell; with it an object that takes most of the rotation is softer than the finger.
#[test]
fn what_gives_way_more_is_told() {
    fn close<S: Simulated>(stiffness_n_per_m: f64, k_m: f64) -> Option<Relative> {
        let world = World::named("ideal").expect("a world");
        let parameters = world.of(S::NAME).expect("a scene");
        let mut simulation = Simulation::<S>::new(&parameters, 1).expect("a simulation");
        simulation.prepare().expect("a record");
        simulation
            .calibrate_on_pins(0.07, PIN_SHARES, 0.7)
            .expect("pins");
        let held = Object {
            mount: ObjectMount::Spring,
            stiffness_n_per_m,
            ..parameters.object
        };
        simulation.plant().mount(&held).expect("a mount");
        let shape = Shape::Cylinder { diameter_m: 0.016 };
        let outcome = simulation
            .close(&Grasp::touching(2, k_m, 0.7, shape))
            .expect("closes");
        println!("{:?}", outcome.verdict);
        let object = simulation.slow().sensing.object();
        object.map(|object| object.relative())
    }
    assert_eq!(close::<P70Grasp>(250.0, 0.035), None);
    // Far out the finger itself is stiff.
    assert_eq!(close::<P70>(150.0, 0.050), Some(Relative::Softer));
    assert_eq!(close::<P70>(3000.0, 0.020), Some(Relative::Stiffer));
}

/// A curve of a soft object on phalanx 1 may not be explained by one elsewhere. Without its compliance in that hypothesis one of these is
/// `unobservable`.
#[test]
fn soft_objects_on_phalanx_1_are_told_to_be_there() {
    let world = World::named("workshop").expect("a world");
    let parameters = world.of("p70").expect("a scene");
    let mut simulation = Simulation::<P70>::new(&parameters, 1).expect("a simulation");
    simulation.prepare().expect("a record");
    simulation
        .calibrate_on_pins(0.07, PIN_SHARES, 0.7)
        .expect("pins");
    for stiffness_n_per_m in [1000.0, 500.0, 250.0] {
        let held = Object {
            mount: ObjectMount::Spring,
            stiffness_n_per_m,
            ..parameters.object
        };
        let told: Vec<Verdict> = [0.03, 0.04, 0.05, 0.06, 0.07, 0.08]
            .into_iter()
            .map(|k_m| {
                let mut simulation = simulation.clone();
                simulation.plant().mount(&held).expect("a mount");
                let shape = Shape::Cylinder { diameter_m: 0.016 };
                (simulation.close(&Grasp::touching(1, k_m, 0.7, shape)))
                    .expect("closes")
                    .verdict
            })
            .collect();
        println!("{stiffness_n_per_m}: {told:?}");
        let proximal = Verdict::NotLocated(NotLocated::Proximal);
        assert!(told.iter().all(|verdict| *verdict == proximal), "{told:?}");
    }
}

/// The plant has no object that moves freely.
#[test]
fn a_free_object_is_refused_by_name() {
    let world = World::named("ideal").expect("a world");
    let parameters = world.of("p70").expect("a scene");
    let mut simulation = Simulation::<P70>::new(&parameters, 1).expect("a simulation");
    let free = Object {
        mount: ObjectMount::Free,
        ..parameters.object
    };
    let refused = simulation.plant().mount(&free).expect_err("refused");
    assert!(refused.to_string().contains("object.mount"), "{refused}");
    assert_eq!(
        simulation.plant().parameters().object.mount,
        ObjectMount::Fixed
    );
}
