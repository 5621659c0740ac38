//! The sensor: samples and directives in, events out.
//!
//! | stage | what runs | where |
//! |---|---|---|
//! | free motion recorded, and the free part of every closing since | [`Pass`](super::friction::Pass), [`Assessment`](super::friction::Assessment) | `record` |
//! | first closing with a record of before a restart | [`Alignment`](super::friction::Alignment) | `search` |
//! | closing, nothing felt | [`Detector`](super::detector::Detector) on the residual of the record | `search` |
//! | contact | [`Curve`](super::curve::Curve), and every block one pass of the [`Locator`](super::locator::Locator), a few points a sample | `contact` |
//! | what there is to say | a location, an ambiguity, a reason why not | `report` |
//! | motion over | the locator's last rounds, a few points a sample; then the last word | `contact` |
//! | contact at a known place, or with the stop | the calibration | `calibrate` |

mod beside;
mod calibrate;
mod contact;
mod known;
mod record;
mod report;
mod search;
mod weight;

use crate::finger::Mechanics;
use crate::sensing::block::{Block, Gate, Step};
use crate::sensing::friction::Friction;
use crate::sensing::joint::{JointSensor, NoHall};
use crate::sensing::location::{Cable, Series};
use crate::sensing::{Calibration, Directive, Drive, Drivetrain, Event, Sample, Settings};
use contact::Contact;
use known::Known;
use record::Learning;
pub use search::Suspicion;
use search::{Found, Search};

/// The current stage. Never two at a time: they share their memory.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put one on")]
enum Work<F: Mechanics, R, X: Series> {
    Nothing,
    /// The finger closes, and nothing has been felt.
    Searching(Search<R>),
    /// A contact is being judged.
    Contact(Contact<F, R, X>),
}

/// Contact sensing of one finger. See the module documentation.
///
/// ```
/// use palpate::scene::Scene;
/// use palpate::sensing::{Directive, Drive, Sample, Sensor};
/// use palpate_scenes::P70;
///
/// let finger = P70::MECHANISM;
/// let mut sensor: Sensor<<P70 as Scene>::Finger> =
///     Sensor::new(finger, P70::drivetrain(&finger), P70::settings(), P70::UNCALIBRATED);
/// sensor.direct(Directive::RecordFriction);
/// // A sample a millisecond, from the chip or from a recording.
/// let sample = Sample {
///     time_us: 1_000,
///     position_counts: 0,
///     current_a: 0.015,
///     drive: Drive::Closing,
///     joint: (),
/// };
/// assert_eq!(sensor.update(&sample), None);
/// ```
///
/// `H` is [`NoHall`] or [`Hall`](crate::sensing::Hall); `X` is [`Cable`] or [`Rigid`](crate::sensing::Rigid).
// In this order for the reach of instructions, as in `Known`.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Sensor<F: Mechanics, H: JointSensor = NoHall, X: Series = Cable> {
    gate: Gate,
    /// The contact of this closing has been judged, or what was found was no contact.
    done: bool,
    known: Known<F, H, X>,
    work: Work<F, H::Reading, X>,
    learning: Learning,
}

impl<F: Mechanics, H: JointSensor, X: Series> Sensor<F, H, X> {
    /// A sensor without friction record.
    pub fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        Self {
            known: Known::new(finger, drivetrain, settings, calibration),
            gate: Gate::default(),
            work: Work::Nothing,
            learning: Learning::default(),
            done: false,
        }
    }

    /// The finger.
    pub fn finger(&self) -> &F {
        &self.known.finger
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.known.settings
    }

    /// Other settings, from the next closing on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.known.settings = settings;
    }

    /// Nominal efficiency of the drivetrain, 0 to 1, from the next closing on; anything else is ignored.
    pub fn set_efficiency(&mut self, efficiency: f32) {
        if efficiency > 0.0 && efficiency <= 1.0 {
            self.known.drivetrain.efficiency = efficiency;
        }
    }

    /// How near the search for a contact is to a decision; `None` while it does not search.
    pub fn suspicion(&self) -> Option<Suspicion> {
        match &self.work {
            Work::Searching(search) => search.suspicion(),
            _ => None,
        }
    }

    /// Change of theta_2 since contact, as the last word on a contact took it into account.
    pub fn joint_change(&self) -> H::Reading {
        self.known.joint_change
    }

    /// The friction record.
    pub fn friction(&self) -> Option<&Friction> {
        self.known.friction.as_ref()
    }

    /// Takes a record of the same zero. One that is not valid is ignored, and said so by `false`.
    pub fn set_friction(&mut self, friction: Friction) -> bool {
        let valid = friction.is_valid();
        if valid {
            self.known.friction = Some(friction);
            self.known.shift_counts = Some(0);
            self.known.shift_sigma_counts = 0.0;
        }
        valid
    }

    /// Takes a record that was kept over a restart, which found another zero: the first closing aligns it, and feels nothing
    /// until it has. One that is not valid is ignored, and said so by `false`.
    pub fn restore_friction(&mut self, friction: Friction) -> bool {
        let valid = self.set_friction(friction);
        if valid {
            self.known.shift_counts = None;
        }
        valid
    }

    /// The encoder's zero is another one from now on: the first closing aligns the record, as after a restart.
    pub fn realign(&mut self) {
        self.known.shift_counts = None;
    }

    /// What is known of torque factor and cable.
    pub fn calibration(&self) -> &Calibration {
        &self.known.calibration
    }

    /// Takes a calibration that was kept, or the nominal one. One that is not valid is ignored, and said so by `false`.
    pub fn set_calibration(&mut self, calibration: Calibration) -> bool {
        let valid = calibration.is_valid();
        if valid {
            self.known.calibration = calibration;
        }
        valid
    }

    /// What the samples from now on are good for. A contact under way is judged with the samples so far; the same directive
    /// again restarts the stage.
    pub fn direct(&mut self, directive: Directive) {
        let known = &mut self.known;
        if matches!(directive, Directive::RecordFriction) {
            let empty = Friction::empty(known.travel_counts(), &known.drivetrain);
            self.learning.begin(empty);
        } else {
            self.learning.end_recording(known);
        }
        if matches!(directive, Directive::Rest)
            && let Work::Contact(contact) = &mut self.work
        {
            // The last word is still to be said, under the old directive; nothing but that comes after.
            contact.end();
            return;
        }
        known.directive = directive;
        known.last_residual = None;
        known.stale_told = false;
        self.done = false;
        self.work = Work::Nothing;
    }

    /// Takes a sample; returns at most one event. Typically some hundred instructions; after every block of a contact, and
    /// after its end for some hundreds of samples, some points of a fit's pass over the curve.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub fn update(&mut self, sample: &Sample<H::Reading>) -> Option<Event> {
        self.known.reading = sample.joint;
        self.known.position_counts = sample.position_counts;
        let known = &self.known;
        match self.gate.push(sample, &known.drivetrain, &known.settings) {
            Step::Pending => {}
            Step::Block(block) => self.take(&block),
            Step::Ended => self.end_run(),
        }
        self.judge();
        let searching = matches!(self.work, Work::Searching(_) | Work::Contact(_));
        self.learning.step(&mut self.known, searching);
        self.known.events.pop_front()
    }

    fn take(&mut self, block: &Block) {
        match self.known.directive {
            Directive::Rest => {}
            Directive::RecordFriction => self.learning.record(block),
            // What comes after the finger has opened is another closing.
            _ if block.drive != Drive::Closing => self.done = false,
            _ if self.done => self.known.remember(block),
            _ => self.feel(block),
        }
    }

    /// A block of a closing.
    fn feel(&mut self, block: &Block) {
        let known = &mut self.known;
        if let Work::Nothing = self.work {
            Search::begin(&mut self.work);
        }
        let Some(past) = known.past(block) else {
            return;
        };
        if let Work::Searching(_) = self.work {
            self.learning.watch(known, block, &past);
        }
        if let Work::Contact(_) = self.work {
            known.remember(block);
        }
        match &mut self.work {
            Work::Contact(contact) => known.press(contact, &past),
            Work::Searching(search) => match known.search(search, block, past) {
                Found::Nothing => {}
                Found::Over => {
                    self.learning.forget();
                    self.done = true;
                }
                Found::Contact(found) => {
                    self.learning.cut(known, &found.onset);
                    self.begin_contact(block, &found);
                }
            },
            Work::Nothing => {}
        }
    }

    fn end_run(&mut self) {
        if let Work::Searching(search) = &self.work
            && let Some(suspect) = search.suspect()
        {
            self.learning.cut(&self.known, &suspect);
        }
        self.learning.end_run(&self.known);
        // A closing that was unusual has said so.
        let free = matches!(self.work, Work::Searching(_)) && !self.done;
        self.known.conclude_closing(free);
        match &mut self.work {
            Work::Nothing => {}
            Work::Searching(_) => self.work = Work::Nothing,
            Work::Contact(contact) => contact.end(),
        }
    }
}
