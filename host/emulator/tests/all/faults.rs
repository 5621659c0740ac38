// SPDX-License-Identifier: GPL-2.0-only
//! Faults injected into the running firmware: the bridge off in time, the right name, nothing moves again.

use crate::support;
use palpate_emulator::sim::{FAULTS, Injected, Object, Settings, judge};

fn settings() -> Settings {
    Settings {
        object: Some(Object::default()),
        max_s: 60.0,
        ..Settings::default()
    }
}

/// Judges every fault whose name passes.
fn judges(wanted: impl Fn(&str) -> bool) {
    let Some(firmware) = support::image(support::FAULTY) else {
        return;
    };
    let mut judged = 0;
    for fault in FAULTS.iter().filter(|fault| wanted(fault.name)) {
        let injected = Injected {
            fault,
            at_s: fault.at_s,
        };
        let judgement =
            judge(&firmware, settings(), Some(injected)).expect("the chip is not misused");
        assert_eq!(judgement.failures, [""; 0], "{}: {judgement:?}", fault.name);
        judged += 1;
    }
    assert!(judged > 0);
}

/// The emulator asks for what the manual promises, apart from the time until the fault is there.
#[test]
fn limits_are_those_of_the_manual() {
    let manual = include_str!("../../../../docs/MANUAL.md");
    let promised_us = |name: &str| -> f64 {
        let row = manual.lines().find(|line| {
            let mut cells = line.split('|').map(str::trim);
            cells.nth(2) == Some(&format!("`{name}`"))
        });
        let cell = row.and_then(|row| row.split('|').nth(4)).expect(name);
        let number = cell.split(':').next().expect(name).trim();
        number.parse().expect(name)
    };
    for fault in FAULTS {
        let Some(longest_us) = fault
            .reported
            .iter()
            .map(|name| promised_us(name))
            .reduce(f64::max)
        else {
            continue;
        };
        let on_the_way_us = match fault.name {
            // A command has to arrive.
            "task-starved" | "executor-hung" | "panic" | "bus-fault" | "stack-overflow" => 50_000.0,
            // The finger has to get there.
            "missing-stop" => 12_000_000.0,
            _ => 0.0,
        };
        assert!(
            fault.limit_us <= longest_us + on_the_way_us,
            "{}: {} us, promised {longest_us} us",
            fault.name,
            fault.limit_us
        );
    }
}

#[test]
fn electrical() {
    judges(|name| {
        ["over-current", "fault-pin", "brown-out"].contains(&name) || name.starts_with("supply")
    });
}

#[test]
fn encoder() {
    judges(|name| name.starts_with("encoder"));
}

#[test]
fn current_sense() {
    judges(|name| name.starts_with("adc") || name.starts_with("sense"));
}

#[test]
fn mechanical() {
    judges(|name| ["stalled-rotor", "missing-stop"].contains(&name));
}

#[test]
fn software() {
    judges(|name| {
        [
            "task-starved",
            "executor-hung",
            "panic",
            "bus-fault",
            "stack-overflow",
        ]
        .contains(&name)
    });
}

#[test]
fn log_reader() {
    judges(|name| name.starts_with("rtt"));
}
