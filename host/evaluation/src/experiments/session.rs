//! A finger with what it learned, its closings, and what each method says of them.

use palpate::finger::Mechanics;
use palpate::sample::Sample;
use palpate::sensing::{Calibration, Friction, Refusal, Settings};
use palpate_plant::{Grasp, Parameters};
use palpate_simulation::Simulated;
use palpate_simulation::places::PIN_SHARES;

use super::judge::{self, Knowledge};
use super::live::{Bench, Failure, Recording, Setup, refusals};
use super::objects::{Object, felt_m};
use super::result::Method;
use crate::paper;
use crate::score::{Contact, Trial};

/// Joint angles at which the pins of the guided calibration are felt, radian: the first that the finger takes. One that its weight
/// closes may begin beyond it.
const PIN_THETA_1_RAD: [f64; 3] = [0.6, 0.75, 0.9];

/// What one closing was, and what it recorded.
#[derive(Clone, Debug)]
pub struct Case {
    /// What was grasped.
    pub object: &'static str,
    /// theta_1 at contact, radian, as wanted.
    pub theta_1_rad: f64,
    /// The true first contact, where it is felt; `None` for a free closing.
    pub truth: Option<Contact>,
    /// The samples.
    pub recording: Recording,
}

/// A finger on a bench with its records.
pub struct Session<S: Simulated> {
    bench: Bench<S>,
    /// Settings of the sensing.
    pub settings: Settings,
    /// The recording of the friction record.
    pub free: Recording,
    /// The friction record.
    pub friction: Friction,
    /// Steps of the guided calibration that were refused: nothing was learned from them.
    pub refused: Vec<Refusal>,
    /// Before any calibration.
    pub nominal: Calibration,
    /// After the guided calibration.
    pub calibrated: Calibration,
    model: paper::Model,
    /// What a free closing does not exceed with each calibration, by its torque factor.
    thresholds: Vec<(f32, f64)>,
}

impl<S: Simulated> Session<S> {
    /// Homes, records friction and goes through the guided calibration.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn new(parameters: &Parameters, setup: &Setup, seed: u64) -> Result<Self, Failure> {
        let (mut bench, free) = Bench::<S>::new(parameters, setup, seed)?;
        let nominal = *bench.calibration();
        let length = judge::length_m::<S>(S::PHALANGES)?;
        let places = PIN_SHARES.map(|share| share * length);
        let mut refused = refusals(&free);
        let (pins, again) = bench.calibrate(&places, &PIN_THETA_1_RAD)?;
        refused.extend(pins);
        let free = again.unwrap_or(free);
        let friction = bench.friction()?;
        let model = judge::paper_model::<S>()?;
        let calibrated = *bench.calibration();
        let mut session = Self {
            calibrated,
            bench,
            settings: setup.settings::<S>(parameters),
            free,
            friction,
            refused,
            nominal,
            model,
            thresholds: Vec::new(),
        };
        let motion = judge::free_motion(&session.free);
        session.learn_thresholds(&motion)?;
        Ok(session)
    }

    /// Takes what a free closing does not exceed for the threshold of the paper's algorithm, with each calibration.
    fn learn_thresholds(&mut self, free_motion: &[Sample]) -> Result<(), Failure> {
        let mut thresholds = Vec::new();
        for calibration in [self.nominal, self.calibrated] {
            let threshold_nm = paper::friction_threshold(&self.scaled(&calibration), free_motion)
                .ok_or(Failure::Missing("closing motion"))?;
            thresholds.push((calibration.torque_factor, threshold_nm));
        }
        self.thresholds = thresholds;
        Ok(())
    }

    /// Judges with the friction record of another time, and the threshold from its free closing.
    ///
    /// # Errors
    /// There is no closing in that.
    pub fn take_record(&mut self, other: &Self) -> Result<(), Failure> {
        self.friction.clone_from(&other.friction);
        self.learn_thresholds(&judge::free_motion(&other.free))
    }

    /// What the paper's algorithm takes for granted, with a calibration of this finger.
    fn scaled(&self, calibration: &Calibration) -> paper::Model {
        // Its torque has what is lost on the way to the joints, ours takes that off along the path.
        let [loss, _] = <S::Finger as Mechanics>::JOINT_LOSS;
        let factor = f64::from(calibration.torque_factor) * (1.0 - f64::from(loss));
        let mut model = self.model.clone();
        model.torque_nm_per_a *= factor;
        model.cable_rad_per_nm = f64::from(calibration.cable_rad_per_nm) / factor;
        model
    }

    /// The paper's algorithm, with one of this finger's two calibrations, and its threshold.
    #[must_use]
    pub fn papers_model(&self, calibration: &Calibration) -> (paper::Model, f64) {
        let of = (self.thresholds.iter()).find(|(factor, _)| *factor == calibration.torque_factor);
        let threshold_nm = of.map_or(f64::NAN, |(_, threshold_nm)| *threshold_nm);
        (self.scaled(calibration), threshold_nm)
    }

    /// Closes on an object at `k_m` of `phalanx`. `None` where the object cannot be there.
    ///
    /// # Errors
    /// [`Failure`], but for an object in the way.
    pub fn grasp(
        &mut self,
        object: &Object,
        phalanx: u8,
        k_m: f64,
        theta_1_rad: f64,
    ) -> Result<Option<Case>, Failure> {
        let grasp = Grasp::touching(phalanx, k_m, theta_1_rad, object.shape.clone());
        let recording = match self.bench.close(&grasp) {
            Ok(recording) => recording,
            Err(Failure::Simulation(palpate_simulation::Error::Plant(_))) => return Ok(None),
            Err(failure) => return Err(failure),
        };
        let Some(first) = recording.contact else {
            // The finger never came there: it felt something before, or stalled.
            let contact = Contact {
                phalanx,
                k_m,
                length_m: judge::length_m::<S>(phalanx)?,
                time_s: f64::INFINITY,
            };
            return Ok(Some(Case {
                object: object.name,
                theta_1_rad,
                truth: Some(contact),
                recording,
            }));
        };
        let touched = first.contact.phalanx;
        let length_m = judge::length_m::<S>(touched)?;
        let place_m = if object.flush_m > 0.0 && touched == phalanx && phalanx > 1 {
            felt_m(
                object,
                k_m,
                length_m,
                judge::stiffest_m::<S>(touched, first.theta_a_rad)?,
            )
        } else {
            first.contact.k_m
        };
        Ok(Some(Case {
            object: object.name,
            theta_1_rad,
            truth: Some(Contact {
                phalanx: touched,
                k_m: place_m,
                length_m,
                time_s: first.time_s,
            }),
            recording,
        }))
    }

    /// Closes on nothing.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn free_closing(&mut self) -> Result<Case, Failure> {
        Ok(Case {
            object: "nothing",
            theta_1_rad: f64::NAN,
            truth: None,
            recording: self.bench.close(&Grasp::Free)?,
        })
    }

    /// Our sensing, with a calibration.
    ///
    /// # Errors
    /// An invalid scene.
    pub fn ours(&self, case: &Case, calibration: &Calibration) -> Result<Trial, Failure> {
        let knowledge = Knowledge {
            friction: self.friction.clone(),
            calibration: *calibration,
            settings: self.settings,
        };
        judge::ours::<S>(&knowledge, &case.recording, case.truth)
    }

    /// The paper's algorithm, with a calibration.
    #[must_use]
    pub fn papers(&self, case: &Case, calibration: &Calibration, rule: paper::Rule) -> Trial {
        let (model, threshold_nm) = self.papers_model(calibration);
        judge::papers(&model, threshold_nm, rule, &case.recording, case.truth)
    }

    /// Both methods, calibrated and not; the paper's with every step of torque, and with two levels.
    ///
    /// # Errors
    /// An invalid scene.
    pub fn all(&self, case: &Case) -> Result<Vec<(Method, bool, Trial)>, Failure> {
        let mut trials = Vec::new();
        for (calibrated, calibration) in [(true, &self.calibrated), (false, &self.nominal)] {
            trials.push((Method::Ours, calibrated, self.ours(case, calibration)?));
            for (step, rule) in Method::papers() {
                trials.push((step, calibrated, self.papers(case, calibration, rule)));
            }
        }
        Ok(trials)
    }
}
