// SPDX-License-Identifier: GPL-2.0-only
//! A grasp recorded from the firmware is replayed to what the firmware said live.
//!
//! Nothing is lost on the way: a sample a millisecond, each with all its digits. The events are not equal to the last digit,
//! because a recording does not tell when the firmware began to record friction: the replay finds the free closing and
//! opening in it by itself. Stated for each: the touch 2 ms and 0.5 mrad, the place half of its deviation, the force one.
//!
//! The image comes from `PALPATE_ELF` (`cargo xtask test` sets it); without it this test says so and passes.

use std::collections::BTreeSet;

use palpate::sensing::{Directive, Event};
use palpate_emulator::Firmware;
use palpate_emulator::sim::{Object, Script, Session, Settings, end_of};
use palpate_evaluation::replay::{Preparation, Replay, replay};
use palpate_evaluation::trace;
use palpate_monitor::recording::Recording;
use palpate_monitor::stream::{Message, parse};
use palpate_scenes::P70;

/// What a grasp came to: its events without their numbers, and the numbers that matter.
#[derive(Debug, Default)]
struct Told {
    events: Vec<String>,
    touch_us: u64,
    onset_mrad: f64,
    k_mm: f64,
    sigma_mm: f64,
    force_n: f64,
    force_sigma_n: f64,
}

fn live(session: &Session<'_>) -> Told {
    let mut told = Told::default();
    for line in &session.lines {
        let event = line.event();
        let number = |key| event.number(key).unwrap_or(f64::NAN);
        match event.name {
            "touch" => {
                told.touch_us = number("time_us") as u64;
                told.onset_mrad = number("theta_a_mrad");
            }
            "located" => {
                told.k_mm = number("k_mm");
                told.sigma_mm = number("sigma_mm");
                told.force_n = number("force_n");
                told.force_sigma_n = number("force_sigma_n");
            }
            "not-located" | "ambiguous" | "unusual" | "stiffness" | "friction-stale" => {}
            _ => continue,
        }
        told.push(event.name);
    }
    told
}

fn replayed(found: &Replay, first_us: u64) -> Told {
    let mut told = Told::default();
    for one in &found.told {
        match one.event {
            Event::Touch {
                time_us,
                theta_a_rad,
                ..
            } => {
                told.touch_us = first_us + time_us;
                told.onset_mrad = 1e3 * f64::from(theta_a_rad);
                told.push("touch");
            }
            Event::Located {
                k_m,
                sigma_m,
                force_n,
                force_sigma_n,
                ..
            } => {
                told.k_mm = 1e3 * f64::from(k_m);
                told.sigma_mm = 1e3 * f64::from(sigma_m);
                told.force_n = force_n.into();
                told.force_sigma_n = force_sigma_n.into();
                told.push("located");
            }
            Event::NotLocated { .. } => told.push("not-located"),
            Event::Ambiguous { .. } => told.push("ambiguous"),
            Event::Unusual { .. } => told.push("unusual"),
            Event::Stiffness { .. } => told.push("stiffness"),
            Event::FrictionStale { .. } => told.push("friction-stale"),
            _ => {}
        }
    }
    told
}

impl Told {
    fn push(&mut self, name: &str) {
        self.events.push(name.to_owned());
    }

    /// How often a place is told on the way is a matter of chance. Of the last two the order is as well: live, the motion ends
    /// because the place is settled, and the replay may settle it only because the motion ends.
    fn kinds(&self) -> BTreeSet<&str> {
        self.events.iter().map(String::as_str).collect()
    }
}

#[test]
fn a_recorded_grasp_is_replayed_to_what_was_said_live() {
    let Some(path) = std::env::var_os("PALPATE_ELF") else {
        eprintln!("PALPATE_ELF is not set: nothing tested");
        return;
    };
    let firmware = Firmware::load(path.as_ref()).expect("the image loads");
    let settings = Settings {
        object: Some(Object {
            phalanx: 2,
            contact_mm: 30.0,
            diameter_mm: 10.0,
            theta_1_deg: 45.0,
        }),
        script: Script::parse("trace on; run"),
        ..Settings::default()
    };
    let session = end_of(&firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(
        session.completed() && session.faults.is_empty(),
        "{:?}",
        session.faults
    );

    let file = std::env::temp_dir().join(format!("palpate-round-{}.csv", std::process::id()));
    let mut recording = Recording::create(&file).expect("a temporary file");
    let mut times_us: Vec<u64> = Vec::new();
    for line in &session.lines {
        // As a printer of the log writes it.
        if let Some(Message::Sample(sample)) = parse(&line.to_string()) {
            recording.sample(&sample).expect("a row");
            times_us.push((1e6 * sample.time_s).round() as u64);
        }
        assert_ne!(line.event().name, "log", "{line}");
    }
    recording.finish().expect("the file is written");
    assert!(times_us.len() > 15_000, "{}", times_us.len());
    assert!(
        times_us.windows(2).all(|pair| pair[1] - pair[0] == 1_000),
        "every millisecond has its sample"
    );

    let opened = std::fs::File::open(&file).expect("the file");
    let (rows, findings) = trace::read(opened).expect("replay reads it");
    assert_eq!((findings.repeated, findings.backward), (0, 0));
    let resampled = trace::resample(&rows, 0);
    assert!(!resampled.interpolated && resampled.gaps.is_empty());
    let before = Preparation {
        friction: None,
        calibration: <P70 as palpate::scene::Scene>::UNCALIBRATED,
    };
    let found = replay::<P70>(&resampled.samples, &before, Directive::Watch);
    std::fs::remove_file(&file).expect("the file is there");

    let first_us = times_us[0];
    let (live, replayed) = (live(&session), replayed(&found, first_us));
    let both = format!("live {live:?}\nreplayed {replayed:?}");
    println!("{both}");
    assert_eq!(live.kinds(), replayed.kinds(), "{both}");
    assert!(live.touch_us.abs_diff(replayed.touch_us) <= 2_000, "{both}");
    assert!(
        (live.onset_mrad - replayed.onset_mrad).abs() < 0.5,
        "{both}"
    );
    assert!(
        (live.k_mm - replayed.k_mm).abs() < 0.5 * live.sigma_mm,
        "{both}"
    );
    assert!(
        (live.sigma_mm - replayed.sigma_mm).abs() < 0.1 * live.sigma_mm,
        "{both}"
    );
    assert!(
        (live.force_n - replayed.force_n).abs() < live.force_sigma_n,
        "{both}"
    );
}
