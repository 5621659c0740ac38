//! Random grasps with random plants: any fault is a false one. `healthy [COUNT] [FIRST_SEED]`.

use palpate::scene::P70;
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_rig::{Rig, Verdict};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// One random plant: friction, then a few random grasps. What went wrong, and the errors in millimetre.
fn grasps(seed: u64) -> (Vec<String>, Vec<f64>) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let parameters = Parameters::default().randomised(seed);
    let mut wrong = Vec::new();
    let mut errors = Vec::new();
    let mut rig = match Rig::<P70>::new(&parameters, seed) {
        Ok(rig) => rig,
        Err(error) => return (vec![error.to_string()], errors),
    };
    let prepared = rig.prepare();
    if !matches!(&prepared, Ok(outcome) if outcome.fault.is_none()) {
        return (
            vec![format!(
                "seed {seed}: prepare {:?}",
                prepared.map(|o| o.fault)
            )],
            errors,
        );
    }
    for _ in 0..5 {
        let phalanx = if random.random_range(0.0..1.0) < 0.3 {
            1
        } else {
            2
        };
        let k_m = random.random_range(0.003..if phalanx == 1 { 0.085 } else { 0.067 });
        let theta_1 = random.random_range(0.25..1.1);
        let diameter_m = random.random_range(0.004..0.04);
        let grasp = Grasp::touching(phalanx, k_m, theta_1, Shape::Cylinder { diameter_m });
        let what = format!(
            "seed {seed}: {phalanx} at {:.1} mm, theta_1 {theta_1:.2}, {:.0} mm",
            1e3 * k_m,
            1e3 * diameter_m
        );
        match rig.close(&grasp) {
            Ok(outcome) => {
                if let Some(fault) = outcome.fault {
                    wrong.push(format!(
                        "{what}: {fault:?} while closing, torque {:.3} N m",
                        outcome.truth.torque_nm
                    ));
                    break;
                }
                if outcome.verdict == Verdict::Free {
                    wrong.push(format!("{what}: not felt"));
                }
                errors.extend(outcome.error_m().map(|e| 1e3 * e));
            }
            Err(error) => {
                wrong.push(format!("{what}: {error}"));
                continue;
            }
        }
        match rig.open() {
            Ok(outcome) if outcome.fault.is_none() => {}
            other => {
                wrong.push(format!(
                    "{what}: {:?} while opening",
                    other.map(|o| (o.fault, o.truth.torque_nm))
                ));
                break;
            }
        }
    }
    (wrong, errors)
}

fn main() {
    let mut numbers = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse::<u64>().ok());
    let count = numbers.next().unwrap_or(200).div_ceil(5);
    let first = numbers.next().unwrap_or(1);
    let start = std::time::Instant::now();
    let results: Vec<_> = (first..first + count).into_par_iter().map(grasps).collect();
    for line in results.iter().flat_map(|(wrong, _)| wrong) {
        println!("{line}");
    }
    let errors: Vec<f64> = results.into_iter().flat_map(|(_, errors)| errors).collect();
    let mean = errors.iter().map(|e| e.abs()).sum::<f64>() / errors.len() as f64;
    println!(
        "{} grasps in {:.1} s, located {}: mean |error| {mean:.2} mm, uncalibrated",
        5 * count,
        start.elapsed().as_secs_f64(),
        errors.len()
    );
}
