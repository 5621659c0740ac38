//! The motion half of the slow loop: carries commands out on the motion sequence and directs the sensing half meanwhile.

use core::marker::PhantomData;

use super::hold::ForceHold;
use super::sensing::SensingRequest;
use super::values::{motion, value};
use crate::app::console::command::{Calibrate, Command};
use crate::app::console::settings::{Overrides, Setting};
use crate::drive::identify::Identified;
use crate::drive::sequence::{Notice, Refused, Request, Sequence, State, StepOutput};
use crate::drive::{Fault, Setpoint, Status};
use crate::numeric::Bounded;
use crate::scene::Scene;
use crate::sensing::location::SeriesElement;
use crate::sensing::{Directive, Event};

/// What the board has to do to complete a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Nothing: accepted, the log reports the rest.
    Accepted,
    /// List the commands.
    Help,
    /// Report the state.
    Status,
    /// List the settings.
    Show,
    /// Run the self-test, which moves the motor by [`Coordinator::set_test`].
    SelfTest,
    /// Identify the motor, moving it by [`Coordinator::set_test`].
    Identify,
    /// A setting changed; `at_restart`: it acts after `save` and a restart, because the control interrupt's limits are fixed
    /// while it runs. A lower limit of the current acts with the next motion.
    Set {
        /// Acts only after `save` and a restart.
        at_restart: bool,
    },
    /// Stream every so many samples to the log; 0 for none.
    Trace(u16),
    /// Write to flash; the bridge is off.
    Save,
    /// Erase what was written; the bridge is off.
    Factory,
}

/// Result of one step of the motion half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoordinatorOutput {
    /// What the sequence decided.
    pub motion: StepOutput,
    /// For the sensing half.
    pub request: Option<SensingRequest>,
}

/// Settings that the friction record depends on: the worm's friction on speed, and the weight is in it.
const IN_RECORD: &[Setting] = &[
    Setting::ClosingSpeed,
    #[cfg(not(weightless))]
    Setting::Mounting,
    #[cfg(not(weightless))]
    Setting::Weight,
];

/// The motion half. See [`ContactSensing`](super::ContactSensing) for why there are two.
#[derive(Clone, Debug)]
pub struct Coordinator<S: Scene> {
    sequence: Sequence,
    overrides: Overrides,
    /// The control interrupt's own limit of the current, fixed at start, ampere.
    limit_a: f32,
    /// What the next closing is for.
    purpose: Directive,
    /// Requests that do not follow from a change of state.
    pending: Pending,
    hold: ForceHold,
    /// The encoder's zero that was asked for last.
    zero: u8,
    /// What the self-test or the identification asks of the motor, while it runs.
    test: Option<Setpoint>,
    identified: Option<Identified>,
    scene: PhantomData<S>,
}

impl<S: Scene> Coordinator<S> {
    /// A sequence at rest, with what the user has set. Where no press has told the cable yet, the first recording leads to one.
    pub fn new(overrides: Overrides, presses: u16) -> Self {
        let mut sequence = Sequence::new(motion::<S>(&overrides), *S::CHECKED.scale());
        sequence.set_press(S::Series::FLEXIBLE && presses == 0);
        Self {
            sequence,
            // Allow for the rounding of the same value typed in milliampere.
            limit_a: 1.00001 * value::<S>(&overrides, Setting::CurrentLimit),
            overrides,
            purpose: Directive::Watch,
            pending: Pending::default(),
            hold: ForceHold::default(),
            zero: 0,
            test: None,
            identified: None,
            scene: PhantomData,
        }
    }

    /// Where the sequence is.
    pub fn state(&self) -> State {
        self.sequence.state()
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        self.sequence.fault()
    }

    /// Whether the friction record is that of the motion to come.
    pub fn friction_known(&self) -> bool {
        self.sequence.friction_known()
    }

    /// What the user has set.
    pub fn overrides(&self) -> &Overrides {
        &self.overrides
    }

    /// Value of a setting now in force or to be in force after a restart, SI units.
    pub fn value(&self, setting: Setting) -> f32 {
        value::<S>(&self.overrides, setting)
    }

    /// What the self-test or the identification asks of the motor from the next step on. False, and nothing is asked, where it was
    /// stopped or a fault has ended it.
    pub fn set_test(&mut self, setpoint: Setpoint) -> bool {
        if self.test.is_some() {
            self.test = Some(setpoint);
        }
        self.test.is_some()
    }

    /// What was identified of the motor, now or before the record was kept.
    pub fn identified(&self) -> Option<&Identified> {
        self.identified.as_ref().filter(|_| S::IDENTIFIES)
    }

    /// Keeps what was identified.
    pub fn set_identified(&mut self, identified: Identified) {
        self.identified = Some(identified);
    }

    /// The self-test, or the identification, is over.
    pub fn end_test(&mut self) {
        self.test = None;
    }

    /// Carries out a command. Whatever moves the motor, the button too, ends a self-test.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn command(&mut self, command: Command) -> Result<Action, Refused> {
        let request = match command {
            Command::Help => return Ok(Action::Help),
            Command::Status => return Ok(Action::Status),
            Command::Show => return Ok(Action::Show),
            Command::Trace(every) => return Ok(Action::Trace(every)),
            Command::SelfTest => return self.begin_test(Action::SelfTest),
            Command::Identify if !S::IDENTIFIES => return Err(Refused::NotFitted),
            Command::Identify => return self.begin_test(Action::Identify),
            Command::Save => return self.resting().map(|()| Action::Save),
            Command::Factory => {
                self.resting()?;
                self.identified = None;
                self.adjust(Overrides::default());
                // What is known until then would be kept by the next `save`.
                self.sequence.forget_friction();
                self.forget_calibration();
                return Ok(Action::Factory);
            }
            Command::Set(setting, value_si) => return self.set(setting, value_si),
            Command::Calibrate(Calibrate::Forget) => {
                self.resting()?;
                self.forget_calibration();
                return Ok(Action::Accepted);
            }
            Command::Calibrate(Calibrate::Cable) if !S::Series::FLEXIBLE => {
                return Err(Refused::NoCable);
            }
            Command::Calibrate(Calibrate::Cable) => Request::Press,
            Command::Calibrate(Calibrate::At { .. }) | Command::Run => Request::Run,
            Command::Close => Request::Close,
            Command::Open => Request::Open,
            Command::Stop => Request::Stop,
            Command::Clear => Request::Clear,
            Command::Home => Request::Home,
            Command::RecordFriction => Request::RecordFriction,
        };
        match command {
            Command::Calibrate(at) => {
                if !self.sequence.friction_known() {
                    // The pin would be in the way of recording it first.
                    return Err(Refused::NoFriction);
                }
                self.request(request, purpose::<S>(at))?;
            }
            _ => self.request(request, Directive::Watch)?,
        }
        Ok(Action::Accepted)
    }

    /// Asks for a motion, and says what a closing in it is for.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn request(&mut self, request: Request, purpose: Directive) -> Result<(), Refused> {
        if self.test.take().is_some() && !matches!(request, Request::Stop) {
            return Ok(());
        }
        self.sequence.request(request)?;
        if !matches!(request, Request::Stop | Request::Open | Request::Clear) {
            self.purpose = purpose;
            // Forget the current that held the last object.
            self.sequence.set_motion(motion::<S>(&self.overrides));
        }
        Ok(())
    }

    /// Takes an event of the sensing half: a located contact sets the current that holds the wanted force. A last word without a force
    /// takes it back, so that the object is held as the scene says. True where the last word asks for more than the limit of the current.
    pub fn event(&mut self, event: &Event) -> bool {
        let (force_n, settled) = match *event {
            Event::Located {
                force_n, settled, ..
            } => (force_n, settled),
            Event::Ambiguous { settled: true, .. } | Event::NotLocated { .. } => (f32::NAN, true),
            _ => return false,
        };
        // Ignore the last word on a closing that was stopped: it may come when the next motion has begun.
        if !matches!(self.sequence.state(), State::Probe | State::Hold) {
            return false;
        }
        if settled {
            self.hold.settle();
        }
        let wanted_n = self.value(Setting::HoldForce);
        let limit_a = self.value(Setting::CurrentLimit);
        let current_a = self.hold.current_a(force_n, wanted_n);
        // With more than probing ended with, a finger whose contact is lost would speed up.
        let scene_a = settled.then(|| S::MOTION.holding_current_a.at_most(self.hold.probed_a()));
        let Some(holding_a) = current_a.or(scene_a) else {
            return false;
        };
        self.sequence
            .set_holding_current(holding_a.at_most(limit_a));
        settled && current_a.is_some_and(|current_a| current_a > limit_a)
    }

    /// One step, about once a millisecond.
    pub fn advance(
        &mut self,
        now_us: u64,
        status: &Status,
        notice: Option<Notice>,
    ) -> CoordinatorOutput {
        let mut motion = self.sequence.advance(now_us, status, notice);
        if self.sequence.state() != State::Idle {
            self.test = None;
        }
        if let Some(setpoint) = self.test {
            motion.demand.setpoint = setpoint;
        }
        // Homing keeps the zero, 0 counts, where a friction record belongs to it and no counts were lost.
        let zero = core::mem::replace(&mut self.zero, motion.demand.zero);
        let moved = zero != motion.demand.zero && motion.demand.zero_at_counts != 0;
        if moved || motion.fault.is_some_and(Fault::loses_counts) {
            self.pending.realign = true;
        }
        match self.sequence.state() {
            State::Close => self.hold.closing(status.current_a),
            State::Probe => self.hold.probing(status.current_a),
            _ => {}
        }
        if motion.changed == Some((State::Probe, State::Hold)) && !self.hold.is_settled() {
            // Until the last word: with more, the finger would close on, and the force that is told would belong to another current.
            self.sequence.limit_holding_current(self.hold.probed_a());
        }
        let directive = match motion.changed {
            Some((_, State::Close)) if self.sequence.is_pressing() => {
                Some(Directive::CalibrateCable)
            }
            Some((_, to)) => directive(to, self.purpose),
            None => None,
        };
        let request = directive.map(SensingRequest::Direct);
        let request = request.or_else(|| self.pending.take(&self.overrides));
        CoordinatorOutput { motion, request }
    }

    fn begin_test(&mut self, action: Action) -> Result<Action, Refused> {
        match (self.sequence.fault(), self.sequence.state()) {
            (Some(fault), _) => Err(Refused::Faulted(fault)),
            (None, State::Idle) => {
                self.test = Some(Setpoint::Off);
                Ok(action)
            }
            (None, state) => Err(Refused::Busy(state)),
        }
    }

    /// Whether the bridge is off.
    fn resting(&self) -> Result<(), Refused> {
        match self.sequence.state() {
            State::Idle | State::Fault => Ok(()),
            state => Err(Refused::Busy(state)),
        }
    }

    fn set(&mut self, setting: Setting, value_si: f32) -> Result<Action, Refused> {
        self.resting()?;
        let mut overrides = self.overrides;
        // The parser has checked the range; what is out of it nevertheless is not taken.
        if overrides.set(setting, value_si).is_ok() {
            self.adjust(overrides);
        }
        let at_restart = match setting {
            // The motion asks for no more than a lower one from now on.
            Setting::CurrentLimit => value_si > self.limit_a,
            Setting::SupplyMin | Setting::SupplyMax => true,
            _ => false,
        };
        Ok(Action::Set { at_restart })
    }

    fn adjust(&mut self, overrides: Overrides) {
        let before = core::mem::replace(&mut self.overrides, overrides);
        // Whether its value is another one: the scene's own may have been set.
        let changes = |setting: &Setting| value::<S>(&before, *setting) != self.value(*setting);
        let recalibrates = changes(&Setting::Efficiency);
        if IN_RECORD.iter().any(changes) {
            self.sequence.forget_friction();
        }
        if recalibrates {
            // The sensing forgets its calibration then.
            self.sequence.set_press(S::Series::FLEXIBLE);
        }
        self.sequence.set_motion(motion::<S>(&overrides));
        self.pending.adjust = true;
    }

    fn forget_calibration(&mut self) {
        self.pending.forget = true;
        self.sequence.set_press(S::Series::FLEXIBLE);
    }
}

/// Requests that wait: one is handed over per step. Those that are made twice count once, and none replaces another.
#[derive(Clone, Copy, Debug, Default)]
struct Pending {
    adjust: bool,
    forget: bool,
    realign: bool,
}

impl Pending {
    fn take(&mut self, overrides: &Overrides) -> Option<SensingRequest> {
        if core::mem::take(&mut self.adjust) {
            Some(SensingRequest::Adjust(*overrides))
        } else if core::mem::take(&mut self.forget) {
            Some(SensingRequest::ForgetCalibration)
        } else if core::mem::take(&mut self.realign) {
            Some(SensingRequest::Realign)
        } else {
            None
        }
    }
}

/// What a state that begins means for the sensing, given what the next closing is for; `None` where the directive stays.
pub fn directive(entered: State, purpose: Directive) -> Option<Directive> {
    match entered {
        State::RecordClosing => Some(Directive::RecordFriction),
        State::Close => Some(purpose),
        State::RecordOpening | State::Probe | State::Hold => None,
        State::Idle | State::CalibrateOffset | State::Home | State::Open | State::Fault => {
            Some(Directive::Rest)
        }
    }
}

/// What a calibration's closing is for.
fn purpose<S: Scene>(calibrate: Calibrate) -> Directive {
    match calibrate {
        Calibrate::At { k_m } => Directive::Calibrate {
            phalanx: S::PHALANGES,
            k_m,
        },
        // Not used: where the sequence presses, `advance` directs the sensing.
        Calibrate::Cable | Calibrate::Forget => Directive::Rest,
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests;
