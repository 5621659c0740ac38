//! Grasp after grasp: when probing and holding end, and what a motion must not inherit of the last.

use super::*;
use crate::drive::sequence::state::JUDGING_S;

/// Runs until a state is left; how long it lasted, seconds, and where the finger was at its end.
fn lasts(
    simulation: &mut Simulation,
    state: State,
    mut notice: impl FnMut(u32) -> Option<Notice>,
) -> (f32, f64) {
    let mut ms = 0;
    for _ in 0..60_000 {
        let is_there = simulation.sequence.state() == state;
        let told = if is_there { notice(ms) } else { None };
        ms += u32::from(is_there);
        simulation.millisecond(told);
        if ms > 0 && simulation.sequence.state() != state {
            return (1e-3 * ms as f32, simulation.bench.link_rad());
        }
    }
    panic!("{state:?}: {:?}", simulation.log);
}

/// The object is held until sensing has said its last word, in every grasp anew.
#[test]
fn an_object_is_held_until_its_contact_is_judged() {
    let mut simulation = Simulation::new(2);
    simulation.bench.object_rad = 0.8;
    simulation.sequence.friction_known = true;
    let holding_s = motion().holding_s;
    for settles_ms in [Some(10), None, Some(2000), None] {
        simulation.sequence.request(Request::Run).expect("at rest");
        simulation.done = None;
        let (held_s, _) = lasts(&mut simulation, State::Hold, |ms| {
            (Some(ms) == settles_ms).then_some(Notice::Settled)
        });
        let expected_s = match settles_ms {
            Some(ms) => holding_s.max(1e-3 * ms as f32),
            None => holding_s + JUDGING_S,
        };
        assert!(
            (held_s - expected_s).abs() < 0.01,
            "{settles_ms:?}: {held_s} s"
        );
        while simulation.done.is_none() {
            simulation.millisecond(None);
        }
    }
}

/// Something soft never makes the motor stall.
#[test]
fn probing_ends_after_its_way_and_where_the_travel_ends() {
    let Motion {
        probing_rad,
        travel_rad,
        ..
    } = motion();
    for object_rad in [0.4, 1.2] {
        let mut simulation = Simulation::new(2);
        simulation.bench.object_rad = object_rad;
        simulation.bench.object_nm_per_rad = 0.02;
        simulation.sequence.friction_known = true;
        simulation.sequence.request(Request::Run).expect("at rest");
        let (_, end_rad) = lasts(&mut simulation, State::Probe, |_| None);
        assert_eq!(simulation.sequence.state(), State::Hold);
        let expected_rad = (object_rad + f64::from(probing_rad)).min(f64::from(travel_rad));
        // It is told of the contact a little later than it began.
        assert!(
            (-0.015..0.03).contains(&(end_rad - expected_rad)),
            "{object_rad}: {end_rad}"
        );
    }
}

/// A clearing clears the fault it was asked for, and none that comes later.
#[test]
fn the_next_fault_stays_until_it_is_cleared_as_well() {
    let mut simulation = Simulation::new(1);
    for fault in [Fault::QueueOverflow, Fault::BadRecord] {
        simulation.millisecond(Some(Notice::Fault(fault)));
        for _ in 0..100 {
            simulation.millisecond(None);
            assert_eq!(simulation.sequence.state(), State::Fault);
            assert_eq!(simulation.sequence.fault(), Some(fault));
        }
        simulation.clear();
        assert_eq!(simulation.sequence.state(), State::Idle);
    }
}

/// After a recording that sensing could not use, the next motion records again.
#[test]
fn a_recording_that_is_unusable_is_repeated() {
    for notice in [Notice::FrictionNotRecorded, Notice::FrictionUnknown] {
        let mut simulation = Simulation::new(1);
        simulation.sequence.friction_known = true;
        simulation.millisecond(Some(notice));
        assert!(!simulation.sequence.friction_known(), "{notice:?}");
        simulation.ends(Request::Close, MotionResult::NoContact);
        assert!(simulation.states().contains(&State::RecordClosing));
    }
}

/// Where counts may be lost, however few, the zero of the record is not kept.
#[test]
fn an_encoder_s_fault_has_the_zero_found_anew() {
    for (fault, keeps) in [(Fault::QueueOverflow, true), (Fault::EncoderJump, false)] {
        let mut simulation = Simulation::new(2);
        simulation.ends(Request::RecordFriction, MotionResult::Complete);
        simulation.ends(Request::Home, MotionResult::Complete);
        assert_eq!(simulation.demand.zero_at_counts, 0);
        simulation.millisecond(Some(Notice::Fault(fault)));
        simulation.clear();
        simulation.ends(Request::Home, MotionResult::Complete);
        assert_eq!(simulation.demand.zero_at_counts == 0, keeps, "{fault:?}");
    }
}

/// All the current there is, where the finger may be pressed on something; gently otherwise, or the stop that is found shifts.
#[test]
fn homing_starts_with_force_after_a_fault_or_a_grip_alone() {
    let first_limit_a = |simulation: &mut Simulation| {
        simulation.done = None;
        simulation.sequence.request(Request::Home).expect("at rest");
        while simulation.sequence.state() != State::Home {
            simulation.millisecond(None);
        }
        let setpoint = simulation.demand.setpoint;
        while simulation.done.is_none() {
            simulation.millisecond(None);
        }
        match setpoint {
            Setpoint::Speed {
                current_limit_a, ..
            } => current_limit_a,
            other => panic!("{other:?}"),
        }
    };
    let mut simulation = Simulation::new(1);
    let gently_a = motion().homing_current_a;
    assert_eq!(first_limit_a(&mut simulation), gently_a);
    simulation.millisecond(Some(Notice::Fault(Fault::QueueOverflow)));
    simulation.clear();
    let force_a = f32::MAX;
    assert_eq!(first_limit_a(&mut simulation), force_a);
    assert_eq!(first_limit_a(&mut simulation), gently_a);
    // A finger that was left gripping.
    simulation.bench.object_rad = 0.8;
    simulation.sequence.friction_known = true;
    simulation.done = None;
    simulation
        .sequence
        .request(Request::Close)
        .expect("at rest");
    while simulation.done.is_none() {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.sequence.state(), State::Idle);
    assert_eq!(first_limit_a(&mut simulation), force_a);
    assert_eq!(first_limit_a(&mut simulation), gently_a);
}

/// Nothing leads there; if something does, the bridge is off and says why.
#[test]
fn a_step_that_is_not_in_the_table_is_a_fault() {
    let mut simulation = Simulation::new(1);
    let status = *simulation.controller.status();
    simulation.sequence.enter(State::Hold, 0, &status);
    let step = simulation.millisecond(None);
    assert_eq!(step.demand.setpoint, Setpoint::Off);
    assert_eq!(simulation.sequence.state(), State::Fault);
    assert_eq!(simulation.sequence.fault(), Some(Fault::IllegalTransition));
}
