//! The torque falls: a softer finger, or one whose weight an object takes over.

use super::sensor::{friction_a, motion, recorded, sensor};
use crate::scene::{P70, Scene};
use crate::sensing::{Directive, Event};

/// The finger becomes softer and then meets something: it must be felt, or the motor would press until it stands.
#[test]
fn a_softer_finger_still_feels_a_contact() {
    let (mut sensor, mut time_us) = recorded();
    sensor.direct(Directive::Watch);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.4), |angle| {
        friction_a(angle) - 0.02 * (angle - 0.5).max(0.0) + 0.15 * (angle - 0.9).max(0.0)
    });
    assert!(
        matches!(
            told[..],
            [Event::Unusual { .. }, Event::Touch { theta_a_rad, .. }, ..] if (theta_a_rad - 0.9).abs() < 0.1
        ),
        "{told:?}"
    );
}

/// A finger that its weight closes: the worm holds it back, with a fifth of the torque that it would take to lift it. An object
/// takes the weight over first, by which the torque falls, and only then it rises.
#[test]
fn an_object_that_carries_the_weight_is_not_unusual() {
    let (mut sensor, mut time_us) = (sensor(), 0);
    let drivetrain = P70::drivetrain(sensor.finger());
    let nm = |a: f32| a * drivetrain.torque_per_ampere_nm * drivetrain.efficiency;
    // 15 mN m of weight.
    let lifted_a = 15e-3 / nm(1.0);
    let closing = |angle: f32| friction_a(angle) + 0.1 * lifted_a;
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 1.5), closing);
    motion(&mut sensor, &mut time_us, (1.5, 0.0), |angle| {
        -friction_a(angle) - lifted_a
    });
    sensor.direct(Directive::Watch);
    // As stiff as a contact in the middle of the distal phalanx.
    let (contact_rad, stiffness) = (0.7, 0.6);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.2), |angle| {
        let load_nm = stiffness * (angle - contact_rad).max(0.0) - 15e-3;
        let share = if load_nm < 0.0 { -0.1 } else { 1.0 };
        friction_a(angle) + share * load_nm / nm(1.0)
    });
    // The place is not checked: this straight rise is no contact of P70, whose weight first holds joint 2 at its stop.
    let [
        Event::FrictionRecorded { .. },
        Event::Touch { theta_a_rad, .. },
        ..,
    ] = told[..]
    else {
        panic!("{told:?}");
    };
    let unusual = |event: &Event| matches!(event, Event::Unusual { .. });
    assert!(!told.iter().any(unusual), "{told:?}");
    // Where the object was met, not where the torque began to rise.
    let rise_rad = contact_rad + 15e-3 / stiffness;
    assert!((theta_a_rad - contact_rad).abs() < (theta_a_rad - rise_rad).abs());
}
