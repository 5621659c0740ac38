// SPDX-License-Identifier: GPL-2.0-only
//! What `sim` tells of a calibration is compared with the truth in the units of the firmware, at the speed of its closing.

use crate::support::firmware;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Calibration, Script, Session, Settings, end_of};
use palpate_plant::Parameters;

/// A sound run of these commands.
fn run<'f>(firmware: &'f Firmware, commands: &str, flash: Option<Vec<u8>>) -> Session<'f> {
    let mut settings = Settings {
        script: Script::parse(commands),
        ..Settings::default()
    };
    settings.setup.flash = flash;
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(session.completed() && session.faults.is_empty());
    session
}

/// What was found is the truth within three deviations, each of which says something.
fn fits(session: &Session<'_>) {
    let world = Parameters::default();
    let found = Calibration::of(&session.lines, &world, &session.calibrated_with);
    let found = found.expect("it has calibrated");
    for value in [found.torque_factor, found.cable_mrad_per_nm] {
        let off = value.deviations().abs();
        assert!(off < 3.0 && value.sigma < 0.05 * value.value, "{value:?}");
    }
}

#[test]
fn the_truth_is_that_of_the_settings_in_force() {
    let Some(firmware) = firmware() else { return };
    let all = "record-friction; calibrate 21; calibrate 53; save";
    let set = "set closing-speed 0.8; set efficiency 40";
    let session = run(&firmware, &format!("{set}; {all}"), None);
    fits(&session);
    // After a restart they are those that were kept.
    let flash = session.machine.flash().to_vec();
    let again = run(&firmware, "calibrate 53", Some(flash));
    fits(&again);
    assert_eq!(again.calibrated_with, session.calibrated_with);
}
