//! The motion half of the slow loop: commands, the motion sequence, and what it wants of the sensing half.

use core::marker::PhantomData;

use super::command::{Calibrate, Command};
use super::sense::Order;
use super::settings::{Overrides, Setting};
use crate::drive::config::{CheckedConfig, OutOfRange};
use crate::drive::sequence::{Motion, Notice, Refused, Request, Sequence, State, StepOutput};
use crate::drive::{Fault, Status};
use crate::scene::Scene;
use crate::sensing::location::Series;
use crate::sensing::{Directive, Event};

/// What a command leads to beside the motion: what only the board can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// Accepted; the log will tell.
    Accepted,
    /// List the commands.
    Help,
    /// Tell the state.
    Status,
    /// List the settings.
    Show,
    /// A setting changed; `at_restart`: it acts after `save` and a restart, because the control interrupt's limits are fixed
    /// while it runs.
    Set {
        /// Acts only after `save` and a restart.
        at_restart: bool,
    },
    /// Write to flash; the bridge is off.
    Save,
    /// Erase what was written; the bridge is off.
    Factory,
}

/// What one step of the motion half decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conducted {
    /// What the sequence decided.
    pub advance: StepOutput,
    /// For the sensing half.
    pub order: Option<Order>,
}

/// The motion half. See [`Sense`](super::sense::Sense) for why there are two.
#[derive(Clone, Debug)]
pub struct Conduct<S: Scene> {
    sequence: Sequence,
    overrides: Overrides,
    /// What the closing to come is for.
    purpose: Directive,
    /// An order that is not given by a change of state.
    pending: Option<Order>,
    free_a: f32,
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

impl<S: Scene> Conduct<S> {
    /// A sequence at rest, with what the user has set.
    pub fn new(overrides: Overrides) -> Self {
        Self {
            sequence: Sequence::new(motion::<S>(&overrides), *S::CHECKED.scale()),
            overrides,
            purpose: Directive::Watch,
            pending: None,
            free_a: 0.0,
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

    /// Carries out a command.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn command(&mut self, command: Command) -> Result<Effect, Refused> {
        let request = match command {
            Command::Help => return Ok(Effect::Help),
            Command::Status => return Ok(Effect::Status),
            Command::Show => return Ok(Effect::Show),
            Command::Save => return self.resting().map(|()| Effect::Save),
            Command::Factory => {
                self.resting()?;
                self.adjust(Overrides::default());
                return Ok(Effect::Factory);
            }
            Command::Set(setting, value_si) => return self.set(setting, value_si),
            Command::Calibrate(Calibrate::Forget) => {
                self.resting()?;
                self.pending = Some(Order::ForgetCalibration);
                return Ok(Effect::Accepted);
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
        Ok(Effect::Accepted)
    }

    /// Asks for a motion, and says what a closing in it is for.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn request(&mut self, request: Request, purpose: Directive) -> Result<(), Refused> {
        self.sequence.request(request)?;
        if !matches!(request, Request::Stop | Request::Open | Request::Clear) {
            self.purpose = purpose;
        }
        Ok(())
    }

    /// Hears an event of the sensing half: a located contact tells which current holds the wanted force.
    ///
    /// In single contact the force is in proportion to the torque above friction, and that to the current above what free
    /// motion took. A force below the one that probing has reached is not given back: the worm locks.
    pub fn hear(&mut self, event: &Event, status: &Status) {
        let Event::Located { force_n, .. } = event else {
            return;
        };
        let load_a = status.current_a - self.free_a;
        if load_a > 0.0 && *force_n > 0.0 {
            let wanted_n = self.value(Setting::HoldForce);
            let limit_a = S::DRIVE.limits.current_a;
            let mut motion = motion::<S>(&self.overrides);
            motion.holding_current_a = (self.free_a + load_a * wanted_n / force_n)
                .min(limit_a)
                .max(0.0);
            self.sequence.set_motion(motion);
        }
    }

    /// One step, about once a millisecond.
    pub fn advance(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Conducted {
        let advance = self.sequence.advance(now_us, status, notice);
        if self.sequence.state() == State::Close {
            // Mean over some 0.1 s; a contact adds little to it until it is felt.
            self.free_a += 0.01 * (status.current_a - self.free_a);
        }
        let order = advance
            .changed
            .and_then(|(_, to)| self.directive(to))
            .map(Order::Direct);
        let order = order.or_else(|| self.pending.take());
        Conducted { advance, order }
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

    /// The bridge is off.
    fn resting(&self) -> Result<(), Refused> {
        match self.sequence.state() {
            State::Idle | State::Fault => Ok(()),
            state => Err(Refused::Busy(state)),
        }
    }

    fn set(&mut self, setting: Setting, value_si: f32) -> Result<Effect, Refused> {
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
        Ok(Effect::Set { at_restart })
    }

    fn adjust(&mut self, overrides: Overrides) {
        if overrides.get(Setting::ClosingSpeed) != self.overrides.get(Setting::ClosingSpeed) {
            // The worm's friction depends on speed.
            self.sequence.forget_friction();
        }
        self.overrides = overrides;
        self.sequence.set_motion(motion::<S>(&overrides));
        self.pending = Some(Order::Adjust(overrides));
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
    use crate::drive::Setpoint;
    use crate::scene::P70;

    fn conduct() -> Conduct<P70> {
        Conduct::new(Overrides::default())
    }

    fn known(conduct: &mut Conduct<P70>) {
        conduct.advance(0, &Status::default(), Some(Notice::FrictionKnown));
    }

    #[test]
    fn every_command_at_rest_is_accepted_or_says_what_is_missing() {
        for (command, expected) in [
            (Command::Help, Ok(Effect::Help)),
            (Command::Status, Ok(Effect::Status)),
            (Command::Run, Ok(Effect::Accepted)),
            (Command::Home, Ok(Effect::Accepted)),
            (Command::RecordFriction, Ok(Effect::Accepted)),
            (
                Command::Calibrate(Calibrate::At { k_m: 0.04 }),
                Err(Refused::NoFriction),
            ),
            (
                Command::Calibrate(Calibrate::Cable),
                Err(Refused::NoFriction),
            ),
            (Command::Calibrate(Calibrate::Forget), Ok(Effect::Accepted)),
            (Command::Close, Ok(Effect::Accepted)),
            (Command::Open, Ok(Effect::Accepted)),
            (Command::Stop, Ok(Effect::Accepted)),
            (Command::Clear, Err(Refused::NoFault)),
            (Command::Show, Ok(Effect::Show)),
            (
                Command::Set(Setting::HoldForce, 2.0),
                Ok(Effect::Set { at_restart: false }),
            ),
            (
                Command::Set(Setting::SupplyMin, 8.0),
                Ok(Effect::Set { at_restart: true }),
            ),
            (Command::Save, Ok(Effect::Save)),
            (Command::Factory, Ok(Effect::Factory)),
        ] {
            assert_eq!(conduct().command(command), expected, "{command:?}");
        }
    }

    #[test]
    fn flash_and_settings_wait_until_the_bridge_is_off() {
        let mut conduct = conduct();
        conduct.command(Command::Run).expect("at rest");
        conduct.advance(1000, &Status::default(), None);
        let busy = Err(Refused::Busy(State::CalibrateOffset));
        for command in [
            Command::Save,
            Command::Factory,
            Command::Set(Setting::HoldTime, 1.0),
            Command::Calibrate(Calibrate::Forget),
            Command::Run,
        ] {
            assert_eq!(conduct.command(command), busy, "{command:?}");
        }
        assert_eq!(conduct.command(Command::Stop), Ok(Effect::Accepted));
        let conducted = conduct.advance(2000, &Status::default(), None);
        assert_eq!(conducted.advance.demand.setpoint, Setpoint::Off);
        assert_eq!(conducted.order, Some(Order::Direct(Directive::Rest)));
        assert_eq!(conduct.command(Command::Save), Ok(Effect::Save));
    }

    #[test]
    fn a_setting_reaches_motion_sensing_and_the_next_start() {
        let mut conduct = conduct();
        known(&mut conduct);
        assert!(conduct.sequence.friction_known());
        conduct
            .command(Command::Set(Setting::ClosingSpeed, 0.2))
            .expect("at rest");
        assert!(
            !conduct.sequence.friction_known(),
            "the worm's friction depends on speed"
        );
        let order = conduct.advance(1, &Status::default(), None).order;
        assert_eq!(order, Some(Order::Adjust(*conduct.overrides())));
        assert_eq!(conduct.value(Setting::ClosingSpeed), 0.2);
        assert_eq!(motion::<P70>(conduct.overrides()).closing_rad_per_s, 0.2);
        conduct
            .command(Command::Set(Setting::CurrentLimit, 0.05))
            .expect("at rest");
        let drive = drive::<P70>(conduct.overrides()).expect("within the scene's trips");
        assert_eq!(drive.config().limits.current_a, 0.05);
        motion::<P70>(conduct.overrides())
            .validate(&drive.config().limits)
            .expect("follows the limit");
    }

    #[test]
    fn every_setting_has_a_default_within_its_range_and_both_ends_make_a_valid_drive() {
        for setting in Setting::ALL {
            let (name, range) = (setting.name(), setting.range());
            let default = range.to_user(conduct().value(setting));
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
        let mut conduct = conduct();
        known(&mut conduct);
        conduct
            .command(Command::Calibrate(Calibrate::At { k_m: 0.04 }))
            .expect("friction is known");
        assert_eq!(
            conduct.directive(State::Close),
            Some(Directive::Calibrate {
                phalanx: 2,
                k_m: 0.04
            })
        );
        conduct.command(Command::Stop).expect("always");
        conduct.advance(1, &Status::default(), None);
        conduct.command(Command::Run).expect("at rest");
        assert_eq!(conduct.directive(State::Close), Some(Directive::Watch));
    }

    #[test]
    fn holding_aims_at_the_wanted_force_within_the_limit() {
        let mut conduct = conduct();
        conduct.free_a = 0.015;
        let located = |force_n| Event::Located {
            phalanx: 2,
            k_m: 0.04,
            sigma_m: 0.001,
            k_c_nm_per_rad: 2.0,
            force_n,
            radius_m: f32::NAN,
            radius_sigma_m: f32::NAN,
            settled: true,
        };
        let status = Status {
            current_a: 0.065,
            ..Status::default()
        };
        let held_a = |conduct: &Conduct<P70>| conduct.sequence.motion().holding_current_a;
        conduct
            .overrides
            .set(Setting::HoldForce, 1.5)
            .expect("in range");
        conduct.hear(&located(1.0), &status);
        assert!((held_a(&conduct) - 0.09).abs() < 1e-6);
        conduct.hear(&located(0.1), &status);
        assert_eq!(held_a(&conduct), P70::DRIVE.limits.current_a);
        let before = held_a(&conduct);
        for force_n in [0.0, -1.0, f32::NAN] {
            conduct.hear(&located(force_n), &status);
            assert_eq!(held_a(&conduct), before);
        }
    }
}
