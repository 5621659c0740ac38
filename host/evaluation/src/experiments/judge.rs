//! What each method says of a recorded closing.

use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::{Calibration, Directive, Event, Friction, NotLocated, Sample, Settings};
use palpate_plant::FingerParameters;

use palpate_simulation::Simulated;

use super::live::{Failure, Recording, nominal_sensor};
use super::result::Trial;
use crate::paper;
use crate::reference::{Finger, Stage};

/// What our sensing is given beside the samples.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// Friction record.
    pub friction: Friction,
    /// Torque factor and cable.
    pub calibration: Calibration,
    /// Settings.
    pub settings: Settings,
}

/// The truth of a closing, as far as a trial needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Phalanx and place where the contact is felt, metre; `None` for a free closing.
    pub place: Option<(u8, f64)>,
    /// Length of that phalanx, metre.
    pub length_m: f64,
    /// First contact, second on the samples' clock.
    pub contact_s: f64,
}

impl Truth {
    fn trial(&self) -> Trial {
        Trial {
            truth: self.place,
            length_m: self.length_m,
            contact_s: self.contact_s,
            touched_s: None,
            phalanx: None,
            place: None,
            ambiguous: false,
        }
    }
}

/// Our sensing on a recording.
///
/// # Errors
/// An invalid scene.
pub fn ours<S: Simulated>(
    knowledge: &Knowledge,
    recording: &Recording,
    truth: &Truth,
) -> Result<Trial, Failure> {
    let mut sensor = nominal_sensor::<S>();
    sensor.set_settings(knowledge.settings);
    sensor.set_calibration(knowledge.calibration);
    sensor.set_friction(knowledge.friction.clone());
    let mut trial = truth.trial();
    let mut directive = Directive::Rest;
    for (wanted, sample) in &recording.samples {
        if *wanted != directive {
            directive = *wanted;
            sensor.direct(directive);
        }
        if let Some(event) = sensor.update(sample) {
            take(&mut trial, &event);
        }
    }
    Ok(trial)
}

/// The last word counts.
fn take(trial: &mut Trial, event: &Event) {
    match *event {
        Event::Touch { time_us, .. } => {
            trial.touched_s = trial.touched_s.or(Some(time_us as f64 * 1e-6));
        }
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            ..
        } => {
            trial.phalanx = Some(phalanx);
            trial.place = Some((f64::from(k_m), Some(f64::from(sigma_m))));
            trial.ambiguous = false;
        }
        Event::Ambiguous {
            phalanx: [phalanx, _],
            k_m: [k_m, _],
            sigma_m: [sigma_m, _],
            ..
        } => {
            trial.phalanx = Some(phalanx);
            trial.place = Some((f64::from(k_m), Some(f64::from(sigma_m))));
            trial.ambiguous = true;
        }
        Event::NotLocated { why, .. } => {
            trial.phalanx = (why == NotLocated::Proximal).then_some(1);
            trial.place = None;
            trial.ambiguous = false;
        }
        _ => {}
    }
}

/// The samples of a closing.
#[must_use]
pub fn closing(recording: &Recording) -> Vec<Sample> {
    recording
        .samples
        .iter()
        .filter(|(directive, _)| *directive == Directive::Watch)
        .map(|(_, sample)| *sample)
        .collect()
}

/// The samples of a friction record.
#[must_use]
pub fn free_motion(recording: &Recording) -> Vec<Sample> {
    recording
        .samples
        .iter()
        .filter(|(directive, _)| *directive == Directive::RecordFriction)
        .map(|(_, sample)| *sample)
        .collect()
}

/// The paper's algorithm on a recording.
#[must_use]
pub fn papers(
    model: &paper::Model,
    threshold_nm: f64,
    recording: &Recording,
    truth: &Truth,
) -> Trial {
    let verdict = paper::locate(model, threshold_nm, &closing(recording));
    let mut trial = truth.trial();
    trial.touched_s = verdict.touched_us().map(|time| time as f64 * 1e-6);
    match verdict {
        paper::Verdict::Proximal { .. } => trial.phalanx = Some(1),
        paper::Verdict::Located { phalanx, k, .. } => {
            trial.phalanx = Some(phalanx);
            trial.place = Some((k, None));
        }
        paper::Verdict::NoContact | paper::Verdict::Touched { .. } => {}
    }
    trial
}

/// What the paper's algorithm takes for granted of a scene: the nominal finger, drivetrain and cable.
///
/// # Errors
/// A scene that the plant does not know.
pub fn paper_model<S: Simulated>() -> Result<paper::Model, Failure> {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let nominal = nominal_finger(&S::parameters()?.finger);
    Ok(paper::Model {
        free: paper::free_table(&nominal, f64::from(S::TRAVEL_RAD)),
        finger: nominal,
        torque_nm_per_a: f64::from(drivetrain.torque_per_ampere_nm * drivetrain.efficiency),
        counts_per_rad: 1.0 / f64::from(drivetrain.rad_per_count),
        cable_rad_per_nm: f64::from(S::UNCALIBRATED.cable_rad_per_nm),
    })
}

/// The finger as its data sheet has it.
fn nominal_finger(table: &FingerParameters) -> Finger {
    let stages = if table.lever_m.is_empty() {
        table
            .pulley_m
            .chunks(2)
            .map(|pair| Stage::Tendon {
                ratio: pair[1] / pair[0],
            })
            .collect()
    } else {
        (0..table.lever_m.len())
            .map(|i| Stage::Linkage {
                drive: table.lever_m[i],
                coupler: table.coupler_m[i],
                driven: table.driven_m[i],
                offset_rad: table.offset_deg[i].to_radians(),
                mode: table.mode[i],
            })
            .collect()
    };
    Finger {
        lengths: table.length_m.clone(),
        springs: table.spring_nm_per_rad.clone(),
        rest_rad: table
            .rest_deg
            .iter()
            .map(|angle| angle.to_radians())
            .collect(),
        stages,
    }
}

/// Length of a phalanx of a scene, metre.
///
/// # Errors
/// A phalanx that the finger does not have.
pub fn length_m<S: Scene>(phalanx: u8) -> Result<f64, Failure> {
    let finger = S::MECHANISM;
    finger
        .phalanx_length_m(phalanx)
        .map(f64::from)
        .ok_or(Failure::Missing("such phalanx"))
}

/// Stiffest place e_2 (27) of a phalanx in the free posture at an input angle, metre.
///
/// # Errors
/// A posture that the finger does not take.
pub fn stiffest_m<S: Scene>(phalanx: u8, theta_a_rad: f64) -> Result<f64, Failure> {
    let finger = S::MECHANISM;
    finger
        .free_at_angle(theta_a_rad as f32, &finger.rest())
        .and_then(|free| finger.stiffest_m(&free.configuration, free.torque_nm, phalanx))
        .map(f64::from)
        .ok_or(Failure::Missing("stiffest place"))
}
