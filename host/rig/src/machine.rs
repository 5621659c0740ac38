//! The control interrupt and the slow loop, in step with the board, as the firmware schedules them.

use crate::{Board, PERIOD_S};
use palpate::drive::config::{Config, OutOfRange};
use palpate::drive::controller::Controller;
use palpate::drive::demand::{Demand, Status};
use palpate::drive::io::Outputs;
use palpate::sample::Sample;

/// What runs once a sample.
pub trait SlowLoop {
    /// Takes a sample and the state of the motor, returns what the motor shall do.
    fn sample(&mut self, sample: &Sample, status: &Status) -> Demand;
}

/// A board with the firmware's control loop and a slow loop.
#[derive(Clone, Debug)]
pub struct Machine<S> {
    /// The world and its connection.
    pub board: Board,
    /// The control interrupt.
    pub controller: Controller,
    /// The slow loop.
    pub slow: S,
    demand: Demand,
    outputs: Outputs,
}

impl<S: SlowLoop> Machine<S> {
    /// A machine just out of reset.
    ///
    /// # Errors
    /// A parameter of the drive's configuration is out of its range.
    pub fn new(board: Board, config: &Config, slow: S) -> Result<Self, OutOfRange> {
        Ok(Self {
            board,
            controller: Controller::new(config)?,
            slow,
            demand: Demand::default(),
            outputs: Outputs::Off,
        })
    }

    /// Runs until the controller hands out a sample, and gives that to the slow loop. Returns the sample.
    pub fn until_sample(&mut self) -> Sample {
        loop {
            self.board.period(self.outputs);
            self.outputs = self.controller.step(&self.board.inputs(), &self.demand);
            if let Some(sample) = self.controller.sample() {
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
