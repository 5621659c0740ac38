//! Motions from their begin to their end.

use super::*;

#[test]
fn a_run_without_object_records_closes_and_opens() {
    use State::*;
    let mut rig = Rig::new(1);
    assert_eq!(
        rig.run(Request::Run, 60),
        Some(Outcome::NoContact),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(
        rig.states(),
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
    rig.log.clear();
    assert_eq!(rig.run(Request::Run, 60), Some(Outcome::NoContact));
    assert_eq!(
        rig.states(),
        [CalibrateOffset, Home, Close, Open, Idle],
        "the record is kept"
    );
}

#[test]
fn a_run_with_object_probes_and_holds() {
    use State::*;
    let mut rig = Rig::new(2);
    rig.bench.object_rad = 0.8;
    rig.sequence.friction_known = true;
    assert_eq!(
        rig.run(Request::Run, 60),
        Some(Outcome::Contact),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(
        rig.states(),
        [CalibrateOffset, Home, Close, Probe, Hold, Open, Idle]
    );
    assert!(rig.bench.link_rad() < 0.07);
}

#[test]
fn homing_finds_the_stop_and_not_the_windup() {
    for (seed, start_rad) in [(1, 0.02), (2, 0.5), (3, 1.4)] {
        let mut rig = Rig::new(seed);
        rig.bench.angle = start_rad * 1280.0;
        assert_eq!(
            rig.run(Request::Home, 60),
            Some(Outcome::Complete),
            "{:?}",
            rig.sequence.fault()
        );
        let zero_rad = rig.bench.link_rad()
            - f64::from(
                rig.controller
                    .scale()
                    .angle_rad(rig.controller.status().position_counts),
            );
        // The stop is at 0, the motor stands at about -0.03 with the bench's friction and cable.
        assert!(zero_rad.abs() < 0.012, "zero off by {zero_rad} rad");
    }
}

#[test]
fn the_zero_stays_with_the_friction_record_unless_counts_were_lost() {
    let mut rig = Rig::new(2);
    let zero_rad = |rig: &Rig| {
        let position_counts = rig.controller.status().position_counts;
        rig.bench.link_rad() - f64::from(rig.controller.scale().angle_rad(position_counts))
    };
    // Where the encoder counts from, which only a new zero changes.
    let zeros = |rig: &Rig| rig.demand.zero_at_counts;
    assert_eq!(
        rig.run(Request::RecordFriction, 60),
        Some(Outcome::Complete)
    );
    let first_rad = zero_rad(&rig);
    assert_ne!(zeros(&rig), 0);
    for _ in 0..2 {
        assert_eq!(rig.run(Request::Home, 60), Some(Outcome::Complete));
        assert_eq!(zeros(&rig), 0, "the zero of the record");
    }
    for lost_counts in [-12_000i32, 12_000] {
        let zero = rig.controller.status().zero;
        for (zero, zero_at_counts) in [(zero.wrapping_add(1), lost_counts), (zero, 0)] {
            let demand = Demand {
                zero,
                zero_at_counts,
                ..rig.demand
            };
            let inputs = rig.bench.step(rig.outputs);
            rig.outputs = rig.controller.step(&inputs, &demand);
        }
        rig.millisecond(None);
        let off_rad = zero_rad(&rig) - first_rad;
        assert!(off_rad.abs() > 0.03, "{lost_counts}: {off_rad} rad");
        assert_eq!(rig.run(Request::Home, 60), Some(Outcome::Complete));
        assert_ne!(zeros(&rig), 0, "{lost_counts}");
        let off_rad = zero_rad(&rig) - first_rad;
        assert!(off_rad.abs() < 0.025, "{lost_counts}: {off_rad} rad");
    }
    // Without a record there is nothing for the zero to fit.
    rig.sequence.forget_friction();
    assert_eq!(rig.run(Request::Home, 60), Some(Outcome::Complete));
    assert_ne!(zeros(&rig), 0);
}

#[test]
fn pressing_ends_at_the_closing_stop() {
    use State::*;
    let mut rig = Rig::new(3);
    rig.sequence.friction_known = true;
    assert_eq!(
        rig.run(Request::Press, 60),
        Some(Outcome::Complete),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(rig.states(), [CalibrateOffset, Home, Close, Open, Idle]);
}

#[test]
fn close_keeps_the_grip_and_open_lets_go() {
    let mut rig = Rig::new(4);
    rig.bench.object_rad = 0.5;
    rig.sequence.friction_known = true;
    assert_eq!(rig.run(Request::Close, 60), Some(Outcome::Contact));
    assert!(rig.bench.link_rad() > 0.5);
    assert_eq!(rig.run(Request::Open, 60), Some(Outcome::Complete));
    assert!(rig.bench.link_rad() < 0.07);
}
