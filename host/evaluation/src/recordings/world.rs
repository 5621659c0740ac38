//! One world of a folder: the calibration, then every recording with it.

use palpate::finger::Mechanics;
use palpate::sensing::{Calibration, Directive, Event, Object, Refusal, Sensor, Settings};
use palpate_cli::progress::ProgressBar;
use palpate_simulation::Simulated;
use rayon::prelude::*;

use super::protocol::{Speeds, follow};
use super::truth::{Class, Truth};
use super::{Plan, Recording};
use crate::score::{Listener, Scores, Trial};

/// What a recording led to.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the recording.
    pub name: String,
    /// Class.
    pub class: Class,
    /// What was said, next to the truth; times on the recording's clock.
    pub trial: Trial,
    /// Phalanx, place in metre and time in second of first contact, whatever class; `None` without contact.
    pub truth: Option<crate::score::Contact>,
    /// True force on the phalanx in contact when a force was told, or at the end of the closing, newton.
    pub true_force_n: f64,
    /// How stiff the object was said to be, in scenes with that option.
    pub object: Option<Object>,
    /// Stiffness of the springs that hold it, newton per metre; `None` of a fixed one.
    pub true_object_n_per_m: Option<f64>,
    /// For what calibrates: why it was refused, if it was.
    pub refused: Option<Refusal>,
    /// The closing could not be followed, and why.
    pub problem: Option<&'static str>,
}

/// What the calibration found, next to the truth.
#[derive(Clone, Copy, Debug)]
pub struct Calibrated {
    /// What is used from here on.
    pub found: Calibration,
    /// Torque factor of a perfect calibration.
    pub true_torque_factor: f64,
    /// Twist of the cable of a perfect calibration, radian per newton metre of nominal torque.
    pub true_cable_rad_per_nm: f64,
}

impl Calibrated {
    /// Error of the torque factor in claimed deviations.
    #[must_use]
    pub fn torque_factor_z(&self) -> f64 {
        (f64::from(self.found.torque_factor) / self.true_torque_factor).ln()
            / f64::from(self.found.torque_factor_sigma)
    }

    /// Error of the torque factor, percent.
    #[must_use]
    pub fn torque_factor_err_pct(&self) -> f64 {
        100.0 * (f64::from(self.found.torque_factor) / self.true_torque_factor - 1.0)
    }

    /// Error of the cable's twist in claimed deviations.
    #[must_use]
    pub fn cable_z(&self) -> f64 {
        (f64::from(self.found.cable_rad_per_nm) - self.true_cable_rad_per_nm)
            / f64::from(self.found.cable_sigma_rad_per_nm)
    }
}

/// A world's recordings, replayed.
#[derive(Clone, Debug)]
pub struct World {
    /// Name.
    pub name: String,
    /// A line for each recording, what calibrates first.
    pub lines: Vec<Line>,
    /// `None` where nothing calibrated.
    pub calibration: Option<Calibrated>,
    /// Scale of forces by a scale under the pins; `None` without one.
    pub force_scale: Option<f64>,
    /// Stiffness of the springs over the scene's.
    pub true_springs: f64,
}

impl World {
    /// Replays a world.
    #[must_use]
    pub fn replay<S: Simulated>(
        name: &str,
        recordings: &[Recording],
        plan: &Plan,
        bar: &ProgressBar,
    ) -> Self {
        let of = |class: Class| recordings.iter().filter(move |r| r.truth.class == class);
        let mut calibration = S::UNCALIBRATED;
        let mut lines = Vec::new();
        for recording in of(Class::Press).chain(of(Class::Pin)) {
            if !plan.uncalibrated {
                let (line, learned) = line::<S>(
                    recording,
                    recording.truth.class,
                    calibration,
                    &S::settings(),
                );
                calibration = learned;
                lines.push(line);
            }
            bar.inc(1);
        }
        let calibrated = lines.first().map(|_| {
            // The drivetrain is the world's: any recording tells it.
            let truth = &recordings[0].truth;
            let drivetrain = S::drivetrain(&S::MECHANISM);
            let nominal = f64::from(drivetrain.torque_per_ampere_nm * drivetrain.efficiency);
            Calibrated {
                found: calibration,
                true_torque_factor: truth.torque_factor(nominal, spring::<S>()),
                true_cable_rad_per_nm: truth.cable_rad_per_nm(nominal),
            }
        });
        let mut settings = S::settings();
        let force_scale = if plan.scale {
            weighed::<S>(of(Class::Pin), calibration)
        } else {
            None
        };
        settings.force_scale = force_scale.map(|scale| scale as f32);
        let judged: Vec<&Recording> = recordings
            .iter()
            .filter(|r| !r.truth.class.calibrates())
            .collect();
        lines.par_extend(judged.par_iter().map(|recording| {
            let (line, _) = line::<S>(recording, recording.truth.class, calibration, &settings);
            bar.inc(1);
            line
        }));
        Self {
            name: name.to_owned(),
            lines,
            calibration: calibrated,
            force_scale,
            true_springs: recordings[0].truth.spring_nm_per_rad / spring::<S>(),
        }
    }

    /// Only the lines whose names are wanted.
    #[must_use]
    pub fn only(mut self, wanted: impl Fn(&str) -> bool) -> Self {
        self.lines.retain(|line| wanted(&line.name));
        self
    }

    /// What is counted: free, distal and proximal recordings; what is hard by design is printed line by line only.
    pub fn counted(&self) -> impl Iterator<Item = &Trial> {
        self.lines
            .iter()
            .filter(|line| !line.class.calibrates() && line.class != Class::Hard)
            .map(|line| &line.trial)
    }

    /// Scores of this world.
    #[must_use]
    pub fn scores(&self) -> Scores {
        Scores::of(self.counted())
    }
}

/// Nominal stiffness of the spring of joint 2, newton metre per radian.
fn spring<S: Simulated>() -> f64 {
    let parameters = S::parameters().ok();
    let springs = parameters.map(|parameters| parameters.finger.spring_nm_per_rad);
    springs
        .and_then(|springs| springs.get(1).copied())
        .unwrap_or(f64::NAN)
}

/// The scale of forces as a user finds it: what a scale reads over the force that is told, mean of all pins. They are felt as anything
/// else is.
fn weighed<'a, S: Simulated>(
    pins: impl Iterator<Item = &'a Recording>,
    calibration: Calibration,
) -> Option<f64> {
    let settings = Settings {
        force_scale: Some(1.0),
        ..S::settings()
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for pin in pins {
        let (line, _) = line::<S>(pin, Class::Distal, calibration, &settings);
        if let Some(force) = line.trial.force.filter(|force| force.told_n > 0.0) {
            sum += force.true_n / force.told_n;
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Replays a recording, taken to be of a class.
fn line<S: Simulated>(
    recording: &Recording,
    class: Class,
    calibration: Calibration,
    settings: &Settings,
) -> (Line, Calibration) {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let speeds = Speeds::of(&recording.samples, settings, drivetrain.rad_per_count);
    let mut sensor: Sensor<S::Finger, palpate::sensing::NoJointSensor, S::Series> =
        Sensor::new(finger, drivetrain, speeds.closing, calibration);
    let truth: &Truth = &recording.truth;
    let purpose = match (class, truth.nominal_k_m) {
        (Class::Press, _) => Directive::CalibrateCable,
        (Class::Pin, Some(k_m)) => Directive::Calibrate {
            phalanx: S::PHALANGES,
            k_m: k_m as f32,
        },
        _ => Directive::Watch,
    };
    let mut listener = Listener::default();
    let mut refused = None;
    let mut unrecorded = true;
    let origin_us = (1e6 * recording.origin_s).round() as u64;
    let complete = follow(
        &mut sensor,
        &recording.samples,
        &speeds,
        purpose,
        |time_us, event| {
            match event {
                Event::FrictionRecorded { .. } => unrecorded = false,
                Event::CalibrationRefused { why } => refused = Some(*why),
                _ => {}
            }
            listener.hear(time_us + origin_us, event, |time_s, phalanx| {
                truth.force_n(time_s, phalanx)
            });
        },
    );
    let contact = truth.contact(|phalanx| {
        sensor
            .finger()
            .phalanx_length_m(phalanx)
            .map_or(f64::NAN, f64::from)
    });
    let trial = listener.trial(contact);
    let line = Line {
        name: recording.name.clone(),
        class,
        truth: contact,
        true_force_n: match (trial.force, contact) {
            (Some(force), _) => force.true_n,
            (None, Some(contact)) => truth.force_n(f64::INFINITY, contact.phalanx),
            (None, None) => f64::NAN,
        },
        trial,
        object: sensor.object(),
        true_object_n_per_m: truth.object_n_per_m(),
        refused,
        problem: match (complete, unrecorded) {
            (false, _) => Some("there is no second closing"),
            (true, true) => Some("friction was not recorded"),
            _ => None,
        },
    };
    (line, *sensor.calibration())
}
