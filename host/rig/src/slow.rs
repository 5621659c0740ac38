//! The slow loop of the simulation: the firmware's own two halves, motion and sensing, called as its tasks call them.

use crate::{Error, Simulated, SlowLoop};
use palpate::app::command::Command;
use palpate::app::conduct::Conduct;
use palpate::app::sense::{Order, Sense, notice};
use palpate::app::settings::Overrides;
use palpate::drive::demand::{Demand, Status};
use palpate::drive::fault::Fault;
use palpate::drive::sequence::{Notice, State};
use palpate::sample::Sample;
use palpate::sensing::{Directive, Event, Sensor};

/// Both halves, and what they said.
#[derive(Clone, Debug)]
pub struct Slow<S: Simulated> {
    sense: Sense<S>,
    conduct: Conduct<S>,
    /// Events with the time they were told, microseconds since reset.
    pub events: Vec<(u64, Event)>,
    /// Samples with what each was good for.
    pub samples: Vec<(Directive, Sample)>,
    /// First fault since it was last taken.
    pub fault: Option<Fault>,
    directive: Directive,
    notice: Option<Notice>,
}

impl<S: Simulated> Slow<S> {
    /// A slow loop at rest, without calibration or friction record.
    ///
    /// # Errors
    /// The scene is not valid.
    pub fn new() -> Result<Self, Error> {
        Ok(Self {
            sense: Sense::new().map_err(Error::Finger)?,
            conduct: Conduct::new(Overrides::default()).map_err(Error::Drive)?,
            events: Vec::new(),
            samples: Vec::new(),
            fault: None,
            directive: Directive::Rest,
            notice: None,
        })
    }

    /// What a user would type.
    ///
    /// # Errors
    /// The sequence is busy or faulted.
    pub fn command(&mut self, command: Command) -> Result<(), Error> {
        self.conduct.command(command).map_err(Error::Refused)?;
        Ok(())
    }

    /// The sensing, to look at.
    #[must_use]
    pub fn sensor(&self) -> &Sensor<S::Finger> {
        self.sense.sensor()
    }

    /// Where the sequence is.
    #[must_use]
    pub fn state(&self) -> State {
        self.conduct.state()
    }

    /// Forgets what was said and sampled before.
    pub fn begin(&mut self) {
        self.events.clear();
        self.samples.clear();
        self.fault = None;
    }
}

impl<S: Simulated> SlowLoop for Slow<S> {
    fn sample(&mut self, sample: &Sample, status: &Status) -> Demand {
        self.samples.push((self.directive, *sample));
        if let Some(event) = self.sense.sample(sample) {
            self.events.push((sample.time_us, event));
            self.conduct.hear(&event, status);
            self.notice = notice(&event).or(self.notice);
        }
        let conducted = self
            .conduct
            .advance(sample.time_us, status, self.notice.take());
        self.fault = self.fault.or(conducted.advance.fault);
        if let Some(order) = conducted.order {
            if let Order::Direct(directive) = order {
                self.directive = directive;
            }
            self.sense.order(order);
        }
        conducted.advance.demand
    }
}
