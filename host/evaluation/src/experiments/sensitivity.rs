//! Sensitivity: errors against one disturbance at a time, with a new calibration each time.

use palpate_plant::Parameters;
use palpate_scenes::P70;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::catalogue::plain_cylinder;
use super::job::{Entry, Job, Plan, Wanted, closing};
use super::live::{Failure, Setup};
use super::session::Session;

/// Contacts at each level.
const CONTACTS: usize = 20;

/// One effect at one level.
struct Level {
    name: String,
    parameters: Parameters,
    setup: Setup,
    /// The friction record is taken in this world, the contacts are felt in the other.
    recorded_in: Option<Parameters>,
}

fn levels(base: &Parameters) -> Vec<Level> {
    let mut levels = Vec::new();
    let mut world = |name: String, change: &dyn Fn(&mut Parameters)| {
        let mut parameters = base.clone();
        change(&mut parameters);
        levels.push(Level {
            name,
            parameters,
            setup: Setup::default(),
            recorded_in: None,
        });
    };
    for noise_ma in [0.0, 0.5, 1.0, 2.0] {
        world(format!("current noise {noise_ma} mA rms"), &|p| {
            p.sense.noise_rms_a = noise_ma * 1e-3;
        });
    }
    for factor in [0.0, 1.0, 3.0] {
        world(format!("backlash x {factor}"), &|p| {
            p.gearhead.backlash_counts *= factor;
            p.worm.backlash_counts *= factor;
        });
    }
    for kn_per_m in [1.5, 3.0, 10.0] {
        world(format!("cable {kn_per_m} kN/m"), &|p| {
            p.cable.stiffness_n_per_m = kn_per_m * 1e3;
        });
    }
    for creep_pct in [0.0, 5.0, 15.0] {
        world(format!("cable creep {creep_pct} %"), &|p| {
            p.cable.creep_fraction = creep_pct * 1e-2;
        });
    }
    for friction in [0.0, 0.1, 0.3] {
        world(format!("contact friction {friction}"), &|p| {
            p.contact.friction = friction;
        });
    }
    for change in [-0.2, -0.05, 0.05, 0.2] {
        let mut recorded = base.clone();
        recorded.gearhead.drag_nm *= 1.0 + change;
        recorded.motor.coulomb_nm *= 1.0 + change;
        levels.push(Level {
            name: format!("friction recorded {:+.0} % off", 100.0 * change),
            parameters: base.clone(),
            setup: Setup::default(),
            recorded_in: Some(recorded),
        });
    }
    for speed in [0.1, 0.2, 0.3, 0.5] {
        levels.push(Level {
            name: format!("speed {speed} rad/s"),
            parameters: base.clone(),
            setup: Setup {
                speed_rad_per_s: Some(speed),
                ..Setup::default()
            },
            recorded_in: None,
        });
    }
    for torque in [0.05, 0.1, 0.2, 0.35] {
        levels.push(Level {
            name: format!("torque rise {torque} N m"),
            parameters: base.clone(),
            setup: Setup {
                torque_limit_nm: Some(torque),
                ..Setup::default()
            },
            recorded_in: None,
        });
    }
    levels
}

fn run(level: &Level, seed: u64, found: &mut Vec<Entry>) -> Result<(), Failure> {
    let mut session = Session::<P70>::new(&level.parameters, &level.setup, seed)?;
    if let Some(other) = &level.recorded_in {
        session.take_record(&Session::new(other, &level.setup, seed)?)?;
    }
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for index in 0..CONTACTS {
        let case = closing(&mut session, || Wanted {
            object: plain_cylinder(),
            phalanx: 2,
            k_m: 0.070 * (0.1 + 0.8 * (index as f64 + 0.5) / CONTACTS as f64),
            theta_1_rad: random.random_range(0.35..1.0),
            any_first: true,
        })?;
        for (method, calibrated, trial) in session.all(&case)? {
            if calibrated {
                found.push(Entry {
                    experiment: level.name.clone(),
                    method,
                    calibrated,
                    trial,
                });
            }
        }
    }
    Ok(())
}

/// (g) every effect at every level.
#[must_use]
pub fn sensitivity(plan: &Plan) -> Vec<Job> {
    levels(&plan.parameters)
        .into_iter()
        .zip(0..)
        .map(|(level, index)| {
            let seed = plan.seed + 5000 + index;
            Job {
                name: level.name.clone(),
                closings: CONTACTS,
                run: Box::new(move |found| run(&level, seed, found)),
            }
        })
        .collect()
}
