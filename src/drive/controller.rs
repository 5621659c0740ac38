//! The control interrupt's work as a pure function: inputs and demand to outputs.

use super::config::{Config, OutOfRange};
use super::convert::Scale;
use super::demand::{Demand, Status};
use super::io::{Inputs, Outputs};
use crate::sample::Sample;

/// State of the control loop.
#[derive(Clone, Debug)]
pub struct Controller {
    scale: Scale,
    status: Status,
    sample: Option<Sample>,
}

impl Controller {
    /// A controller at rest.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn new(config: &Config) -> Result<Self, OutOfRange> {
        Ok(Self {
            scale: Scale::new(config)?,
            status: Status::default(),
            sample: None,
        })
    }

    /// One control period (50 us): what was measured, what is wanted, what the bridge shall do.
    pub fn step(&mut self, _inputs: &Inputs, _demand: &Demand) -> Outputs {
        Outputs::Off
    }

    /// The 1 ms average completed by the last step, once: every twentieth call of [`step`](Self::step) makes one.
    pub fn sample(&mut self) -> Option<Sample> {
        self.sample.take()
    }

    /// What the slow loop wants to know, as of the last step.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// The scales of this board and drivetrain.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }
}
