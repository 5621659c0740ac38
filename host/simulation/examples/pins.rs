//! What a second pin does that is not where it was said to be: `cargo run --profile host -p palpate-simulation --example pins --
//! [WORLD] [SCENE] [FINGERS] [FIRST SEED]`.
//!
//! Fingers of a world are drawn and calibrated on a pin at 30 % of the last phalanx. Then each takes a second pin, several times from
//! the same state: where it is said to be, and some millimetres off (told farther out than it is, or nearer).

use palpate::drive::sequence::Request;
use palpate::sensing::{Calibration, Directive, Event, Refusal};
use palpate_plant::{Grasp, Object, ObjectMount, Shape, TrueCalibration, World};
use palpate_simulation::places::{PIN_RAD, PIN_SHARES};
use palpate_simulation::{Simulated, Simulation};
use rayon::prelude::*;

/// Places of the second pin, as shares of the last phalanx.
const SHARES: [f64; 2] = [0.43, PIN_SHARES[1]];
/// By how much what is told of it is off, metre.
const OFF_M: [f64; 3] = [0.0, 3e-3, -3e-3];

/// What a pin at `true_m` teaches that is said to be at `told_m`.
fn taught<S: Simulated>(
    simulation: &mut Simulation<S>,
    true_m: f64,
    told_m: f64,
) -> Option<Result<Calibration, Refusal>> {
    let pin = Shape::Cylinder {
        diameter_m: 2.0 * f64::from(S::settings().pin_radius_m),
    };
    let object = Object {
        mount: ObjectMount::Fixed,
        ..simulation.plant().parameters().object
    };
    simulation.plant().mount(&object).ok()?;
    let grasp = Grasp::touching(S::PHALANGES, true_m, PIN_RAD, pin);
    simulation.plant().place(&grasp).ok()?;
    let directive = Directive::Calibrate {
        phalanx: S::PHALANGES,
        k_m: told_m as f32,
    };
    let outcome = simulation.motion(Request::Close, directive).ok()?;
    simulation.open().ok()?;
    outcome.events.iter().find_map(|(_, event)| match event {
        Event::Calibrated { calibration } => Some(Ok(*calibration)),
        Event::CalibrationRefused { why } => Some(Err(*why)),
        _ => None,
    })
}

/// Error of a torque factor in its deviations.
fn deviations(known: &Calibration, truth: &TrueCalibration) -> f64 {
    let factor = (f64::from(known.torque_factor) / truth.torque_factor).ln();
    factor / f64::from(known.torque_factor_sigma)
}

/// A second pin: place, by how much what is told is off, what came of it, and the error of the factor after it.
type Told = (f64, f64, Result<(), Refusal>, f64);

fn finger<S: Simulated>(world: &World, seed: u64) -> Vec<Told> {
    let tried = || {
        let parameters = world.of(S::NAME).ok()?.randomised(seed);
        let truth = TrueCalibration::of(
            &parameters,
            S::EFFICIENCY.into(),
            S::DRIVE.motor.torque_constant_nm_per_a.into(),
            S::MOTION.closing_rad_per_s.into(),
        );
        let length_m = parameters.finger.length_m[usize::from(S::PHALANGES) - 1];
        let mut first = Simulation::<S>::new(&parameters, seed).ok()?;
        first.prepare().ok()?;
        let first_m = PIN_SHARES[0] * length_m;
        let before = taught(&mut first, first_m, first_m)?.ok()?;
        let mut told = vec![(PIN_SHARES[0], 0.0, Ok(()), deviations(&before, &truth))];
        for share in SHARES {
            for off_m in OFF_M {
                let mut second = first.clone();
                let true_m = share * length_m;
                let taken = taught(&mut second, true_m, true_m + off_m)?;
                let known = taken.unwrap_or(before);
                told.push((share, off_m, taken.map(|_| ()), deviations(&known, &truth)));
            }
        }
        Some(told)
    };
    tried().unwrap_or_default()
}

fn study<S: Simulated>(world: &World, seeds: std::ops::Range<u64>) {
    let told: Vec<Told> = seeds
        .into_par_iter()
        .flat_map_iter(|seed| finger::<S>(world, seed))
        .collect();
    println!(
        "place, %  off, mm    n  taken  implausible  misfit  uninformative  factor z rms  within 2 sigma, %  \
         of those taken"
    );
    let cells = [(PIN_SHARES[0], 0.0)].into_iter().chain(
        SHARES
            .into_iter()
            .flat_map(|share| OFF_M.map(|off_m| (share, off_m))),
    );
    for (share, off_m) in cells {
        let of: Vec<&Told> = told
            .iter()
            .filter(|told| told.0 == share && told.1 == off_m)
            .collect();
        let count = |what: Result<(), Refusal>| of.iter().filter(|told| told.2 == what).count();
        let judged = |of: &[f64]| {
            let n = of.len() as f64;
            let within = of.iter().filter(|z| z.abs() <= 2.0).count() as f64;
            let squares: f64 = of.iter().map(|z| z * z).sum();
            ((squares / n).sqrt(), 100.0 * within / n)
        };
        let all: Vec<f64> = of.iter().map(|told| told.3).collect();
        let taken: Vec<f64> = of.iter().filter(|t| t.2.is_ok()).map(|t| t.3).collect();
        let ((rms, within), (rms_taken, within_taken)) = (judged(&all), judged(&taken));
        println!(
            "{:8.0} {:8.0} {:4} {:6} {:12} {:7} {:14} {rms:13.2} {within:18.0} {rms_taken:10.2} {within_taken:4.0}",
            100.0 * share,
            1e3 * off_m,
            of.len(),
            taken.len(),
            count(Err(Refusal::Implausible)),
            count(Err(Refusal::Misfit)),
            count(Err(Refusal::Uninformative)),
        );
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let of =
        |index: usize, default: &str| given.get(index).map_or(default.to_owned(), Clone::clone);
    let world = World::named(&of(0, "workshop"))?;
    let (fingers, first): (u64, u64) = (of(2, "20").parse()?, of(3, "7001").parse()?);
    let scene = of(1, "p70");
    palpate_scenes::for_scene!(scene.as_str(), |S| study::<S>(
        &world,
        first..first + fingers
    ))
    .ok_or("no such scene")?;
    Ok(())
}
