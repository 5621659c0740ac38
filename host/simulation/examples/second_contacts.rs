//! Second contacts told next to the truth, on drawn grasps. `second_contacts [SCENE] [WORLD] [FINGERS] [GRASPS] [calibrated]`, for
//! scenes whose firmware looks for one: how many power grasps were told, how many single contacts were told as two.

use palpate::sensing::{Followed, Grip};
use palpate_plant::{Contact, Grasp, Shape, World};
use palpate_simulation::{Error, Outcome, Row, Simulated, Simulation};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A phalanx presses on the object, newton: less is a graze.
const PRESSES_N: f64 = 0.2;

/// Samples most of which show two phalanges in contact.
const PRESSES_MS: usize = 20;
/// Motor turns after the second contact without which it came as the motion ended.
const LEAST_TURNS: f64 = 4.0;

/// What a run of grasps came to.
#[derive(Default)]
struct Score {
    power: u32,
    told: u32,
    late: u32,
    late_told: u32,
    faults: u32,
    enveloped: u32,
    phalanx_right: u32,
    grazed: u32,
    single: u32,
    false_ones: u32,
    /// Error and deviation of each place, as shares of the phalanx.
    places: Vec<(f64, f64)>,
}

fn drawn(phalanges: usize, lengths_m: &[f64], random: &mut Pcg64Mcg) -> Grasp {
    // Large objects against the inner phalanges meet another phalanx, small ones out there do not.
    let is_large = random.random_bool(0.6);
    let phalanx = if is_large {
        random.random_range(1..phalanges)
    } else {
        random.random_range(1..=phalanges)
    };
    let share = if is_large { 0.5..0.95 } else { 0.2..0.9 };
    let diameter_m = if is_large { 0.04..0.10 } else { 0.006..0.03 };
    let shape = Shape::Cylinder {
        diameter_m: random.random_range(diameter_m),
    };
    let k_m = random.random_range(share) * lengths_m[phalanx - 1];
    let theta_1_rad = random.random_range(0.55..1.0);
    Grasp::touching(phalanx as u8, k_m, theta_1_rad, shape)
}

/// Turns that the motor made from when two phalanges pressed, bounces left out, to where closing ends. Beyond that the motor holds
/// with a current of its own and shows no torque.
fn turns_after_second(outcome: &Outcome, counts_per_turn: f64, travel_counts: f64) -> f64 {
    let pressing = |row: &Row| row.true_pressing.count_ones() > 1;
    let began = (outcome.trace.windows(PRESSES_MS))
        .find(|rows| rows.iter().filter(|row| pressing(row)).count() > PRESSES_MS / 2);
    let first = began.and_then(|rows| rows.first());
    let last = outcome.trace.iter().map(|row| row.encoder_counts).max();
    let last = last.map(|last| f64::from(last).min(travel_counts));
    let way = first.zip(last);
    way.map_or(0.0, |(first, last)| last - f64::from(first.encoder_counts)) / counts_per_turn
}

fn score<S: Simulated>(
    world: &World,
    fingers: u64,
    grasps: u32,
    calibrated: bool,
) -> Result<Score, Error> {
    let mut score = Score::default();
    'fingers: for seed in 1..=fingers {
        let parameters = world.of(S::NAME)?.randomised(seed);
        let lengths_m = parameters.finger.length_m.clone();
        let drivetrain = S::drivetrain(&S::MECHANISM);
        let travel_counts = f64::from(S::TRAVEL_RAD / drivetrain.rad_per_count);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut simulation = Simulation::<S>::new(&parameters, seed)?;
        let prepared = simulation.prepare()?;
        println!("finger {seed}: {:?}", prepared.events.last());
        if calibrated {
            simulation.press()?;
            let last = lengths_m.len();
            for share in [0.3, 0.75] {
                let k_m = share * lengths_m[last - 1];
                simulation.calibrate(last as u8, k_m as f32, 0.8)?;
            }
        }
        simulation.traced = true;
        for _ in 0..grasps {
            let grasp = drawn(lengths_m.len(), &lengths_m, &mut random);
            let Ok(outcome) = simulation.close(&grasp) else {
                continue;
            };
            let Some(first) = outcome.first_contact.map(|first| first.contact.phalanx) else {
                continue;
            };
            let others = || outcome.truth.contacts.iter().filter(|c| c.phalanx != first);
            let second: Option<&Contact> = others()
                .filter(|c| c.force_n > PRESSES_N)
                .max_by(|a, b| a.force_n.total_cmp(&b.force_n));
            let turns =
                turns_after_second(&outcome, parameters.encoder.counts_per_rev, travel_counts);
            let told = outcome.second_contact();
            let grip = outcome.grip();
            println!(
                "  first {first}, second {:?}, {turns:.1} turns: {:?}, {:?}, {told:?}, fault {:?}",
                second.map(|c| (c.phalanx, 1e3 * c.k_m, c.force_n)),
                outcome.verdict,
                grip,
                outcome.fault
            );
            if outcome.fault.is_some() {
                score.faults += 1;
                continue 'fingers;
            }
            match (second, told) {
                (Some(_), told) if turns < LEAST_TURNS => {
                    score.late += 1;
                    score.late_told += u32::from(told.is_some());
                }
                (Some(truth), told) => {
                    score.power += 1;
                    score.told += u32::from(told.is_some());
                    score.enveloped += u32::from(grip == Some(Grip::Enveloped));
                    if let Some(Followed::SecondContact {
                        phalanx,
                        k_m,
                        sigma_m,
                        ..
                    }) = told
                    {
                        let is_right = phalanx == truth.phalanx;
                        score.phalanx_right += u32::from(is_right);
                        if is_right && k_m.is_finite() {
                            let length_m = lengths_m[usize::from(phalanx) - 1];
                            let error = (f64::from(k_m) - truth.k_m) / length_m;
                            score.places.push((error, f64::from(sigma_m) / length_m));
                        }
                    }
                }
                (None, _) if others().next().is_some() => score.grazed += 1,
                (None, told) => {
                    score.single += 1;
                    score.false_ones += u32::from(told.is_some());
                }
            }
            simulation.open()?;
        }
    }
    Ok(score)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut options = std::env::args().skip(1);
    let scene = options.next().unwrap_or_else(|| "p70-grasp".to_owned());
    let world = World::named(options.next().as_deref().unwrap_or("workshop"))?;
    let fingers = options.next().map_or(Ok(3), |n| n.parse())?;
    let grasps = options.next().map_or(Ok(10), |n| n.parse())?;
    let calibrated = options.next().is_some();
    let scene = scene.as_str();
    let score =
        palpate_scenes::for_scene!(scene, |S| score::<S>(&world, fingers, grasps, calibrated))
            .ok_or("no such scene")??;
    println!(
        "{} of {} second contacts told ({} with the right phalanx, {} enveloped); {} told in {} single contacts; {} grazed, {} of {} told that came as the motion ended; {} fingers with a fault",
        score.told,
        score.power,
        score.phalanx_right,
        score.enveloped,
        score.false_ones,
        score.single,
        score.grazed,
        score.late_told,
        score.late,
        score.faults
    );
    if !score.places.is_empty() {
        let count = score.places.len() as f64;
        let mean = score.places.iter().map(|(e, _)| e.abs()).sum::<f64>() / count;
        let within = score.places.iter().filter(|(e, s)| e.abs() <= 2.0 * s);
        println!(
            "{} places: mean error {:.1} % of the phalanx, {:.0} % within two deviations",
            score.places.len(),
            100.0 * mean,
            100.0 * within.count() as f64 / count
        );
    }
    Ok(())
}
