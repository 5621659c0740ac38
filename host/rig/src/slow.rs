//! The slow loop of the simulation: motion sequence and sensing, each told what the other found.

use crate::{Simulated, SlowLoop};
use palpate::drive::convert::Scale;
use palpate::drive::demand::{Demand, Status};
use palpate::drive::fault::Fault;
use palpate::drive::sequence::{Notice, Refused, Request, Sequence, State};
use palpate::finger::ConfigError;
use palpate::sample::Sample;
use palpate::sensing::{Directive, Event, NoHall, Sensor};

/// Sequence, sensor, and what they said.
#[derive(Clone, Debug)]
pub struct Slow<S: Simulated> {
    /// Sensing.
    pub sensor: Sensor<S::Finger, NoHall>,
    /// Events with the time they were told, microseconds since reset.
    pub events: Vec<(u64, Event)>,
    /// First fault since it was last taken.
    pub fault: Option<Fault>,
    sequence: Sequence,
    /// What a closing is for.
    closing: Directive,
    directive: Directive,
    notice: Option<Notice>,
}

impl<S: Simulated> Slow<S> {
    /// A slow loop at rest, without calibration or friction record.
    ///
    /// # Errors
    /// The scene's finger is not valid.
    pub fn new(scale: Scale) -> Result<Self, ConfigError> {
        let finger = S::finger()?;
        let drivetrain = S::drivetrain(&finger);
        Ok(Self {
            sensor: Sensor::new(finger, drivetrain, S::settings(), S::UNCALIBRATED),
            events: Vec::new(),
            fault: None,
            sequence: Sequence::new(S::MOTION, scale),
            closing: Directive::Watch,
            directive: Directive::Rest,
            notice: None,
        })
    }

    /// Asks for a motion, with what a closing in it is for.
    ///
    /// # Errors
    /// The sequence is busy or faulted.
    pub fn request(&mut self, request: Request, closing: Directive) -> Result<(), Refused> {
        self.closing = closing;
        self.sequence.request(request)
    }

    /// Where the sequence is.
    #[must_use]
    pub fn state(&self) -> State {
        self.sequence.state()
    }
}

impl<S: Simulated> SlowLoop for Slow<S> {
    fn sample(&mut self, sample: &Sample, status: &Status) -> Demand {
        if let Some(event) = self.sensor.update(sample) {
            self.events.push((sample.time_us, event));
            self.notice = notice(&event).or(self.notice);
        }
        let advance = self
            .sequence
            .advance(sample.time_us, status, self.notice.take());
        self.fault = self.fault.or(advance.fault);
        let directive = match self.sequence.state() {
            State::RecordClosing | State::RecordOpening => Directive::RecordFriction,
            State::Close | State::Probe => self.closing,
            _ => Directive::Rest,
        };
        if directive != self.directive {
            self.directive = directive;
            self.sensor.direct(directive);
        }
        advance.demand
    }
}

/// What an event means to the sequence.
fn notice(event: &Event) -> Option<Notice> {
    match event {
        Event::Touch { .. } => Some(Notice::Touched),
        Event::FrictionRecorded { .. } => Some(Notice::FrictionKnown),
        Event::FrictionStale { .. } => Some(Notice::FrictionUnknown),
        Event::Located { settled, .. } | Event::Ambiguous { settled, .. } => {
            settled.then_some(Notice::Settled)
        }
        Event::NotLocated { .. } => Some(Notice::Settled),
        _ => None,
    }
}
