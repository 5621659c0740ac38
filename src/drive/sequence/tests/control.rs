//! What the controller makes of demands, with a motor behind it.

use super::*;

#[test]
fn position_is_limited_before_it_trips() {
    let mut simulation = closing(5);
    let speed = simulation.controller.scale().counts_per_s(0.3);
    simulation.bench.wrong = Defect::NoStop;
    simulation.demand.setpoint = Setpoint::Speed {
        counts_per_s: speed,
        current_limit_a: 0.1,
    };
    let mut limited = false;
    for _ in 0..20 * 8000 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        limited |= simulation.controller.status().limited.position;
        assert_eq!(simulation.controller.status().fault, None);
    }
    assert!(limited);
    // The motor stopped there.
    let limit_rad = f64::from(p70().limits.position_max_rad);
    assert!(
        (simulation.bench.link_rad() - limit_rad).abs() < 0.03,
        "{}",
        simulation.bench.link_rad()
    );
    // A current outward is suppressed as well.
    simulation.demand.setpoint = Setpoint::Current { a: 0.1 };
    for _ in 0..20 * 500 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
    }
    assert!(simulation.controller.status().limited.position);
    assert!(
        (simulation.bench.link_rad() - limit_rad).abs() < 0.03,
        "{}",
        simulation.bench.link_rad()
    );
}

#[test]
fn a_current_demand_is_held_and_its_speed_is_limited() {
    let mut simulation = closing(6);
    simulation.bench.object_rad = simulation.bench.link_rad() + 0.1;
    simulation.demand.setpoint = Setpoint::Current { a: 0.07 };
    let mut fastest = 0.0f64;
    for _ in 0..20 * 2000 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        fastest = fastest.max(simulation.bench.speed / 1280.0);
    }
    assert!(fastest < 0.85, "{fastest} rad/s, 0.8 is the limit");
    assert!(
        (simulation.bench.current_a - 0.07).abs() < 2e-3,
        "{}",
        simulation.bench.current_a
    );
    simulation.demand.setpoint = Setpoint::Current { a: 1.0 };
    let mut limited = false;
    for _ in 0..20 * 500 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        limited |= simulation.controller.status().limited.current;
        assert!(
            simulation.bench.current_a < 0.13,
            "{}",
            simulation.bench.current_a
        );
    }
    assert!(limited);
}

#[test]
fn samples_come_every_millisecond_and_tell_the_drive() {
    use crate::sample::Drive;
    let mut simulation = closing(8);
    let mut last_us = None;
    for period in 0..20 * 300 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        if let Some(sample) = simulation.controller.sample() {
            assert!(simulation.controller.sample().is_none());
            if let Some(last_us) = last_us {
                assert_eq!(sample.time_us - last_us, 1000);
                assert_eq!(
                    sample.drive,
                    if period < 20 * 100 {
                        Drive::Closing
                    } else {
                        sample.drive
                    }
                );
            }
            // The rotor needs some ten milliseconds to turn, and the model of the reading must not see it as motion.
            if (20 * 102..20 * 104).contains(&period) {
                assert_eq!(sample.drive, Drive::Idle);
            }
            if period > 20 * 250 {
                assert_eq!(sample.drive, Drive::Opening);
                assert!(sample.current_a < -5e-3, "{sample:?}");
            }
            last_us = Some(sample.time_us);
        }
        if period == 20 * 100 {
            let speed = simulation.controller.scale().counts_per_s(-0.3);
            simulation.demand.setpoint = Setpoint::Speed {
                counts_per_s: speed,
                current_limit_a: 0.1,
            };
        }
    }
}

#[test]
fn steady_speed_is_steady() {
    let mut simulation = closing(9);
    let wanted = f64::from(simulation.controller.scale().counts_per_s(0.3)) / 1024.0
        * core::f64::consts::TAU;
    let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
    for _ in 0..20 * 1000 {
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        sum += simulation.bench.speed;
        squares += simulation.bench.speed * simulation.bench.speed;
        n += 1.0;
    }
    let mean = sum / n;
    let ripple = (squares / n - mean * mean).sqrt() / mean;
    assert!(
        (mean / wanted - 1.0).abs() < 2e-3,
        "{mean} against {wanted}"
    );
    // The encoder is uneven by 1.5 counts a turn: 0.6 % rms of the speed, which the loop follows in part.
    assert!(ripple < 0.01, "{ripple}");
}

#[test]
fn a_motor_that_works_too_hard_is_switched_off_before_it_is_hot() {
    let mut config = p70();
    // A winding with little to take, so that the test need not wait for minutes.
    config.motor.thermal.winding_k_per_w = 150.0;
    config.motor.thermal.winding_s = 0.5;
    let mut controller = Controller::new(&CheckedConfig::new(config).expect("valid"));
    let mut bench = TestMotor::new(1);
    bench.wrong = Defect::RotorLocked;
    let demand = Demand::from(Setpoint::Current { a: 0.12 });
    let mut outputs = Outputs::Off;
    for _ in 0..20 * 5000 {
        let inputs = bench.step(outputs);
        outputs = controller.step(&inputs, &demand);
        assert!(controller.status().winding_c < config.motor.thermal.limit_c + 0.1);
    }
    assert_eq!(controller.status().fault, Some(Fault::WindingHot));
    assert_eq!(outputs, Outputs::Off);
    // Clearing does not help while it is hot.
    let demand = Demand { clear: 1, ..demand };
    let inputs = bench.step(outputs);
    controller.step(&inputs, &demand);
    assert!(controller.status().winding_c < 84.9 || controller.status().fault.is_some());
}

#[test]
fn a_reading_at_rest_that_is_no_offset_is_found_without_any_motion() {
    let mut simulation = Simulation::new(1);
    for _ in 0..100 {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.sequence.fault(), None);
    simulation.bench.wrong = Defect::SenseOffset;
    for _ in 0..100 {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.sequence.fault(), Some(Fault::OffsetOutOfRange));
}

#[test]
fn nothing_drives_before_the_bridge_is_awake() {
    let mut controller = Controller::new(&CheckedConfig::new(p70()).expect("valid"));
    let mut bench = TestMotor::new(1);
    let demand = Demand::from(Setpoint::Current { a: 0.05 });
    let mut outputs = Outputs::Off;
    let mut awake_us = 0;
    while !matches!(outputs, Outputs::Drive { .. }) {
        let inputs = bench.step(outputs);
        outputs = controller.step(&inputs, &demand);
        awake_us += 50;
        assert!(awake_us < 3000);
    }
    assert!(awake_us > 1000, "{awake_us}");
}

#[test]
fn the_fault_pin_is_judged_when_the_bridge_is_awake_and_before_its_outputs_are_enabled() {
    // nFAULT low for so long after the bridge is woken, periods; and whether that is a fault.
    for (low, faults) in [(0, false), (29, false), (31, true), (1000, true)] {
        let mut controller = Controller::new(&CheckedConfig::new(p70()).expect("valid"));
        let mut bench = TestMotor::new(1);
        let demand = Demand::from(Setpoint::Brake);
        let mut outputs = Outputs::Off;
        let (mut awake, mut enabled) = (0, false);
        for _ in 0..200 {
            let mut inputs = bench.step(outputs);
            inputs.bridge_fault = outputs != Outputs::Off && awake < low;
            outputs = controller.step(&inputs, &demand);
            awake += u32::from(outputs != Outputs::Off);
            enabled |= outputs == Outputs::Brake;
        }
        assert_eq!(
            controller.status().fault,
            faults.then_some(Fault::Bridge),
            "{low}"
        );
        assert_eq!(enabled, !faults, "{low}");
    }
}

#[test]
fn braking_from_full_speed_is_no_over_current() {
    let mut controller = Controller::new(&CheckedConfig::new(p70()).expect("valid"));
    let mut bench = TestMotor::new(1);
    // Without the choke more current flows.
    bench.resistance_ohm = 35.0;
    let mut outputs = Outputs::Off;
    // 0.8 rad/s at the input link of 1,310,720 counts a turn.
    let speed = Demand::from(Setpoint::Speed {
        counts_per_s: 166_900.0,
        current_limit_a: 0.12,
    });
    let mut peak_a = 0.0f64;
    for period in 0..20 * 400 {
        let demand = if period < 20 * 300 {
            speed
        } else {
            Demand::from(Setpoint::Brake)
        };
        let inputs = bench.step(outputs);
        outputs = controller.step(&inputs, &demand);
        if period > 20 * 300 {
            peak_a = peak_a.max(bench.current_a.abs());
        }
    }
    assert!(
        peak_a > f64::from(p70().limits.current_trip_a),
        "{peak_a}: nothing tested"
    );
    assert_eq!(controller.status().fault, None);
}

/// Whoever sees the echo of a new zero sees the position in its counts, in the very period: samples come every twentieth.
#[test]
fn the_echo_of_a_zero_comes_with_a_position_in_its_counts() {
    let mut simulation = Simulation::new(3);
    simulation.ends(Request::Home, MotionResult::Complete);
    for period in 1..40 {
        let before = *simulation.controller.status();
        simulation.demand = Demand {
            zero: before.zero.wrapping_add(1),
            zero_at_counts: 1000,
            ..simulation.demand
        };
        let inputs = simulation.bench.step(simulation.outputs);
        simulation.outputs = simulation.controller.step(&inputs, &simulation.demand);
        let after = simulation.controller.status();
        assert_eq!(after.zero, simulation.demand.zero);
        let moved = before.position_counts - after.position_counts;
        // The motor may turn meanwhile.
        assert!((moved - 1000).abs() < 50, "{period}: {moved}");
    }
}
