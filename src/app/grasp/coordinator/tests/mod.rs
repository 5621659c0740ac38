//! What commands and events make of the state.

mod calibration;
mod halves;
mod holding;
mod homing;
mod zero;

use super::*;
use crate::app::grasp::values::drive;
use crate::drive::OffsetState;
use crate::scene::P70;

fn coordinator() -> Coordinator<P70> {
    Coordinator::new(Overrides::default(), 0)
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
        (Command::Identify, Err(Refused::NotFitted)),
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

/// A limit above the one that the control interrupt has from the start on needs a restart, whatever was set meanwhile.
#[test]
fn a_lower_current_limit_acts_at_once_and_a_higher_one_after_a_restart() {
    let mut coordinator = coordinator();
    let started_a = coordinator.value(Setting::CurrentLimit);
    for (value_a, at_restart) in [
        (0.06, false),
        (started_a, false),
        (120.0 * 1e-3, false),
        (0.15, true),
        (0.1, false),
    ] {
        let set = coordinator.command(Command::Set(Setting::CurrentLimit, value_a));
        assert_eq!(set, Ok(Action::Set { at_restart }), "{value_a} A");
    }
    assert_eq!(coordinator.sequence.motion().probing_current_a, 0.1);
}

/// A fragile object feels what `probe-torque` asks for, not what the current limit allows, whichever is set first.
#[test]
fn a_lower_torque_of_probing_lowers_its_current() {
    let probing_a = |set: &[(Setting, f32)]| {
        let mut coordinator = coordinator();
        for &(setting, value_si) in set {
            (coordinator.command(Command::Set(setting, value_si))).expect("at rest");
        }
        coordinator.sequence.motion().probing_current_a
    };
    let usual_a = probing_a(&[]);
    let usual_nm = P70::settings().torque_limit_nm;
    assert_eq!(probing_a(&[(Setting::ProbeTorque, usual_nm)]), usual_a);
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let free_a = P70::MOTION.free_current_a;
    for torque_nm in [0.005, 0.05, 0.1] {
        let torque = (Setting::ProbeTorque, torque_nm);
        let limit = (Setting::CurrentLimit, P70::DRIVE.limits.current_a);
        let found_a = probing_a(&[torque]);
        let found_nm = (found_a - free_a) * drivetrain.torque_per_ampere_nm * drivetrain.efficiency;
        assert!((found_nm - torque_nm).abs() < 1e-6, "{found_nm} N m");
        assert_eq!(probing_a(&[torque, limit]), found_a);
        assert_eq!(probing_a(&[limit, torque]), found_a);
    }
    let low = [(Setting::ProbeTorque, 0.1), (Setting::CurrentLimit, 0.05)];
    assert_eq!(probing_a(&low), 0.05);
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
fn no_request_replaces_another() {
    let mut coordinator = coordinator();
    for command in [
        Command::Calibrate(Calibrate::Forget),
        Command::Set(Setting::ContactFriction, 0.25),
    ] {
        coordinator.command(command).expect("at rest");
    }
    let mut told = [1, 2, 3].map(|i| coordinator.advance(i, &Status::default(), None).request);
    told.sort_by_key(|request| *request != Some(SensingRequest::ForgetCalibration));
    assert_eq!(
        told,
        [
            Some(SensingRequest::ForgetCalibration),
            Some(SensingRequest::Adjust(*coordinator.overrides())),
            None
        ]
    );
}

#[test]
fn what_is_asked_for_after_a_stop_at_rest_is_carried_out() {
    let mut coordinator = coordinator();
    coordinator.command(Command::Stop).expect("never refused");
    coordinator.command(Command::Run).expect("at rest");
    let step = coordinator.advance(1000, &Status::default(), None);
    assert_eq!(
        step.motion.changed,
        Some((State::Idle, State::CalibrateOffset))
    );
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
    let drive = drive::<P70>(coordinator.overrides(), None).expect("within the scene's trips");
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
            let limits = drive::<P70>(&overrides, None).expect(name).config().limits;
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
        directive(State::Close, coordinator.purpose),
        Some(Directive::Calibrate {
            phalanx: 2,
            k_m: 0.04
        })
    );
    coordinator.command(Command::Stop).expect("always");
    coordinator.advance(1, &Status::default(), None);
    coordinator.command(Command::Run).expect("at rest");
    assert_eq!(
        directive(State::Close, coordinator.purpose),
        Some(Directive::Watch)
    );
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
fn another_mounting_or_weight_discards_the_friction_record() {
    for (setting, value) in [(Setting::Mounting, 0.5), (Setting::Weight, 0.0)] {
        let mut coordinator = coordinator();
        known(&mut coordinator);
        coordinator
            .command(Command::Set(setting, value))
            .expect("at rest");
        assert!(!coordinator.sequence.friction_known(), "{setting:?}");
        known(&mut coordinator);
        coordinator
            .command(Command::Set(setting, value))
            .expect("at rest");
        assert!(coordinator.sequence.friction_known(), "nothing changed");
    }
}

#[test]
fn the_sensing_is_told_of_a_press_that_was_asked_for() {
    let mut coordinator = coordinator();
    known(&mut coordinator);
    coordinator
        .command(Command::Calibrate(Calibrate::Cable))
        .expect("friction is known");
    let mut status = Status {
        homed: true,
        ..Status::default()
    };
    let mut requests = Vec::new();
    for step in 1..20 {
        status.offset = [OffsetState::Measuring, OffsetState::Known][usize::from(step > 3)];
        requests.extend(coordinator.advance(1000 * step, &status, None).request);
    }
    let pressing = SensingRequest::Direct(Directive::CalibrateCable);
    assert!(requests.contains(&pressing), "{requests:?}");
}
