// SPDX-License-Identifier: GPL-2.0-only
//! The unmodified image against a finger and an object that MuJoCo computes: it feels the contact where that world has it,
//! and an emulated run stays the same from one time to the next. Needs the feature `mujoco`.

#![cfg(feature = "mujoco")]

use crate::support::firmware;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Settings, Summary, Told, end_of};
use palpate_plant::{Engine, Parameters};

/// Of the length of phalanx 2, 70 mm: what an uncalibrated finger may be off by.
const SHARE: f64 = 0.1;

fn told(firmware: &Firmware, seed: u64) -> (Summary, Vec<String>) {
    let settings = Settings {
        parameters: Parameters {
            engine: Engine::Mujoco,
            ..Parameters::default()
        },
        object: Some(Object::default()),
        seed,
        ..Settings::default()
    };
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(session.completed(), "not completed");
    assert_eq!(session.faults, []);
    let lines = session.lines.iter().map(ToString::to_string).collect();
    (Summary::of(&session), lines)
}

#[test]
fn the_image_locates_a_contact_in_the_other_engine() {
    let Some(firmware) = firmware() else { return };
    let (summary, lines) = told(&firmware, 1);
    println!("{summary:?}");
    assert_eq!(summary.told, Told::Located, "{summary:?}");
    let (found, truth) = (summary.k_mm, summary.true_k_mm);
    let (found, truth) = (found.expect("a place"), truth.expect("a contact"));
    assert!((truth - 30.0).abs() < 0.2, "{truth} mm");
    assert!((found - truth).abs() < SHARE * 70.0, "{found} mm");
    assert_eq!(told(&firmware, 1).1, lines, "the same seed");
}
