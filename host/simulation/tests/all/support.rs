//! What several tests begin with.

use palpate_plant::Parameters;
use palpate_simulation::{Simulated, Simulation};

/// Shares of the last phalanx at which the pins stand.
const PINS: [f64; 2] = [0.3, 0.75];

/// Returns a finger that has recorded its friction and is calibrated on the stop and on two pins of its last phalanx, which is
/// `last_m` long, with joint 1 at an angle.
pub fn calibrated_on_pins<S: Simulated>(
    parameters: &Parameters,
    last_m: f64,
    pins_rad: f64,
) -> Simulation<S> {
    let mut simulation = Simulation::<S>::new(parameters, 1).expect("a simulation");
    simulation.prepare().expect("a record");
    simulation
        .calibrate_on_pins(last_m, PINS, pins_rad)
        .expect("pins");
    simulation
}
