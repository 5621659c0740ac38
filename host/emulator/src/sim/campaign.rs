// SPDX-License-Identifier: GPL-2.0-only
//! Faults at every phase of a grasp, one or two at a time, and what the finger can do after they were cleared.
//!
//! Whatever happens: the first fault named is one that was injected, the bridge is then off and stays off until `clear`, no
//! stored record changes, and the grasp after `clear` works. A fault that the phase lets nobody see (an encoder's broken wire
//! while the motor stands) may be found later or not at all; the stated time counts where it can be seen at once.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::fault::{FAULTS, Fault};
use super::judge::{WATCH, control, names, stored};
use super::script::{Script, Step};
use super::session::{Session, Settings, end_of};
use crate::rtt::Reader;
use crate::time::{self, TICKS_PER_MS, TICKS_PER_US, Ticks};
use crate::world::Wires;
use crate::{Error, Firmware};

/// Phases of a grasp, as the log names them, in their order.
pub const PHASES: &[&str] = &[
    "calibrate-offset",
    "home",
    "record-closing",
    "record-opening",
    "close",
    "probe",
    "hold",
    "open",
];

/// When a fault comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// So many milliseconds after this phase was reported.
    Phase(&'static str, u32),
    /// At this time, second.
    At(f64),
}

/// Faults of one run.
#[derive(Clone, Debug)]
pub struct Case {
    /// Each with its moment.
    pub faults: Vec<(&'static Fault, When)>,
    /// Seed of the simulated noise.
    pub seed: u64,
}

impl Case {
    /// For messages.
    #[must_use]
    pub fn name(&self) -> String {
        let one = |(fault, when): &(&Fault, When)| match when {
            When::Phase(phase, ms) => format!("{}@{phase}+{ms}ms", fault.name),
            When::At(s) => format!("{}@{s:.3}s", fault.name),
        };
        self.faults.iter().map(one).collect::<Vec<_>>().join(" ")
    }
}

/// What came of a case.
#[derive(Clone, Debug, Default)]
pub struct Aftermath {
    /// Phase in which the first fault came.
    pub phase: String,
    /// Faults reported, the first cause first.
    pub reported: Vec<String>,
    /// From the injection of the one that was reported first until the bridge was off.
    pub off_us: Option<f64>,
    /// The stated time applies: a single fault that its phase lets be seen at once.
    pub timed: bool,
    /// Grasps it took after `clear` until one went through: a second one where friction had to be recorded anew.
    pub grasps: u32,
    /// Most instructions of a control interrupt.
    pub instructions: u64,
    /// Why it failed; empty if it did not.
    pub failures: Vec<String>,
    /// What the firmware said, of a run that failed.
    pub log: Vec<String>,
}

/// Every fault at every phase, or those of these names.
#[must_use]
pub fn matrix(seed: u64, names: &[&str]) -> Vec<Case> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let cells = FAULTS
        .iter()
        .flat_map(|fault| PHASES.iter().map(move |phase| (fault, *phase)));
    cells
        .map(|(fault, phase)| Case {
            faults: vec![(fault, When::Phase(phase, random.random_range(10..160)))],
            seed,
        })
        .filter(|case| names.is_empty() || names.contains(&case.faults[0].0.name))
        .collect()
}

/// Pairs of different faults at random times of a grasp of 9 s.
#[must_use]
pub fn pairs(count: usize, seed: u64) -> Vec<Case> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    // A log that nobody reads is no second fault: it hides the first one's name.
    let faults: Vec<&'static Fault> = FAULTS.iter().filter(|f| !f.reported.is_empty()).collect();
    let when = |random: &mut Pcg64Mcg| When::At(random.random_range(0.15..9.15));
    (0..count)
        .map(|_| {
            let first = random.random_range(0..faults.len());
            let second = (first + random.random_range(1..faults.len())) % faults.len();
            Case {
                faults: vec![
                    (faults[first], when(&mut random)),
                    (faults[second], when(&mut random)),
                ],
                seed: seed + random.random_range(0..1000),
            }
        })
        .collect()
}

/// Flash of a finger that has recorded its friction and kept it, so that a run grasps at once.
///
/// # Errors
/// As [`end_of`].
pub fn prepared(firmware: &Firmware, settings: &Settings) -> Result<Vec<u8>, Error> {
    let settings = Settings {
        object: None,
        script: Script::parse("record-friction; save"),
        ..settings.clone()
    };
    Ok(end_of(firmware, settings)?.machine.flash().to_vec())
}

/// Runs cases on all cores; `told` hears of each as it ends, in any order.
///
/// # Errors
/// The first that a run ended with.
pub fn run(
    firmware: &Firmware,
    settings: &Settings,
    cases: &[Case],
    told: impl Fn(&Case, &Aftermath) + Sync,
) -> Result<Vec<Aftermath>, Error> {
    let flash = prepared(firmware, settings)?;
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Result<Aftermath, Error>>>> =
        Mutex::new(cases.iter().map(|_| None).collect());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers.min(cases.len()) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else {
                        break;
                    };
                    let result = follow(firmware, settings, &flash, case);
                    if let Ok(aftermath) = &result {
                        told(case, aftermath);
                    }
                    if let Ok(mut results) = results.lock() {
                        results[index] = Some(result);
                    }
                }
            });
        }
    });
    let results = results.into_inner().unwrap_or_default();
    results.into_iter().flatten().collect()
}

/// The stated time counts for this fault in this phase.
fn seen_at_once(fault: &Fault, phase: &str) -> bool {
    let moving = ["record-closing", "record-opening", "close", "open"].contains(&phase);
    match fault.name {
        "sense-offset" => phase == "calibrate-offset",
        // Its time is that of the way to where the stop was.
        "missing-stop" => false,
        name if name.starts_with("encoder") => moving,
        "stalled-rotor" | "adc-stuck-zero" | "adc-stuck-last" => moving,
        _ => !fault.reported.is_empty(),
    }
}

/// Longest grasp.
const GRASP: Ticks = 45_000 * TICKS_PER_MS;

/// One case.
///
/// # Errors
/// The engine fails, or the firmware misuses the chip.
fn follow(
    firmware: &Firmware,
    settings: &Settings,
    flash: &[u8],
    case: &Case,
) -> Result<Aftermath, Error> {
    let mut settings = settings.clone();
    settings.seed = case.seed;
    settings.script = Script::parse("run");
    let records = case
        .faults
        .iter()
        .any(|(_, when)| matches!(when, When::Phase(phase, _) if phase.starts_with("record")));
    if !records {
        settings.setup.flash = Some(flash.to_vec());
    }
    let mut session = Session::start(firmware, settings, None)?;
    let kept = stored(&session);
    let mut aftermath = Aftermath::default();
    let end = session.machine.now() + GRASP;
    let mut pending = case.faults.clone();
    let mut injected: Vec<(&Fault, Ticks)> = Vec::new();
    let (mut phase, mut since) = (String::new(), 0);
    let mut told_at: Option<Ticks> = None;
    while session.machine.now() < end
        && told_at.is_none_or(|told_at| session.machine.now() < told_at + WATCH)
        && !(session.completed() && pending.is_empty())
    {
        session.millisecond()?;
        let now = session.machine.now();
        if session.state != phase {
            phase.clone_from(&session.state);
            since = now;
        }
        let due = |when: &When| match *when {
            When::Phase(wanted, ms) => {
                phase == wanted && now >= since + Ticks::from(ms) * TICKS_PER_MS
            }
            When::At(s) => now >= time::ticks(s),
        };
        while let Some(index) = pending.iter().position(|(_, when)| due(when)) {
            let (fault, _) = pending.remove(index);
            if injected.is_empty() {
                aftermath.phase.clone_from(&phase);
            }
            session.inject(fault)?;
            injected.push((fault, session.machine.now()));
        }
        if told_at.is_none() && !session.faults.is_empty() {
            told_at = Some(session.machine.now());
        }
    }
    if injected.is_empty() {
        aftermath.failures.push("no fault was injected".to_owned());
    }
    judge(&session, &injected, &mut aftermath);
    if stored(&session) != kept {
        aftermath.failures.push("stored records changed".to_owned());
    }
    recover(&mut session, &mut aftermath)?;
    session.finish()?;
    if !aftermath.failures.is_empty() {
        let said = session.lines.iter();
        aftermath.log = said.map(ToString::to_string).collect();
    }
    aftermath.instructions = control(&session, &mut aftermath.failures).max.instructions;
    Ok(aftermath)
}

/// Name, bridge and time.
fn judge(session: &Session<'_>, injected: &[(&Fault, Ticks)], aftermath: &mut Aftermath) {
    aftermath.reported = names(&session.faults);
    let world = session.machine.world();
    let Some(name) = aftermath.reported.first() else {
        let unseen = |(fault, _): &(&Fault, Ticks)| !seen_at_once(fault, &aftermath.phase);
        if !injected.iter().all(unseen) {
            aftermath.failures.push("no fault was reported".to_owned());
        }
        return;
    };
    let cause = injected
        .iter()
        .find(|(fault, _)| fault.reported.contains(&name.as_str()));
    if cause.is_none() {
        aftermath.failures.push(format!("reported as {name}"));
    }
    if world.bridge_on() {
        aftermath
            .failures
            .push("the bridge was on half a second later".to_owned());
    }
    let Some((fault, at)) = cause.or(injected.first()) else {
        return;
    };
    aftermath.off_us = world
        .bridge_off_since()
        .map(|off| off.saturating_sub(*at) as f64 / TICKS_PER_US as f64);
    aftermath.timed = injected.len() == 1 && seen_at_once(fault, &aftermath.phase);
    if let Some(us) = aftermath.off_us
        && aftermath.timed
        && us > fault.limit_us
    {
        aftermath.failures.push(format!("off after {us:.0} us"));
    }
}

/// What was broken is mended, the fault cleared, and the finger asked to grasp.
fn recover(session: &mut Session<'_>, aftermath: &mut Aftermath) -> Result<(), Error> {
    if let Some(plant) = session.machine.plant_mut() {
        plant.faults = palpate_plant::Faults::default();
    }
    session.machine.rewire(|wires| *wires = Wires::default());
    session.machine.set_reader(Reader::Attached);
    let wait = |session: &mut Session<'_>, ms: u64| -> Result<bool, Error> {
        let mut moved = false;
        for _ in 0..ms {
            session.millisecond()?;
            moved |= session.machine.world().bridge_on();
        }
        Ok(moved)
    };
    if !session.faults.is_empty() {
        session.interrupt("run");
        if wait(session, 200)? {
            aftermath.failures.push("moved before clear".to_owned());
        }
        session.interrupt("clear");
        wait(session, 300)?;
    }
    // A motion that nothing disturbed, or that a reset ended without a word.
    session.interrupt("stop");
    wait(session, 300)?;
    session.abandon();
    for _ in 0..2 {
        let (faults, lines) = (session.faults.len(), session.lines.len());
        aftermath.grasps += 1;
        session.enter(Step::Command("run".to_owned()));
        let end = session.machine.now() + GRASP;
        session.millisecond()?;
        while !session.completed() && session.machine.now() < end {
            session.millisecond()?;
        }
        if let Some((_, name)) = session.faults.get(faults) {
            aftermath
                .failures
                .push(format!("the next grasp ended in {name}"));
            return Ok(());
        }
        let told = |name: &str| {
            let mut lines = session.lines[lines..].iter();
            lines.any(|line| line.event().name == name)
        };
        if ["located", "ambiguous", "not-located", "unusual"]
            .into_iter()
            .any(told)
        {
            return Ok(());
        }
    }
    aftermath
        .failures
        .push("the grasps after it felt nothing".to_owned());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_has_every_cell_and_pairs_are_of_two() {
        assert_eq!(matrix(1, &[]).len(), FAULTS.len() * PHASES.len());
        let names = |seed| pairs(50, seed).iter().map(Case::name).collect::<Vec<_>>();
        assert_eq!(names(3), names(3));
        assert_ne!(names(3), names(4));
        for case in pairs(500, 1) {
            assert_ne!(case.faults[0].0.name, case.faults[1].0.name);
        }
    }
}
