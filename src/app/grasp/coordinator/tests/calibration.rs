//! When the finger presses on its stop, and which calibration stays in force.

use super::*;
use crate::app::grasp::sensing::ContactSensing;
use crate::app::storage::record::Record;
use crate::sensing::Calibration;

/// Records friction from rest; whether the sensing is told of a press on the closing stop afterwards. Then stops.
fn presses(coordinator: &mut Coordinator<P70>) -> bool {
    let record = coordinator.command(Command::RecordFriction);
    record.expect("at rest");
    let mut requests = Vec::new();
    for step in 1..20 {
        let beyond_the_travel = coordinator.state() == State::RecordClosing;
        let status = Status {
            homed: true,
            offset: [OffsetState::Measuring, OffsetState::Known][usize::from(step > 3)],
            position_counts: if beyond_the_travel { i32::MAX / 2 } else { 0 },
            ..Status::default()
        };
        requests.extend(coordinator.advance(1000 * step, &status, None).request);
    }
    let record = SensingRequest::Direct(Directive::RecordFriction);
    assert!(requests.contains(&record), "{requests:?}");
    coordinator.command(Command::Stop).expect("never refused");
    coordinator.advance(20_000, &Status::default(), None);
    assert_eq!(coordinator.state(), State::Idle);
    requests.contains(&SensingRequest::Direct(Directive::CalibrateCable))
}

/// Where there is a cable the first recording leads to a press on the closing stop, and so does the first after `calibrate forget`;
/// a calibration that was kept from before needs none, with a record of friction or without.
#[test]
fn the_first_recording_leads_to_a_press() {
    let mut coordinator = coordinator();
    assert!(presses(&mut coordinator), "nobody knows the cable");
    known(&mut coordinator);
    assert!(!presses(&mut coordinator), "pressed before");
    let mut restarted = Coordinator::new(Overrides::default(), 1);
    assert!(!presses(&mut restarted), "a calibration from before");
    let forget = coordinator.command(Command::Calibrate(Calibrate::Forget));
    forget.expect("at rest");
    assert!(presses(&mut coordinator), "forgotten");
}

/// A recording that is stopped while the finger opens may be good, but no press has followed it.
#[test]
fn a_recording_that_was_stopped_leaves_the_press_due() {
    let mut coordinator = coordinator();
    known(&mut coordinator);
    assert!(presses(&mut coordinator), "nobody knows the cable");
}

/// Nothing of it is left for a `save` after it.
#[test]
fn factory_forgets_what_was_learnt_and_recorded() {
    let mut coordinator = Coordinator::<P70>::new(Overrides::default(), 1);
    known(&mut coordinator);
    let factory = coordinator.command(Command::Factory);
    assert_eq!(factory, Ok(Action::Factory));
    assert!(!coordinator.friction_known());
    let told = [1, 2].map(|i| coordinator.advance(i, &Status::default(), None).request);
    assert!(
        told.contains(&Some(SensingRequest::ForgetCalibration)),
        "{told:?}"
    );
    assert!(presses(&mut coordinator), "nobody knows the cable any more");
}

/// The torque factor corrects the efficiency that it was calibrated with.
#[test]
fn another_efficiency_forgets_the_calibration() {
    for (setting, value, forgets) in [
        (Setting::Efficiency, 0.45, true),
        (Setting::Efficiency, P70::EFFICIENCY, false),
        (Setting::HoldForce, 0.45, false),
    ] {
        let mut coordinator = Coordinator::<P70>::new(Overrides::default(), 1);
        let mut sensing = ContactSensing::<P70>::new();
        let calibrated = Calibration {
            torque_factor: 0.9,
            presses: 1,
            contacts: 1,
            ..P70::UNCALIBRATED
        };
        sensing.restore(&Record {
            overrides: &Overrides::default(),
            calibration: &calibrated,
            friction: None,
            identified: None,
        });
        let set = coordinator.command(Command::Set(setting, value));
        set.expect("at rest");
        let request = coordinator.advance(1000, &Status::default(), None).request;
        sensing.request(request.expect("another setting"));
        let kept = if forgets {
            P70::UNCALIBRATED
        } else {
            calibrated
        };
        assert_eq!(*sensing.calibration(), kept, "{setting:?} {value}");
        // What was calibrated with another efficiency is not known any more.
        assert_eq!(presses(&mut coordinator), forgets, "{setting:?} {value}");
    }
}
