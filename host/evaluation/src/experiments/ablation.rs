//! Ablation: from the paper's algorithm to ours on the same distal contacts, one change after the other.

use palpate::scene::Scene;
use palpate::sensing::{Calibration, Friction, Sample, Settings};
use palpate_scenes::P70;

use super::catalogue::distal_wanted;
use super::job::{Entry, Job, Plan, closing};
use super::judge::{self, Knowledge};
use super::live::{Failure, Recording, Setup};
use super::objects;
use super::result::Method;
use super::session::{Case, Session};
use crate::paper::{self, Rule, STEPS_NM};
use crate::score::Trial;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// So small a deviation holds a parameter where it is.
const HELD: f32 = 1e-4;
/// Of the paper's steps of torque the one at which the way begins.
const STEP_INDEX: usize = 3;
const STEP: Rule = Rule::Rise(STEPS_NM[STEP_INDEX]);
/// The way from theirs to ours.
const STEPS: [&str; 6] = [
    "the paper's algorithm",
    "+ friction table",
    "+ finite step, whole curve",
    "+ torque factor calibrated",
    "+ cable calibrated",
    "+ contact and joint friction",
];

/// The samples less the recorded friction.
fn without_friction(recording: &Recording, friction: &Friction) -> Recording {
    let per_ampere = P70::drivetrain(&P70::MECHANISM).torque_per_ampere_nm;
    let samples = recording
        .samples
        .iter()
        .map(|(directive, sample)| {
            let torque_nm = friction
                .beyond(sample.position_counts)
                .map_or(0.0, |known| known.torque_nm);
            let less = Sample {
                current_a: sample.current_a - torque_nm / per_ampere,
                ..*sample
            };
            (*directive, less)
        })
        .collect();
    Recording {
        samples,
        ..recording.clone()
    }
}

/// Every step of the way on one contact; `free` is a free closing after the one that was recorded.
fn ladder(session: &Session<P70>, free: &Case, case: &Case) -> Result<Vec<Trial>, Failure> {
    let (nominal, calibrated) = (session.nominal, session.calibrated);
    let (model, _) = session.papers_model(&nominal);
    let free = judge::closing(&without_friction(&free.recording, &session.friction));
    let threshold = paper::friction_threshold(&model, &free).ok_or(Failure::Missing("closing"))?;
    let table = judge::papers(
        &model,
        threshold,
        STEP,
        &without_friction(&case.recording, &session.friction),
        case.truth,
    );
    let held = |calibration: Calibration| Calibration {
        torque_factor_sigma: HELD,
        cable_sigma_rad_per_nm: HELD,
        correlation: 0.0,
        ..calibration
    };
    let smooth = Settings {
        contact_friction: [0.0, HELD],
        joint_friction_nm: [0.0, HELD * 0.01],
        ..session.settings
    };
    let factor_only = Calibration {
        torque_factor: calibrated.torque_factor,
        ..nominal
    };
    let ours = |calibration: Calibration, settings: Settings| {
        let knowledge = Knowledge {
            friction: session.friction.clone(),
            calibration,
            settings,
        };
        judge::ours::<P70>(&knowledge, &case.recording, case.truth)
    };
    Ok(vec![
        session.papers(case, &nominal, STEP),
        table,
        ours(held(nominal), smooth)?,
        ours(held(factor_only), smooth)?,
        ours(held(calibrated), smooth)?,
        ours(calibrated, session.settings)?,
    ])
}

/// The 40 distal grasps again, judged step by step.
#[must_use]
pub fn ablation(plan: &Plan) -> Vec<Job> {
    (0..4)
        .map(|row| {
            let (parameters, seed) = (plan.parameters.clone(), plan.seed + 10 + row as u64);
            let objects = objects::ten();
            let run = move |found: &mut Vec<Entry>| {
                let mut session = Session::<P70>::new(&parameters, &Setup::default(), seed)?;
                let free = session.free_closing()?;
                let mut random = Pcg64Mcg::seed_from_u64(seed);
                for object in &objects {
                    let case = closing(&mut session, || distal_wanted(object, row, &mut random))?;
                    let trials = ladder(&session, &free, &case)?;
                    for (step, trial) in trials.into_iter().enumerate() {
                        found.push(Entry {
                            experiment: format!("ablation: {}", STEPS[step]),
                            method: if step < 2 {
                                Method::Paper(STEP_INDEX)
                            } else {
                                Method::Ours
                            },
                            calibrated: step > 2,
                            trial,
                        });
                    }
                }
                Ok(())
            };
            Job {
                name: "ablation".to_owned(),
                closings: 10,
                run: Box::new(run),
            }
        })
        .collect()
}
