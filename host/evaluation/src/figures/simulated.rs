//! The paper's Figs 11 to 14 from simulated experiments, and speed and delay against error.

use std::path::Path;

use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate_scenes::P70;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::experiments::catalogue::{
    PRESHAPE_PLACES_M, PRESHAPES_RAD, distal_wanted, plain_cylinder,
};
use crate::experiments::job::{Plan, Wanted, closing};
use crate::experiments::judge;
use crate::experiments::live::{Failure, Setup};
use crate::experiments::objects;
use crate::experiments::session::{Case, Session};
use crate::paper::Rule;
use crate::reference::{free_posture, tangent_compliance};
use crate::score::{Trial, mean_and_deviation, median};
use palpate_document::chart::{
    BLUE, Chart, DrawError, GREEN, GREY, Legend, Mark, ORANGE, PINK, SKY, Series, write,
};

/// One a posture.
const COLOURS: [palpate_document::chart::RGBColor; 5] = [BLUE, ORANGE, GREEN, PINK, SKY];

/// Step of torque of the paper's algorithm in the figures: the middle one of those that experiments try.
const FIGURE_RULE: Rule = Rule::Rise(0.05);

/// Closing speeds of the figure, radian per second.
const SPEEDS: [f32; 6] = [0.15, 0.2, 0.3, 0.4, 0.5, 0.6];

fn session(plan: &Plan, setup: &Setup, seed: u64) -> Result<Session<P70>, Failure> {
    Session::new(&plan.parameters, setup, seed)
}

/// Closes on a plain cylinder.
fn touch(session: &mut Session<P70>, k_m: f64, theta_1_rad: f64) -> Result<Case, Failure> {
    closing(session, || Wanted {
        object: plain_cylinder(),
        phalanx: 2,
        k_m,
        theta_1_rad,
        any_first: true,
    })
}

/// Fig 11: stiffness after contact as estimated, over the true place, with the model.
fn figure_11(plan: &Plan) -> Result<Chart, Failure> {
    let mut session = session(plan, &Setup::default(), plan.seed + 300)?;
    let model = judge::paper_model::<P70>()?;
    let posture = free_posture(&model.finger, 0.0).ok_or(Failure::Missing("posture"))?;
    let line = (1..=130)
        .filter_map(|step| {
            let k = 0.066 * f64::from(step) / 130.0;
            Some((
                1e3 * k,
                1.0 / tangent_compliance(&model.finger, &posture, 0.0, 2, k)?,
            ))
        })
        .collect();
    let finger = P70::MECHANISM;
    let stiffness = |k_m: f64| {
        let free = finger.free_at_angle(0.0, &finger.rest())?;
        let compliance =
            finger.contact_compliance(&free.configuration, free.torque_nm, 2, k_m as f32)?;
        Some(1.0 / f64::from(compliance))
    };
    let mut points = Vec::new();
    for step in 0..24 {
        let case = touch(&mut session, 0.004 + 0.0025 * f64::from(step), 0.6)?;
        let trial = session.ours(&case, &session.calibrated)?;
        if let (Some(contact), Some((found_m, _))) = (trial.truth, trial.answer.place())
            && let Some(k_c) = stiffness(found_m)
        {
            points.push((1e3 * contact.k_m, k_c));
        }
    }
    Ok(Chart {
        title: "Fig 11: stiffness after contact, simulated prototype".into(),
        x_label: "true contact location k_2 / mm".into(),
        y_label: "K_c / (N m/rad)".into(),
        x: (0.0, 70.0),
        y: (0.1, 100.0),
        log_y: true,
        legend: Legend::UpperLeft,
        series: vec![
            Series::new("model (18), f64", GREY, Mark::Line, line),
            Series::new(
                "estimated from motor current and encoder",
                BLUE,
                Mark::Dots,
                points,
            ),
        ],
    })
}

/// Fig 12: torque and angle of the actuator during a closing, and of a free one.
fn figure_12(plan: &Plan) -> Result<Vec<Chart>, Failure> {
    let mut session = session(plan, &Setup::default(), plan.seed + 301)?;
    let case = touch(&mut session, 0.035, 0.6)?;
    let (model, threshold) = session.papers_model(&session.nominal);
    let trial = session.ours(&case, &session.calibrated)?;
    let closing = judge::closing(&case.recording);
    let begin = closing
        .first()
        .map_or(0.0, |sample| sample.time_us as f64 * 1e-6);
    let mut torque = Vec::new();
    let mut friction = Vec::new();
    let mut angle = Vec::new();
    for (index, chunk) in closing.chunks_exact(8).enumerate() {
        let mean: f64 = chunk.iter().map(|s| f64::from(s.current_a)).sum::<f64>() / 8.0;
        let last = &chunk[7];
        let time = last.time_us as f64 * 1e-6 - begin;
        if index > 12 {
            torque.push((time, 1e3 * mean * model.torque_nm_per_a));
            if let Some(known) = session.friction.beyond(last.position_counts) {
                let lossy = model.torque_nm_per_a / f64::from(per_ampere());
                friction.push((time, 1e3 * f64::from(known.torque_nm) * lossy));
            }
        }
        angle.push((time, f64::from(last.position_counts) / model.counts_per_rad));
    }
    let end = angle.last().map_or(1.0, |(time, _)| *time);
    let contact = case.truth.map_or(f64::NAN, |contact| contact.time_s) - begin;
    let decided = trial.touched_s.map_or(f64::NAN, |time| time - begin);
    let upright = |time: f64, top: f64| vec![(time, 0.0), (time, top)];
    Ok(vec![
        Chart {
            title: "Fig 12: actuator torque while closing on a 10 mm cylinder".into(),
            x_label: "time / s".into(),
            y_label: "torque at the input link / (mN m)".into(),
            x: (0.0, end),
            y: (0.0, 450.0),
            log_y: false,
            legend: Legend::UpperLeft,
            series: vec![
                Series::new("torque from the motor current", BLUE, Mark::Line, torque),
                Series::new("recorded friction", GREEN, Mark::Line, friction),
                Series::new(
                    "the paper's threshold",
                    ORANGE,
                    Mark::Dashes,
                    vec![(0.0, 1e3 * threshold), (end, 1e3 * threshold)],
                ),
                Series::new("true contact", GREY, Mark::Dashes, upright(contact, 450.0)),
                Series::new(
                    "contact decided",
                    PINK,
                    Mark::Dashes,
                    upright(decided, 450.0),
                ),
            ],
        },
        Chart {
            title: "Fig 12: actuator angle".into(),
            x_label: "time / s".into(),
            y_label: "angle of the input link / rad".into(),
            x: (0.0, end),
            y: (0.0, 1.5),
            log_y: false,
            legend: Legend::UpperLeft,
            series: vec![
                Series::new("angle from the encoder", BLUE, Mark::Line, angle),
                Series::new("true contact", GREY, Mark::Dashes, upright(contact, 1.5)),
            ],
        },
    ])
}

fn per_ampere() -> f32 {
    P70::drivetrain(&P70::MECHANISM).torque_per_ampere_nm
}

/// Fig 13: true against estimated places of the 40 distal grasps.
fn figure_13(plan: &Plan) -> Result<Vec<Chart>, Failure> {
    let mut ours = Series::new(
        "this firmware, calibrated (bars: two deviations)",
        BLUE,
        Mark::Dots,
        Vec::new(),
    );
    let mut paper = Series::new(
        "the paper's algorithm, same samples",
        ORANGE,
        Mark::Crosses,
        Vec::new(),
    );
    let mut errors: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    for row in 0..4 {
        let seed = plan.seed + 10 + row as u64;
        let mut session = session(plan, &Setup::default(), seed)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for object in objects::ten() {
            let case = closing(&mut session, || distal_wanted(&object, row, &mut random))?;
            let mine = session.ours(&case, &session.calibrated)?;
            let theirs = session.papers(&case, &session.calibrated, FIGURE_RULE);
            let both = [(mine, &mut ours), (theirs, &mut paper)];
            for ((trial, series), errors) in both.into_iter().zip(&mut errors) {
                if let (Some(error), Some(contact)) = (trial.error_m(), trial.truth) {
                    let true_m = contact.k_m;
                    series.points.push((1e3 * true_m, 1e3 * (true_m + error)));
                    errors.push(1e3 * error.abs());
                    if let Some((_, sigma)) = trial.answer.place().filter(|(_, s)| s.is_finite()) {
                        series.bars.push(2e3 * sigma);
                    }
                }
            }
        }
    }
    let charts = [(ours, 0), (paper, 1)].map(|(series, which)| {
        let (mean, deviation) = mean_and_deviation(&errors[which]).unwrap_or_default();
        let colour = series.colour;
        let line = |shift: f64| vec![(0.0, shift), (72.0, 72.0 + shift)];
        Chart {
            title: format!("Fig 13: 40 distal grasps, |error| {mean:.2} ± {deviation:.2} mm"),
            x_label: "true contact location k_2 / mm".into(),
            y_label: "estimated contact location / mm".into(),
            x: (0.0, 72.0),
            y: (-2.0, 82.0),
            log_y: false,
            legend: Legend::UpperLeft,
            series: vec![
                Series::new("exact", GREY, Mark::Line, line(0.0)),
                Series::new("mean |error|", colour, Mark::Dashes, line(mean)),
                Series::new("", colour, Mark::Dashes, line(-mean)),
                series,
            ],
        }
    });
    Ok(charts.into())
}

/// Fig 14: error over the place for five postures.
fn figure_14(plan: &Plan) -> Result<Vec<Chart>, Failure> {
    let mut charts = Vec::new();
    let mut series: [Vec<Series>; 2] = [Vec::new(), Vec::new()];
    for ((theta_1, colour), offset) in PRESHAPES_RAD.into_iter().zip(COLOURS).zip(20..) {
        let mut session = session(plan, &Setup::default(), plan.seed + offset)?;
        let mut points: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
        for k_m in PRESHAPE_PLACES_M {
            let case = touch(&mut session, k_m, theta_1)?;
            let trials = [
                session.ours(&case, &session.calibrated)?,
                session.papers(&case, &session.calibrated, FIGURE_RULE),
            ];
            for (trial, points) in trials.iter().zip(&mut points) {
                if let (Some(error), Some(contact)) = (trial.error_m(), trial.truth) {
                    points.push((1e3 * k_m, 100.0 * error.abs() / contact.length_m));
                }
            }
        }
        for (points, series) in points.into_iter().zip(&mut series) {
            series.push(Series::new(
                format!("theta_1 = {theta_1} rad"),
                colour,
                Mark::Line,
                points.clone(),
            ));
            series.push(Series::new("", colour, Mark::Dots, points));
        }
    }
    for (series, name) in series
        .into_iter()
        .zip(["this firmware, calibrated", "the paper's algorithm"])
    {
        charts.push(Chart {
            title: format!("Fig 14: error and preshaping, {name}"),
            x_label: "true contact location k_2 / mm".into(),
            y_label: "|error| / % of l_2".into(),
            x: (0.0, 70.0),
            y: (0.0, 16.0),
            log_y: false,
            legend: Legend::UpperLeft,
            series,
        });
    }
    Ok(charts)
}

/// Closing speed against error and delay.
fn speed(plan: &Plan) -> Result<Vec<Chart>, Failure> {
    let mut errors: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    let mut delays: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for (speed, offset) in SPEEDS.into_iter().zip(400..) {
        let setup = Setup {
            speed_rad_per_s: Some(speed),
            ..Setup::default()
        };
        let mut session = session(plan, &setup, plan.seed + offset)?;
        let mut trials: [Vec<Trial>; 2] = [Vec::new(), Vec::new()];
        for step in 0..16 {
            let theta_1 = 0.4 + 0.1 * f64::from(step % 6);
            let case = touch(&mut session, 0.006 + 0.0037 * f64::from(step), theta_1)?;
            trials[0].push(session.ours(&case, &session.calibrated)?);
            trials[1].push(session.papers(&case, &session.calibrated, FIGURE_RULE));
        }
        for (which, trials) in trials.iter().enumerate() {
            let found: Vec<f64> = trials
                .iter()
                .filter_map(|trial| Some(100.0 * trial.error_m()?.abs() / trial.truth?.length_m))
                .collect();
            let late: Vec<f64> = trials
                .iter()
                .filter_map(|trial| Some(1e3 * (trial.touched_s? - trial.truth?.time_s)))
                .collect();
            if let (Some((mean, _)), Some(delay)) = (mean_and_deviation(&found), median(&late)) {
                errors[which].push((f64::from(speed), mean));
                delays[which].push((f64::from(speed), delay));
            }
        }
    }
    let chart = |title: &str, y_label: &str, y: (f64, f64), data: [Vec<(f64, f64)>; 2]| {
        let [ours, paper] = data;
        Chart {
            title: title.into(),
            x_label: "closing speed of the input link / (rad/s)".into(),
            y_label: y_label.into(),
            x: (0.1, 0.65),
            y,
            log_y: false,
            legend: Legend::UpperRight,
            series: vec![
                Series::new("this firmware", BLUE, Mark::Line, ours.clone()),
                Series::new("", BLUE, Mark::Dots, ours),
                Series::new("the paper's algorithm", ORANGE, Mark::Line, paper.clone()),
                Series::new("", ORANGE, Mark::Crosses, paper),
            ],
        }
    };
    Ok(vec![
        chart(
            "Speed against error, both calibrated",
            "mean |error| / % of l_2",
            (0.0, 12.0),
            errors,
        ),
        chart(
            "Speed against delay of the detection",
            "median delay / ms",
            (0.0, 220.0),
            delays,
        ),
    ])
}

/// Writes Figs 11 to 14 and the trade of speed.
///
/// # Errors
/// A simulation that fails, a file that cannot be written.
pub fn simulated(directory: &Path, plan: &Plan) -> Result<(), DrawError> {
    write(
        directory,
        "fig11_stiffness_after_contact",
        &[figure_11(plan)?],
    )?;
    write(directory, "fig12_closing", &figure_12(plan)?)?;
    write(directory, "fig13_distal_grasps", &figure_13(plan)?)?;
    write(directory, "fig14_preshaping", &figure_14(plan)?)?;
    write(directory, "speed_against_error", &speed(plan)?)
}
