//! The slow loop of the simulation: connects the library's two halves.

use crate::{Simulated, SlowLoop};
use palpate::app::console::settings::Overrides;
use palpate::app::grasp::sensing::{SensingRequest, followed_notice, notice};
use palpate::app::grasp::{ContactSensing, Coordinator};
use palpate::drive::demand::{Demand, Status};
use palpate::drive::fault::Fault;
use palpate::drive::sequence::{Notice, Refused, Request, State};
use palpate::sample::Sample;
use palpate::scene::SampleOf;
use palpate::sensing::{Directive, Event, Followed};

/// Both halves, and what they said.
#[derive(Clone, Debug)]
pub struct Slow<S: Simulated> {
    /// Sensing.
    pub sensing: ContactSensing<S>,
    /// Motion.
    pub coordinator: Coordinator<S>,
    /// Events with the time they were told, microseconds since reset.
    pub events: Vec<(u64, Event)>,
    /// What followed the first contact, as `events`, in scenes with that option.
    pub followed: Vec<(u64, Followed)>,
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
            sensing: ContactSensing::new(),
            coordinator: Coordinator::new(Overrides::default(), 0),
            events: Vec::new(),
            followed: Vec::new(),
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
        self.coordinator.request(request, closing)
    }

    /// Where the sequence is.
    #[must_use]
    pub fn state(&self) -> State {
        self.coordinator.state()
    }
}

impl<S: Simulated> SlowLoop for Slow<S> {
    type Joint = S::Joint;

    fn sample(&mut self, sample: &SampleOf<S>, status: &Status) -> Demand {
        self.samples.push((self.directive, sample.with_joint(())));
        let told = self.sensing.sample(sample);
        if let Some(event) = told {
            self.coordinator.event(&event);
            self.events.push((sample.time_us, event));
            self.notice = notice::<S>(&event).or(self.notice);
        }
        if let Some(followed) = self.sensing.follow(sample, told.as_ref()) {
            self.followed.push((sample.time_us, followed));
            self.notice = followed_notice(&followed).or(self.notice);
        }
        let step = self
            .coordinator
            .advance(sample.time_us, status, self.notice.take());
        self.fault = self.fault.or(step.motion.fault);
        if let Some(request) = step.request {
            if let SensingRequest::Direct(directive) = request {
                self.directive = directive;
            }
            self.sensing.request(request);
        }
        step.motion.demand
    }
}
