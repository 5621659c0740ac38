// SPDX-License-Identifier: GPL-2.0-only
//! The fast simulation and the emulated firmware say the same of the same grasp.
//!
//! Both run the same library against the same plant with the same seed. They cannot agree to the last bit: the chip's plant
//! is stepped where its peripherals look, so that the noise is drawn at other instants, and the chip's tasks start a few
//! periods apart. So each event has a stated tolerance: friction 2 %, the onset of the touch 15 mrad (a block or two), its
//! delay 15 ms, a place within twice what both claim together, their claims within a quarter.

use crate::support::{self, firmware};
use palpate::sensing::{Event, NotLocated};
use palpate_emulator::sim::{Object, Script, Settings, end_of};
use palpate_emulator::{Firmware, log};
use palpate_plant::{FirstContact, Grasp, Parameters};
use palpate_scenes::P70;
use palpate_simulation::{Outcome, Simulation};

const FRICTION_SHARE: f64 = 0.02;
const ONSET_MRAD: f64 = 15.0;
const DELAY_MS: f64 = 15.0;
const DEVIATIONS: f64 = 2.0;
const CLAIM_SHARE: f64 = 0.25;

/// What a grasp came to, from either side.
#[derive(Debug)]
struct Told {
    friction_mnm: f64,
    onset_mrad: Option<f64>,
    delay_ms: Option<f64>,
    /// Phalanx, place and deviation in millimetre.
    place: Option<(u32, f64, f64)>,
    proximal: bool,
}

fn emulated(firmware: &Firmware, object: Option<Object>, seed: u64) -> Told {
    let settings = Settings {
        object,
        seed,
        script: Script::parse("record-friction; close"),
        ..Settings::default()
    };
    let session = end_of(firmware, settings).expect("the firmware keeps to the rules of the chip");
    assert!(
        session.completed() && session.faults.is_empty(),
        "{:?}",
        session.faults
    );
    // Friction is told when the press on the closing stop begins, which is not the last closing.
    let whole_run = session.lines.iter().map(|line| line.event());
    let friction = last(whole_run, "friction-recorded", "closing_mnm");
    let last = |name: &str, key: &str| last(support::last_closing(&session), name, key);
    let contact = session
        .machine
        .plant()
        .and_then(|plant| plant.truth().first_contact);
    let touch_s = last("touch", "time_us").map(|us| 1e-6 * us);
    let located = last("located", "k_mm");
    Told {
        friction_mnm: friction.expect("friction is recorded"),
        onset_mrad: last("touch", "theta_a_mrad"),
        delay_ms: touch_s.and_then(|touch_s| delay_ms(touch_s, contact.as_ref())),
        place: located.map(|k_mm| {
            let number = |key| last("located", key).expect("it is in the line");
            (number("phalanx") as u32, k_mm, number("sigma_mm"))
        }),
        proximal: session.lines.iter().any(|line| {
            let event = line.event();
            event.name == "not-located" && event.field("why") == Some("proximal")
        }),
    }
}

/// The last value of a field of the events with a name.
fn last<'s>(
    events: impl DoubleEndedIterator<Item = log::Event<'s>>,
    name: &str,
    key: &str,
) -> Option<f64> {
    (events.filter(|event| event.name == name))
        .filter_map(|event| event.number(key))
        .next_back()
}

fn delay_ms(touch_s: f64, contact: Option<&FirstContact>) -> Option<f64> {
    Some(1e3 * (touch_s - contact?.time_s))
}

fn simulated(object: Option<Object>, seed: u64) -> Told {
    let mut simulation =
        Simulation::<P70>::new(&Parameters::default(), seed).expect("the defaults are valid");
    let prepared = simulation
        .prepare()
        .expect("an idle finger records friction");
    let grasp = object.map_or(Grasp::Free, |object| object.grasp());
    let outcome = simulation
        .close(&grasp)
        .expect("the object is clear of the open finger");
    assert_eq!(outcome.fault, None);
    let friction = prepared.events.iter().find_map(|(_, event)| match event {
        Event::FrictionRecorded { closing_nm, .. } => Some(1e3 * f64::from(*closing_nm)),
        _ => None,
    });
    let onset = find(&outcome, |event| match event {
        Event::Touch { theta_a_rad, .. } => Some(1e3 * f64::from(*theta_a_rad)),
        _ => None,
    });
    Told {
        friction_mnm: friction.expect("friction is recorded"),
        onset_mrad: onset,
        delay_ms: outcome.delay_s().map(|delay_s| 1e3 * delay_s),
        place: find(&outcome, |event| match *event {
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                ..
            } => Some((
                phalanx.into(),
                1e3 * f64::from(k_m),
                1e3 * f64::from(sigma_m),
            )),
            _ => None,
        }),
        proximal: find(&outcome, |event| match event {
            Event::NotLocated {
                why: NotLocated::Proximal,
                ..
            } => Some(()),
            _ => None,
        })
        .is_some(),
    }
}

/// What the last event of a kind tells.
fn find<T>(outcome: &Outcome, told: impl Fn(&Event) -> Option<T>) -> Option<T> {
    outcome
        .events
        .iter()
        .filter_map(|(_, event)| told(event))
        .last()
}

fn object(phalanx: u8, contact_mm: f64, diameter_mm: f64) -> Option<Object> {
    Some(Object {
        phalanx,
        contact_mm,
        diameter_mm,
        theta_1_deg: 40.0,
    })
}

fn agree(object: Option<Object>, seed: u64) {
    let Some(firmware) = firmware() else { return };
    let (chip, fast) = (emulated(&firmware, object, seed), simulated(object, seed));
    let both = format!("emulated {chip:?}\nsimulated {fast:?}");
    println!("{both}");
    let near = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance;
    assert!(
        near(
            chip.friction_mnm,
            fast.friction_mnm,
            FRICTION_SHARE * fast.friction_mnm
        ),
        "{both}"
    );
    assert_eq!(chip.proximal, fast.proximal, "{both}");
    assert_eq!(
        chip.onset_mrad.is_some(),
        fast.onset_mrad.is_some(),
        "{both}"
    );
    if let (Some(chip), Some(fast)) = (chip.onset_mrad, fast.onset_mrad) {
        assert!(near(chip, fast, ONSET_MRAD), "{both}");
    }
    if let (Some(chip), Some(fast)) = (chip.delay_ms, fast.delay_ms) {
        assert!(near(chip, fast, DELAY_MS), "{both}");
    }
    assert_eq!(chip.place.is_some(), fast.place.is_some(), "{both}");
    if let (Some((on, k_mm, sigma_mm)), Some((fast_on, fast_k_mm, fast_sigma_mm))) =
        (chip.place, fast.place)
    {
        assert_eq!(on, fast_on, "{both}");
        assert!(
            near(k_mm, fast_k_mm, DEVIATIONS * sigma_mm.hypot(fast_sigma_mm)),
            "{both}"
        );
        assert!(
            near(sigma_mm, fast_sigma_mm, CLAIM_SHARE * fast_sigma_mm),
            "{both}"
        );
    }
}

#[test]
fn a_distal_contact() {
    agree(object(2, 32.0, 12.0), 3);
}

#[test]
fn a_contact_near_the_tip() {
    agree(object(2, 55.0, 30.0), 4);
}

#[test]
fn a_proximal_contact() {
    agree(object(1, 50.0, 10.0), 5);
}

#[test]
fn a_free_closing() {
    agree(None, 6);
}
