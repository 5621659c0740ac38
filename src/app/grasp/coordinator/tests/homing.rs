//! What homing means for the sensing.

use super::*;

/// What sensing is asked for while the finger homes on a stop that is at an angle from the encoder's zero.
fn homes(
    coordinator: &mut Coordinator<P70>,
    status: &mut Status,
    stop_rad: f32,
) -> Vec<SensingRequest> {
    let scale = P70::CHECKED.scale();
    let mut stop_counts = scale.counts(stop_rad);
    status.position_counts = scale.counts(stop_rad + 0.5);
    status.offset = OffsetState::Measuring;
    coordinator.command(Command::Home).expect("at rest");
    let mut told = Vec::new();
    let mut rests = 0;
    for ms in 0..20_000 {
        let step = coordinator.advance(ms * 1000, status, None);
        told.extend(step.request);
        let demand = &step.motion.demand;
        if demand.zero != status.zero {
            status.zero = demand.zero;
            status.position_counts -= demand.zero_at_counts;
            stop_counts -= demand.zero_at_counts;
        }
        let speed = match demand.setpoint {
            Setpoint::Speed { counts_per_s, .. } => counts_per_s,
            _ => 0.0,
        };
        let free_counts = status.position_counts + (1e-3 * speed) as i32;
        status.limited.current = free_counts < stop_counts;
        status.speed_counts_per_s = if status.limited.current { 0.0 } else { speed };
        status.position_counts = free_counts.max(stop_counts);
        if ms > 10 {
            status.offset = OffsetState::Known;
            rests += u32::from(coordinator.state() == State::Idle);
        }
        // What waits is handed over one at a time.
        if rests > 3 {
            return told;
        }
    }
    panic!("{:?}", coordinator.state());
}

/// A homing that ends before the finger meets its stop finds no zero, whatever the last one found.
#[test]
fn a_homing_that_is_stopped_leaves_the_friction_record_aligned() {
    let mut coordinator = coordinator();
    known(&mut coordinator);
    let mut status = Status::default();
    let told = homes(&mut coordinator, &mut status, -0.3);
    assert!(told.contains(&SensingRequest::Realign), "{told:?}");
    coordinator.command(Command::Home).expect("at rest");
    let mut told = Vec::new();
    for ms in 0..100 {
        status.offset = [OffsetState::Measuring, OffsetState::Known][usize::from(ms > 10)];
        if ms == 50 {
            assert_eq!(coordinator.state(), State::Home);
            coordinator.command(Command::Stop).expect("never refused");
        }
        told.extend(
            coordinator
                .advance(30_000_000 + ms * 1000, &status, None)
                .request,
        );
    }
    assert_eq!(coordinator.state(), State::Idle);
    assert!(!told.contains(&SensingRequest::Realign), "{told:?}");
}

/// A stop that is elsewhere than the zero of the friction record says that counts were lost.
#[test]
fn a_zero_that_moves_has_the_friction_record_aligned_anew() {
    let mut coordinator = coordinator();
    known(&mut coordinator);
    let mut status = Status::default();
    for (stop_rad, moves) in [(-0.3, true), (0.0, false), (0.004, false), (0.08, true)] {
        let told = homes(&mut coordinator, &mut status, stop_rad);
        assert_eq!(
            told.contains(&SensingRequest::Realign),
            moves,
            "{stop_rad}: {told:?}"
        );
    }
}
