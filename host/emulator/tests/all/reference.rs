// SPDX-License-Identifier: GPL-2.0-only
//! Every class of instructions against another implementation. Needs the feature `reference`; `PALPATE_FUZZ_CASES` sets how many
//! of each class.

#![cfg(feature = "reference")]

use palpate_emulator::cortex::reference::differences;

fn check(conditional: bool, modes: bool) {
    let cases = std::env::var("PALPATE_FUZZ_CASES");
    let cases = cases.map_or(2000, |text| text.parse().expect("a number"));
    let wrong = differences(cases, conditional, modes);
    for text in &wrong {
        println!("{text}");
    }
    assert!(wrong.is_empty(), "{} differ", wrong.len());
}

#[test]
fn instructions_do_what_the_reference_does() {
    check(false, false);
}

#[test]
fn instructions_do_what_the_reference_does_in_it_blocks() {
    check(true, false);
}

#[test]
fn arithmetic_follows_the_modes_of_fpscr() {
    check(false, true);
}
