// SPDX-License-Identifier: GPL-2.0-only
//! The self-test on the emulated chip: it passes on a sound board, moves the finger by a few degrees at most, and names what is
//! wrong where something is.

use crate::support::{self, firmware};
use palpate_emulator::sim::{Script, Session, Settings};
use palpate_emulator::{Firmware, Quirks};
use palpate_plant::Faults;

/// What may be wrong with a board.
enum Wrong {
    Nothing,
    /// From the start.
    Parts(Quirks),
    /// In finger, motor or encoder, before the test or after a step has passed.
    Plant(fn(&mut Faults), Option<&'static str>),
    /// The converter gives this voltage for the current, before the test or after a step has passed.
    Current(f64, Option<&'static str>),
    /// It gives none until the offset has been told, as if the sense's were zero.
    OffsetOfZero,
}

/// What a test said.
struct Said {
    /// Step, result and remedy of each line.
    steps: Vec<[String; 3]>,
    answer: Option<String>,
    /// The log, for finding the reason.
    log: String,
    /// Largest excursion of the finger, degrees at the input link.
    moved_deg: f64,
}

impl Said {
    /// The last step and its result.
    fn last(&self) -> [&str; 2] {
        let [step, result, _] = self.steps.last().expect("at least one step");
        [step, result]
    }
}

const COUNTS_PER_DEG: f64 = 1_310_720.0 / 360.0;

fn selftest(firmware: &Firmware, wrong: &Wrong) -> Said {
    let mut settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    if let Wrong::Parts(quirks) = wrong {
        settings.setup.quirks = *quirks;
    }
    let mut session = Session::start(firmware, settings, None).expect("a sound start");
    let millisecond = |session: &mut Session<'_>| {
        session
            .millisecond()
            .expect("the firmware keeps to the rules of the chip");
    };
    for _ in 0..200 {
        millisecond(&mut session);
    }
    let break_it = |session: &mut Session<'_>| match wrong {
        Wrong::Plant(fault, _) => {
            fault(&mut session.machine.plant_mut().expect("there is one").faults);
        }
        Wrong::Current(volt, _) => session
            .machine
            .rewire(|wires| wires.current_v = Some(*volt)),
        Wrong::OffsetOfZero => (session.machine).rewire(|wires| wires.current_v = Some(0.0)),
        Wrong::Nothing | Wrong::Parts(_) => {}
    };
    let after = match wrong {
        Wrong::Plant(_, after) | Wrong::Current(_, after) => *after,
        _ => None,
    };
    let mut broken = after.is_none();
    if broken {
        break_it(&mut session);
    }
    session.machine.command("selftest\n");
    let counts = |session: &Session<'_>| {
        let plant = session.machine.plant().expect("there is one");
        plant.encoder_count() as f64
    };
    let start = counts(&session);
    let mut moved_deg = 0.0f64;
    let mut answer = None;
    for _ in 0..4000 {
        millisecond(&mut session);
        moved_deg = moved_deg.max((counts(&session) - start).abs() / COUNTS_PER_DEG);
        if !broken && after.is_some_and(|step| passed(&session, step)) {
            broken = true;
            break_it(&mut session);
        }
        if matches!(wrong, Wrong::OffsetOfZero)
            && steps(&session).iter().any(|[name, ..]| name == "offset")
        {
            session.machine.rewire(|wires| wires.current_v = None);
        }
        let texts = session.lines.iter().map(|line| &line.message);
        answer = texts
            .filter_map(|text| text.strip_prefix("answer ").map(str::to_owned))
            .next();
        if answer.is_some() {
            break;
        }
    }
    Said {
        steps: steps(&session),
        log: session
            .lines
            .iter()
            .map(|line| format!("{line}\n"))
            .collect(),
        answer,
        moved_deg,
    }
}

fn steps(session: &Session<'_>) -> Vec<[String; 3]> {
    let events = session.lines.iter().map(|line| line.event());
    events
        .filter(|event| event.name == "selftest")
        .map(|event| {
            ["step", "result", "remedy"].map(|key| event.field(key).unwrap_or_default().to_owned())
        })
        .collect()
}

fn passed(session: &Session<'_>, step: &str) -> bool {
    steps(session)
        .iter()
        .any(|[name, result, _]| name == step && result == "ok")
}

#[test]
fn a_sound_board_passes_every_step_and_the_finger_moves_by_a_few_degrees() {
    let Some(firmware) = firmware() else { return };
    let said = selftest(&firmware, &Wrong::Nothing);
    assert_eq!(
        said.answer.as_deref(),
        Some("selftest passed"),
        "{}",
        said.log
    );
    let names: Vec<&str> = said.steps.iter().map(|step| step[0].as_str()).collect();
    let all = palpate::app::selftest::SelfTestStep::ALL.map(|step| step.name());
    assert_eq!(names, all);
    assert!((2.0..4.0).contains(&said.moved_deg), "{}", said.moved_deg);
}

/// Many a bridge has such an offset: it costs accuracy, and what comes after it is tried all the same.
#[test]
fn an_offset_of_zero_is_told_and_does_not_end_the_test() {
    let Some(firmware) = firmware() else { return };
    let said = selftest(&firmware, &Wrong::OffsetOfZero);
    let failed: Vec<&str> = (said.steps.iter())
        .filter(|[_, result, _]| result == "failed")
        .map(|[step, ..]| step.as_str())
        .collect();
    assert_eq!(failed, ["offset"], "{}", said.log);
    assert_eq!(said.last(), ["travel", "ok"], "{}", said.log);
    let answer = said.answer.as_deref();
    assert_eq!(answer, Some("selftest failed at offset"), "{}", said.log);
}

#[test]
fn what_is_wrong_is_named_and_nothing_moves_before_it_is_safe() {
    let Some(firmware) = firmware() else { return };
    let asleep = Quirks {
        wake_fault_s: 1.0,
        ..Quirks::default()
    };
    let held = Quirks {
        fault_pin_held_high: true,
        ..Quirks::default()
    };
    let cases: &[(&str, Wrong, &str, &str)] = &[
        (
            "supply low",
            Wrong::Plant(|f| f.supply_v = Some(8.0), None),
            "supply",
            "divider at A5",
        ),
        ("bridge asleep", Wrong::Parts(asleep), "wake", "nSLEEP"),
        (
            "fault pin held high",
            Wrong::Parts(held),
            "break-input",
            "pull-up",
        ),
        (
            "sense reads zero",
            Wrong::Current(0.0, None),
            // After the offset: nothing that makes no noise is driven.
            "noise",
            "A1, and nSLEEP at D4",
        ),
        (
            "sense offset too large",
            Wrong::Current(0.2, None),
            "offset",
            "too large",
        ),
        (
            "encoder never rests",
            Wrong::Plant(|f| f.encoder.storm_edges_per_s = 2e4, Some("break-input")),
            "offset",
            "does not rest",
        ),
        (
            "sense not connected",
            Wrong::Current(0.03, None),
            "noise",
            "A1, and nSLEEP at D4",
        ),
        (
            "sense wire off",
            Wrong::Current(0.0, Some("noise")),
            "current",
            "sense wire",
        ),
        (
            "encoder swapped",
            Wrong::Plant(|f| f.encoder.swapped = true, None),
            "encoder",
            "swap",
        ),
        (
            "encoder A cut",
            Wrong::Plant(|f| f.encoder.a_cut = true, None),
            "encoder",
            "D12",
        ),
        (
            "encoder B cut",
            Wrong::Plant(|f| f.encoder.b_cut = true, None),
            "encoder",
            "D11",
        ),
        (
            "rotor locked",
            Wrong::Plant(|f| f.rotor_locked = true, None),
            "encoder",
            "free the finger",
        ),
        (
            "finger jammed",
            Wrong::Plant(|f| f.rotor_locked = true, Some("encoder")),
            "travel",
            "free the finger",
        ),
    ];
    for (name, wrong, step, remedy) in cases {
        let said = selftest(&firmware, wrong);
        assert_eq!(said.last(), [*step, "failed"], "{name}: {:?}", said.steps);
        let told = &said.steps.last().expect("at least one")[2];
        assert!(told.contains(remedy), "{name}: {told}");
        let first = (said.steps.iter()).find(|[_, result, _]| result == "failed");
        let answer = format!("selftest failed at {}", first.expect("one")[0]);
        assert_eq!(said.answer, Some(answer), "{name}");
        let moves = ["current", "encoder", "travel"].contains(step);
        assert!(
            said.moved_deg < if moves { 4.0 } else { 0.05 },
            "{name}: {}",
            said.moved_deg
        );
    }
}

/// Limits that wait for a restart are not those by which the supply is judged, nor would they name a fault.
#[test]
fn the_supply_is_judged_by_the_limits_in_force() {
    let Some(firmware) = firmware() else { return };
    let settings = Settings {
        script: Script::parse("set supply-min 11.5; set supply-max 12.5; selftest"),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a sound start");
    let plant = session.machine.plant_mut().expect("there is one");
    plant.faults.supply_v = Some(11.0);
    support::run_out(&mut session);
    let events = session.lines.iter().map(|line| line.event());
    let mut supply = events.filter(|event| event.field("step") == Some("supply"));
    let told = supply.next().expect("its line");
    assert_eq!(told.field("result"), Some("ok"), "{told:?}");
    let mut said = session.lines.iter().map(|line| line.message.as_str());
    assert!(said.clone().any(|line| line.contains("want=9 to 15 V")));
    assert_eq!(said.next_back(), Some("answer selftest passed"));
}
