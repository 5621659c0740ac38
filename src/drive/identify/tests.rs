//! The motions with the controller and a simple motor, and what a stored result must be.

use super::*;
use crate::drive::Controller;
use crate::drive::config::CheckedConfig;
use crate::drive::config::tests::p70;
use crate::drive::demand::{Demand, Setpoint, Status};
use crate::drive::io::Outputs;
use crate::drive::test_motor::TestMotor;
use crate::drive::thermal::COPPER_PER_K;

/// Where the link stands at the start, radian from its stop.
const START_RAD: f64 = 0.05;

/// What came of it.
struct Run {
    ended: Result<Identified, NotIdentified>,
    /// Farthest opened and closed, radian from the start.
    lowest_rad: f64,
    highest_rad: f64,
    /// Times the bridge braked for a millisecond after the offset was measured.
    braked: u32,
}

/// Identifies; `calls` says how often the procedure's turn comes in a millisecond, `change` may change the motor at a way from
/// the start, radian.
fn identify(calls: impl FnMut() -> u32, change: impl FnMut(&mut TestMotor, f64)) -> Run {
    identify_told(calls, change, |_| ())
}

/// The same; `tell` may change what the procedure is told of the controller.
fn identify_told(
    mut calls: impl FnMut() -> u32,
    mut change: impl FnMut(&mut TestMotor, f64),
    tell: impl Fn(&mut Status),
) -> Run {
    let config = CheckedConfig::new(p70()).expect("valid");
    let mut controller = Controller::new(&config);
    let mut motor = TestMotor::new(3);
    let mut identification = Identification::new(&config, 0.3, controller.status());
    let (mut demand, mut outputs) = (Demand::default(), Outputs::Off);
    let (mut lowest_rad, mut highest_rad, mut braked) = (0.0f64, 0.0f64, 0);
    let mut ended = None;
    for ms in 0..30_000 {
        // After its end the bridge is off: a motor that still turned would go on.
        for _ in 0..20 {
            let inputs = motor.step(outputs);
            outputs = controller.step(&inputs, &demand);
        }
        let way_rad = motor.link_rad() - START_RAD;
        lowest_rad = lowest_rad.min(way_rad);
        highest_rad = highest_rad.max(way_rad);
        braked += u32::from(ms > 600 && outputs == Outputs::Brake);
        change(&mut motor, way_rad);
        assert_eq!(controller.status().fault, None);
        for _ in 0..calls() {
            if ended.is_none() {
                let mut status = *controller.status();
                tell(&mut status);
                let setpoint = match identification.advance(&status) {
                    Ok(Step::Ask(setpoint)) => setpoint,
                    Ok(Step::Done(identified)) => {
                        ended = Some(Ok(identified));
                        Setpoint::Off
                    }
                    Err(why) => {
                        ended = Some(Err(why));
                        Setpoint::Off
                    }
                };
                demand = setpoint.into();
            }
        }
    }
    Run {
        ended: ended.expect("within the longest time"),
        lowest_rad,
        highest_rad,
        braked,
    }
}

fn undisturbed() -> Run {
    identify(|| 1, |_, _| ())
}

#[test]
fn it_closes_over_a_turn_of_the_worm_and_opens_to_above_its_start() {
    let run = undisturbed();
    assert!(run.ended.is_ok_and(|identified| identified.is_valid()));
    assert_eq!(run.lowest_rad, 0.0);
    assert!(
        (0.33..0.5).contains(&run.highest_rad),
        "{}",
        run.highest_rad
    );
    assert_eq!(run.braked, 0);
}

/// No way of the earlier pulses tells of this one.
#[test]
fn a_motor_that_loses_its_friction_near_the_start_is_braked_above_it() {
    let mut near = 0;
    for (falls_at_rad, friction_nm) in [(0.15, 5e-6), (0.10, 5e-6), (0.12, 1e-6), (0.2, 2e-5)] {
        let mut opening = false;
        let run = identify(
            || 1,
            |motor, way_rad| {
                opening |= way_rad > 0.33;
                if opening && way_rad < falls_at_rad {
                    motor.friction_nm = friction_nm;
                }
            },
        );
        // It was near the start, or coasted for too long before it came there.
        assert!(
            matches!(run.ended, Ok(_) | Err(NotIdentified::TimedOut)),
            "{:?}",
            run.ended
        );
        near += u32::from(run.ended.is_ok());
        assert!(run.braked > 0, "{falls_at_rad}: nothing to brake");
        assert!(run.lowest_rad >= 0.0, "{falls_at_rad}: {}", run.lowest_rad);
    }
    assert!(near > 0, "none was braked near its start");
}

#[test]
fn a_motor_that_nothing_halts_is_braked_and_not_identified() {
    let mut opening = false;
    let run = identify(
        || 1,
        |motor, way_rad| {
            opening |= way_rad > 0.33;
            if opening {
                motor.friction_nm = 3e-6;
            }
        },
    );
    assert_eq!(run.ended, Err(NotIdentified::TimedOut));
    assert!(
        run.braked > 0 && run.lowest_rad >= 0.0,
        "{}",
        run.lowest_rad
    );
}

/// A task that ran late gets no turn for some milliseconds and then several in one: skipped and repeated statuses.
#[test]
fn turns_that_come_late_and_together_change_nothing_but_scatter() {
    let clean = undisturbed();
    let reference = clean.ended.expect("identified");
    for late_ms in [1, 2, 5] {
        let (mut ms, mut owed) = (0u32, 0);
        let run = identify(
            || {
                ms += 1;
                owed += 1;
                // Every 23 ms, a number that shares no divisor with the pulses' lengths.
                if ms % 23 < late_ms {
                    return 0;
                }
                core::mem::take(&mut owed)
            },
            |_, _| (),
        );
        let identified = run.ended.expect("identified");
        for quantity in Quantity::ALL {
            let (one, other) = (identified.of(quantity), reference.of(quantity));
            let apart = (one.value - other.value) / one.sigma;
            assert!(apart.abs() < 1.0, "{late_ms} {quantity:?}: {apart}");
        }
        assert!(run.lowest_rad >= 0.0, "{late_ms}: {}", run.lowest_rad);
    }
}

/// The winding's resistance is told at 25 degrees Celsius; the choke in its lead hardly warms.
#[test]
fn a_warm_winding_counts_as_warm_and_the_choke_does_not() {
    const RISE_K: f32 = 80.0;
    let motor = p70().motor;
    let ohm = |run: Run| {
        let identified = run.ended.expect("identified");
        identified.of(Quantity::Resistance).value
    };
    let cold = ohm(undisturbed());
    let warm = ohm(identify_told(
        || 1,
        |_, _| (),
        |status| status.winding_c = motor.thermal.ambient_c + RISE_K,
    ));
    // The procedure takes it for half as warm as it is told: after a power cut nobody knows.
    let growth = 1.0 + 0.5 * RISE_K * COPPER_PER_K;
    let (told, expected) = ((warm - motor.choke_ohm) * growth, cold - motor.choke_ohm);
    assert!(
        motor.choke_ohm > 0.0 && (told / expected - 1.0).abs() < 0.005,
        "{told} {expected}"
    );
}

/// The same status for ever: the control interrupt hangs.
#[test]
fn a_status_that_only_repeats_ends_it_in_time_and_asks_for_no_motion() {
    let config = CheckedConfig::new(p70()).expect("valid");
    let status = Status::default();
    let mut identification = Identification::new(&config, 0.3, &status);
    for _ in 0..20_000 {
        let step = identification.advance(&status);
        assert_eq!(step, Ok(Step::Ask(Setpoint::MeasureOffset)));
    }
    assert_eq!(
        identification.advance(&status),
        Err(NotIdentified::TimedOut)
    );
}

#[test]
fn a_value_without_a_positive_deviation_is_none() {
    let of = |value, sigma| Identified {
        estimates: [Estimate { value, sigma }; Quantity::ALL.len()],
    };
    for sigma in [f32::MIN_POSITIVE, 1e-9, 1.0, 1e8] {
        assert!(of(1.0, sigma).is_valid(), "{sigma}");
        assert!(!of(f32::NAN, sigma).is_valid() && !of(f32::INFINITY, sigma).is_valid());
    }
    for sigma in [0.0, -0.0, -1e-9, -1.0, 1e9, f32::INFINITY, f32::NAN] {
        let mut one = of(1.0, 1.0);
        one.estimates[Quantity::DeadTime as usize].sigma = sigma;
        assert!(!one.is_valid(), "{sigma}");
    }
    assert!(!Identified::default().is_valid());
}
