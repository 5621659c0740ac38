//! The torque falls: a softer finger, or one whose weight an object takes over.

use super::sensor::{friction_a, motion, recorded, sensor};
use crate::finger::Mounting;
use crate::scene::{P70, Scene, Tendon2};
use crate::sensing::{Directive, Drivetrain, Event, Sensor, Settings};

/// Current of a closing whose load is held back by the worm where it is negative, with a tenth of the torque that would lift it.
fn closing_a(drivetrain: &Drivetrain, angle: f32, load_nm: f32) -> f32 {
    let share = if load_nm < 0.0 { -0.1 } else { 1.0 };
    friction_a(angle) + share * load_nm / nm_per_a(drivetrain)
}

/// Torque at the input link per ampere, newton metre.
fn nm_per_a(drivetrain: &Drivetrain) -> f32 {
    drivetrain.torque_per_ampere_nm * drivetrain.efficiency
}

/// Angle of the touch that follows a friction record, where the finger was not taken for softer.
fn touched_rad(told: &[Event]) -> f32 {
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
    theta_a_rad
}

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
    let weight_nm = 15e-3;
    let lifted_a = weight_nm / nm_per_a(&drivetrain);
    let closing = |angle: f32| closing_a(&drivetrain, angle, -weight_nm);
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 1.5), closing);
    motion(&mut sensor, &mut time_us, (1.5, 0.0), |angle| {
        -friction_a(angle) - lifted_a
    });
    sensor.direct(Directive::Watch);
    // As stiff as a contact in the middle of the distal phalanx.
    let (contact_rad, stiffness) = (0.7, 0.6);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.2), |angle| {
        let load_nm = stiffness * (angle - contact_rad).max(0.0) - weight_nm;
        closing_a(&drivetrain, angle, load_nm)
    });
    // The place is not checked: this straight rise is no contact of P70, whose weight first holds joint 2 at its stop.
    let theta_a_rad = touched_rad(&told);
    // Where the object was met, not where the torque began to rise.
    let rise_rad = contact_rad + weight_nm / stiffness;
    assert!((theta_a_rad - contact_rad).abs() < (theta_a_rad - rise_rad).abs());
}

/// The same for a finger with springs, whose weight beats them: the scene states it, and the record tells nothing of it.
#[test]
fn an_object_that_carries_more_than_the_springs_hold_is_met_where_it_is() {
    // Twice the weight that the scene states, hanging so that it closes the finger.
    let settings = Settings {
        mounting: Some(Mounting {
            gravity_rad: 100f32.to_radians(),
            share: 2.0,
        }),
        ..Tendon2::settings()
    };
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let finger = Tendon2::MECHANISM;
    let mut sensor = Sensor::new(finger, drivetrain, settings, Tendon2::UNCALIBRATED);
    let mut time_us = 0;
    let model = sensor.clone();
    let needed_nm = |angle: f32| model.free_at(angle).map_or(0.0, |free| free.torque_nm);
    let current_a = |angle: f32, load_nm: f32| closing_a(&drivetrain, angle, load_nm);
    sensor.direct(Directive::RecordFriction);
    motion(&mut sensor, &mut time_us, (0.0, 1.5), |angle| {
        current_a(angle, needed_nm(angle))
    });
    motion(&mut sensor, &mut time_us, (1.5, 0.0), |angle| {
        -friction_a(angle) + needed_nm(angle) / nm_per_a(&drivetrain)
    });
    sensor.direct(Directive::Watch);
    let (contact_rad, stiffness) = (0.5, 0.3);
    let told = motion(&mut sensor, &mut time_us, (0.0, 1.0), |angle| {
        let pressed_nm = needed_nm(contact_rad) + stiffness * (angle - contact_rad);
        current_a(angle, needed_nm(angle).max(pressed_nm))
    });
    let theta_a_rad = touched_rad(&told);
    let rise_rad = contact_rad - needed_nm(contact_rad) / stiffness;
    assert!(
        (theta_a_rad - contact_rad).abs() < 0.2 * (rise_rad - contact_rad),
        "{theta_a_rad} {contact_rad} {rise_rad}"
    );
}
