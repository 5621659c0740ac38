//! Contacts reported by the library next to the truth. `grasps [SCENE] [random]`.

use palpate_plant::{Grasp, Shape};
use palpate_simulation::{Error, Simulated, Simulation};

fn grasps<S: Simulated>(theta_1: f64, random: bool) -> Result<(), Error> {
    for seed in 1..=3 {
        let base = S::parameters()?;
        let parameters = if random { base.randomised(seed) } else { base };
        let start = std::time::Instant::now();
        let mut simulation = Simulation::<S>::new(&parameters, seed)?;
        println!("seed {seed}: {:?}", simulation.prepare()?.events.last());
        for calibrated in [false, true] {
            if calibrated {
                for k_m in [0.02, 0.045] {
                    println!("{:?}", simulation.calibrate(2, k_m, theta_1)?.events.last());
                }
            }
            for (phalanx, k_m) in [(2, 0.015), (2, 0.03), (2, 0.045), (2, 0.06), (1, 0.06)] {
                let outcome = simulation.close(&Grasp::touching(
                    phalanx,
                    k_m,
                    theta_1,
                    Shape::Cylinder { diameter_m: 0.01 },
                ))?;
                println!(
                    "  {phalanx} at {:.1} mm: {:?}, error {:.2?} mm, delay {:.0?} ms, {} events",
                    1e3 * k_m,
                    outcome.verdict,
                    outcome.error_m().map(|e| 1e3 * e),
                    outcome.delay_s().map(|d| 1e3 * d),
                    outcome.events.len(),
                );
                if outcome.fault.is_some() {
                    return Ok(());
                }
                simulation.open()?;
            }
            println!("  free: {:?}", simulation.close(&Grasp::Free)?.verdict);
        }
        println!(
            "{:.0} times real time",
            simulation.plant().time_s() / start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

fn main() -> Result<(), Error> {
    let options: Vec<String> = std::env::args().skip(1).collect();
    let random = options.iter().any(|o| o == "random");
    let theta_1 = |scene: &str| match scene {
        "linkage3" => 0.7,
        "p70" | "p70-rigid" => 0.8,
        _ => 0.9,
    };
    let named = options.first().map_or("p70", String::as_str);
    let scene = if palpate_scenes::NAMES.contains(&named) {
        named
    } else {
        "p70"
    };
    palpate_scenes::for_scene!(scene, |S| grasps::<S>(theta_1(scene), random)).unwrap_or(Ok(()))
}
