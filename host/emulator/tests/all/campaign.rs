// SPDX-License-Identifier: GPL-2.0-only
//! Faults at every phase of a grasp and in pairs, on a finger of two phalanges and one of three: the first cause named, the bridge
//! off in its time and until `clear`, nothing kept is lost, and the next grasp works. A sample of what
//! `cargo xtask faults --matrix --pairs 1000` runs.

use crate::support;
use palpate_emulator::sim::campaign::{self, Case, When};
use palpate_emulator::sim::{FAULTS, Object, Settings};
use palpate_plant::Parameters;

/// Of the matrix; prime to the number of phases, so that the phases take turns.
const EVERY: usize = 9;
/// On the one finger the first phases, on the other those after them: each phase once.
const CELLS: [usize; 2] = [5, 3];
const PAIRS: usize = 2;

fn passes(scene: &str, cases: &[Case]) {
    let variable = match scene {
        "p70" => support::FAULTY,
        _ => support::FAULTY_TENDON3,
    };
    let Some(firmware) = support::image(variable) else {
        return;
    };
    let settings = Settings {
        parameters: Parameters::of(scene).expect("one of the scenes"),
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

/// Some cells of the matrix, from this one on.
fn cells(from: usize, count: usize) -> Vec<Case> {
    let cells = campaign::matrix(1, &[]);
    cells
        .into_iter()
        .skip(from)
        .step_by(EVERY)
        .take(count)
        .collect()
}

#[test]
fn at_every_phase() {
    passes("p70", &cells(0, CELLS[0]));
}

#[test]
fn at_every_phase_of_three_phalanges() {
    passes("tendon3", &cells(CELLS[0], CELLS[1]));
}

#[test]
fn in_pairs() {
    passes("p70", &campaign::pairs(PAIRS, 1));
}

/// The chip's supply dips while a fault is latched and the bridge off.
#[test]
fn a_reset_clears_nothing() {
    let fault = |name: &str| {
        let mut faults = FAULTS.iter();
        faults.find(|fault| fault.name == name).expect(name)
    };
    let after = |first, second| Case {
        faults: vec![
            (fault(first), When::At(3.0)),
            (fault(second), When::At(3.3)),
        ],
        seed: 1,
    };
    passes("p70", &[after("over-current", "brown-out")]);
}
