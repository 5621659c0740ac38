// SPDX-License-Identifier: GPL-2.0-only
//! Faults at every phase of a grasp and in pairs: the first cause named, the bridge off, nothing kept is lost, and the next grasp
//! works. A sample of what `cargo xtask faults --matrix --pairs 1000` runs.

mod support;

use palpate_emulator::sim::campaign::{self, Case};
use palpate_emulator::sim::{Object, Settings};

/// Of the matrix; prime to the number of phases, so that the phases take turns.
const EVERY: usize = 9;
/// As many as a few minutes allow.
const CELLS: usize = 15;
const PAIRS: usize = 8;

fn passes(cases: &[Case]) {
    let Some(firmware) = support::image(support::FAULTY) else {
        return;
    };
    let settings = Settings {
        object: Some(Object::default()),
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
    passes(
        &cells
            .into_iter()
            .step_by(EVERY)
            .take(CELLS)
            .collect::<Vec<_>>(),
    );
}

#[test]
fn in_pairs() {
    passes(&campaign::pairs(PAIRS, 1));
}
