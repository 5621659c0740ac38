// SPDX-License-Identifier: GPL-2.0-only
//! Tests of TIM1.

use super::*;
use crate::time::TICKS_PER_US;

fn at(now: Ticks) -> Clocks {
    Clocks { now, bus: 24 }
}

/// 100 kHz centre-aligned PWM, update at 20 kHz as TRGO2, active-low break.
fn bridge() -> Tim1 {
    let mut timer = Tim1::new();
    let set = |timer: &mut Tim1, offset, value| timer.write(offset, value, at(0)).unwrap();
    for (offset, value) in [
        (ARR, 850),
        (RCR, 9),
        (CR2, 2 << 20),
        (CCMR1, 6 << 4 | 8),
        (CCER, 1),
        (CCR1, 425),
        (BDTR, BKE),
        (EGR, 1),
        (CR1, 0x20 | 1),
    ] {
        set(&mut timer, offset, value);
    }
    timer.set_break_pin(Some(true));
    timer.write(BDTR, BKE | MOE, at(0)).unwrap();
    timer
}

#[test]
fn updates_every_50_us_and_triggers() {
    let mut timer = bridge();
    assert_eq!(timer.next_event(), Some(50 * TICKS_PER_US));
    assert!(!timer.update(at(49 * TICKS_PER_US)));
    assert!(timer.update(at(50 * TICKS_PER_US)));
    assert_eq!(timer.next_event(), Some(100 * TICKS_PER_US));
}

#[test]
fn the_compare_value_waits_for_the_update() {
    let mut timer = bridge();
    assert_eq!(timer.duty(), Some(0.5));
    timer.write(CCR1, 850, at(TICKS_PER_US)).unwrap();
    assert_eq!(timer.duty(), Some(0.5));
    timer.update(at(50 * TICKS_PER_US));
    assert_eq!(timer.duty(), Some(1.0));
}

#[test]
fn a_break_turns_the_outputs_off_and_keeps_them_off() {
    let mut timer = bridge();
    timer.set_break_pin(Some(false));
    assert_eq!(timer.duty(), None);
    timer.write(BDTR, BKE | MOE, at(9)).unwrap();
    assert!(
        !timer.main_output(),
        "while the pin is low MOE cannot be set"
    );
    timer.set_break_pin(Some(true));
    assert!(!timer.main_output(), "latched");
    timer.write(SR, !BIF, at(9)).unwrap();
    timer.write(BDTR, BKE | MOE, at(9)).unwrap();
    assert!(timer.main_output());
    timer.system_break = true;
    timer.apply_break();
    assert!(!timer.main_output());
}
