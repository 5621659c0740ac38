//! The slow loop of the simulation: the library's two halves, each told what the other found.

use crate::{Simulated, SlowLoop};
use palpate::app::console::settings::Overrides;
use palpate::app::sense::{Order, notice};
use palpate::app::{Conduct, Sense};
use palpate::drive::demand::{Demand, Status};
use palpate::drive::fault::Fault;
use palpate::drive::sequence::{Notice, Refused, Request, State};
use palpate::sample::Sample;
use palpate::scene::{JointPin, SampleOf};
use palpate::sensing::{Directive, Event};

/// Both halves, and what they said.
#[derive(Clone, Debug)]
pub struct Slow<S: Simulated> {
    /// Sensing.
    pub sense: Sense<S>,
    /// Motion.
    pub conduct: Conduct<S>,
    /// Events with the time they were told, microseconds since reset.
    pub events: Vec<(u64, Event)>,
    /// Samples with what each was good for; without the reading of joint 2, which not every scene has.
    pub samples: Vec<(Directive, Sample)>,
    /// First fault since it was last taken.
    pub fault: Option<Fault>,
    directive: Directive,
    notice: Option<Notice>,
}

impl<S: Simulated> Default for Slow<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Simulated> Slow<S> {
    /// A slow loop at rest, without calibration or friction record.
    #[must_use]
    pub fn new() -> Self {
        Self {
            sense: Sense::new(),
            conduct: Conduct::new(Overrides::default()),
            events: Vec::new(),
            samples: Vec::new(),
            fault: None,
            directive: Directive::Rest,
            notice: None,
        }
    }

    /// Asks for a motion, with what a closing in it is for.
    ///
    /// # Errors
    /// The sequence is busy or faulted.
    pub fn request(&mut self, request: Request, closing: Directive) -> Result<(), Refused> {
        self.conduct.request(request, closing)
    }

    /// Where the sequence is.
    #[must_use]
    pub fn state(&self) -> State {
        self.conduct.state()
    }
}

impl<S: Simulated> SlowLoop for Slow<S> {
    type Input = JointPin<S>;

    fn sample(&mut self, sample: &SampleOf<S>, status: &Status) -> Demand {
        self.samples.push((self.directive, sample.with_joint(())));
        if let Some(event) = self.sense.sample(sample) {
            self.conduct.hear(&event, status);
            self.events.push((sample.time_us, event));
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
