//! Faults that are found in time, and healthy motors that have none.

use super::*;

#[test]
fn every_injected_fault_is_found_in_time_and_under_its_name() {
    // Time to bridge off, control periods: 2 for what one period shows, the detector's own persistence and the time that
    // the contradiction takes to grow for the rest.
    let cases: &[(Defect, &[Fault], u32)] = &[
        (
            Defect::Short,
            &[Fault::OverCurrent, Fault::EncoderStuck],
            220,
        ),
        (Defect::SupplyLow, &[Fault::SupplyLow], 2),
        (Defect::SupplyHigh, &[Fault::SupplyHigh], 2),
        (Defect::BridgeFault, &[Fault::Bridge], 2),
        (Defect::Overrun, &[Fault::Overrun], 2),
        (Defect::SenseFull, &[Fault::SenseSaturated], 2),
        (Defect::SenseZero, &[Fault::SenseStuck], 5000),
        (Defect::SenseStuck, &[Fault::SenseStuck], 50),
        (Defect::PhaseCut, &[Fault::EncoderStuck], 600),
        (Defect::EncoderDead, &[Fault::EncoderStuck], 600),
        (
            Defect::EncoderReversed,
            &[Fault::EncoderReversed, Fault::EncoderJump],
            600,
        ),
        (Defect::EncoderNoise, &[Fault::EncoderJump], 50),
        (Defect::EncoderJump, &[Fault::EncoderJump], 2),
        // Found by the sequence.
        (Defect::RotorLocked, &[Fault::Stall], 20 * 400),
    ];
    for &(wrong, expected, limit) in cases {
        for seed in 1..=3 {
            let mut simulation = closing(seed);
            simulation.bench.wrong = wrong;
            let mut periods = 0;
            let mut peak_a = 0.0f64;
            while simulation.outputs != Outputs::Off && periods <= limit {
                // The slow loop goes on as ever.
                if periods % 20 == 19 {
                    simulation.now_us += 1000;
                    simulation.demand = simulation
                        .sequence
                        .advance(simulation.now_us, simulation.controller.status(), None)
                        .demand;
                }
                let inputs = simulation.bench.step(simulation.outputs);
                simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
                peak_a = peak_a.max(simulation.bench.current_a.abs());
                periods += 1;
            }
            simulation.millisecond(None);
            let fault = simulation.sequence.fault();
            assert!(
                fault.is_some_and(|fault| expected.contains(&fault)),
                "{wrong:?}: {fault:?} after {periods} periods"
            );
            assert!(periods <= limit, "{wrong:?}: {periods} periods");
            assert!(peak_a < 0.35, "{wrong:?}: {peak_a} A");
            // What still shows at rest is not cleared.
            let shows = matches!(
                wrong,
                Defect::SupplyLow | Defect::SupplyHigh | Defect::BridgeFault | Defect::SenseFull
            );
            if shows {
                let refused = simulation.sequence.request(Request::Clear);
                assert_eq!(refused, Err(Refused::StillThere(expected[0])));
            }
            // Latched: nothing restarts, whatever is asked, until it is cleared and homed again.
            simulation.bench.wrong = Defect::Nothing;
            assert!(simulation.sequence.request(Request::Run).is_err());
            for _ in 0..100 {
                simulation.millisecond(None);
                assert_eq!(simulation.outputs, Outputs::Off, "{wrong:?}");
            }
            simulation.clear();
            assert_eq!(
                (simulation.sequence.state(), simulation.sequence.fault()),
                (State::Idle, None),
                "{wrong:?}"
            );
            assert!(!simulation.controller.status().homed);
        }
    }
}

#[test]
fn a_missing_stop_is_found_within_the_travel() {
    let mut simulation = Simulation::new(1);
    simulation.bench.wrong = Defect::NoStop;
    assert_eq!(simulation.run(Request::Home, 60), None);
    assert_eq!(simulation.sequence.fault(), Some(Fault::TravelLimit));
}

#[test]
fn an_offset_out_of_range_is_found_before_anything_moves() {
    let mut simulation = Simulation::new(1);
    simulation.bench.wrong = Defect::SenseOffset;
    assert_eq!(simulation.run(Request::Run, 60), None);
    assert_eq!(simulation.sequence.fault(), Some(Fault::OffsetOutOfRange));
    assert!((simulation.bench.link_rad() - 0.05).abs() < 1e-9);
}

#[test]
fn an_encoder_connected_the_wrong_way_is_found_at_the_first_motion() {
    for wrong in [Defect::EncoderReversed, Defect::EncoderDead] {
        let mut simulation = Simulation::new(1);
        simulation.bench.angle = 0.8 * 1280.0;
        simulation.bench.wrong = wrong;
        assert_eq!(simulation.run(Request::Run, 60), None);
        let expected = if wrong == Defect::EncoderDead {
            Fault::EncoderStuck
        } else {
            Fault::EncoderReversed
        };
        assert_eq!(simulation.sequence.fault(), Some(expected));
        assert!(
            (simulation.bench.link_rad() - 0.8).abs() < 0.05,
            "{wrong:?}: moved to {}",
            simulation.bench.link_rad()
        );
    }
}

#[test]
fn healthy_grasps_of_motors_at_the_edge_of_their_tolerances_never_fault() {
    for seed in 0..10u64 {
        let mut simulation = Simulation::new(seed + 1);
        let mut spread = |share: f64| 1.0 + 2.0 * share * simulation.bench.random();
        let (resistance, constant, inertia, friction, gain) = (
            spread(0.2),
            spread(0.1),
            spread(0.2),
            spread(0.3),
            spread(0.05),
        );
        let (offset_a, supply_v) = (5e-3 * (spread(1.0) - 1.0), 12.0 * spread(0.1));
        simulation.bench.resistance_ohm *= resistance;
        simulation.bench.torque_constant *= constant;
        simulation.bench.inertia *= inertia;
        simulation.bench.friction_nm *= friction;
        simulation.bench.gain = gain;
        simulation.bench.offset_a = offset_a;
        simulation.bench.supply_v = supply_v;
        simulation.bench.object_rad = 0.3 + 1.4 * (simulation.bench.random() + 0.5);
        simulation.bench.object_nm_per_rad =
            0.3 * 10f64.powf(2.0 * (simulation.bench.random() + 0.5));
        simulation.sequence.friction_known = true;
        let outcome = simulation.run(Request::Run, 60);
        assert!(
            outcome.is_some(),
            "seed {seed}: {:?} {:?} R {resistance} k {constant} {:?}",
            simulation.sequence.fault(),
            simulation.log,
            simulation.controller.status()
        );
    }
}

/// Homing closes too, for a run-up and off the stop: what stands in the way then stalls the motor at once, not until the timeout.
#[test]
fn a_homing_that_is_blocked_while_it_closes_is_a_stall() {
    use super::homing::Homing;
    for (start_rad, blocked) in [(0.02, Homing::RunUp), (0.5, Homing::BackOff)] {
        let mut simulation = Simulation::new(1);
        simulation.bench.angle = start_rad * 1280.0;
        simulation.sequence.request(Request::Home).expect("at rest");
        let mut since_ms = 0;
        while simulation.sequence.state() != State::Fault && since_ms < 2000 {
            simulation.millisecond(None);
            if simulation.sequence.homing == blocked {
                simulation.bench.wrong = Defect::RotorLocked;
                since_ms += 1;
            }
        }
        assert_eq!(
            simulation.sequence.fault(),
            Some(Fault::Stall),
            "{blocked:?}"
        );
        assert!(since_ms < 500, "{since_ms} ms");
    }
}

/// A board on its desk, without the motor's supply: what start has found can be cleared, and settings be made.
#[test]
fn a_supply_that_is_off_keeps_no_other_fault() {
    let mut simulation = Simulation::new(1);
    simulation.bench.wrong = Defect::SupplyLow;
    simulation.millisecond(Some(Notice::Fault(Fault::BadRecord)));
    simulation.millisecond(None);
    assert_eq!(simulation.sequence.fault(), Some(Fault::BadRecord));
    simulation.clear();
    assert_eq!(simulation.sequence.fault(), None);
}
