//! What several tests begin with.

use palpate::sensing::Event;
use palpate_plant::{Grasp, Parameters};
use palpate_simulation::places::PIN_SHARES;
use palpate_simulation::{Outcome, Simulated, Simulation};

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
        .calibrate_on_pins(last_m, PIN_SHARES, pins_rad)
        .expect("pins");
    simulation
}

/// Closes on an object and opens again.
pub fn close_and_open<S: Simulated>(simulation: &mut Simulation<S>, grasp: &Grasp) -> Outcome {
    let outcome = simulation.close(grasp).expect("closes");
    simulation.open().expect("opens");
    outcome
}

/// The last word on a place: its phalanx, place and deviation in metre; `None` where there was none.
pub fn settled(outcome: &Outcome) -> Option<(u8, [f64; 2])> {
    outcome.events.iter().find_map(|(_, event)| match event {
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            settled: true,
            ..
        } => Some((*phalanx, [*k_m, *sigma_m].map(f64::from))),
        _ => None,
    })
}

/// Closings on phalanx 2, and how true the places were that they told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Places {
    /// Closings.
    pub closings: u32,
    /// Of these, with a place on phalanx 2.
    pub located: u32,
    /// Of these, within two deviations.
    pub within: u32,
    sum_m: f64,
}

impl Places {
    /// Closes on an object at a place of phalanx 2.
    pub fn feel<S: Simulated>(&mut self, simulation: &mut Simulation<S>, k_m: f64, grasp: &Grasp) {
        let outcome = close_and_open(simulation, grasp);
        self.closings += 1;
        if let Some((2, [told_m, sigma_m])) = settled(&outcome) {
            let off_m = (told_m - k_m).abs();
            println!(
                "{:.1} mm: off by {:.2} mm +- {:.2}",
                1e3 * k_m,
                1e3 * off_m,
                1e3 * sigma_m
            );
            self.located += 1;
            self.within += u32::from(off_m < 2.0 * sigma_m);
            self.sum_m += off_m;
        }
    }

    /// Mean error without sign, metre; NaN without a place.
    pub fn error_m(&self) -> f64 {
        self.sum_m / f64::from(self.located)
    }
}
