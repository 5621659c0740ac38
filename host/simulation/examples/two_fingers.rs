//! Two fingers close on one cylinder between them, and what each of them feels gives its centre and radius:
//! `cargo run --profile host -p palpate-simulation --example two_fingers -- [CYLINDERS] [WORLD]`.
//!
//! The second finger is the mirror image of the first, across a line parallel to phalanx 1 at rest. Centres and diameters are
//! drawn; the last lines compare what was felt with the truth.

use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::P70;
use palpate_simulation::{Simulation, between};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Distance between the fingers' bases, metre.
const APART_M: f64 = 0.18;
/// Cylinders before another pair of fingers is drawn: much of what is wrong about a finger stays.
const PER_PAIR: u64 = 5;

/// Errors of one unknown, next to their deviations.
#[derive(Default)]
struct Errors(Vec<[f64; 2]>);

impl Errors {
    fn print(&self, name: &str) {
        let count = self.0.len() as f64;
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| self.0.iter().map(of).sum::<f64>() / count;
        println!(
            "{name}: mean error {:.2} mm, {:+.2} mm with its sign; z rms {:.2}, {:.0} % within two deviations",
            1e3 * mean(&|[error, _]| error.abs()),
            1e3 * mean(&|[error, _]| *error),
            mean(&|[error, sigma]| (error / sigma).powi(2)).sqrt(),
            100.0 * mean(&|[error, sigma]| f64::from(u8::from(error.abs() <= 2.0 * sigma)))
        );
    }
}

/// The next two fingers of a world that can be calibrated; one that stalls under its own weight cannot.
fn pair(
    world: &World,
    seeds: &mut impl Iterator<Item = u64>,
) -> Result<Vec<Simulation<P70>>, Box<dyn std::error::Error>> {
    let mut fingers = Vec::new();
    for seed in seeds {
        let parameters = world.of("p70")?.randomised(seed);
        let mut finger = Simulation::<P70>::new(&parameters, seed)?;
        let mut calibrated = || {
            finger.prepare()?;
            for k_m in [0.02, 0.05] {
                finger.calibrate(2, k_m, 0.8)?;
            }
            finger.open()
        };
        if calibrated().is_ok_and(|outcome| outcome.fault.is_none()) {
            fingers.push(finger);
        } else {
            println!("finger {seed} is left out: it stalls while it is calibrated");
        }
        if fingers.len() == 2 {
            break;
        }
    }
    Ok(fingers)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut options = std::env::args().skip(1);
    let cylinders = options.next().map_or(Ok(10), |n| n.parse())?;
    let world = World::named(options.next().as_deref().unwrap_or("workshop"))?;
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut errors: [Errors; 3] = Default::default();
    let mut unfelt = 0;
    let (mut fingers, mut seeds) = (Vec::new(), 1..);
    for number in 0..cylinders {
        if number % PER_PAIR == 0 {
            fingers = pair(&world, &mut seeds)?;
        }
        let radius_m = random.random_range(0.010..0.025);
        let truth = [
            random.random_range(0.100..0.118),
            0.5 * APART_M + random.random_range(-0.008..0.008),
            radius_m,
        ];
        let [x_m, y_m, _] = truth;
        let mut told = Vec::new();
        for (index, finger) in fingers.iter().enumerate() {
            let mut finger = finger.clone();
            finger.plant().reseed(2 * number + index as u64);
            let is_mirrored = index == 1;
            let y_m = if is_mirrored { APART_M - y_m } else { y_m };
            let outcome = finger.close(&Grasp::At {
                origin_m: [x_m, y_m],
                angle_rad: 0.0,
                shape: Shape::Cylinder {
                    diameter_m: 2.0 * radius_m,
                },
            })?;
            let own = between::felt::<P70>(&outcome);
            told.extend(own.into_iter().flatten().map(|equation| {
                if is_mirrored {
                    equation.mirrored(APART_M)
                } else {
                    equation
                }
            }));
        }
        let Some((found, sigma)) = between::cylinder(&told) else {
            unfelt += 1;
            continue;
        };
        let each = |i: usize| {
            let [truth, found, sigma] = [truth[i], found[i], sigma[i]].map(|metre| 1e3 * metre);
            format!("{truth:.1} felt {found:.1} +- {sigma:.1}")
        };
        println!("x {}, y {}, radius {} mm", each(0), each(1), each(2));
        for (i, errors) in errors.iter_mut().enumerate() {
            errors.0.push([found[i] - truth[i], sigma[i]]);
        }
    }
    println!("{cylinders} cylinders, {unfelt} of them not located by a finger");
    for (errors, name) in errors.iter().zip(["x", "y", "radius"]) {
        errors.print(name);
    }
    Ok(())
}
