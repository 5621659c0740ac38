//! The current that holds an object.

use core::cell::Cell;

use super::*;
use crate::sensing::NotLocated;

pub(super) fn located(force_n: f32) -> Event {
    Event::Located {
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
    }
}

/// The same before the last word.
fn refined(force_n: f32) -> Event {
    let mut event = located(force_n);
    if let Event::Located { settled, .. } = &mut event {
        *settled = false;
    }
    event
}

/// Closes, probes with a current of 80 mA over a free one of 20 mA, both known after a hundred samples, and holds.
fn holding(coordinator: &mut Coordinator<P70>) {
    holding_after(coordinator, 0.08);
}

/// The same after probing has ended with another current, ampere, at the end of the travel.
fn holding_after(coordinator: &mut Coordinator<P70>, probed_a: f32) {
    holding_told(coordinator, probed_a, None, false);
}

/// The same with a last word while probing, if there is one, which may end it.
fn holding_told(
    coordinator: &mut Coordinator<P70>,
    probed_a: f32,
    last: Option<&Event>,
    ends: bool,
) {
    known(coordinator);
    coordinator.command(Command::Close).expect("at rest");
    let mut status = Status {
        homed: true,
        ..Status::default()
    };
    let mut now_us = 0;
    let position_counts = Cell::new(0);
    let mut advance = |coordinator: &mut Coordinator<P70>, current_a, notice| {
        now_us += 1000;
        status.position_counts = position_counts.get();
        status.current_a = current_a;
        status.offset = [OffsetState::Measuring, OffsetState::Known][usize::from(now_us > 3000)];
        coordinator.advance(now_us, &status, notice);
    };
    while coordinator.state() != State::Close {
        advance(coordinator, 0.0, None);
    }
    // The free current is a mean over some hundred samples.
    for _ in 0..100 {
        advance(coordinator, 0.02, None);
    }
    advance(coordinator, 0.02, Some(Notice::Touched));
    assert_eq!(coordinator.state(), State::Probe);
    advance(coordinator, probed_a, None);
    if let Some(last) = last {
        // In the order of the board: the event, then its notice.
        let _ = coordinator.event(last);
        advance(coordinator, probed_a, ends.then_some(Notice::Settled));
    }
    if !ends {
        position_counts.set(P70::CHECKED.scale().counts(P70::MOTION.travel_rad));
        advance(coordinator, probed_a, None);
    }
    assert_eq!(coordinator.state(), State::Hold);
    // What the motor takes while it turns counts, not what it is given to hold.
    for _ in 0..10 {
        advance(coordinator, 0.03, None);
    }
}

fn held_a(coordinator: &Coordinator<P70>) -> f32 {
    coordinator.sequence.motion().holding_current_a
}

/// The current that holds follows from that of probing, though the last word comes while the motor holds with another one.
#[test]
fn a_located_contact_sets_the_holding_current() {
    let mut coordinator = coordinator();
    holding(&mut coordinator);
    let expected_a = coordinator.hold.current_a(2.0, 1.0).expect("a load");
    assert!(!coordinator.event(&located(2.0)), "within the limit");
    assert!((held_a(&coordinator) - expected_a).abs() < 1e-6);
    assert!((0.04..0.07).contains(&expected_a), "{expected_a}");
    // Nothing follows from what is no force, before the last word; that one takes back what was told before.
    assert!(!coordinator.event(&refined(f32::NAN)));
    assert!((held_a(&coordinator) - expected_a).abs() < 1e-6);
    for last in [
        located(f32::NAN),
        located(-1.0),
        Event::NotLocated {
            why: NotLocated::Unexplained,
            torque_nm: 0.1,
        },
    ] {
        assert!(!coordinator.event(&refined(2.0)));
        assert!((held_a(&coordinator) - expected_a).abs() < 1e-6);
        assert!(!coordinator.event(&last));
        assert!((held_a(&coordinator) - P70::MOTION.holding_current_a).abs() < 1e-6);
    }
    assert!(!coordinator.event(&located(2.0)));
    // The next grasp may end in a contact without a force: it is held as the scene says.
    coordinator.command(Command::Stop).expect("never refused");
    coordinator.advance(1_000_000, &Status::default(), None);
    coordinator.command(Command::Run).expect("at rest");
    assert!((held_a(&coordinator) - P70::MOTION.holding_current_a).abs() < 1e-6);
    // Nor does what comes late of the last one count.
    coordinator.advance(1_001_000, &Status::default(), None);
    assert!(!coordinator.event(&located(0.1)));
    assert!((held_a(&coordinator) - P70::MOTION.holding_current_a).abs() < 1e-6);
}

/// With more the finger would close on, and the force that the last word tells would not be that of the current of probing.
#[test]
fn before_the_last_word_a_finger_is_held_with_no_more_than_it_was_probed_with() {
    let mut coordinator = coordinator();
    holding_after(&mut coordinator, 0.045);
    assert!((held_a(&coordinator) - 0.045).abs() < 1e-6);
    let expected_a = coordinator.hold.current_a(0.5, 1.0).expect("a load");
    assert!(!coordinator.event(&located(0.5)) && expected_a > 0.06);
    assert!((held_a(&coordinator) - expected_a).abs() < 1e-6);
    // A last word without a force may be that of a contact that was lost: with more the finger would speed up.
    assert!(!coordinator.event(&located(f32::NAN)));
    assert!((held_a(&coordinator) - 0.045).abs() < 1e-6);
    // Braked as probing ended, the motor must not open the finger.
    let mut coordinator = super::coordinator();
    holding_after(&mut coordinator, -0.02);
    assert_eq!(held_a(&coordinator), 0.0);
    // Probed with more, it is held as the scene says from the beginning.
    let mut coordinator = super::coordinator();
    holding(&mut coordinator);
    assert!((held_a(&coordinator) - P70::MOTION.holding_current_a).abs() < 1e-6);
}

/// Where the last word ends probing its current is that of the force, though probing took less; so it is where a second contact is looked
/// for after it, until the travel ends.
#[test]
fn after_the_last_word_a_finger_is_held_with_what_its_force_needs() {
    for ends in [true, false] {
        let mut coordinator = coordinator();
        holding_told(&mut coordinator, 0.045, Some(&located(0.5)), ends);
        let expected_a = coordinator.hold.current_a(0.5, 1.0).expect("a load");
        assert!(expected_a > 0.06, "{expected_a}");
        assert!((held_a(&coordinator) - expected_a).abs() < 1e-6, "{ends}");
        // That of the next grasp has not been told yet.
        coordinator.command(Command::Stop).expect("never refused");
        coordinator.advance(1_000_000, &Status::default(), None);
        holding_after(&mut coordinator, 0.045);
        assert!((held_a(&coordinator) - 0.045).abs() < 1e-6, "{ends}");
    }
}

/// At most what the user allows; the last word says so where that is too little.
#[test]
fn a_force_that_cannot_be_held_is_told() {
    let mut coordinator = coordinator();
    let overrides = &mut coordinator.overrides;
    overrides.set(Setting::HoldForce, 20.0).expect("in range");
    overrides
        .set(Setting::CurrentLimit, 0.05)
        .expect("in range");
    holding(&mut coordinator);
    assert!(!coordinator.event(&refined(1.5)), "once, at the end");
    assert!(coordinator.event(&located(1.5)));
    assert!((held_a(&coordinator) - 0.05).abs() < 1e-6);
}
