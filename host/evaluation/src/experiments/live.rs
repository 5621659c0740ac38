//! A simulated finger used like one on a bench: it is homed, records its friction, feels pins at known places, and then one
//! object after another is put in its way. What runs is the firmware's control loop, sequence and sensing.

use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate::sample::Sample;
use palpate::scene::Scene;
use palpate::sensing::{
    Calibration, Directive, Event, Friction, NoJointSensor, Refusal, Sensor, Settings,
};
use palpate_plant::{FirstContact, Grasp, Parameters};
use palpate_simulation::{Outcome, Simulated, Simulation};

/// The smallest deviation that can be wanted, metre: probing goes on to the torque's limit.
const NEVER_SURE_M: f32 = 1.0e-4;

/// What is changed of the scene's settings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setup {
    /// Speed of closing, probing and recording, radian per second.
    pub speed_rad_per_s: Option<f32>,
    /// Torque at which probing ends, newton metre.
    pub torque_limit_nm: Option<f32>,
}

impl Setup {
    /// Settings of the sensing of a scene, with what the user knows of skin and worm.
    #[must_use]
    pub fn settings<S: Simulated>(&self, parameters: &Parameters) -> Settings {
        let mut settings = S::settings();
        let replace = |place: &mut f32, value: Option<f32>| *place = value.unwrap_or(*place);
        replace(&mut settings.speed_rad_per_s, self.speed_rad_per_s);
        replace(&mut settings.torque_limit_nm, self.torque_limit_nm);
        if let Some(friction) = parameters.contact.stated() {
            settings.contact_friction = settings.rubbed_with(friction as f32);
        }
        let worm_error_rad = parameters.transmission.stated();
        replace(
            &mut settings.worm_error_rad,
            worm_error_rad.map(|rad| rad as f32),
        );
        settings.mounting = S::mounting(parameters);
        settings
    }
}

/// Why a simulated finger did not do what it was asked.
#[derive(Debug)]
pub enum Failure {
    /// The simulation could not run.
    Simulation(palpate_simulation::Error),
    /// The firmware switched off.
    Fault(palpate::drive::fault::Fault),
    /// A motion ended without what it was for.
    Missing(&'static str),
    /// Any of these, of a finger whose contacts count all the same: as not felt.
    Unfelt(Box<Failure>),
}

impl Failure {
    /// Whether what was to be done is left out of the figures.
    #[must_use]
    pub fn leaves_out(&self) -> bool {
        !matches!(self, Self::Unfelt(_))
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Simulation(error) => write!(out, "{error}"),
            Self::Fault(fault) => write!(out, "the firmware switched off: {}", fault.name()),
            Self::Missing(what) => write!(out, "no {what}"),
            Self::Unfelt(failure) => write!(out, "{failure}; its contacts count as not felt"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<palpate_simulation::Error> for Failure {
    fn from(error: palpate_simulation::Error) -> Self {
        Self::Simulation(error)
    }
}

/// What one motion left behind.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Samples with what each was good for.
    pub samples: Vec<(Directive, Sample)>,
    /// First contact with the object.
    pub contact: Option<FirstContact>,
    /// What the sensing said while it went on.
    pub events: Vec<(u64, Event)>,
    /// The truth once a millisecond while something is touched: time in second, phalanx that presses hardest, its force in
    /// newton.
    pub forces: Vec<(f64, u8, f64)>,
}

impl Recording {
    /// True contact force on a phalanx at an instant, newton; NaN where another presses harder, or none. What presses at the end goes on.
    #[must_use]
    pub fn force_n(&self, time_s: f64, phalanx: u8) -> f64 {
        // Half a sample before the end there is a row in any case.
        let end_us = self.samples.last().map_or(0, |(_, sample)| sample.time_us);
        let time_s = time_s.min(1e-6 * end_us as f64 - 0.5e-3);
        let after = self.forces.partition_point(|(time, ..)| *time < time_s);
        match self.forces.get(after) {
            Some(&(_, pressed, force_n)) if pressed == phalanx => force_n,
            _ => f64::NAN,
        }
    }
}

impl TryFrom<Outcome> for Recording {
    type Error = Failure;

    fn try_from(outcome: Outcome) -> Result<Self, Failure> {
        match outcome.fault {
            Some(fault) => Err(Failure::Fault(fault)),
            None => Ok(Self {
                samples: outcome.samples,
                contact: outcome.first_contact,
                events: outcome.events,
                forces: outcome
                    .trace
                    .iter()
                    .filter(|row| row.true_phalanx > 0)
                    .map(|row| (row.time_s, row.true_phalanx, row.true_force_n))
                    .collect(),
            }),
        }
    }
}

/// A finger on a bench.
pub struct Bench<S: Simulated> {
    simulation: Simulation<S>,
    seed: u64,
    closings: u64,
    /// The product has said that its friction record no longer fits.
    stale: bool,
}

impl<S: Simulated> Bench<S> {
    /// A finger that has been homed and has recorded its friction. The recording of that comes with it.
    ///
    /// Probing goes on to the torque's limit, however sure the sensing is: what it would have said earlier can be had
    /// from the recording, which other methods need as a whole.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn new(
        parameters: &Parameters,
        setup: &Setup,
        seed: u64,
    ) -> Result<(Self, Recording), Failure> {
        let mut simulation = Simulation::<S>::new(parameters, seed)?;
        let settings = [
            (Setting::WantedDeviation, Some(NEVER_SURE_M)),
            (Setting::ClosingSpeed, setup.speed_rad_per_s),
            (Setting::ProbeTorque, setup.torque_limit_nm),
        ];
        for (setting, value) in settings {
            if let Some(value) = value {
                simulation
                    .slow()
                    .coordinator
                    .command(Command::Set(setting, value))
                    .map_err(palpate_simulation::Error::Refused)?;
            }
            // One order a millisecond reaches the sensing.
            simulation.idle(0.01);
        }
        let recording = Recording::try_from(simulation.prepare()?)?;
        let bench = Self {
            simulation,
            seed,
            closings: 0,
            stale: false,
        };
        Ok((bench, recording))
    }

    /// The friction record.
    ///
    /// # Errors
    /// There is none.
    pub fn friction(&mut self) -> Result<Friction, Failure> {
        let record = self.simulation.slow().sensing.sensor().friction().cloned();
        record.ok_or(Failure::Missing("friction record"))
    }

    /// What is known of torque factor and cable.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        self.simulation.calibration()
    }

    /// Closes on an object from the open position, with a noise of its own. The finger on the bench stays as it is: each
    /// closing begins from the same state, and the time for opening is saved.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn close(&mut self, grasp: &Grasp) -> Result<Recording, Failure> {
        self.closings += 1;
        let mut simulation = self.simulation.clone();
        simulation.traced = true;
        simulation.reseed(
            self.seed
                .wrapping_mul(1_000_003)
                .wrapping_add(self.closings),
        );
        Recording::try_from(simulation.close(grasp)?)
    }

    /// The guided calibration, after the press on the closing stop that follows the record: a pin at each of these places of the
    /// distal phalanx, met with joint 1 at the first of these angles that the finger takes. Friction is recorded again where the log asks
    /// for it.
    ///
    /// Returns what was refused, and the recording of the last friction record if there was another one.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn calibrate(
        &mut self,
        places_m: &[f64],
        theta_1_rad: &[f64],
    ) -> Result<(Vec<Refusal>, Option<Recording>), Failure> {
        let (mut refused, mut again) = (Vec::new(), None);
        for &k_m in places_m {
            let mut met = Err(Failure::Missing("angle for a pin"));
            for &angle_rad in theta_1_rad {
                met = (self.simulation)
                    .calibrate(S::PHALANGES, k_m as f32, angle_rad)
                    .map_err(Failure::from);
                // No such place at this angle: nothing has moved yet.
                if !matches!(
                    met,
                    Err(Failure::Simulation(palpate_simulation::Error::Plant(_)))
                ) {
                    break;
                }
            }
            let outcome = met?;
            let felt = Recording::try_from(outcome)?;
            self.stale |= tells_to_record(&felt);
            refused.extend(refusals(&felt));
            again = self.record_if_stale()?.or(again);
        }
        Ok((refused, again))
    }

    /// Does what the log asks of a user whose friction record no longer fits: records again with nothing in the way. The
    /// next closing would do so with the object there.
    ///
    /// # Errors
    /// [`Failure`].
    fn record_if_stale(&mut self) -> Result<Option<Recording>, Failure> {
        if !std::mem::take(&mut self.stale) {
            return Ok(None);
        }
        Recording::try_from(self.simulation.prepare()?).map(Some)
    }
}

/// The firmware's hint after these events is to record friction.
fn tells_to_record(recording: &Recording) -> bool {
    recording.events.iter().any(|(_, event)| {
        matches!(
            event,
            Event::FrictionStale { .. } | Event::FrictionNotRecorded { .. }
        )
    })
}

/// What a recording shows of calibrations that were refused.
pub(super) fn refusals(recording: &Recording) -> Vec<Refusal> {
    recording
        .events
        .iter()
        .filter_map(|(_, event)| match event {
            Event::CalibrationRefused { why } => Some(*why),
            _ => None,
        })
        .collect()
}

/// A sensor as the firmware of this scene makes it, but for the sensor of joint 2, whose readings are not recorded.
#[must_use]
pub fn nominal_sensor<S: Scene>() -> Sensor<S::Finger, NoJointSensor, S::Series> {
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    Sensor::new(finger, drivetrain, S::settings(), S::UNCALIBRATED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::sample::Drive;
    use palpate_scenes::P70;

    #[test]
    fn what_is_stated_of_the_worm_is_known_live_and_in_judgements() {
        for stated in [0.0, 2e-3] {
            let mut parameters = Parameters::of("p70").expect("a scene");
            parameters.transmission.stated_worm_error_rad = stated;
            let setup = Setup::default();
            let judged = setup.settings::<P70>(&parameters).worm_error_rad;
            let (mut bench, _) = Bench::<P70>::new(&parameters, &setup, 1).expect("a bench");
            let sensor = bench.simulation.slow().sensing.sensor();
            let live = sensor.settings().worm_error_rad;
            assert_eq!([judged, live], [stated as f32; 2]);
        }
    }

    #[test]
    fn what_presses_at_the_end_presses_on() {
        let sample = Sample {
            time_us: 1_000_000,
            position_counts: 0,
            current_a: 0.0,
            emf_v: f32::NAN,
            drive: Drive::Idle,
            joint: (),
        };
        let recording = Recording {
            samples: vec![(Directive::Watch, sample)],
            // The truth's clock is a sum, and may come out less than the sample's.
            forces: vec![(0.999, 2, 2.0), (1.0 - 1e-9, 2, 3.0)],
            ..Recording::default()
        };
        for time_s in [1.0, 1.5, 9.0] {
            assert!((recording.force_n(time_s, 2) - 3.0).abs() < 1e-12);
            assert!(recording.force_n(time_s, 1).is_nan());
        }
        assert!((recording.force_n(0.5, 2) - 2.0).abs() < 1e-12);
    }
}
