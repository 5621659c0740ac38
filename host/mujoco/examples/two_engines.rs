//! How many times faster than real time both worlds step the prototype's whole plant, pressing on an object.

use palpate_plant::{Engine, Grasp, Parameters, Pins, Shape};
use std::time::Instant;

const SECONDS: f64 = 2.0;

fn main() {
    for engine in [Engine::Plant, Engine::Mujoco] {
        let parameters = Parameters {
            engine,
            ..Parameters::default()
        };
        let object = Grasp::touching(2, 0.03, 0.4, Shape::Cylinder { diameter_m: 0.02 });
        let mut plant =
            palpate_mujoco::plant(&parameters, &object, 1).expect("the defaults are valid");
        let pins = Pins::closing(0.5);
        let start = Instant::now();
        while plant.time_s() < SECONDS {
            plant.step(&pins, 50e-6);
        }
        let times = SECONDS / start.elapsed().as_secs_f64();
        let truth = plant.truth();
        println!(
            "{engine}: {times:.0} times real time, touched at {:?} s, contacts {:?}",
            truth.first_contact.map(|first| first.time_s),
            truth.contacts
        );
    }
}
