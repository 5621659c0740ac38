//! What the bridge is told to do, and what clearing a fault leaves behind.

use super::*;
use crate::drive::io::Direction;
use crate::drive::limit::limit_magnitude;

/// A bench and its controller, and what the bridge does.
struct Driven {
    bench: TestMotor,
    controller: Controller,
    outputs: Outputs,
}

impl Driven {
    fn new(config: crate::drive::config::Config) -> Self {
        Self {
            bench: TestMotor::new(1),
            controller: Controller::new(&CheckedConfig::new(config).expect("valid")),
            outputs: Outputs::Off,
        }
    }

    /// A period; what the bridge does next.
    fn step(&mut self, demand: &Demand) -> Outputs {
        let inputs = self.bench.step(self.outputs);
        self.outputs = self.controller.step(&inputs, demand);
        self.outputs
    }

    fn milliseconds(&mut self, demand: &Demand, number: u32) {
        for _ in 0..20 * number {
            self.step(demand);
        }
    }
}

/// A start after a stop wakes the bridge as the first one does.
#[test]
fn every_start_wakes_the_bridge_before_it_drives() {
    let mut driven = Driven::new(p70());
    for setpoint in [
        Setpoint::Current { a: 0.05 },
        Setpoint::Brake,
        Setpoint::Current { a: -0.05 },
    ] {
        driven.milliseconds(&Demand::from(Setpoint::Off), 50);
        assert_eq!(driven.outputs, Outputs::Off);
        let mut waking_us = 0;
        while driven.step(&Demand::from(setpoint)) == Outputs::Wake {
            waking_us += 50;
        }
        assert!(waking_us > 1000, "{setpoint:?}: {waking_us}");
    }
}

/// Whatever a demand allows, a finger that is broken away among them, the configured limit stands.
#[test]
fn a_speed_demand_is_held_to_the_limit_of_the_configuration() {
    let limit_a = p70().limits.current_a;
    for counts_per_s in [60e3, -60e3] {
        let mut driven = Driven::new(p70());
        driven.bench.wrong = Defect::RotorLocked;
        let demand = Demand::from(Setpoint::Speed {
            counts_per_s,
            current_limit_a: f32::MAX,
        });
        let mut limited = false;
        let mut peak_a = 0.0f64;
        for _ in 0..20 * 500 {
            driven.step(&demand);
            limited |= driven.controller.status().limited.current;
            peak_a = peak_a.max(driven.bench.current_a.abs());
        }
        assert_eq!(driven.controller.status().fault, None);
        assert!(limited && peak_a < 1.1 * f64::from(limit_a), "{peak_a} A");
        assert!(peak_a > 0.9 * f64::from(limit_a), "{peak_a} A");
    }
}

/// The direction pin acts before the duty does.
#[test]
fn between_two_directions_the_bridge_brakes() {
    let mut driven = Driven::new(p70());
    let (mut last, mut turned) = (None, 0);
    for period in 0..20 * 400 {
        let a = if period / (20 * 40) % 2 == 0 {
            0.08
        } else {
            -0.08
        };
        let now = match driven.step(&Demand::from(Setpoint::Current { a })) {
            // At a duty of 0 it brakes in either direction.
            Outputs::Drive { direction, duty } => (duty.0 > 0).then_some(direction),
            _ => None,
        };
        let turns = matches!(
            (last, now),
            (Some(Direction::Closing), Some(Direction::Opening))
                | (Some(Direction::Opening), Some(Direction::Closing))
        );
        assert!(!turns, "at period {period}");
        turned += u32::from(now == Some(Direction::Opening));
        last = now;
    }
    assert!(turned > 20 * 100, "{turned}: nothing tested");
}

/// The first fault is the cause; what follows from it, or comes later, does not take its place.
#[test]
fn the_first_fault_is_the_one_that_is_told() {
    let mut simulation = closing(1);
    simulation.bench.wrong = Defect::BridgeFault;
    simulation.millisecond(None);
    simulation.bench.wrong = Defect::SupplyHigh;
    for _ in 0..10 {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.controller.status().fault, Some(Fault::Bridge));
    assert_eq!(simulation.sequence.fault(), Some(Fault::Bridge));
    // What is still there keeps it from being cleared, and is named.
    let refused = simulation.sequence.request(Request::Clear);
    assert_eq!(refused, Err(Refused::StillThere(Fault::SupplyHigh)));
    assert_eq!(simulation.sequence.state(), State::Fault);
    simulation.bench.wrong = Defect::Nothing;
    for _ in 0..1000 {
        simulation.millisecond(None);
    }
    simulation.clear();
    assert_eq!(simulation.sequence.state(), State::Idle);
}

/// However long it lasted: nothing of what led to it is left once it is mended and cleared.
#[test]
fn a_fault_that_lasted_is_cleared_at_once() {
    let mut simulation = Simulation::new(1);
    simulation.bench.wrong = Defect::SenseOffset;
    for _ in 0..5000 {
        simulation.millisecond(None);
    }
    assert_eq!(simulation.sequence.fault(), Some(Fault::OffsetOutOfRange));
    let refused = simulation.sequence.request(Request::Clear);
    assert_eq!(refused, Err(Refused::StillThere(Fault::OffsetOutOfRange)));
    simulation.bench.wrong = Defect::Nothing;
    for _ in 0..5 {
        simulation.millisecond(None);
    }
    simulation.clear();
    assert_eq!(simulation.sequence.state(), State::Idle);
    assert_eq!(simulation.controller.status().fault, None);
    simulation.ends(Request::Home, MotionResult::Complete);
}

/// A winding that has cooled down is driven again.
#[test]
fn a_hot_winding_is_cleared_once_it_is_cool() {
    let mut config = p70();
    config.motor.thermal.winding_k_per_w = 150.0;
    config.motor.thermal.winding_s = 0.5;
    let mut driven = Driven::new(config);
    driven.bench.wrong = Defect::RotorLocked;
    driven.milliseconds(&Demand::from(Setpoint::Current { a: 0.12 }), 5000);
    assert_eq!(driven.controller.status().fault, Some(Fault::WindingHot));
    driven.milliseconds(&Demand::from(Setpoint::Off), 2000);
    assert!(driven.controller.status().winding_c < config.motor.thermal.limit_c - 5.0);
    let cleared = Demand {
        clear: 1,
        ..Demand::from(Setpoint::Off)
    };
    driven.milliseconds(&cleared, 5);
    assert_eq!(driven.controller.status().fault, None);
}

/// An amplifier in the motor's lead tells the sign itself: either way the current is held, and what comes of the two halves of a
/// period means nothing.
#[test]
fn a_sense_with_a_sign_holds_a_current_either_way() {
    let mut config = p70();
    let sense = &mut config.sense;
    sense.signed = true;
    sense.zero_v = 0.5 * sense.reference_v;
    sense.volt_per_a = 3.0;
    for wanted_a in [0.06f32, -0.06] {
        let mut driven = Driven::new(config);
        driven.bench.wrong = Defect::RotorLocked;
        // What the model does not know, the reading has to correct.
        driven.bench.resistance_ohm *= 1.15;
        let demand = Demand::from(Setpoint::Current { a: wanted_a });
        for period in 0..20 * 100 {
            let mut inputs = driven.bench.step(driven.outputs);
            let noise_a = 1e-4 * (7 * period % 11) as f32;
            let (read_a, _) = limit_magnitude(driven.bench.current_a as f32 + noise_a, 0.5);
            inputs.current = driven.controller.scale().current_code(read_a);
            inputs.late_excess = i16::MAX;
            driven.outputs = driven.controller.step(&inputs, &demand);
        }
        let status = driven.controller.status();
        assert_eq!(status.fault, None, "{wanted_a}");
        assert!((status.current_a - wanted_a).abs() < 2e-3, "{status:?}");
        let flows_a = driven.bench.current_a as f32;
        assert!((flows_a - wanted_a).abs() < 2e-3, "{flows_a} A");
    }
}
