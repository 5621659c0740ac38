// SPDX-License-Identifier: GPL-2.0-only
//! Images of other scenes on the emulated chip: what they have in addition to the default scene works.

use std::f64::consts::TAU;

use crate::support;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings, Summary, Told, end_of};
use palpate_plant::{ObjectMount, Parameters, World};

/// A grasp; control stays within its bounds whatever a scene adds to it.
fn grasp<'f>(
    firmware: &'f Firmware,
    scene: &str,
    script: Script,
    contact: (f64, f64),
) -> Session<'f> {
    let parameters = Parameters::of(scene).expect("one of the scenes");
    grasp_in(firmware, parameters, script, contact)
}

/// The same in any world; the contact by the angle of joint 1 and its place on phalanx 2.
fn grasp_in(
    firmware: &Firmware,
    parameters: Parameters,
    script: Script,
    contact: (f64, f64),
) -> Session<'_> {
    let settings = Settings {
        parameters,
        script,
        object: Some(on_distal(contact)),
        ..Settings::default()
    };
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    ended_well(&session);
    session
}

fn ended_well(session: &Session<'_>) {
    assert!(session.completed(), "not completed");
    assert_eq!(session.faults, []);
    support::keeps_up(session);
}

/// What phalanx 2 meets, by the angle of joint 1 and the place on it.
fn on_distal((theta_1_deg, contact_mm): (f64, f64)) -> Object {
    Object {
        phalanx: 2,
        contact_mm,
        diameter_mm: 10.0,
        theta_1_deg,
    }
}

/// With the joint so far closed, two places on phalanx 2 fit the curve, on either side of e_2; the Hall sensor's voltage,
/// from the pin through ADC2 to the verdict, says which.
#[test]
fn joint_2_is_read_and_decides_the_side() {
    let Some(firmware) = support::image(support::HALL) else {
        return;
    };
    let settings = Settings {
        parameters: Parameters::of("tendon2-hall").expect("one of the scenes"),
        script: Script::button(),
        object: Some(on_distal((95.0, 17.0))),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a session");
    // The true motor angle and that of joint 2 on the way to the object.
    let mut free = Vec::new();
    while !session.over() {
        session
            .millisecond()
            .expect("the firmware keeps to the rules of the chip");
        let truth = session.machine.plant().expect("a plant").truth();
        if session.state == "close" && truth.first_contact.is_none() {
            free.push((truth.motor_angle_rad, truth.joint_rad[1]));
        }
    }
    ended_well(&session);
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    // Nothing was calibrated, and joint 2 is near 90 degrees: the claimed deviation says how little is known.
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 2.0 * sigma_mm, "{summary:?}");
    let branches: Vec<_> = session
        .lines
        .iter()
        .map(|line| line.event())
        .filter(|event| event.name == "branch")
        .collect();
    let last = branches.last().expect("a verdict of joint 2");
    assert_eq!(last.field("side"), Some("below"), "{last:?}");
    // The curve begins four turns of the motor before the one in which the contact is detected.
    let at_contact_rad = free.last().expect("a free closing").0;
    let begins = free
        .iter()
        .rev()
        .find(|(motor_rad, _)| at_contact_rad - motor_rad > 4.5 * TAU)
        .expect("a closing that long");
    let truth = session.truth_at_estimate.as_ref().expect("an estimate");
    let true_mrad = 1e3 * (truth.joint_rad[1] - begins.1);
    let change_mrad = last.number("change_mrad").expect("a number");
    // Three deviations that the firmware states of such a sensor.
    assert!(
        (change_mrad - true_mrad).abs() < 3.0 * 3.5,
        "{change_mrad} of {true_mrad}"
    );
    assert!(
        session
            .lines
            .iter()
            .all(|line| line.event().name != "joint"),
        "the sensor was never without a reading"
    );
}

/// Contact friction holds joint 2 there, and the fits take their longest: samples must not wait.
#[test]
fn a_fit_with_the_sensor_ends_in_time() {
    let Some(firmware) = support::image(support::HALL) else {
        return;
    };
    let world = World::named("workshop").expect("one of the worlds");
    for contact_mm in [12.0, 60.0] {
        let parameters = world.of("tendon2-hall").expect("one of the scenes");
        grasp_in(&firmware, parameters, Script::button(), (94.0, contact_mm));
    }
}

/// The same finger without a cable: a contact is placed, and the guided calibration sends nobody to the closing stop.
#[test]
fn without_a_cable_there_is_none_to_calibrate() {
    let Some(firmware) = support::image(support::RIGID) else {
        return;
    };
    let session = grasp(&firmware, "p70-rigid", Script::button(), (45.0, 30.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    assert!(error_mm.abs() < 3.5, "{summary:?}");
    let said = |text: &str| {
        session
            .lines
            .iter()
            .any(|line| line.to_string().contains(text))
    };
    assert!(
        !said("enter: calibrate cable"),
        "nobody is sent to the stop"
    );
    assert!(said("hint put a pin at"), "a pin comes first");
}

/// Joint 1's motor alone closes on an object, and joint 2, held by its own worm, gives way: a contact is placed.
#[test]
fn a_motor_at_every_joint_places_a_contact() {
    let Some(firmware) = support::image(support::DIRECT) else {
        return;
    };
    let session = grasp(&firmware, "direct2", Script::button(), (45.0, 35.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 3.0 * sigma_mm, "{summary:?}");
}

/// The amplifier's middle, sign and gain go from the scene into world and firmware alike: a contact is placed, and the self-test
/// takes an offset of either sign.
#[test]
fn a_signed_current_is_read_with_its_sign() {
    let Some(firmware) = support::image(support::SHUNT) else {
        return;
    };
    let session = grasp(&firmware, "p70-shunt", Script::button(), (45.0, 30.0));
    let summary = Summary::of(&session);
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let error_mm = summary.k_mm.expect("a place") - summary.true_k_mm.expect("a contact");
    let sigma_mm = summary.sigma_mm.expect("a deviation");
    assert!(error_mm.abs() < 3.0 * sigma_mm, "{summary:?}");

    let mut parameters = Parameters::of("p70-shunt").expect("one of the scenes");
    parameters.sense.offset_a = -5e-3;
    let settings = Settings {
        parameters,
        script: Script::parse("selftest"),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a session");
    while !session.timed_out() && session.machine.time_s() < 10.0 {
        session.millisecond().expect("no misuse");
    }
    let steps: Vec<String> = session
        .lines
        .iter()
        .map(ToString::to_string)
        .filter(|line| line.contains("selftest step="))
        .collect();
    assert_eq!(steps.len(), 8, "{steps:#?}");
    assert!(
        steps.iter().all(|step| step.contains("result=ok")),
        "{steps:#?}"
    );
    assert!(
        steps.iter().any(|step| step.contains("value=-5")),
        "{steps:#?}"
    );
}

/// An object on springs of 0.5 N/mm behind pins that are fixed.
#[test]
fn the_stiffness_of_an_object_is_told() {
    let Some(firmware) = support::firmware() else {
        return;
    };
    let mut parameters = Parameters::of("p70").expect("a scene");
    parameters.object.mount = ObjectMount::Spring;
    parameters.object.stiffness_n_per_m = 500.0;
    let settings = Settings {
        parameters,
        object: Some(Object {
            contact_mm: 35.0,
            ..Object::default()
        }),
        script: Script::calibration(&[21.0, 52.0]),
        ..Settings::default()
    };
    let session = end_of(&firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(session.completed() && session.faults.is_empty());
    let events: Vec<_> = session.lines.iter().map(|line| line.event()).collect();
    let last = |name: &str| {
        let found = events.iter().rfind(|event| event.name == name);
        found.unwrap_or_else(|| panic!("no line {name}"))
    };
    let place = last("located");
    let [k_mm, sigma_mm] = ["k_mm", "sigma_mm"].map(|key| place.number(key).expect("a number"));
    assert!(
        (k_mm - 35.0).abs() < 2.0 * sigma_mm && sigma_mm < 2.0,
        "{k_mm} {sigma_mm}"
    );
    let object = last("object");
    let [given, sigma, least] = [
        "compliance_mm_per_n",
        "compliance_sigma_mm_per_n",
        "least_n_per_mm",
    ]
    .map(|key| object.number(key).expect("a number"));
    assert!(
        (given - 2.0).abs() < 2.0 * sigma && sigma < 0.6,
        "{given} {sigma}"
    );
    assert!(least < 0.5, "{least}");
    let told = events.iter().filter(|event| event.name == "object");
    assert_eq!(told.count(), 1, "with the last word, and not of a pin");
}
