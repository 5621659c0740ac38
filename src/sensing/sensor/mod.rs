//! The sensor: samples and directives in, events out.
//!
//! | stage | what runs | where |
//! |---|---|---|
//! | free motion recorded, and the free part of every closing since | [`Pass`](super::friction::Pass), [`Assessment`](super::friction::Assessment) | `record` |
//! | first closing with a record of before a restart | [`Alignment`](super::friction::Alignment) | `search` |
//! | closing, nothing felt | [`Detector`](super::detector::Detector) on the residual of the record | `search` |
//! | contact | [`Curve`](super::curve::Curve) (`collector`), and every block one pass of the [`Locator`](super::locator::Locator), a few points a sample | `contact` |
//! | what there is to say | a location, an ambiguity, a reason why not | `report` |
//! | motion over | the locator's last rounds, a few points a sample; then the last word | `contact` |
//! | end of a closing | `K_a` against that of a free finger (7) | `global` |
//! | contact at a known place, or with the stop | the calibration | `calibrate` |

mod beside;
mod calibrate;
mod collector;
mod contact;
#[cfg(not(weightless))]
mod free_closing;
mod global;
mod record;
mod report;
mod search;
mod state;
#[cfg(all(test, feature = "firmware"))]
mod tests;
mod weight;

use crate::finger::{MAX_PHALANGES, Mechanics};
use crate::joint_sensor::{JointSensor, NoJointSensor};
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::friction::Friction;
use crate::sensing::location::{Cable, SeriesElement};
use crate::sensing::torque_constant::TorqueConstant;
use crate::sensing::{
    Calibration, Directive, Drive, Drivetrain, Event, Object, Refusal, Sample, Settings,
};
pub(super) use collector::{FADED_SHARE, LOST_SIGMAS};
use contact::Contact;
use record::Learning;
pub(super) use report::NEAR_SIGMAS;
use report::Spot;
pub use search::Suspicion;
use search::{Search, SearchOutcome};
use state::SensorState;

/// The current stage. An enum because stages exclude each other and so share memory.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put one on")]
enum Stage<F: Mechanics, H: JointSensor, X: SeriesElement> {
    Idle,
    /// The finger closes without a contact so far.
    Searching(Search<H::Reading>),
    /// A contact is being judged.
    Contact(Contact<F, H, X>),
    /// Idle after a contact that is unobservable; see [`Sensor::vague_place`].
    Vague(Spot),
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
///     emf_v: 3.4,
///     drive: Drive::Closing,
///     joint: (),
/// };
/// assert_eq!(sensor.update(&sample), None);
/// ```
///
/// `H` is [`NoJointSensor`] or [`HallSensor`](crate::sensing::HallSensor); `X` is [`Cable`] or [`Rigid`](crate::sensing::Rigid).
// Fields in this order for the reason given at `SensorState`.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Sensor<F: Mechanics, H: JointSensor = NoJointSensor, X: SeriesElement = Cable> {
    averager: BlockAverager,
    /// Whether this closing has its result: the rest of it is not searched.
    done: bool,
    /// Whether the motion is ignored, though the last word on a contact may still be due.
    rests: bool,
    state: SensorState<F, H, X>,
    stage: Stage<F, H, X>,
    learning: Learning,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> Sensor<F, H, X> {
    /// A sensor without friction record. A finger of more than [`MAX_PHALANGES`] phalanges does not compile: it has more hypotheses than
    /// the locator holds.
    pub fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        const {
            assert!(
                F::PHALANGES <= MAX_PHALANGES,
                "sensing has hypotheses for three phalanges"
            );
        }
        Self {
            state: SensorState::new(finger, drivetrain, settings, calibration),
            averager: BlockAverager::default(),
            stage: Stage::Idle,
            learning: Learning::default(),
            done: false,
            rests: true,
        }
    }

    /// The finger.
    pub fn finger(&self) -> &F {
        &self.state.finger
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.state.settings
    }

    /// Takes other settings, from the next sample on: a closing under way goes on with them. At another speed what was calibrated is less
    /// sure. A contact that is still judged is dropped where speed, contact friction or mounting change, as by [`Self::set_calibration`].
    pub fn set_settings(&mut self, settings: Settings) {
        let state = &mut self.state;
        let before = core::mem::replace(&mut state.settings, settings);
        #[cfg(weightless)]
        let is_turned = false;
        #[cfg(not(weightless))]
        let is_turned = before.mounting != state.settings.mounting;
        let (was, friction) = (before.speed_rad_per_s, before.contact_friction);
        let now = state.settings.speed_rad_per_s;
        if is_turned || was != now || friction != state.settings.contact_friction {
            self.stage = Stage::Idle;
        }
        // Approximate the logarithm of the speeds' ratio (0.91 for 0.98 at a ratio of 2.7); exactly 0 where the speed stays.
        let change = (now - was) / (0.5 * (now + was));
        let share = state.drivetrain.efficiency_per_speed * change;
        state.calibration.change_speed(share);
        state.hang();
    }

    /// Nominal efficiency of the drivetrain, 0 to 1, from the next sample on; anything else is ignored. Whether it is another one.
    pub fn set_efficiency(&mut self, efficiency: f32) -> bool {
        let in_force = &mut self.state.drivetrain.efficiency;
        let changes = efficiency > 0.0 && efficiency <= 1.0 && efficiency != *in_force;
        if changes {
            *in_force = efficiency;
        }
        changes
    }

    /// Standard deviation of the torque constant, as a share, 0 to 1; anything else is ignored. 0 where it was measured: the back-EMF of
    /// a closing corrects it no further.
    pub fn set_torque_constant_sigma(&mut self, sigma: f32) {
        if (0.0..=1.0).contains(&sigma) {
            self.state.drivetrain.torque_constant_sigma = sigma;
        }
    }

    /// How near the search for a contact is to a decision; `None` while it does not search.
    pub fn suspicion(&self) -> Option<Suspicion> {
        match &self.stage {
            Stage::Searching(search) => search.suspicion(),
            _ => None,
        }
    }

    /// Change of theta_2 since contact, as the last word on a contact took it into account.
    pub fn joint_change(&self) -> H::Reading {
        self.state.joint_change
    }

    /// How stiff the object of the last place is; `None` without the option ([`SoftObject`](super::SoftObject)).
    pub fn object(&self) -> Option<Object> {
        self.state.object
    }

    /// The friction record.
    pub fn friction(&self) -> Option<&Friction> {
        self.state.friction.as_ref()
    }

    /// Takes a record of the same zero. Returns false for an invalid one, which is ignored.
    pub fn set_friction(&mut self, friction: Friction) -> bool {
        let valid = friction.is_valid();
        if valid {
            self.state.friction = Some(friction);
            self.state.shift_counts = Some(0);
            self.state.shift_sigma_counts = 0.0;
        }
        valid
    }

    /// Takes a record from before a restart, whose zero was another one: the first closing aligns it and detects no contact until
    /// that is done. Returns false for an invalid one, which is ignored.
    pub fn restore_friction(&mut self, friction: Friction) -> bool {
        let valid = self.set_friction(friction);
        if valid {
            self.state.shift_counts = None;
        }
        valid
    }

    /// To be called when the encoder's zero changes: the next closing aligns the record, as after a restart.
    pub fn realign(&mut self) {
        self.state.shift_counts = None;
    }

    /// What was calibrated.
    pub fn calibration(&self) -> &Calibration {
        &self.state.calibration
    }

    /// Takes a stored or nominal calibration. Returns false for an invalid one, which is ignored. A contact that is still judged is
    /// dropped: it would be judged by both, and a pin would add to this one what it has learned with the other.
    // Not inlined: called from several places.
    #[inline(never)]
    pub fn set_calibration(&mut self, calibration: Calibration) -> bool {
        let valid = calibration.is_valid();
        if valid {
            self.state.calibration = calibration;
            self.stage = Stage::Idle;
        }
        valid
    }

    /// Sets the use of the following samples. A contact in progress is evaluated with the samples so far; repeating a directive
    /// restarts the stage.
    pub fn direct(&mut self, directive: Directive) {
        self.conclude_search();
        let state = &mut self.state;
        if matches!(directive, Directive::RecordFriction) {
            let empty = Friction::empty(state.travel_counts(), &state.drivetrain);
            self.learning.begin(empty);
            state.torque_constant = TorqueConstant::default();
        } else {
            self.learning.end_recording(state);
        }
        self.averager.leave_stop();
        self.rests = matches!(directive, Directive::Rest);
        if self.rests
            && let Stage::Contact(contact) = &mut self.stage
        {
            // The final verdict is still due, under the old directive; after it the sensor rests.
            contact.end();
            return;
        }
        state.directive = directive;
        // Of a closing on which everything else has been said.
        state.conclude_closing(false);
        state.stale_told = false;
        self.done = false;
        self.stage = Stage::Idle;
    }

    /// Takes a sample; returns at most one event. Typically takes some hundred instructions; after every block of a contact, and
    /// for some hundreds of samples after its end, also some points of a fit's pass over the curve.
    // Not inlined, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub fn update(&mut self, sample: &Sample<H::Reading>) -> Option<Event> {
        self.state.reading = sample.joint;
        self.state.position_counts = sample.position_counts;
        let state = &self.state;
        match self
            .averager
            .push(sample, &state.drivetrain, &state.settings)
        {
            BlockUpdate::Pending => {
                if !self.averager.is_adjacent() {
                    // A turn that made no block lies between: the reading is too old for the mean with the next one.
                    self.state.before = H::Reading::default();
                }
            }
            BlockUpdate::Block(block) => {
                self.take(&block);
                self.state.before = self.state.reading;
            }
            BlockUpdate::Ended => {
                // Forget the reading: the first turn of the next run makes no block, and the one after it would be averaged with this.
                self.state.before = H::Reading::default();
                self.end_run();
            }
        }
        // Before the judgement: an update that gives the last word on a contact has no time to learn as well.
        let busy = matches!(self.stage, Stage::Searching(_) | Stage::Contact(_));
        self.judge();
        self.learning.step(&mut self.state, busy);
        self.state.events.pop_front()
    }

    fn take(&mut self, block: &Block) {
        let state = &mut self.state;
        state.torque_constant.push(block, &state.drivetrain);
        match self.state.directive {
            _ if self.rests => {}
            Directive::RecordFriction => self.learning.record(block),
            // Opening ends a closing: the next one is searched again.
            _ if block.drive != Drive::Closing => self.done = false,
            _ => self.close(block),
        }
    }

    /// Takes a block of a closing: searches for a contact, presses on one, or remembers the block once all is told.
    fn close(&mut self, block: &Block) {
        let state = &mut self.state;
        let corrected = state.corrected(block);
        if !self.done
            && let Stage::Idle | Stage::Vague(_) = self.stage
        {
            Search::begin(&mut self.stage);
        }
        let Some(corrected) = corrected else {
            return;
        };
        if self.done {
            state.remember(&corrected);
            return;
        }
        if let Stage::Searching(search) = &self.stage {
            if search.unusual {
                self.learning.forget();
            } else {
                self.learning.watch(state, block, &corrected);
            }
        }
        if let Stage::Contact(_) = self.stage {
            state.remember(&corrected);
        }
        match &mut self.stage {
            Stage::Contact(contact) => state.press(contact, corrected),
            Stage::Searching(search) => match state.search(search, block, corrected) {
                SearchOutcome::Nothing => {}
                SearchOutcome::Over => {
                    self.learning.forget();
                    self.done = true;
                }
                SearchOutcome::Contact(found) => {
                    self.learning.cut(state, &found.onset);
                    self.begin_contact(block, &found);
                }
            },
            Stage::Idle | Stage::Vague(_) => {}
        }
    }

    fn end_run(&mut self) {
        self.conclude_search();
        self.learning.end_run(&self.state);
        // Closings in contact, and those whose search is over, end here too.
        self.state.conclude_closing(false);
        if let Stage::Contact(contact) = &mut self.stage {
            contact.end();
        }
    }

    /// Ends a closing without contact.
    // Not inlined: called from two places.
    #[inline(never)]
    fn conclude_search(&mut self) {
        if let Stage::Searching(search) = &self.stage {
            // What may be a contact is not learned as friction. Here, because the motion ends some samples after its directive.
            if let Some(suspect) = search.suspect() {
                self.learning.cut(&self.state, &suspect);
            }
            // An unusual one has been reported already.
            let free = !search.unusual && !self.done;
            self.state.conclude_closing(free);
            if !self.done && self.state.is_calibrating() {
                self.state.emit(Event::CalibrationRefused {
                    why: Refusal::NoContact,
                });
            }
            self.stage = Stage::Idle;
        }
    }
}
