//! A quiet plant, and how to drive it.
#![allow(dead_code, reason = "not every test uses all of it")]

use palpate_plant::{Parameters, Pins, Plant, Shape};

/// Step of the simulation, second.
pub const STEP: f64 = 50e-6;

/// A scene without noise.
pub fn scene(name: &str) -> Parameters {
    silent(Parameters::of(name).expect(name))
}

/// Levels that drive with a duty, closing where it is positive.
pub fn drive(duty: f64) -> Pins {
    Pins {
        outputs_enabled: true,
        awake: true,
        duty: duty.abs(),
        closing: duty >= 0.0,
    }
}

/// Lets time pass.
pub fn run(plant: &mut Plant, pins: &Pins, seconds: f64) {
    for _ in 0..(seconds / STEP).round() as u64 {
        plant.step(pins, STEP);
    }
}

/// The default scene without noise.
pub fn quiet() -> Parameters {
    silent(Parameters::default())
}

/// The same world without noise.
pub fn silent(mut p: Parameters) -> Parameters {
    p.sense.noise_rms_a = 0.0;
    p.sense.offset_a = 0.0;
    p.sense.offset_drift_a = 0.0;
    p.sense.gain_error = 0.0;
    p.supply.noise_rms_v = 0.0;
    p.hall.noise_rms_v = 0.0;
    p
}

/// A cylinder.
pub fn cylinder(diameter_m: f64) -> Shape {
    Shape::Cylinder { diameter_m }
}
