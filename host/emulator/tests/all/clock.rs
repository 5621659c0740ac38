// SPDX-License-Identifier: GPL-2.0-only
//! A grasp while the clock of the tasks passes 2^32 us, 71 minutes after power-on: a task that keeps the lower half of a time
//! would stumble there. Samples carry a time of their own, counted by the control interrupt;
//! `host/simulation/tests/all/endurance.rs` takes that past the same boundary.
//!
//! Nobody waits 71 minutes: the clock's driver counts periods of 2^15 us in a word of RAM, and a flash image in which that word
//! starts with a large number makes the chip believe that it has been on for so long. The timer itself, of which the driver uses
//! 16 bits at 1 MHz, and the encoder's counter wrap in every phase that lasts long enough: here they are counted.

use std::collections::BTreeMap;

use crate::support::firmware;
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings};

/// Period of the driver's count, second.
const PERIOD_S: f64 = 32_768e-6;
/// Periods until the boundary.
const BOUNDARY: u32 = 1 << (32 - 15);
/// Size of the driver's state in words.
const DRIVER_WORDS: u32 = 6;

fn settings(flash: Vec<u8>) -> Settings {
    let mut settings = Settings {
        object: Some(Object::default()),
        script: Script::parse("record-friction; close; open"),
        ..Settings::default()
    };
    settings.setup.flash = Some(flash);
    settings
}

/// Where the driver's count of periods lies: the word of its state that has counted them a second after power-on.
fn period_word(firmware: &Firmware) -> u32 {
    let driver = firmware
        .symbol_with("time_driver6driver6DRIVER")
        .expect("embassy's clock");
    let settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    let mut session = Session::start(firmware, settings, None).expect("a sound start");
    while session.machine.time_s() < 1.0 {
        session.millisecond().expect("a sound run");
    }
    let counted = |address: &u32| {
        let started = (0.9 / PERIOD_S) as u32..=(1.0 / PERIOD_S) as u32;
        session
            .machine
            .word(*address)
            .is_some_and(|word| started.contains(&word))
    };
    let words: Vec<u32> = (0..DRIVER_WORDS)
        .map(|word| driver + 4 * word)
        .filter(counted)
        .collect();
    assert_eq!(words.len(), 1, "{words:x?}");
    words[0]
}

/// Flash of a chip whose clock passes the boundary so long after power-on, to a period or two.
fn image(firmware: &Firmware, word: u32, seconds: f64) -> Vec<u8> {
    let settings = Settings::default();
    let session = Session::start(firmware, settings, None).expect("a sound start");
    let mut image = session.machine.flash().to_vec();
    let symbol = |name| firmware.symbol(name).expect("of cortex-m-rt");
    let at = (symbol("__sidata") - 0x0800_0000 + word - symbol("__sdata")) as usize;
    // An even number: the counter starts in its lower half.
    let periods = (BOUNDARY - (seconds / PERIOD_S) as u32) & !1;
    image[at..at + 4].copy_from_slice(&periods.to_le_bytes());
    image
}

/// Wraps of 16-bit counters in a phase.
#[derive(Debug, Default)]
struct Wraps {
    clock: u32,
    encoder: u32,
}

/// Runs to the end, and counts the wraps in each phase.
fn run(firmware: &Firmware, flash: Vec<u8>) -> (Session<'_>, BTreeMap<String, Wraps>) {
    let mut session = Session::start(firmware, settings(flash), None).expect("a sound start");
    let turns = |session: &Session<'_>| {
        let plant = session.machine.plant().expect("there is one");
        // The driver's timer and the encoder's begin with the firmware's start, some milliseconds after power-on.
        let clock = (session.machine.time_s() * 1e6) as i64 >> 16;
        (clock, plant.encoder_count() >> 16)
    };
    let mut wraps = BTreeMap::<String, Wraps>::new();
    while !session.over() {
        let before = turns(&session);
        session.millisecond().expect("a sound run");
        let after = turns(&session);
        let phase = wraps.entry(session.state.clone()).or_default();
        phase.clock += u32::from(after.0 != before.0);
        phase.encoder += u32::from(after.1 != before.1);
    }
    session.finish().expect("a sound run");
    assert!(session.completed(), "{:?}", session.faults);
    (session, wraps)
}

/// The log's words, but for the times: what is said of the contact, the last of each kind, and then the rest in its order, of
/// several lines of a kind in a row the last. How often and when a contact is told before its last word depends on how many
/// samples a round of the locator took.
fn words(session: &Session<'_>) -> Vec<String> {
    let kind = |message: &str| message.split(' ').next().unwrap_or_default().to_owned();
    let (of_contact, mut rest): (Vec<&str>, Vec<&str>) = session
        .lines
        .iter()
        .map(|line| line.message.as_str())
        .partition(|message| ["located", "object", "stiffness"].contains(&kind(message).as_str()));
    let last: BTreeMap<_, _> = of_contact.iter().map(|line| (kind(line), *line)).collect();
    rest.reverse();
    rest.dedup_by_key(|message| kind(message));
    (last.into_values().chain(rest.into_iter().rev()))
        .flat_map(|message| message.split(' '))
        .filter(|word| !word.starts_with("time_us="))
        .map(str::to_owned)
        .collect()
}

/// Keys of what is estimated from noise: standard deviations of what a record of friction leaves and of its wander, and the least stiffness
/// of an object, which follows from its compliance's deviation.
const OF_NOISE: [&str; 3] = ["residual_mnm", "wander_mnm", "least_n_per_mm"];

/// The same word, or the same key with numbers that differ by no more than 5 %, those of noise 15 %, deviations 50 %, besides torques half
/// a millinewton metre, a radius's deviation, which jumps where the fit of one more radius joins, 1 mm, and what is about zero: a cable's
/// stiffening 0.01 per newton metre, a rigid object's compliance 0.05 mm/N and its share of the rotation 0.01. A start with another time takes some microseconds more or less, and the noise is drawn at other instants.
fn alike(a: &str, b: &str) -> bool {
    let number = |word: &str| {
        let (key, value) = word.split_once('=')?;
        Some((key.to_owned(), value.parse::<f64>().ok()?))
    };
    match (number(a), number(b)) {
        (Some((key, a)), Some((same, b))) => {
            let share = if key.contains("sigma") {
                0.5
            } else if OF_NOISE.contains(&key.as_str()) {
                0.15
            } else {
                0.05
            };
            let besides = match key.as_str() {
                "torque_mnm" => 0.5,
                "stiffening_per_nm" => 0.01,
                "radius_sigma_mm" => 1.0,
                "compliance_mm_per_n" => 0.05,
                "share" => 0.01,
                _ => 0.0,
            };
            let most = share * b.abs() + besides;
            key == same && (a.is_nan() && b.is_nan() || (a - b).abs() <= most)
        }
        _ => a == b,
    }
}

#[test]
fn a_grasp_goes_on_while_the_lower_half_of_the_time_wraps() {
    let Some(firmware) = firmware() else { return };
    let word = period_word(&firmware);
    let (usual, wraps) = run(
        &firmware,
        image(&firmware, word, PERIOD_S * f64::from(BOUNDARY)),
    );
    println!("{wraps:?}");
    for phase in ["home", "record-closing", "record-opening", "close", "open"] {
        let Wraps { clock, encoder } = wraps[phase];
        assert!(clock > 0 && encoder > 0, "{phase}: {clock} {encoder}");
    }
    for phase in ["calibrate-offset", "probe", "hold"] {
        assert!(wraps[phase].clock > 0, "{phase}");
    }
    let end_s = usual.machine.time_s();
    // In homing, in the recording of friction, in the closing, and about where the contact is probed.
    for share in [0.05, 0.3, 0.7, 0.8] {
        let (session, _) = run(&firmware, image(&firmware, word, share * end_s));
        let wrapped = session.machine.word(word).is_some_and(|p| p > BOUNDARY);
        assert!(wrapped, "the boundary was not passed: nothing tested");
        let (told, wanted) = (words(&session), words(&usual));
        assert_eq!(told.len(), wanted.len(), "at {share} of the run: {told:?}");
        for (word, wanted) in told.iter().zip(&wanted) {
            assert!(
                alike(word, wanted),
                "at {share} of the run: {word} for {wanted}"
            );
        }
    }
}
