//! Motions from their begin to their end.

use super::*;

#[test]
fn a_run_without_object_records_closes_and_opens() {
    use State::*;
    let mut simulation = Simulation::new(1);
    simulation.ends(Request::Run, MotionResult::NoContact);
    assert_eq!(
        simulation.states(),
        [
            CalibrateOffset,
            Home,
            RecordClosing,
            RecordOpening,
            Close,
            Open,
            Idle
        ]
    );
    simulation.log.clear();
    simulation.ends(Request::Run, MotionResult::NoContact);
    assert_eq!(
        simulation.states(),
        [CalibrateOffset, Home, Close, Open, Idle],
        "the record is kept"
    );
}

#[test]
fn a_run_with_object_probes_and_holds() {
    use State::*;
    let mut simulation = Simulation::new(2);
    simulation.bench.object_rad = 0.8;
    simulation.sequence.friction_known = true;
    simulation.ends(Request::Run, MotionResult::Contact);
    assert_eq!(
        simulation.states(),
        [CalibrateOffset, Home, Close, Probe, Hold, Open, Idle]
    );
    assert!(simulation.bench.link_rad() < 0.07);
}

#[test]
fn homing_finds_the_stop_and_not_the_windup() {
    for (seed, start_rad) in [(1, 0.02), (2, 0.5), (3, 1.4)] {
        let mut simulation = Simulation::new(seed);
        simulation.bench.angle = start_rad * 1280.0;
        simulation.ends(Request::Home, MotionResult::Complete);
        let zero_rad = simulation.bench.link_rad()
            - f64::from(
                simulation
                    .controller
                    .scale()
                    .angle_rad(simulation.controller.status().position_counts),
            );
        // The stop is at 0, the motor stands at about -0.03 with the bench's friction and cable.
        assert!(zero_rad.abs() < 0.012, "zero off by {zero_rad} rad");
    }
}

#[test]
fn the_zero_stays_with_the_friction_record_unless_counts_were_lost() {
    let mut simulation = Simulation::new(2);
    let zero_rad = |simulation: &Simulation| {
        let position_counts = simulation.controller.status().position_counts;
        simulation.bench.link_rad()
            - f64::from(simulation.controller.scale().angle_rad(position_counts))
    };
    // Where the encoder counts from, which only a new zero changes.
    let zeros = |simulation: &Simulation| simulation.demand.zero_at_counts;
    simulation.ends(Request::RecordFriction, MotionResult::Complete);
    let first_rad = zero_rad(&simulation);
    assert_ne!(zeros(&simulation), 0);
    for _ in 0..2 {
        simulation.ends(Request::Home, MotionResult::Complete);
        assert_eq!(zeros(&simulation), 0, "the zero of the record");
    }
    let lose = |simulation: &mut Simulation, lost_counts: i32| {
        let zero = simulation.controller.status().zero;
        for (zero, zero_at_counts) in [(zero.wrapping_add(1), lost_counts), (zero, 0)] {
            let demand = Demand {
                zero,
                zero_at_counts,
                ..simulation.demand
            };
            let inputs = simulation.bench.step(simulation.outputs);
            simulation.outputs = simulation.controller.step(&inputs, &demand);
        }
        simulation.millisecond(None);
    };
    for lost_counts in [-12_000i32, 12_000] {
        lose(&mut simulation, lost_counts);
        let off_rad = zero_rad(&simulation) - first_rad;
        assert!(off_rad.abs() > 0.03, "{lost_counts}: {off_rad} rad");
        simulation.ends(Request::Home, MotionResult::Complete);
        assert_ne!(zeros(&simulation), 0, "{lost_counts}");
        let off_rad = zero_rad(&simulation) - first_rad;
        assert!(off_rad.abs() < 0.025, "{lost_counts}: {off_rad} rad");
    }
    // Without a record there is nothing for the zero to fit: however few counts are lost, it is found anew.
    lose(&mut simulation, 500);
    simulation.sequence.forget_friction();
    simulation.ends(Request::Home, MotionResult::Complete);
    assert_ne!(zeros(&simulation), 0);
}

#[test]
fn pressing_ends_at_the_closing_stop() {
    use State::*;
    let mut simulation = Simulation::new(3);
    simulation.sequence.friction_known = true;
    simulation.ends(Request::Press, MotionResult::Complete);
    assert_eq!(
        simulation.states(),
        [CalibrateOffset, Home, Close, Open, Idle]
    );
}

/// Whoever records friction shows that nothing is in the way. What was asked for follows the press.
#[test]
fn a_recording_is_followed_by_a_press_where_nobody_knows_the_cable() {
    use State::*;
    let recorded = [CalibrateOffset, Home, RecordClosing, RecordOpening];
    for (request, result, last) in [
        (
            Request::RecordFriction,
            MotionResult::Complete,
            &[Close, Open, Idle][..],
        ),
        (
            Request::Run,
            MotionResult::NoContact,
            &[Close, Open, Close, Open, Idle],
        ),
        (Request::Press, MotionResult::Complete, &[Close, Open, Idle]),
    ] {
        let mut simulation = Simulation::new(3);
        simulation.sequence.set_press(true);
        simulation.ends(request, result);
        assert_eq!(simulation.states(), [&recorded[..], last].concat());
    }
}

/// Once the sensing has found the record good, that press has begun, and another recording needs none.
#[test]
fn another_recording_is_not_followed_by_a_press() {
    let mut simulation = Simulation::new(3);
    simulation.sequence.set_press(true);
    let record = simulation.sequence.request(Request::RecordFriction);
    record.expect("accepted");
    while simulation.sequence.state() != State::Close {
        simulation.millisecond(None);
    }
    simulation.millisecond(Some(Notice::FrictionKnown));
    while simulation.done.is_none() {
        simulation.millisecond(None);
    }
    simulation.log.clear();
    simulation.ends(Request::RecordFriction, MotionResult::Complete);
    assert!(!simulation.states().contains(&State::Close));
}

/// A record that becomes stale during the press is recorded anew before what was asked for follows.
#[test]
fn after_a_press_with_a_stale_record_friction_is_recorded_again() {
    use State::*;
    let mut simulation = Simulation::new(3);
    simulation.sequence.set_press(true);
    simulation.sequence.request(Request::Run).expect("accepted");
    while simulation.sequence.state() != Close {
        simulation.millisecond(None);
    }
    simulation.millisecond(Some(Notice::FrictionKnown));
    simulation.millisecond(Some(Notice::FrictionUnknown));
    while simulation.done.is_none() {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.done, Some(MotionResult::NoContact));
    assert_eq!(
        simulation.states()[4..],
        [Close, Open, RecordClosing, RecordOpening, Close, Open, Idle]
    );
}

#[test]
fn a_press_ends_where_friction_was_not_recorded_or_the_user_opens() {
    for (notice, request, result) in [
        (
            Some(Notice::FrictionNotRecorded),
            None,
            MotionResult::NotRecorded,
        ),
        (None, Some(Request::Open), MotionResult::Complete),
    ] {
        let mut simulation = Simulation::new(3);
        simulation.sequence.set_press(true);
        simulation.sequence.request(Request::Run).expect("accepted");
        while simulation.sequence.state() != State::Close {
            simulation.millisecond(None);
        }
        assert!(simulation.sequence.is_pressing());
        if let Some(request) = request {
            simulation.sequence.request(request).expect("accepted");
        }
        simulation.millisecond(notice);
        assert_eq!(simulation.sequence.state(), State::Open);
        while simulation.done.is_none() {
            simulation.millisecond(None);
        }
        assert_eq!(simulation.done, Some(result));
    }
}

#[test]
fn pressing_on_a_soft_cable_ends_at_the_position_limit() {
    let mut simulation = Simulation::new(3);
    simulation.ends(Request::Home, MotionResult::Complete);
    // As if the cable wound up without end: the torque never reaches the current limit.
    simulation.bench.wrong = Defect::NoStop;
    simulation.sequence.friction_known = true;
    simulation.ends(Request::Press, MotionResult::Complete);
}

/// A finger that holds an object, with friction known.
fn grasping(seed: u64) -> Simulation {
    let mut simulation = Simulation::new(seed);
    simulation.bench.object_rad = 0.5;
    simulation.sequence.friction_known = true;
    simulation.ends(Request::Close, MotionResult::Contact);
    simulation
}

/// Pressed on, an object in the finger would be taken for the stop.
#[test]
fn a_press_of_a_closed_finger_begins_with_its_opening() {
    use State::*;
    let mut simulation = grasping(3);
    // Taken away as soon as the finger lets go.
    simulation.bench.object_rad = f64::INFINITY;
    simulation.log.clear();
    simulation.ends(Request::Press, MotionResult::Complete);
    assert_eq!(
        simulation.states(),
        [CalibrateOffset, Open, Close, Open, Idle]
    );
}

#[test]
fn close_keeps_the_grip_and_open_lets_go() {
    let mut simulation = grasping(4);
    assert!(simulation.bench.link_rad() > 0.5);
    simulation.ends(Request::Open, MotionResult::Complete);
    assert!(simulation.bench.link_rad() < 0.07);
}

/// A closing that begins under load would miss where the contact began.
#[test]
fn a_second_closing_begins_with_an_opening() {
    use State::*;
    let mut simulation = grasping(7);
    simulation.log.clear();
    simulation.ends(Request::Close, MotionResult::Contact);
    assert_eq!(
        simulation.states(),
        [CalibrateOffset, Open, Close, Probe, Hold, Idle]
    );
}

/// The bench's worm takes as much current to be started under a load as made the load, free motion a third of it.
#[test]
fn a_worm_that_settled_under_load_is_broken_away() {
    let pressed = |seed| {
        let mut simulation = grasping(seed);
        let mut motion = motion();
        motion.free_current_a = 0.06;
        simulation.sequence.set_motion(motion);
        simulation
    };
    let mut simulation = pressed(5);
    simulation.ends(Request::Open, MotionResult::Complete);
    assert!(simulation.bench.link_rad() < 0.07);

    // After a fault the position counts for nothing: homing has to start from the object.
    let mut simulation = pressed(6);
    simulation.millisecond(Some(Notice::Fault(Fault::QueueOverflow)));
    simulation.clear();
    simulation.ends(Request::Home, MotionResult::Complete);
    assert!(simulation.bench.link_rad() < 0.07);
}
