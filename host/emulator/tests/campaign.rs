// SPDX-License-Identifier: GPL-2.0-only
//! Faults at every phase of a grasp and in pairs: the first cause named, the bridge off, nothing kept is lost, and the next grasp
//! works. A sample of what `cargo xtask faults --matrix --pairs 1000` runs.
//!
//! The image, built with the feature `fault-injection`, comes from `PALPATE_FAULT_ELF` (`cargo xtask test` sets it);
//! without it these tests say so and pass.

use palpate_emulator::Firmware;
use palpate_emulator::sim::campaign::{self, Case};
use palpate_emulator::sim::{Object, Settings};

/// Of the matrix; prime to the number of phases, so that the phases take turns.
const EVERY: usize = 9;
const PAIRS: usize = 20;

fn passes(cases: &[Case]) {
    let Some(path) = std::env::var_os("PALPATE_FAULT_ELF") else {
        eprintln!("PALPATE_FAULT_ELF is not set: nothing tested");
        return;
    };
    let firmware = Firmware::load(path.as_ref()).expect("the image loads");
    let object = Object {
        phalanx: 2,
        contact_mm: 30.0,
        diameter_mm: 10.0,
        theta_1_deg: 45.0,
    };
    let settings = Settings {
        object: Some(object),
        max_s: 120.0,
        ..Settings::default()
    };
    let results = campaign::run(&firmware, &settings, cases, |_, _| {}).expect("no misuse");
    for (case, aftermath) in cases.iter().zip(&results) {
        assert_eq!(
            aftermath.failures,
            [""; 0],
            "{}: {aftermath:#?}",
            case.name()
        );
    }
}

#[test]
fn at_every_phase() {
    let cells = campaign::matrix(1, &[]);
    passes(&cells.into_iter().step_by(EVERY).collect::<Vec<_>>());
}

#[test]
fn in_pairs() {
    passes(&campaign::pairs(PAIRS, 1));
}
