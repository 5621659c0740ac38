//! What one half of the slow loop tells the other: settings to the sensing, events to the motion.

use super::holding::located;
use super::*;
use crate::app::grasp::sensing::{ContactSensing, notice};
use crate::app::storage::record::Record;
use crate::finger::Mounting;
use crate::sensing::{NotLocated, Refusal, Settings};

fn settings(sensing: &ContactSensing<P70>) -> Settings {
    *sensing.sensor().settings()
}

/// At once, and after a restart, and all are back where nothing is set.
#[test]
fn every_setting_of_the_sensing_reaches_it() {
    let mut overrides = Overrides::default();
    for (setting, value_si) in [
        (Setting::ClosingSpeed, 0.2),
        (Setting::ProbeTorque, 0.111),
        (Setting::WantedDeviation, 0.007),
        (Setting::Sensitivity, 3.0),
        (Setting::ContactFriction, 0.9),
        (Setting::ForceScale, 1.3),
        (Setting::Efficiency, 0.45),
        (Setting::Mounting, 0.5),
        (Setting::Weight, 2.0),
    ] {
        overrides.set(setting, value_si).expect("in range");
    }
    let mut sensing = ContactSensing::<P70>::new();
    sensing.request(SensingRequest::Adjust(Overrides::default()));
    let nominal = settings(&sensing);
    let efficiency = sensing.sensor().drivetrain().efficiency;
    let wanted = Settings {
        speed_rad_per_s: 0.2,
        torque_limit_nm: 0.111,
        wanted_sigma_m: 0.007,
        false_contacts_per_thousand: 3.0,
        contact_friction: P70::settings().rubbed_with(0.9),
        force_scale: Some(1.3),
        mounting: Some(Mounting {
            gravity_rad: 0.5,
            share: 2.0,
        }),
        ..nominal
    };
    sensing.request(SensingRequest::Adjust(overrides));
    assert_eq!(settings(&sensing), wanted);
    assert_eq!(sensing.sensor().drivetrain().efficiency, 0.45);

    let mut restarted = ContactSensing::<P70>::new();
    restarted.restore(&Record {
        overrides: &overrides,
        calibration: &P70::UNCALIBRATED,
        friction: None,
        identified: None,
    });
    assert_eq!(settings(&restarted), wanted);
    assert_eq!(restarted.sensor().drivetrain().efficiency, 0.45);

    sensing.request(SensingRequest::Adjust(Overrides::default()));
    assert_eq!(settings(&sensing), nominal);
    assert_eq!(sensing.sensor().drivetrain().efficiency, efficiency);
}

/// A recording that failed, a record that no longer fits, and the last word of a calibration, taken or refused.
#[test]
fn what_concerns_the_motion_is_told_under_its_name() {
    let ambiguous = |settled| Event::Ambiguous {
        phalanx: [1, 2],
        p_phalanx: [0.5; 2],
        k_m: [0.04; 2],
        sigma_m: [0.001; 2],
        settled,
    };
    let not_located = Event::NotLocated {
        why: NotLocated::Proximal,
        torque_nm: 0.1,
    };
    let calibrated = Event::Calibrated {
        calibration: P70::UNCALIBRATED,
    };
    let refused = Event::CalibrationRefused {
        why: Refusal::Misfit,
    };
    for (event, told) in [
        (
            Event::FrictionStale { misfit_nm: 0.01 },
            Some(Notice::FrictionUnknown),
        ),
        (
            Event::FrictionNotRecorded { coverage: 0.3 },
            Some(Notice::FrictionNotRecorded),
        ),
        (located(1.0), Some(Notice::Settled)),
        (ambiguous(true), Some(Notice::Settled)),
        (ambiguous(false), None),
        (not_located, Some(Notice::Settled)),
        (calibrated, Some(Notice::Settled)),
        (refused, Some(Notice::Settled)),
    ] {
        assert_eq!(notice::<P70>(&event), told, "{event:?}");
    }
}

/// Until a restart the control interrupt has its old limit; the motion must not ask for more than what is set.
#[test]
fn a_smaller_current_is_in_force_for_the_very_next_motion() {
    let mut coordinator = coordinator();
    for setting in [
        Setting::CurrentLimit,
        Setting::SupplyMin,
        Setting::SupplyMax,
    ] {
        let value_si = setting.range().to_si(setting.range().min);
        let set = Command::Set(setting, value_si.expect("in range"));
        let told = coordinator.command(set);
        // The motion has a smaller current at once; the interrupt's trip of the supply is that of the start.
        let at_restart = setting != Setting::CurrentLimit;
        assert_eq!(told, Ok(Action::Set { at_restart }), "{setting:?}");
    }
    let motion = *coordinator.sequence.motion();
    for current_a in [
        motion.free_current_a,
        motion.homing_current_a,
        motion.probing_current_a,
        motion.holding_current_a,
    ] {
        assert!(current_a < 0.0301, "{motion:?}");
    }
}

/// The bridge is off then: what was set may be kept, and a motor is not driven.
#[test]
fn a_fault_allows_what_needs_no_motor_and_refuses_the_rest() {
    let mut coordinator = coordinator();
    let faulted = Status {
        fault: Some(Fault::OverCurrent),
        ..Status::default()
    };
    coordinator.advance(1000, &faulted, None);
    for command in [Command::SelfTest, Command::Run, Command::Open] {
        let refused = Err(Refused::Faulted(Fault::OverCurrent));
        assert_eq!(coordinator.command(command), refused, "{command:?}");
    }
    assert!(!coordinator.set_test(Setpoint::Current { a: 0.04 }));
    for command in [
        Command::Set(Setting::HoldTime, 1.0),
        Command::Calibrate(Calibrate::Forget),
        Command::Save,
        Command::Factory,
        Command::Stop,
    ] {
        assert!(coordinator.command(command).is_ok(), "{command:?}");
    }
}

/// Nor while the finger moves.
#[test]
fn a_self_test_does_not_begin_in_a_motion() {
    let mut coordinator = coordinator();
    coordinator.command(Command::Run).expect("at rest");
    let status = Status::default();
    coordinator.advance(1000, &status, None);
    let busy = Err(Refused::Busy(State::CalibrateOffset));
    assert_eq!(coordinator.command(Command::SelfTest), busy);
    assert!(!coordinator.set_test(Setpoint::Current { a: 0.04 }));
    let step = coordinator.advance(2000, &status, None);
    assert_eq!(step.motion.demand.setpoint, Setpoint::MeasureOffset);
}
