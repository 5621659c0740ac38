//! The experiments: which closings on which worlds.

use palpate_plant::Shape;
use palpate_scenes::P70;
use palpate_simulation::Simulated;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::job::{Entry, Job, Plan, Wanted, entries, job};
use super::judge;
use super::live::Setup;
use super::objects::{self, Object};
use super::session::Session;

/// Object of the experiments in which the object does not matter.
#[must_use]
pub fn plain_cylinder() -> Object {
    Object {
        name: "cylinder 10 mm",
        shape: Shape::Cylinder { diameter_m: 0.010 },
        flush_m: 0.0,
    }
}

/// Postures of the paper's preshaping experiment, theta_1, radian: chosen over the prototype's travel.
pub const PRESHAPES_RAD: [f64; 5] = [0.3, 0.5, 0.7, 0.9, 1.1];
/// Places of the paper's preshaping experiment, metre.
pub const PRESHAPE_PLACES_M: [f64; 5] = [0.010, 0.022, 0.035, 0.048, 0.060];
/// Middle of the object along the phalanx in the 40 distal grasps, share of its length.
const DISTAL_SHARES: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Free closings of one finger.
const FREE_CLOSINGS: usize = 100;
/// Random contacts of one finger.
const RANDOM_CONTACTS: usize = 8;

/// (a) 25 proximal grasps, five on each of five fingers.
#[must_use]
pub fn proximal(plan: &Plan) -> Vec<Job> {
    (0..5)
        .map(|finger| {
            let objects = objects::ten();
            job::<P70>(
                "proximal",
                Ok(plan.parameters.clone()),
                plan.seed + finger,
                5,
                move |index, random| Wanted {
                    object: objects[(2 * index + finger as usize) % objects.len()].clone(),
                    phalanx: 1,
                    k_m: random.random_range(0.030..0.080),
                    theta_1_rad: random.random_range(0.3..0.9),
                    any_first: false,
                },
            )
        })
        .collect()
}

/// The contact of one of the 40 distal grasps.
#[must_use]
pub fn distal_wanted(object: &Object, row: usize, random: &mut Pcg64Mcg) -> Wanted {
    let length_m = 0.070;
    let share: f64 = DISTAL_SHARES[row % DISTAL_SHARES.len()] + random.random_range(-0.08..0.08);
    // A flush side stays on the phalanx.
    let half = 0.5 * object.flush_m;
    Wanted {
        object: object.clone(),
        phalanx: 2,
        k_m: (share * length_m).clamp(half.max(0.005), (length_m - half).max(half)),
        theta_1_rad: random.random_range(0.35..1.0),
        any_first: true,
    }
}

/// (b) 40 distal grasps: ten objects, each at four places, on four fingers.
#[must_use]
pub fn distal(plan: &Plan) -> Vec<Job> {
    (0..DISTAL_SHARES.len())
        .map(|row| {
            let objects = objects::ten();
            job::<P70>(
                "distal",
                Ok(plan.parameters.clone()),
                plan.seed + 10 + row as u64,
                objects.len(),
                move |index, random| distal_wanted(&objects[index], row, random),
            )
        })
        .collect()
}

/// (c) five places at five postures.
#[must_use]
pub fn preshape(plan: &Plan) -> Vec<Job> {
    PRESHAPES_RAD
        .into_iter()
        .zip(20..)
        .map(|(theta_1_rad, offset)| {
            job::<P70>(
                "preshape",
                Ok(plan.parameters.clone()),
                plan.seed + offset,
                PRESHAPE_PLACES_M.len(),
                move |index, _| Wanted {
                    object: plain_cylinder(),
                    phalanx: 2,
                    k_m: PRESHAPE_PLACES_M[index],
                    theta_1_rad,
                    any_first: true,
                },
            )
        })
        .collect()
}

/// (d) free closings: 100 on each of 10 drawn fingers, in MuJoCo of 5.
#[must_use]
pub fn free(plan: &Plan) -> Vec<Job> {
    (0..plan.fingers(1, 10))
        .map(|finger| {
            let seed = plan.seed + 100 + finger;
            let parameters = plan.parameters.randomised(seed);
            let run = move |found: &mut Vec<Entry>| {
                let mut session = Session::<P70>::new(&parameters, &Setup::default(), seed)?;
                for _ in 0..FREE_CLOSINGS {
                    let case = session.free_closing()?;
                    found.extend(entries("free", &session, &case)?);
                }
                Ok(())
            };
            Job {
                name: "free".to_owned(),
                closings: FREE_CLOSINGS,
                run: Box::new(run),
            }
        })
        .collect()
}

/// (e) random contacts over phalanx and posture on 100 fingers (in MuJoCo 50) drawn from the spreads: few on each, because
/// what distinguishes fingers counts for more than what distinguishes the contacts of one.
#[must_use]
pub fn random(plan: &Plan) -> Vec<Job> {
    (0..plan.fingers(25, 100))
        .map(|finger| {
            let seed = plan.seed + 1000 + finger;
            job::<P70>(
                "random",
                Ok(plan.parameters.randomised(seed)),
                seed,
                RANDOM_CONTACTS,
                |_, random| {
                    let phalanx = if random.random_bool(0.2) { 1 } else { 2 };
                    let length_m = if phalanx == 1 { 0.090 } else { 0.070 };
                    Wanted {
                        object: random_cylinder(random),
                        phalanx,
                        k_m: length_m * random.random_range(0.05..0.95),
                        theta_1_rad: random.random_range(0.25..1.1),
                        any_first: true,
                    }
                },
            )
        })
        .collect()
}

/// 4 to 40 mm, as many thin as thick ones.
#[must_use]
pub fn random_cylinder(random: &mut Pcg64Mcg) -> Object {
    Object {
        name: "random cylinder",
        shape: Shape::Cylinder {
            diameter_m: random.random_range(0.004_f64.ln()..0.040_f64.ln()).exp(),
        },
        flush_m: 0.0,
    }
}

/// A finger of experiment (f).
struct Other {
    scene: &'static str,
    /// Name of the experiment with fingers that are drawn from the spreads.
    drawn: &'static str,
    /// First seeds of the nominal and of the drawn fingers.
    seeds: [u64; 2],
}

/// Tendon with two and three phalanges, with a hidden one and with a return cable, the prototype with a preloaded spring,
/// linkage with three, a motor at every joint.
const OTHERS: [Other; 7] = [
    Other {
        scene: "tendon2",
        drawn: "tendon2, drawn",
        seeds: [50, 2000],
    },
    Other {
        scene: "tendon3",
        drawn: "tendon3, drawn",
        seeds: [60, 2100],
    },
    Other {
        scene: "hidden3",
        drawn: "hidden3, drawn",
        seeds: [90, 2400],
    },
    Other {
        scene: "return2",
        drawn: "return2, drawn",
        seeds: [40, 2500],
    },
    Other {
        scene: "p70-preloaded",
        drawn: "p70-preloaded, drawn",
        seeds: [95, 2600],
    },
    Other {
        scene: "linkage3",
        drawn: "linkage3, drawn",
        seeds: [70, 2200],
    },
    Other {
        scene: "direct2",
        drawn: "direct2, drawn",
        seeds: [80, 2300],
    },
];

/// (f) the other fingers, as far as the folder of scenes has them: nominal ones, and ones drawn from the spreads.
#[must_use]
pub fn scenes(plan: &Plan) -> Vec<Job> {
    let drawn = plan.fingers(3, 12);
    let rounds = (0..3)
        .map(|finger| (finger, false))
        .chain((0..drawn).map(|finger| (finger, true)));
    rounds
        .flat_map(|(finger, drawn)| {
            OTHERS.iter().filter_map(move |other| {
                palpate_scenes::for_scene!(other.scene, |S| {
                    let name = if drawn { other.drawn } else { other.scene };
                    let seed = other.seeds[usize::from(drawn)] + finger;
                    scene::<S>(name, plan, seed, drawn)
                })
            })
        })
        .collect()
}

fn scene<S: Simulated + 'static>(
    experiment: &'static str,
    plan: &Plan,
    offset: u64,
    drawn: bool,
) -> Job {
    let seed = plan.seed + offset;
    let nominal = plan.of(S::NAME);
    job::<S>(
        experiment,
        if drawn {
            nominal.map(|parameters| parameters.randomised(seed))
        } else {
            nominal
        },
        seed,
        8,
        move |_, random| {
            let phalanx = random.random_range(2..=S::PHALANGES);
            let length_m = judge::length_m::<S>(phalanx).unwrap_or(0.05);
            Wanted {
                object: random_cylinder(random),
                phalanx,
                k_m: length_m * random.random_range(0.1..0.9),
                // Past the rest angle of the springs, with way left for the probing.
                theta_1_rad: random.random_range(0.65..0.95),
                any_first: true,
            }
        },
    )
}

/// All of (a) to (f).
#[must_use]
pub fn all(plan: &Plan) -> Vec<Job> {
    [
        proximal(plan),
        distal(plan),
        preshape(plan),
        free(plan),
        random(plan),
        scenes(plan),
    ]
    .into_iter()
    .flatten()
    .collect()
}
