//! The transition table, and stop, against what really happens.

use super::*;

/// Every transition that ever happens, by stimulating every state with everything.
#[test]
fn the_table_is_what_really_happens_no_more_no_less() {
    let mut seen = std::collections::BTreeSet::new();
    let stimuli = |state: State| -> Vec<(Option<Request>, Option<Notice>, bool)> {
        let _ = state;
        let requests = [
            Request::Run,
            Request::Close,
            Request::Open,
            Request::Stop,
            Request::Clear,
            Request::Home,
            Request::RecordFriction,
            Request::Press,
        ];
        let notices = [
            Notice::Touched,
            Notice::Settled,
            Notice::FrictionKnown,
            Notice::FrictionUnknown,
            Notice::FrictionNotRecorded,
            Notice::Fault(Fault::QueueOverflow),
        ];
        requests
            .iter()
            .map(|&request| (Some(request), None, false))
            .chain(notices.iter().map(|&notice| (None, Some(notice), false)))
            .chain([(None, None, true)])
            .collect()
    };
    // Goals and whether a record is there lead to every state on every way.
    for goal in [
        Request::Run,
        Request::Close,
        Request::Open,
        Request::Home,
        Request::RecordFriction,
        Request::Press,
    ] {
        for known in [false, true] {
            for homed_before in [false, true] {
                let mut simulation = Simulation::new(7);
                simulation.bench.object_rad = 0.9;
                simulation.bench.object_nm_per_rad = 0.4;
                if homed_before {
                    simulation.run(Request::Home, 60);
                    if !known {
                        // Somewhere on the way.
                        simulation.bench.object_rad = 0.4;
                        simulation.sequence.friction_known = true;
                        simulation.run(Request::Close, 60);
                    }
                }
                simulation.bench.object_rad = if known { 0.9 } else { f64::INFINITY };
                simulation.sequence.friction_known = known;
                simulation.sequence.set_press(!homed_before);
                simulation.done = None;
                let _ = simulation.sequence.request(goal);
                let mut last = None;
                for _ in 0..40_000 {
                    let state = simulation.sequence.state();
                    if last != Some(state) {
                        last = Some(state);
                        for (request, notice, late) in stimuli(state) {
                            let mut fork = simulation.sequence.clone();
                            if let Some(request) = request {
                                let _ = fork.request(request);
                            }
                            let now_us = if late {
                                simulation.now_us + 1_000_000_000
                            } else {
                                simulation.now_us + 1
                            };
                            let advance =
                                fork.advance(now_us, simulation.controller.status(), notice);
                            seen.extend(advance.changed.map(|(a, b)| (a.name(), b.name())));
                            assert_ne!(
                                fork.fault(),
                                Some(Fault::IllegalTransition),
                                "{state:?} {request:?} {notice:?}"
                            );
                            let limited = state.timeout_s(&motion()).is_some();
                            if late && limited {
                                assert_eq!(fork.fault(), Some(Fault::StateTimeout), "{state:?}");
                            }
                        }
                    }
                    simulation.millisecond(None);
                    if simulation.done.is_some() {
                        break;
                    }
                }
                seen.extend(simulation.log.iter().map(|&(a, b)| (a.name(), b.name())));
                assert_eq!(
                    simulation.sequence.fault(),
                    None,
                    "{goal:?} {known} {homed_before} {:?}",
                    simulation.log
                );
            }
        }
    }
    // Clearing.
    let mut simulation = Simulation::new(9);
    simulation.millisecond(Some(Notice::Fault(Fault::BadRecord)));
    simulation.clear();
    seen.extend(simulation.log.iter().map(|&(a, b)| (a.name(), b.name())));
    let table: std::collections::BTreeSet<_> = State::ALL
        .iter()
        .flat_map(|from| from.successors().iter().map(|to| (from.name(), to.name())))
        .collect();
    assert_eq!(seen, table);
}

#[test]
fn stop_works_in_every_state_and_beats_what_was_asked_before_and_after() {
    let mut simulation = Simulation::new(3);
    simulation.bench.object_rad = 0.9;
    simulation.sequence.request(Request::Run).expect("accepted");
    let mut tried = std::collections::BTreeSet::new();
    for _ in 0..60_000 {
        simulation.millisecond(None);
        let state = simulation.sequence.state();
        if state == State::RecordClosing {
            simulation.bench.object_rad = f64::INFINITY;
        } else if state == State::Close {
            simulation.bench.object_rad = 0.9;
        }
        if tried.insert(state.name()) && state != State::Idle {
            let mut fork = simulation.sequence.clone();
            let _ = fork.request(Request::Open);
            fork.request(Request::Stop).expect("never refused");
            for other in [Request::Run, Request::Open, Request::Close, Request::Home] {
                assert!(fork.request(other).is_err(), "{state:?}");
            }
            let advance = fork.advance(
                simulation.now_us + 1,
                simulation.controller.status(),
                Some(Notice::Touched),
            );
            assert_eq!(advance.demand.setpoint, Setpoint::Off, "{state:?}");
            assert_eq!(advance.done, Some(MotionResult::Stopped), "{state:?}");
        }
        if simulation.done.is_some() {
            break;
        }
    }
    // All but the state of a fault, where the motor is off already.
    assert_eq!(
        tried.len(),
        State::ALL.len() - 1,
        "{tried:?} {:?}",
        simulation.sequence.fault()
    );
}
