// SPDX-License-Identifier: GPL-2.0-only
//! What `trace on` costs the processor: a sample a millisecond is to take no more than 2 % of its time.
//!
//! The same motions are run with and without it, and the instructions of everything that runs, interrupts and tasks, are compared.

use crate::support::{self, firmware};
use palpate_emulator::Firmware;
use palpate_emulator::rtt::Reader;
use palpate_emulator::sim::{Object, Script, Session, Settings};
use palpate_emulator::time::CYCLES_PER_INSTRUCTION;

/// Core clock, hertz.
const CLOCK_HZ: f64 = 170e6;
/// Most that tracing may take of the processor's time.
const MOST_SHARE: f64 = 0.02;
/// A run that takes less time than this, in seconds, has not seen a whole grasp.
const WHOLE_S: f64 = 10.0;

/// Instructions a second, and samples a second in the log, from the first motion to the end of a grasp.
fn rates(firmware: &Firmware, commands: &str) -> (f64, f64) {
    let settings = Settings {
        object: Some(Object::default()),
        script: Script::parse(commands),
        ..Settings::default()
    };
    let mut session = Session::start(firmware, settings, None).expect("a sound start");
    let mut begun = None;
    while !session.over() {
        session
            .millisecond()
            .expect("the firmware keeps to the rules of the chip");
        if begun.is_none() && !session.state.is_empty() {
            begun = Some(counted(&session));
        }
    }
    let ended = counted(&session);
    assert!(
        session.completed() && session.faults.is_empty(),
        "{:?}",
        session.faults
    );
    let begun = begun.expect("a motion");
    let seconds = ended.0 - begun.0;
    assert!(seconds > WHOLE_S, "{seconds} s");
    let samples = session
        .lines
        .iter()
        .filter(|line| line.event().name == "sample");
    (
        (ended.1 - begun.1) as f64 / seconds,
        samples.count() as f64 / seconds,
    )
}

/// Time in seconds, and instructions so far.
fn counted(session: &Session<'_>) -> (f64, u64) {
    let machine = &session.machine;
    (machine.time_s(), machine.account().total().instructions)
}

#[test]
fn tracing_takes_at_most_two_per_cent_of_the_processor() {
    let Some(firmware) = firmware() else { return };
    let (without, none) = rates(&firmware, "run");
    let (with, samples) = rates(&firmware, "trace on; run");
    let (cycles, instructions) = CYCLES_PER_INSTRUCTION;
    let share = (with - without) * cycles as f64 / instructions as f64 / CLOCK_HZ;
    println!(
        "tracing: {:.3} of {:.2} million instructions a second, {samples:.0} samples a second, {:.2} % of the core",
        1e-6 * (with - without),
        1e-6 * with,
        100.0 * share
    );
    assert!(
        none == 0.0 && samples > 990.0,
        "{none} and {samples} samples a second"
    );
    assert!(share > 0.0 && share <= MOST_SHARE, "{share}");
}

/// While nobody reads, the line that tells of lost records finds no room either: it is told once there is, and counts the others alone.
#[test]
fn lost_records_are_counted_and_the_line_that_tells_of_them_is_none() {
    let Some(firmware) = firmware() else { return };
    let settings = Settings {
        script: Script::parse("trace on; status"),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a sound start");
    support::run_out(&mut session);
    for (reader, milliseconds) in [(Reader::Absent, 500), (Reader::Attached, 100)] {
        session.machine.set_reader(reader);
        for _ in 0..milliseconds {
            session.millisecond().expect("a sound run");
        }
    }
    let of = |name: &str, key: &str| -> Vec<f64> {
        let events = session.lines.iter().map(|line| line.event());
        (events.filter(|event| event.name == name))
            .filter_map(|event| event.number(key))
            .collect()
    };
    let times_us = of("sample", "time_us");
    let missing: f64 = (times_us.windows(2))
        .map(|pair| ((pair[1] - pair[0]) / 1e3).round() - 1.0)
        .sum();
    assert!(missing > 400.0, "{missing}");
    // It is shorter than a sample, and finds the last room: the first losses may be told at once.
    let told = of("log", "dropped");
    assert!(told.len() < 5, "{told:?}");
    assert_eq!(told.last(), Some(&missing), "{told:?}");
}
