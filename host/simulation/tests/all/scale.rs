//! A scale under a contact sets the scale of every force after it: springs, and what contact friction changes. Simulated: the ideal world
//! with springs that are off by 10 %.

use crate::support::{calibrated_on_pins, close_and_open};
use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::P70;
use palpate_simulation::Simulation;

/// The force that is told at a place with its deviation, and what a scale reads at that instant.
fn felt(simulation: &mut Simulation<P70>, k_m: f64) -> [f64; 3] {
    let shape = Shape::Cylinder { diameter_m: 0.012 };
    let grasp = Grasp::touching(2, k_m, 0.7, shape);
    let outcome = close_and_open(simulation, &grasp);
    let told = outcome.events.iter().find_map(|(time_us, event)| {
        let Event::Located {
            force_n,
            force_sigma_n,
            settled: true,
            ..
        } = event
        else {
            return None;
        };
        let time_s = 1e-6 * *time_us as f64;
        let row = outcome.trace.iter().find(|row| row.time_s >= time_s)?;
        let [told_n, sigma_n] = [*force_n, *force_sigma_n].map(f64::from);
        Some([told_n, sigma_n, row.true_force_n])
    });
    told.unwrap_or_else(|| panic!("{:?}", outcome.verdict))
}

#[test]
fn a_force_that_is_known_makes_the_others_true() {
    for spring_error in [-0.1, 0.1] {
        let world = World::named("ideal").expect("a world");
        let mut parameters = world.of("p70").expect("a scene");
        parameters.mechanism.spring_error = spring_error;
        let mut simulation = calibrated_on_pins::<P70>(&parameters, 0.07, 0.7);
        simulation.traced = true;
        let set = |simulation: &mut Simulation<P70>, share: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "the firmware's precision")]
            let command = Command::Set(Setting::ForceScale, share as f32);
            simulation
                .slow()
                .coordinator
                .command(command)
                .expect("taken");
        };
        let off = |[told_n, _, true_n]: [f64; 3]| told_n / true_n - 1.0;
        let before: [[f64; 3]; 2] = [0.022, 0.045].map(|k_m| felt(&mut simulation, k_m));
        set(&mut simulation, 1.0);
        let [told_n, _, scale_n] = felt(&mut simulation, 0.034);
        let share = scale_n / told_n;
        set(&mut simulation, share);
        if spring_error < 0.0 {
            let misled = before.map(|felt| off(felt).abs());
            assert!(misled.iter().all(|off| *off > 0.1), "{misled:?}");
        }
        for (k_m, before) in [0.022, 0.045].into_iter().zip(before) {
            let after = felt(&mut simulation, k_m);
            println!(
                "springs off by {spring_error}, {k_m} m: force off by {:.3}, with a scale {:.3}, deviation {:.3}",
                off(before),
                off(after),
                after[1] / after[0]
            );
            assert!(off(after).abs() < 0.03, "{after:?}");
            assert!((after[0] - after[2]).abs() < 2.0 * after[1]);
            assert!(after[1] / after[0] < before[1] / before[0], "surer");
        }
    }
}
