//! Accuracy of the guided calibration on fingers with hidden values, and its effect on locations.

use palpate::scene::Scene;
use palpate::sensing::Calibration;
use palpate_document::table::head;
use palpate_plant::{Parameters, TrueCalibration};
use palpate_scenes::P70;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

use super::catalogue::random_cylinder;
use super::fingers;
use super::job::{Plan, Wanted, closing};
use super::live::{Failure, Setup};
use super::session::Session;
use crate::score::{Scores, Trial};

/// Contacts felt on each finger, distal phalanx.
const CONTACTS: usize = 6;

/// At the speed at which the finger closes.
fn true_calibration(parameters: &Parameters) -> TrueCalibration {
    TrueCalibration::of(
        parameters,
        P70::EFFICIENCY.into(),
        P70::DRIVE.motor.torque_constant_nm_per_a.into(),
        P70::MOTION.closing_rad_per_s.into(),
    )
}

/// One finger, calibrated.
#[derive(Clone, Debug)]
pub struct Finger {
    /// Of its hidden values.
    pub seed: u64,
    /// Them.
    pub truth: TrueCalibration,
    /// What the guided sequence found.
    pub found: Calibration,
    /// Steps of the sequence that were refused.
    pub refused: usize,
    /// The same contacts judged before and after the calibration.
    pub contacts: Vec<[Trial; 2]>,
}

impl Finger {
    fn new(seed: u64, parameters: &Parameters) -> Result<Self, Failure> {
        let mut session = Session::<P70>::new(parameters, &Setup::default(), seed)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x00ca_11b8);
        let mut contacts = Vec::new();
        for _ in 0..CONTACTS {
            let case = closing(&mut session, || Wanted {
                object: random_cylinder(&mut random),
                phalanx: 2,
                k_m: 0.070 * random.random_range(0.05..0.95),
                theta_1_rad: random.random_range(0.25..1.1),
                any_first: true,
            })?;
            contacts.push([
                session.ours(&case, &session.nominal)?,
                session.ours(&case, &session.calibrated)?,
            ]);
        }
        Ok(Self {
            seed,
            truth: true_calibration(parameters),
            found: session.calibrated,
            refused: session.refused.len(),
            contacts,
        })
    }

    /// Errors of torque factor and cable in claimed deviations.
    #[must_use]
    pub fn deviations(&self) -> [f64; 2] {
        let found = &self.found;
        let factor = (f64::from(found.torque_factor) / self.truth.torque_factor).ln();
        let cable = f64::from(found.cable_rad_per_nm) - self.truth.cable_rad_per_nm;
        [
            factor / f64::from(found.torque_factor_sigma),
            cable / f64::from(found.cable_sigma_rad_per_nm),
        ]
    }

    /// Absolute errors of the places, metre, before (0) or after (1).
    pub fn errors_m(&self, after: usize) -> impl Iterator<Item = f64> + '_ {
        self.contacts
            .iter()
            .filter_map(move |trials| trials[after].error_m().map(f64::abs))
    }

    /// One line of JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let found = &self.found;
        let errors = |after| self.errors_m(after).map(|e| 1e3 * e).collect::<Vec<_>>();
        json!({
            "type": "calibration", "seed": self.seed,
            "torque_factor": found.torque_factor, "torque_factor_sigma": found.torque_factor_sigma,
            "torque_factor_true": self.truth.torque_factor,
            "cable_mrad_per_nm": 1e3 * found.cable_rad_per_nm,
            "cable_sigma_mrad_per_nm": 1e3 * found.cable_sigma_rad_per_nm,
            "cable_true_mrad_per_nm": 1e3 * self.truth.cable_rad_per_nm,
            "contacts": found.contacts, "presses": found.presses, "refused": self.refused,
            "abs_err_before_mm": errors(0), "abs_err_after_mm": errors(1),
        })
    }
}

/// Fingers with hidden values of their own, calibrated and tried. The second list: what could not be done.
#[must_use]
pub fn study(plan: &Plan) -> (Vec<Finger>, Vec<(u64, Failure)>) {
    let first = plan.seed + 3000;
    let seeds = first..first + plan.fingers(10, 100);
    fingers::each("fingers calibrated", seeds, |seed| {
        Finger::new(seed, &plan.parameters.randomised(seed))
    })
}

/// What all fingers together show.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Fingers.
    pub fingers: usize,
    /// Steps of the guided sequence that were refused.
    pub refused: usize,
    /// True torque factor and cable within two claimed deviations, percent of the fingers.
    pub within_2sigma_pct: [f64; 2],
    /// Root mean square error of torque factor and cable, percent, before and after.
    pub rms_pct: [[f64; 2]; 2],
    /// Root mean square of the errors of torque factor and cable in claimed deviations: 1 for honest ones.
    pub z_rms: [f64; 2],
    /// The contacts before and after.
    pub places: [Scores; 2],
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

impl Summary {
    /// Of fingers.
    #[must_use]
    pub fn of(fingers: &[Finger]) -> Self {
        let nominal = P70::UNCALIBRATED;
        let within = |which: usize| {
            let good = |finger: &&Finger| finger.deviations()[which].abs() <= 2.0;
            percent(fingers.iter().filter(good).count(), fingers.len())
        };
        let rms = |error: &dyn Fn(&Finger) -> f64| {
            let sum: f64 = fingers.iter().map(|finger| error(finger).powi(2)).sum();
            100.0 * (sum / fingers.len().max(1) as f64).sqrt()
        };
        let errors = |calibration: &dyn Fn(&Finger) -> Calibration| {
            [
                rms(&|f| f64::from(calibration(f).torque_factor) / f.truth.torque_factor - 1.0),
                rms(&|f| {
                    f64::from(calibration(f).cable_rad_per_nm) / f.truth.cable_rad_per_nm - 1.0
                }),
            ]
        };
        let places = [0, 1].map(|after| {
            let contacts = fingers.iter().flat_map(|finger| &finger.contacts);
            Scores::of(contacts.map(|trials| &trials[after]))
        });
        let z_rms = [0, 1].map(|which| {
            let squares = fingers
                .iter()
                .map(|finger| finger.deviations()[which].powi(2));
            (squares.sum::<f64>() / fingers.len().max(1) as f64).sqrt()
        });
        Self {
            fingers: fingers.len(),
            refused: fingers.iter().map(|finger| finger.refused).sum(),
            within_2sigma_pct: [within(0), within(1)],
            z_rms,
            rms_pct: [errors(&|_| nominal), errors(&|finger| finger.found)],
            places,
        }
    }

    /// One line of JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let places = self.places.each_ref().map(|scores| {
            let mut all = serde_json::to_value(scores).unwrap_or_default();
            if let Value::Object(fields) = &mut all {
                fields.insert("n".into(), json!(scores.closings));
                fields.insert(
                    "located_pct".into(),
                    json!(percent(scores.located, scores.distal)),
                );
                fields.insert("mean_abs_err_mm".into(), json!(scores.err_mean_mm));
                fields.insert("within_2sigma_pct".into(), json!(scores.within2_pct));
            }
            all
        });
        json!({
            "type": "calibration-summary", "fingers": self.fingers, "refused": self.refused,
            "torque_factor_within_2sigma_pct": self.within_2sigma_pct[0],
            "cable_within_2sigma_pct": self.within_2sigma_pct[1],
            "torque_factor_z_rms": self.z_rms[0], "cable_z_rms": self.z_rms[1],
            "torque_factor_rms_pct": [self.rms_pct[0][0], self.rms_pct[1][0]],
            "cable_rms_pct": [self.rms_pct[0][1], self.rms_pct[1][1]],
            "before": places[0], "after": places[1],
        })
    }

    /// As a table.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "Guided calibration of {} simulated fingers (a press on the stop, two pins), {} steps refused\n\n{}",
            self.fingers,
            self.refused,
            head("| before | after | true value within 2 sigma | z, rms")
        );
        for (which, name) in ["torque factor, rms error", "cable, rms error"]
            .into_iter()
            .enumerate()
        {
            text += &format!(
                "| {name} | {:.1} % | {:.1} % | {:.0} % | {:.2} |\n",
                self.rms_pct[0][which],
                self.rms_pct[1][which],
                self.within_2sigma_pct[which],
                self.z_rms[which],
            );
        }
        let [before, after] = &self.places;
        let mut row = |name: &str, value: fn(&Scores) -> Option<f64>, unit: &str| {
            let cell = |scores: &Scores| {
                value(scores).map_or_else(|| "–".to_owned(), |value| format!("{value:.2} {unit}"))
            };
            text += &format!("| {name} | {} | {} | | |\n", cell(before), cell(after));
        };
        row(
            "contacts located",
            |s| Some(percent(s.located, s.distal)),
            "%",
        );
        row("place, mean error", |s| s.err_mean_mm, "mm");
        row("place, 95 % below", |s| s.err_95_pct, "% of length");
        row("place within 2 sigma", |s| s.within2_pct, "%");
        text
    }
}
