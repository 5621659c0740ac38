//! The sensor: samples and directives in, events out.
//!
//! | stage | what runs | where |
//! |---|---|---|
//! | free motion recorded | [`Recorder`] | `record` |
//! | closing, nothing felt | [`Detector`] on the residual of the record | `search` |
//! | contact | [`Curve`](super::curve::Curve), and every block one step of the [`Locator`](super::locator::Locator) | `touch`, `press` |
//! | what there is to say | a location, an ambiguity, a reason why not | `report` |
//! | motion over | the locator until its fits stand still, one step every dozen samples; then the last word | `last_word` |
//! | contact at a known place, or with the stop | the calibration | `learn` |

mod last_word;
mod learn;
mod press;
mod record;
mod report;
mod search;
mod touch;

use crate::finger::Mechanics;
use crate::sensing::block::{Block, Gate, Step};
use crate::sensing::detector::Detector;
use crate::sensing::friction::{Friction, Recorder};
use crate::sensing::joint::{JointSensor, NoHall};
use crate::sensing::{Calibration, Directive, Drive, Drivetrain, Event, Sample, Settings};
use core::mem;
use heapless::Deque;
use search::{HISTORY, Past};
use touch::Touching;

/// Error of the friction beyond the record, continued periodically, as a share of its unevenness within (R, chosen).
const UNSURE_BEYOND: f32 = 0.15;

/// What is in hand. Never two at a time: they share their memory.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put one on")]
enum Work<R> {
    Nothing,
    /// Friction is being recorded.
    Recording(Recorder),
    /// A contact is being judged.
    Contact(Touching<R>),
}

/// Contact sensing of one finger. See the module documentation.
///
/// `H` is [`NoHall`] or [`Hall`](crate::sensing::Hall).
#[derive(Clone, Debug)]
pub struct Sensor<F: Mechanics, H: JointSensor = NoHall> {
    finger: F,
    drivetrain: Drivetrain,
    settings: Settings,
    calibration: Calibration,
    directive: Directive,
    gate: Gate,
    friction: Option<Friction>,
    work: Work<H::Reading>,
    detector: Option<Detector>,
    history: Deque<Past<H::Reading>, HISTORY>,
    /// The contact of this closing has been judged, or what was found was no contact.
    done: bool,
    stale_told: bool,
    posture: F::Configuration,
    reading: H::Reading,
    /// Change of theta_2 since contact, as the last verdict took it into account.
    joint_change: H::Reading,
    events: Deque<Event, 4>,
}

impl<F: Mechanics, H: JointSensor> Sensor<F, H> {
    /// A sensor without friction record.
    pub fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        let posture = finger.rest();
        Self {
            finger,
            drivetrain,
            settings,
            calibration,
            directive: Directive::Rest,
            gate: Gate::default(),
            friction: None,
            work: Work::Nothing,
            detector: None,
            history: Deque::new(),
            done: false,
            stale_told: false,
            posture,
            reading: H::Reading::default(),
            joint_change: H::Reading::default(),
            events: Deque::new(),
        }
    }

    /// The finger.
    pub fn finger(&self) -> &F {
        &self.finger
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Other settings, from the next closing on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Nominal efficiency of the drivetrain, 0 to 1, from the next closing on; anything else is ignored.
    pub fn set_efficiency(&mut self, efficiency: f32) {
        if efficiency > 0.0 && efficiency <= 1.0 {
            self.drivetrain.efficiency = efficiency;
        }
    }

    /// Change of theta_2 since contact, as the last word on a contact took it into account.
    pub fn joint_change(&self) -> H::Reading {
        self.joint_change
    }

    /// The friction record.
    pub fn friction(&self) -> Option<&Friction> {
        self.friction.as_ref()
    }

    /// Takes a record that was kept. One that is not valid is ignored, and said so by `false`.
    pub fn set_friction(&mut self, friction: Friction) -> bool {
        let valid = friction.is_valid();
        if valid {
            self.friction = Some(friction);
        }
        valid
    }

    /// What is known of torque factor and cable.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Takes a calibration that was kept, or the nominal one. One that is not valid is ignored, and said so by `false`.
    pub fn set_calibration(&mut self, calibration: Calibration) -> bool {
        let valid = calibration.is_valid();
        if valid {
            self.calibration = calibration;
        }
        valid
    }

    /// What the samples from now on are good for. A contact in hand is judged with what is there; the same directive
    /// again starts anew.
    pub fn direct(&mut self, directive: Directive) {
        if self.directive == Directive::RecordFriction
            && directive != Directive::RecordFriction
            && let Work::Recording(mut recorder) = mem::replace(&mut self.work, Work::Nothing)
        {
            self.end_recording(&mut recorder);
        }
        if directive == Directive::Rest && matches!(self.work, Work::Contact(_)) {
            // The last word is still to be said, under the old directive; nothing but that comes after.
            self.end_motion();
            return;
        }
        self.directive = directive;
        self.detector = None;
        self.done = false;
        self.stale_told = false;
        self.history.clear();
        self.work = match directive {
            Directive::RecordFriction => Work::Recording(Recorder::new(self.travel_counts())),
            _ => Work::Nothing,
        };
    }

    /// Takes a sample; tells at most one thing. Typically some hundred instructions; every block of a contact, and
    /// after its end for some tens of samples, one step of a fit.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub fn update(&mut self, sample: &Sample<H::Reading>) -> Option<Event> {
        self.reading = sample.joint;
        match self.gate.push(sample, &self.drivetrain, &self.settings) {
            Step::Pending => {}
            Step::Block(block) => self.take(&block),
            Step::Ended => self.end_run(),
        }
        self.conclude();
        self.events.pop_front()
    }

    fn travel_counts(&self) -> i32 {
        // Saturates where nonsense was set.
        (self.settings.travel_rad / self.drivetrain.rad_per_count) as i32
    }

    fn tell(&mut self, event: Event) {
        // Four wait at most: a touch, a location, staleness and a calibration. A fifth would repeat one of them.
        let _ = self.events.push_back(event);
    }

    fn take(&mut self, block: &Block) {
        match self.directive {
            Directive::Rest => {}
            Directive::RecordFriction => {
                if let Work::Recording(recorder) = &mut self.work {
                    recorder.push(block);
                }
            }
            // What comes after the finger has opened is another closing.
            _ if block.drive != Drive::Closing => self.done = false,
            _ if self.done => {}
            _ => {
                let past = self.past(block);
                match (&self.work, past) {
                    (Work::Contact(touching), Some(past)) if touching.last_steps.is_none() => {
                        self.with_contact(|sensor, touching| sensor.press(touching, &past));
                    }
                    (Work::Contact(_), _) | (_, None) => {}
                    (_, Some(past)) => self.search(block, past),
                }
            }
        }
    }

    /// Does something with the contact in hand, which lies on the stack meanwhile: not inlined, so that it does not lie there
    /// for the other users of the caller's frame too.
    #[inline(never)]
    fn with_contact(&mut self, act: impl FnOnce(&mut Self, &mut Touching<H::Reading>)) {
        match mem::replace(&mut self.work, Work::Nothing) {
            Work::Contact(mut touching) => {
                act(self, &mut touching);
                self.work = Work::Contact(touching);
            }
            other => self.work = other,
        }
    }

    fn end_run(&mut self) {
        if let Work::Recording(recorder) = &mut self.work {
            recorder.end_run();
        }
        self.detector = None;
        self.history.clear();
        self.end_motion();
    }

    fn end_motion(&mut self) {
        if let Work::Contact(touching) = &mut self.work {
            touching.end();
        }
    }
}
