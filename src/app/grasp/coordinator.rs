//! The motion half of the slow loop: carries commands out on the motion sequence and says what the sensing half has to do
//! meanwhile.

use core::marker::PhantomData;

use super::hold::ForceHold;
use super::sensing::SensingRequest;
use crate::app::console::command::{Calibrate, Command};
use crate::app::console::settings::{Overrides, Setting};
use crate::drive::config::{CheckedConfig, OutOfRange};
use crate::drive::sequence::{Motion, Notice, Refused, Request, Sequence, State, StepOutput};
use crate::drive::{Fault, Setpoint, Status};
use crate::scene::Scene;
use crate::sensing::location::Series;
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
    /// A setting changed; `at_restart`: it acts after `save` and a restart, because the control interrupt's limits are fixed
    /// while it runs.
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
pub struct Step {
    /// What the sequence decided.
    pub motion: StepOutput,
    /// For the sensing half.
    pub request: Option<SensingRequest>,
}

/// The motion half. See [`ContactSensing`](super::ContactSensing) for why there are two.
#[derive(Clone, Debug)]
pub struct Coordinator<S: Scene> {
    sequence: Sequence,
    overrides: Overrides,
    /// What the next closing is for.
    purpose: Directive,
    /// A request that does not follow from a change of state.
    pending: Option<SensingRequest>,
    hold: ForceHold,
    /// What the self-test asks of the motor, while it runs.
    test: Option<Setpoint>,
    scene: PhantomData<S>,
}

/// The drive with what the user has set: what the controller is built from at start.
///
/// # Errors
/// The first value that no longer fits the scene.
pub fn drive<S: Scene>(overrides: &Overrides) -> Result<CheckedConfig, OutOfRange> {
    let value = |setting| value::<S>(overrides, setting);
    S::CHECKED.with_limits(
        value(Setting::CurrentLimit),
        value(Setting::SupplyMin),
        value(Setting::SupplyMax),
    )
}

impl<S: Scene> Coordinator<S> {
    /// A sequence at rest, with what the user has set.
    pub fn new(overrides: Overrides) -> Self {
        Self {
            sequence: Sequence::new(motion::<S>(&overrides), *S::CHECKED.scale()),
            overrides,
            purpose: Directive::Watch,
            pending: None,
            hold: ForceHold::default(),
            test: None,
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

    /// What the user has set.
    pub fn overrides(&self) -> &Overrides {
        &self.overrides
    }

    /// Value of a setting now in force or to be in force after a restart, SI units.
    pub fn value(&self, setting: Setting) -> f32 {
        value::<S>(&self.overrides, setting)
    }

    /// What the self-test asks of the motor from the next step on. False, and nothing is asked, where it was stopped or a fault
    /// has ended it.
    pub fn set_test(&mut self, setpoint: Setpoint) -> bool {
        if self.test.is_some() {
            self.test = Some(setpoint);
        }
        self.test.is_some()
    }

    /// The self-test is over.
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
            Command::SelfTest => return self.begin_test(),
            Command::Save => return self.resting().map(|()| Action::Save),
            Command::Factory => {
                self.resting()?;
                self.adjust(Overrides::default());
                return Ok(Action::Factory);
            }
            Command::Set(setting, value_si) => return self.set(setting, value_si),
            Command::Calibrate(Calibrate::Forget) => {
                self.resting()?;
                self.pending = Some(SensingRequest::ForgetCalibration);
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
        }
        Ok(())
    }

    /// Takes an event of the sensing half: a located contact sets the current that holds the wanted force.
    pub fn event(&mut self, event: &Event, status: &Status) {
        let Event::Located { force_n, .. } = event else {
            return;
        };
        let wanted_n = self.value(Setting::HoldForce);
        let limit_a = S::DRIVE.limits.current_a;
        let current_a = self
            .hold
            .current_a(status.current_a, *force_n, wanted_n, limit_a);
        if let Some(current_a) = current_a {
            let mut motion = motion::<S>(&self.overrides);
            motion.holding_current_a = current_a;
            self.sequence.set_motion(motion);
        }
    }

    /// One step, about once a millisecond.
    pub fn advance(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Step {
        let mut motion = self.sequence.advance(now_us, status, notice);
        if self.sequence.state() != State::Idle {
            self.test = None;
        }
        if let Some(setpoint) = self.test {
            motion.demand.setpoint = setpoint;
        }
        if motion.fault.is_some_and(Fault::loses_counts) {
            self.pending = Some(SensingRequest::Realign);
        }
        if self.sequence.state() == State::Close {
            self.hold.closing(status.current_a);
        }
        let request = motion
            .changed
            .and_then(|(_, to)| self.directive(to))
            .map(SensingRequest::Direct);
        let request = request.or_else(|| self.pending.take());
        Step { motion, request }
    }

    /// What a state that begins means for the sensing; `None` where the directive stays.
    fn directive(&self, entered: State) -> Option<Directive> {
        match entered {
            State::RecordClosing => Some(Directive::RecordFriction),
            State::Close => Some(self.purpose),
            State::RecordOpening | State::Probe | State::Hold => None,
            State::Idle | State::CalibrateOffset | State::Home | State::Open | State::Fault => {
                Some(Directive::Rest)
            }
        }
    }

    fn begin_test(&mut self) -> Result<Action, Refused> {
        match (self.sequence.fault(), self.sequence.state()) {
            (Some(fault), _) => Err(Refused::Faulted(fault)),
            (None, State::Idle) => {
                self.test = Some(Setpoint::Off);
                Ok(Action::SelfTest)
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
        let at_restart = matches!(
            setting,
            Setting::CurrentLimit | Setting::SupplyMin | Setting::SupplyMax
        );
        Ok(Action::Set { at_restart })
    }

    fn adjust(&mut self, overrides: Overrides) {
        if overrides.get(Setting::ClosingSpeed) != self.overrides.get(Setting::ClosingSpeed) {
            // The worm's friction depends on speed.
            self.sequence.forget_friction();
        }
        self.overrides = overrides;
        self.sequence.set_motion(motion::<S>(&overrides));
        self.pending = Some(SensingRequest::Adjust(overrides));
    }
}

/// What a calibration's closing is for.
fn purpose<S: Scene>(calibrate: Calibrate) -> Directive {
    match calibrate {
        Calibrate::At { k_m } => Directive::Calibrate {
            phalanx: S::PHALANGES,
            k_m,
        },
        Calibrate::Cable => Directive::CalibrateCable,
        Calibrate::Forget => Directive::Rest,
    }
}

/// The sequence's speeds and currents with what the user has set.
fn motion<S: Scene>(overrides: &Overrides) -> Motion {
    let mut motion = S::MOTION;
    motion.closing_rad_per_s =
        value::<S>(overrides, Setting::ClosingSpeed).min(S::DRIVE.limits.speed_rad_per_s);
    motion.holding_s = value::<S>(overrides, Setting::HoldTime);
    if let Some(limit_a) = overrides.get(Setting::CurrentLimit) {
        // What probing may ask for follows the limit; the rest must not exceed it.
        motion.probing_current_a = limit_a;
        for current_a in [
            &mut motion.free_current_a,
            &mut motion.homing_current_a,
            &mut motion.holding_current_a,
        ] {
            *current_a = current_a.min(limit_a);
        }
    }
    motion
}

/// A setting's value, SI units.
fn value<S: Scene>(overrides: &Overrides, setting: Setting) -> f32 {
    overrides
        .get(setting)
        .unwrap_or_else(|| default_value::<S>(setting))
}

/// A setting's value where the user has set none, SI units.
fn default_value<S: Scene>(setting: Setting) -> f32 {
    match setting {
        Setting::ClosingSpeed => S::MOTION.closing_rad_per_s,
        Setting::CurrentLimit => S::DRIVE.limits.current_a,
        Setting::ProbeTorque => S::settings().torque_limit_nm,
        Setting::WantedDeviation => S::settings().wanted_sigma_m,
        Setting::Sensitivity => S::settings().false_contacts_per_thousand,
        Setting::HoldForce => S::HOLD_FORCE_N,
        Setting::HoldTime => S::MOTION.holding_s,
        Setting::Efficiency => S::EFFICIENCY,
        Setting::SupplyMin => S::DRIVE.limits.supply_min_v,
        Setting::SupplyMax => S::DRIVE.limits.supply_max_v,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::P70;

    fn coordinator() -> Coordinator<P70> {
        Coordinator::new(Overrides::default())
    }

    fn known(coordinator: &mut Coordinator<P70>) {
        coordinator.advance(0, &Status::default(), Some(Notice::FrictionKnown));
    }

    #[test]
    fn every_command_at_rest_is_accepted_or_says_what_is_missing() {
        for (command, expected) in [
            (Command::Help, Ok(Action::Help)),
            (Command::Status, Ok(Action::Status)),
            (Command::SelfTest, Ok(Action::SelfTest)),
            (Command::Run, Ok(Action::Accepted)),
            (Command::Home, Ok(Action::Accepted)),
            (Command::RecordFriction, Ok(Action::Accepted)),
            (
                Command::Calibrate(Calibrate::At { k_m: 0.04 }),
                Err(Refused::NoFriction),
            ),
            (
                Command::Calibrate(Calibrate::Cable),
                Err(Refused::NoFriction),
            ),
            (Command::Calibrate(Calibrate::Forget), Ok(Action::Accepted)),
            (Command::Close, Ok(Action::Accepted)),
            (Command::Open, Ok(Action::Accepted)),
            (Command::Stop, Ok(Action::Accepted)),
            (Command::Clear, Err(Refused::NoFault)),
            (Command::Show, Ok(Action::Show)),
            (Command::Trace(10), Ok(Action::Trace(10))),
            (
                Command::Set(Setting::HoldForce, 2.0),
                Ok(Action::Set { at_restart: false }),
            ),
            (
                Command::Set(Setting::SupplyMin, 8.0),
                Ok(Action::Set { at_restart: true }),
            ),
            (Command::Save, Ok(Action::Save)),
            (Command::Factory, Ok(Action::Factory)),
        ] {
            assert_eq!(coordinator().command(command), expected, "{command:?}");
        }
    }

    #[test]
    fn flash_and_settings_wait_until_the_bridge_is_off() {
        let mut coordinator = coordinator();
        coordinator.command(Command::Run).expect("at rest");
        coordinator.advance(1000, &Status::default(), None);
        let busy = Err(Refused::Busy(State::CalibrateOffset));
        for command in [
            Command::Save,
            Command::Factory,
            Command::Set(Setting::HoldTime, 1.0),
            Command::Calibrate(Calibrate::Forget),
            Command::Run,
        ] {
            assert_eq!(coordinator.command(command), busy, "{command:?}");
        }
        assert_eq!(coordinator.command(Command::Stop), Ok(Action::Accepted));
        let step = coordinator.advance(2000, &Status::default(), None);
        assert_eq!(step.motion.demand.setpoint, Setpoint::Off);
        assert_eq!(step.request, Some(SensingRequest::Direct(Directive::Rest)));
        assert_eq!(coordinator.command(Command::Save), Ok(Action::Save));
    }

    #[test]
    fn an_encoder_s_fault_has_the_friction_record_aligned_anew() {
        for (fault, wanted) in [
            (Fault::EncoderStuck, Some(SensingRequest::Realign)),
            (Fault::OverCurrent, None),
        ] {
            let mut coordinator = coordinator();
            coordinator.command(Command::Run).expect("at rest");
            coordinator.advance(1000, &Status::default(), None);
            let status = Status {
                fault: Some(fault),
                ..Status::default()
            };
            coordinator.advance(2000, &status, None);
            assert_eq!(coordinator.advance(3000, &status, None).request, wanted);
        }
    }

    #[test]
    fn a_setting_reaches_motion_sensing_and_the_next_start() {
        let mut coordinator = coordinator();
        known(&mut coordinator);
        assert!(coordinator.sequence.friction_known());
        coordinator
            .command(Command::Set(Setting::ClosingSpeed, 0.2))
            .expect("at rest");
        assert!(
            !coordinator.sequence.friction_known(),
            "the worm's friction depends on speed"
        );
        let request = coordinator.advance(1, &Status::default(), None).request;
        assert_eq!(
            request,
            Some(SensingRequest::Adjust(*coordinator.overrides()))
        );
        assert_eq!(coordinator.value(Setting::ClosingSpeed), 0.2);
        assert_eq!(
            motion::<P70>(coordinator.overrides()).closing_rad_per_s,
            0.2
        );
        coordinator
            .command(Command::Set(Setting::CurrentLimit, 0.05))
            .expect("at rest");
        let drive = drive::<P70>(coordinator.overrides()).expect("within the scene's trips");
        assert_eq!(drive.config().limits.current_a, 0.05);
        motion::<P70>(coordinator.overrides())
            .validate(&drive.config().limits)
            .expect("follows the limit");
    }

    #[test]
    fn every_setting_has_a_default_within_its_range_and_both_ends_make_a_valid_drive() {
        for setting in Setting::ALL {
            let (name, range) = (setting.name(), setting.range());
            let default = range.to_user(coordinator().value(setting));
            assert!(
                range.to_si(default * (1.0 - 1e-6)).is_some(),
                "{name}: {default}"
            );
            for end in [range.min, range.max] {
                let mut overrides = Overrides::default();
                overrides
                    .set(setting, range.to_si(end).expect("in range"))
                    .expect("in range");
                let limits = drive::<P70>(&overrides).expect(name).config().limits;
                let motion = motion::<P70>(&overrides);
                assert_eq!(motion.validate(&limits), Ok(()), "{name} {end}");
            }
        }
    }

    #[test]
    fn a_calibration_watches_the_pin_and_the_next_run_does_not() {
        let mut coordinator = coordinator();
        known(&mut coordinator);
        coordinator
            .command(Command::Calibrate(Calibrate::At { k_m: 0.04 }))
            .expect("friction is known");
        assert_eq!(
            coordinator.directive(State::Close),
            Some(Directive::Calibrate {
                phalanx: 2,
                k_m: 0.04
            })
        );
        coordinator.command(Command::Stop).expect("always");
        coordinator.advance(1, &Status::default(), None);
        coordinator.command(Command::Run).expect("at rest");
        assert_eq!(coordinator.directive(State::Close), Some(Directive::Watch));
    }

    #[test]
    fn a_self_test_moves_the_motor_until_it_ends_a_command_or_a_fault_comes() {
        let asked = |coordinator: &mut Coordinator<P70>, status: &Status| {
            coordinator.advance(1, status, None).motion.demand.setpoint
        };
        let current = Setpoint::Current { a: 0.04 };
        let healthy = Status::default();
        for command in [Some(Command::Stop), Some(Command::Run), None] {
            let mut coordinator = coordinator();
            assert!(!coordinator.set_test(current), "not begun");
            coordinator.command(Command::SelfTest).expect("at rest");
            assert!(coordinator.set_test(current));
            assert_eq!(asked(&mut coordinator, &healthy), current);
            match command {
                Some(command) => {
                    coordinator.command(command).expect("never refused");
                    assert_eq!(asked(&mut coordinator, &healthy), Setpoint::Off);
                }
                None => {
                    let faulted = Status {
                        fault: Some(Fault::OverCurrent),
                        ..healthy
                    };
                    asked(&mut coordinator, &faulted);
                    assert_eq!(coordinator.state(), State::Fault);
                }
            }
            assert!(!coordinator.set_test(current), "{command:?}");
        }
    }

    #[test]
    fn a_located_contact_sets_the_holding_current() {
        let mut coordinator = coordinator();
        let located = |force_n| Event::Located {
            phalanx: 2,
            p_phalanx: 1.0,
            k_m: 0.04,
            sigma_m: 0.001,
            k_c_nm_per_rad: 2.0,
            force_n,
            force_sigma_n: 0.1,
            radius_m: f32::NAN,
            radius_sigma_m: f32::NAN,
            settled: true,
        };
        let status = Status {
            current_a: 0.065,
            ..Status::default()
        };
        let held_a =
            |coordinator: &Coordinator<P70>| coordinator.sequence.motion().holding_current_a;
        coordinator
            .overrides
            .set(Setting::HoldForce, 1.5)
            .expect("in range");
        coordinator.event(&located(1.5), &status);
        assert!((held_a(&coordinator) - 0.065).abs() < 1e-6);
        coordinator.event(&located(-1.0), &status);
        assert!((held_a(&coordinator) - 0.065).abs() < 1e-6);
    }
}
