//! The control interrupt and the slow loop, in step with the board, as the firmware schedules them.

use crate::{Board, PERIOD_S};
use palpate::drive::config::{CheckedConfig, Config, OutOfRange};
use palpate::drive::controller::Controller;
use palpate::drive::demand::{Demand, Status};
use palpate::drive::io::Outputs;
use palpate::joint_sensor::JointSensor;
use palpate::sample::Sample;

/// What runs once a sample.
pub trait SlowLoop {
    /// How joint 2 is read.
    type Joint: JointSensor;

    /// Takes a sample and the state of the motor, returns what the motor shall do.
    fn sample(&mut self, sample: &SampleOf<Self>, status: &Status) -> Demand;
}

/// A sample for a slow loop.
pub type SampleOf<S> = Sample<<<S as SlowLoop>::Joint as JointSensor>::Reading>;

/// A board with the firmware's control loop and a slow loop.
#[derive(Clone, Debug)]
pub struct Machine<S: SlowLoop> {
    /// The world and its connection.
    pub board: Board,
    /// The control interrupt.
    pub controller: Controller,
    /// The slow loop.
    pub slow: S,
    joint: S::Joint,
    demand: Demand,
    outputs: Outputs,
}

impl<S: SlowLoop> Machine<S> {
    /// A machine just out of reset; `joint` reads joint 2.
    ///
    /// # Errors
    /// A parameter of the drive's configuration is out of its range.
    pub fn new(
        board: Board,
        config: &Config,
        joint: S::Joint,
        slow: S,
    ) -> Result<Self, OutOfRange> {
        Ok(Self {
            board,
            controller: Controller::new(&CheckedConfig::new(*config)?),
            slow,
            joint,
            demand: Demand::default(),
            outputs: Outputs::Off,
        })
    }

    /// Runs until the controller hands out a sample, and gives that to the slow loop. Returns the sample.
    pub fn until_sample(&mut self) -> SampleOf<S> {
        loop {
            self.board.period(self.outputs);
            self.outputs = self.controller.step(&self.board.inputs(), &self.demand);
            if let Some(sample) = self.controller.sample() {
                let raw = S::Joint::take(|| self.board.joint_code().0);
                let sample = sample.with_joint(self.joint.reading(raw));
                self.demand = self.slow.sample(&sample, self.controller.status());
                return sample;
            }
        }
    }

    /// Demand in force.
    #[must_use]
    pub fn demand(&self) -> &Demand {
        &self.demand
    }

    /// What the controller decided in the last period; the board takes it over with the next.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// Samples in a duration, second.
    #[must_use]
    pub fn samples(seconds: f64) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number of samples"
        )]
        let samples = (seconds / (20.0 * PERIOD_S)).round().max(0.0) as u64;
        samples
    }
}
