//! Random grasps with random plants, each within its spread: whatever the protection says, it is wrong.
//!
//! 100 grasps, or as many as `PALPATE_GRASPS` says.

use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::Simulation;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// Grasps with one plant, after one friction record.
const PER_PLANT: u64 = 10;

/// Faults and refusals in the life of one random plant, and its grasps.
fn wrong(seed: u64) -> (u64, Vec<String>) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let parameters = Parameters::default().randomised(seed);
    let mut simulation = Simulation::<P70>::new(&parameters, seed).expect("a valid plant");
    let prepared = simulation.prepare().expect("accepted");
    if let Some(fault) = prepared.fault {
        return (
            0,
            vec![format!("seed {seed}: {fault:?} while recording friction")],
        );
    }
    let (mut made, mut wrong) = (0, Vec::new());
    for _ in 0..PER_PLANT {
        let phalanx = if random.random_bool(0.3) { 1 } else { 2 };
        let k_m = random.random_range(0.003..if phalanx == 1 { 0.085 } else { 0.067 });
        let theta_1 = random.random_range(0.25..1.1);
        let diameter_m = random.random_range(0.004..0.04);
        let grasp = Grasp::touching(phalanx, k_m, theta_1, Shape::Cylinder { diameter_m });
        let what = format!(
            "seed {seed}: {:.0} mm at {:.1} mm of phalanx {phalanx}, theta_1 {theta_1:.2}",
            1e3 * diameter_m,
            1e3 * k_m,
        );
        let closed = match simulation.close(&grasp) {
            Ok(outcome) => outcome,
            // Some random objects cannot be where they are wanted; the finger has not moved.
            Err(palpate_simulation::Error::Plant(_)) => continue,
            Err(error) => panic!("{what}: {error}"),
        };
        made += 1;
        let fault = closed
            .fault
            .or_else(|| simulation.open().expect("accepted").fault);
        if let Some(fault) = fault {
            wrong.push(format!(
                "{what}: {fault:?}, torque {:.3} N m",
                closed.truth.torque_nm
            ));
            break;
        }
    }
    (made, wrong)
}

#[test]
fn healthy_grasps_show_no_fault() {
    let grasps: u64 = std::env::var("PALPATE_GRASPS").map_or(100, |number| {
        number.parse().expect("PALPATE_GRASPS is a number")
    });
    let found: Vec<(u64, Vec<String>)> = (1..=grasps.div_ceil(PER_PLANT))
        .into_par_iter()
        .map(wrong)
        .collect();
    let made: u64 = found.iter().map(|(made, _)| made).sum();
    let wrong: Vec<String> = found.into_iter().flat_map(|(_, wrong)| wrong).collect();
    println!("{made} grasps made of {grasps}");
    assert_eq!(wrong, [""; 0], "{} of {made}", wrong.len());
    // Some objects cannot be where they are wanted.
    assert!(made > grasps / 2, "{made} of {grasps}");
}
