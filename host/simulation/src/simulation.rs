//! A finger on a bench: power it, let it learn its friction, calibrate it, give it objects.

use crate::outcome::verdict;
use crate::{Board, Machine, Outcome, Row, Slow};
use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate::drive::config::OutOfRange;
use palpate::drive::controller::Controller;
use palpate::drive::sequence::{Refused, Request, State};
use palpate::finger::Mounting;
use palpate::scene::Scene;
use palpate::sensing::{Calibration, Directive};
use palpate_plant::{Grasp, Object, ObjectMount, Parameters, Plant, Shape};

/// A scene that can be simulated: any that the plant has values of.
pub trait Simulated: Scene<Finger: Clone + std::fmt::Debug> + Clone + std::fmt::Debug {
    /// Its nominal values in the default world.
    ///
    /// # Errors
    /// A scene that the plant does not know.
    fn parameters() -> Result<Parameters, Error> {
        Ok(Parameters::of(Self::NAME)?)
    }

    /// How the finger hangs, as a user knows it; `None` where the scene states no weight.
    #[must_use]
    fn mounting(parameters: &Parameters) -> Option<Mounting> {
        let (deg, share) = parameters.stated_mounting()?;
        Some(Mounting {
            gravity_rad: deg.to_radians() as f32,
            share: share as f32,
        })
    }
}

impl<S: Scene<Finger: Clone + std::fmt::Debug> + Clone + std::fmt::Debug> Simulated for S {}

/// Why a simulation cannot run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The plant, or the object in it.
    #[error(transparent)]
    Plant(#[from] palpate_plant::Error),
    /// The parameters are those of another scene.
    #[error("the parameters are those of scene {found}, the simulation is of {expected}")]
    OtherScene {
        /// Scene of the parameters.
        found: String,
        /// Scene of the simulation.
        expected: &'static str,
    },
    /// The scene's drive.
    #[error("scene: {0:?}")]
    Drive(OutOfRange),
    /// The sequence does not take the request now.
    #[error("refused: {0:?}")]
    Refused(Refused),
}

/// Longest motion, second: the sequence's own timeouts end every motion before.
const LONGEST_S: f64 = 240.0;
/// Samples after a motion, for the last word of the sensing.
const AFTERWARDS_S: f64 = 0.6;

/// A simulated finger with its firmware. A clone goes its own way: let one record its friction and clone it for many
/// grasps, each with a [`reseed`](Self::reseed).
#[derive(Clone, Debug)]
pub struct Simulation<S: Simulated> {
    machine: Machine<Slow<S>>,
    /// Whether motions keep their samples.
    pub traced: bool,
}

impl<S: Simulated> Simulation<S> {
    /// A finger at power-on: not homed, nothing known.
    ///
    /// # Errors
    /// A parameter out of range, or the parameters of another scene.
    pub fn new(parameters: &Parameters, seed: u64) -> Result<Self, Error> {
        if parameters.scene != S::NAME {
            return Err(Error::OtherScene {
                found: parameters.scene.clone(),
                expected: S::NAME,
            });
        }
        let plant = palpate_mujoco::plant(parameters, &Grasp::Free, seed)?;
        let slow = Slow::new();
        let machine = S::joint_sensor()
            .and_then(|joint| Machine::new(Board::new(plant), &S::DRIVE, joint, slow))
            .map_err(Error::Drive)?;
        Ok(Self {
            machine,
            traced: false,
        })
    }

    /// Another noise from here on.
    pub fn reseed(&mut self, seed: u64) {
        self.machine.board.plant.reseed(seed);
    }

    /// The world, for faults and truth.
    pub fn plant(&mut self) -> &mut Plant {
        &mut self.machine.board.plant
    }

    /// The control interrupt, for what a user cannot do to it: counters near their wrap.
    pub fn controller(&mut self) -> &mut Controller {
        &mut self.machine.controller
    }

    /// What the sensing knows of torque factor and cable.
    #[must_use]
    pub fn calibration(&self) -> &Calibration {
        self.machine.slow.sensing.calibration()
    }

    /// The slow loop, for settings and records.
    pub fn slow(&mut self) -> &mut Slow<S> {
        &mut self.machine.slow
    }

    /// Lets time pass.
    pub fn idle(&mut self, seconds: f64) {
        for _ in 0..Machine::<Slow<S>>::samples(seconds) {
            self.machine.until_sample();
        }
    }

    /// What the user knows of skin and worm is set; then offset, homing, friction recorded on a free closing and opening, and, where there is
    /// a cable that nobody knows yet, a press on the closing stop.
    ///
    /// # Errors
    /// The sequence refused.
    pub fn prepare(&mut self) -> Result<Outcome, Error> {
        let parameters = self.machine.board.plant.parameters();
        let skin = parameters
            .contact
            .stated()
            .map(|stated| (Setting::ContactFriction, stated as f32));
        let hangs = S::mounting(parameters).map(|hangs| {
            [
                (Setting::Mounting, hangs.gravity_rad),
                (Setting::Weight, hangs.share),
            ]
        });
        if let Some(worm_error_rad) = parameters.transmission.stated() {
            self.slow().sensing.state_worm_error(worm_error_rad as f32);
        }
        for (setting, value) in skin.into_iter().chain(hangs.into_iter().flatten()) {
            self.slow()
                .coordinator
                .command(Command::Set(setting, value))
                .map_err(Error::Refused)?;
            // One order a millisecond reaches the sensing.
            self.idle(0.002);
        }
        self.machine.board.plant.place(&Grasp::Free)?;
        self.motion(Request::RecordFriction, Directive::Watch)
    }

    /// Closes on an object (or on nothing), probes and holds. The finger stays closed on a contact.
    ///
    /// # Errors
    /// The object cannot be there; the sequence refused.
    pub fn close(&mut self, grasp: &Grasp) -> Result<Outcome, Error> {
        self.close_while(grasp, |_, _| {})
    }

    /// The same while something else happens: `meanwhile` is called after every sample, with the world and where the sequence
    /// is.
    ///
    /// # Errors
    /// As [`close`](Self::close).
    pub fn close_while(
        &mut self,
        grasp: &Grasp,
        meanwhile: impl FnMut(&mut Plant, State),
    ) -> Result<Outcome, Error> {
        self.machine.board.plant.place(grasp)?;
        self.motion_while(Request::Close, Directive::Watch, meanwhile)
    }

    /// Takes the object out of the hand, then opens. (An object that has slipped past the fingertip would jam the opening
    /// finger from behind.)
    ///
    /// # Errors
    /// The sequence refused.
    pub fn open(&mut self) -> Result<Outcome, Error> {
        self.machine.board.plant.place(&Grasp::Free)?;
        self.motion(Request::Open, Directive::Watch)
    }

    /// Closes on a pin of the diameter that the scene asks for, fixed at a known place, learns from it, opens.
    ///
    /// # Errors
    /// No such place; the sequence refused.
    pub fn calibrate(&mut self, phalanx: u8, k_m: f32, theta_1_rad: f64) -> Result<Outcome, Error> {
        let pin = Shape::Cylinder {
            diameter_m: 2.0 * f64::from(S::settings().pin_radius_m),
        };
        let grasp = Grasp::touching(phalanx, k_m.into(), theta_1_rad, pin);
        let object = self.plant().parameters().object;
        self.plant().mount(&Object {
            mount: ObjectMount::Fixed,
            ..object
        })?;
        self.plant().place(&grasp)?;
        let outcome = self.motion(Request::Close, Directive::Calibrate { phalanx, k_m })?;
        self.open()?;
        self.plant().mount(&object)?;
        Ok(outcome)
    }

    /// Calibrates on pins at these shares of the last phalanx, whose length is given, with joint 1 at an angle.
    ///
    /// # Errors
    /// As [`calibrate`](Self::calibrate).
    pub fn calibrate_on_pins(
        &mut self,
        length_m: f64,
        shares: [f64; 2],
        theta_1_rad: f64,
    ) -> Result<(), Error> {
        for share in shares {
            #[expect(clippy::cast_possible_truncation, reason = "the firmware's precision")]
            self.calibrate(S::PHALANGES, (share * length_m) as f32, theta_1_rad)?;
        }
        Ok(())
    }

    /// A motion until the sequence rests again, and what it showed.
    ///
    /// # Errors
    /// The sequence refused.
    pub fn motion(&mut self, request: Request, closing: Directive) -> Result<Outcome, Error> {
        self.motion_while(request, closing, |_, _| {})
    }

    fn motion_while(
        &mut self,
        request: Request,
        closing: Directive,
        mut meanwhile: impl FnMut(&mut Plant, State),
    ) -> Result<Outcome, Error> {
        let machine = &mut self.machine;
        machine.slow.events.clear();
        machine.slow.followed.clear();
        machine.slow.samples.clear();
        machine.slow.fault = None;
        machine
            .slow
            .request(request, closing)
            .map_err(Error::Refused)?;
        let mut trace = Vec::new();
        let mut left = Machine::<Slow<S>>::samples(LONGEST_S);
        let mut started = false;
        let mut resting = false;
        while left > 0 {
            let sample = machine.until_sample();
            meanwhile(&mut machine.board.plant, machine.slow.state());
            if self.traced {
                let truth = machine.board.plant.truth();
                trace.push(Row::new(&sample, machine.outputs(), &truth));
            }
            let rests = matches!(machine.slow.state(), State::Idle | State::Fault);
            started |= !rests;
            if started && rests && !resting {
                resting = true;
                left = Machine::<Slow<S>>::samples(AFTERWARDS_S);
            }
            left -= 1;
        }
        let truth = machine.board.plant.truth();
        let events = std::mem::take(&mut machine.slow.events);
        Ok(Outcome {
            verdict: verdict(&events, machine.slow.fault),
            first_contact: truth.first_contact,
            fault: machine.slow.fault,
            events,
            followed: std::mem::take(&mut machine.slow.followed),
            samples: std::mem::take(&mut machine.slow.samples),
            truth,
            trace,
        })
    }
}

/// One grasp from power-on.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The world.
    pub parameters: Parameters,
    /// What is grasped.
    pub grasp: Grasp,
    /// Seed of everything random.
    pub seed: u64,
    /// Pins at these places (phalanx, metre) first.
    pub calibrate: Vec<(u8, f32)>,
    /// Keep the samples of the closing.
    pub traced: bool,
}

/// Runs a scenario: friction, calibration, grasp. A fault on the way is the outcome.
///
/// # Errors
/// A parameter, an object or the scene is not valid.
pub fn run<S: Simulated>(scenario: &Scenario) -> Result<Outcome, Error> {
    let mut simulation = Simulation::<S>::new(&scenario.parameters, scenario.seed)?;
    let mut last = simulation.prepare()?;
    for &(phalanx, k_m) in &scenario.calibrate {
        if last.fault.is_none() {
            last = simulation.calibrate(phalanx, k_m, MIDDLE_RAD)?;
        }
    }
    if last.fault.is_some() {
        return Ok(last);
    }
    simulation.traced = scenario.traced;
    simulation.close(&scenario.grasp)
}

/// theta_1 at which pins are placed, radian.
const MIDDLE_RAD: f64 = 0.8;
