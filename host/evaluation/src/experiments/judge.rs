//! Judges each method on a recorded closing.

use nalgebra::DVector;
use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::{Calibration, Directive, Friction, Sample, Settings};
use palpate_plant::FingerParameters;

use palpate_simulation::Simulated;

use super::live::{Failure, Recording, nominal_sensor};
use crate::paper;
use crate::recordings::protocol::{LAST_WORD, idle_after};
use crate::reference::{Finger, Stage};
use crate::score::{Answer, Contact, Listener, Trial};

/// What our sensing is given in addition to the samples.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// Friction record.
    pub friction: Friction,
    /// Torque factor and cable.
    pub calibration: Calibration,
    /// Settings.
    pub settings: Settings,
}

/// Our sensing on a recording.
///
/// # Errors
/// An invalid scene.
pub fn ours<S: Simulated>(
    knowledge: &Knowledge,
    recording: &Recording,
    truth: Option<Contact>,
) -> Result<Trial, Failure> {
    let mut sensor = nominal_sensor::<S>();
    sensor.set_settings(knowledge.settings);
    sensor.set_calibration(knowledge.calibration);
    sensor.set_friction(knowledge.friction.clone());
    let force_n = |time_s, phalanx| recording.force_n(time_s, phalanx);
    let mut listener = Listener::default();
    let mut directive = Directive::Rest;
    for (wanted, sample) in &recording.samples {
        if *wanted != directive {
            directive = *wanted;
            sensor.direct(directive);
        }
        if let Some(event) = sensor.update(sample) {
            listener.hear(sample.time_us, &event, force_n);
        }
    }
    // With another calibration the last word may need more fits than it did while the finger closed.
    let last = recording.samples.last().map(|(_, sample)| *sample);
    for idle in idle_after(last.as_slice(), LAST_WORD) {
        if let Some(event) = sensor.update(&idle) {
            listener.hear(idle.time_us, &event, force_n);
        }
    }
    Ok(listener.trial(truth))
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
    rule: paper::Rule,
    recording: &Recording,
    truth: Option<Contact>,
) -> Trial {
    let found = paper::locate(model, threshold_nm, &closing(recording), rule);
    let answer = match found {
        paper::PaperResult::NoContact => Answer::Nothing,
        paper::PaperResult::Touched { .. } => Answer::NotLocated,
        paper::PaperResult::Proximal { .. } => Answer::Proximal,
        paper::PaperResult::Located { phalanx, k, .. } => Answer::Located {
            phalanx,
            k_m: k,
            // It claims none.
            sigma_m: f64::NAN,
        },
    };
    Trial {
        truth,
        touched_s: found.touched_us().map(|time_us| time_us as f64 * 1e-6),
        answer,
        force: None,
        unusual: false,
    }
}

/// What the paper's algorithm takes for granted of a scene: the nominal finger, drivetrain and cable.
///
/// # Errors
/// A scene that the plant does not know.
pub fn paper_model<S: Simulated>() -> Result<paper::Model, Failure> {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let table = S::parameters()?.finger;
    let nominal = nominal_finger(&table);
    let travel_rad = f64::from(S::TRAVEL_RAD);
    Ok(paper::Model {
        free: match returned(&table) {
            // Joint 1 turns alone.
            Some([_, torque_nm, nm_per_rad]) => [0.0, travel_rad]
                .map(|angle| (angle, torque_nm + nm_per_rad * angle))
                .into(),
            None => paper::free_table(&nominal, travel_rad),
        },
        stopped: stopped(&table, &nominal),
        finger: nominal,
        hidden_base: table.hidden_base,
        torque_nm_per_a: f64::from(drivetrain.torque_per_ampere_nm * drivetrain.efficiency),
        counts_per_rad: 1.0 / f64::from(drivetrain.rad_per_count),
        counts_per_turn: f64::from(drivetrain.counts_per_turn),
        cable_rad_per_nm: f64::from(S::UNCALIBRATED.cable_rad_per_nm),
    })
}

/// Of a return cable: its lever about joint 2 over that about joint 1, its torque about joint 1 with the finger open, newton metre, and the
/// growth of that with the angle, newton metre per radian.
fn returned(table: &FingerParameters) -> Option<[f64; 3]> {
    let [first, second] = *table.return_pulley_m.as_slice() else {
        return None;
    };
    let per_rad = table.return_n_per_m * first * first;
    Some([second / first, table.return_tension_n * first, per_rad])
}

/// What holds joint 2 of a finger of two phalanges at its stop, by its data sheet.
fn stopped(table: &FingerParameters, nominal: &Finger) -> Option<paper::Stopped> {
    const STEP_RAD: f64 = 1e-4;
    let at = |theta_2: f64| nominal.theta_a(&DVector::from_vec(vec![0.0, theta_2]));
    let [_, rest_deg] = *table.rest_deg.as_slice() else {
        return None;
    };
    let stop_rad = table.joint_min_deg[1].to_radians();
    let preload_nm = table.spring_nm_per_rad[1] * (stop_rad - rest_deg.to_radians());
    let x_2 = (at(stop_rad + STEP_RAD) - at(stop_rad - STEP_RAD)) / (2.0 * STEP_RAD);
    let share = returned(table).map(|[ratio, ..]| ratio - x_2);
    (share.is_some() || preload_nm > 0.0).then_some(paper::Stopped {
        x_2,
        preload_nm: preload_nm.max(0.0),
        share: share.unwrap_or(0.0),
    })
}

/// The finger as its data sheet has it.
fn nominal_finger(table: &FingerParameters) -> Finger {
    let stages = if table.lever_m.is_empty() {
        // Joints that motors of their own hold do not turn the input link.
        let held = table.held_backlash_deg.iter().map(|_| 0.0);
        let pulled = table.pulley_m.chunks(2).map(|pair| pair[1] / pair[0]);
        held.chain(pulled)
            .map(|ratio| Stage::Tendon { ratio })
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
            .zip(&table.joint_min_deg)
            .map(|(rest, stop)| rest.max(*stop).to_radians())
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
