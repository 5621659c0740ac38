//! The same grasp with finger and object computed by MuJoCo: it is felt, and where it was felt agrees with the truth of
//! that world. Needs the feature `mujoco`.

#![cfg(feature = "mujoco")]

use palpate_plant::{Engine, Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Outcome, Simulation, Verdict};

/// The prototype with its friction recorded.
fn prepared(engine: Engine) -> Simulation<P70> {
    let parameters = Parameters {
        engine,
        ..Parameters::default()
    };
    let mut simulation = Simulation::<P70>::new(&parameters, 1).expect("the defaults are valid");
    let prepared = simulation.prepare().expect("an idle finger");
    assert_eq!(prepared.fault, None, "{engine}");
    simulation
}

fn close(simulation: &mut Simulation<P70>) -> Outcome {
    let object = Grasp::touching(2, 0.030, 0.8, Shape::Cylinder { diameter_m: 0.010 });
    simulation.close(&object).expect("clear of the open finger")
}

#[test]
fn both_engines_let_the_same_contact_be_located() {
    for engine in [Engine::Plant, Engine::Mujoco] {
        let closed = close(&mut prepared(engine));
        assert_eq!(closed.fault, None, "{engine}");
        let first = closed.first_contact.expect("the object is in the way");
        assert_eq!(first.contact.phalanx, 2, "{engine}");
        assert!((first.contact.k_m - 0.030).abs() < 2e-4, "{engine}");
        let delay_s = closed.delay_s().expect("a touch");
        println!(
            "{engine}: {:?}, {delay_s:.4} s after {:?}",
            closed.verdict, first
        );
        assert!((-2e-3..0.2).contains(&delay_s), "{engine}: {delay_s} s");
        let Verdict::Located { k_m, .. } = closed.verdict else {
            panic!("{engine}: {:?}", closed.verdict);
        };
        assert!(
            (k_m - first.contact.k_m).abs() < 0.1 * 0.070,
            "{engine}: {k_m} m"
        );
    }
}

#[test]
fn a_clone_goes_its_own_way_to_the_same_end() {
    let mut simulation = prepared(Engine::Mujoco);
    let mut twin = simulation.clone();
    let told = [&mut simulation, &mut twin].map(|one| {
        let closed = close(one);
        // As text: a radius that is not known yet is no number, and not equal to itself.
        format!("{:?} {:?}", closed.events, closed.truth)
    });
    assert_eq!(told[0], told[1]);
}
