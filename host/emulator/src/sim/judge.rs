// SPDX-License-Identifier: GPL-2.0-only
//! Injects a fault into a run and judges the chip's reaction.

use super::fault::{Fault, Injected, Injection, MOVING_S};
use super::session::{Session, Settings};
use crate::cortex::account::Calls;
use crate::rtt::Reader;
use crate::time::{self, TICKS_PER_MS, TICKS_PER_US, Ticks};
use crate::{Error, Firmware};
use palpate::app::storage::store::{PAGE, PAGES};

impl Session<'_> {
    /// Lets the fault happen now.
    ///
    /// # Errors
    /// The engine fails.
    pub fn inject(&mut self, fault: &Fault) -> Result<(), Error> {
        match fault.injection {
            Injection::Plant(change) => {
                if let Some(plant) = self.machine.plant_mut() {
                    change(&mut plant.faults);
                }
            }
            Injection::Wiring(change) => {
                let volts = self
                    .machine
                    .plant()
                    .map_or(0.0, palpate_plant::Plant::current_sense_v);
                self.machine.rewire(|wires| change(wires, volts));
            }
            Injection::Command(line) => self.machine.command(&format!("{line}\n")),
            Injection::Reset(cause) => {
                self.machine.reset(cause)?;
                self.resets.push((self.machine.time_s(), cause));
            }
            Injection::Reader(reader, _) => self.machine.set_reader(reader),
        }
        Ok(())
    }
}

/// What came of an injected fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// From the injection until the bridge was off for good; `None` if it never was, or had no need to be.
    pub off_us: Option<f64>,
    /// Names of the faults reported.
    pub reported: Vec<String>,
    /// The control interrupt's calls in this run.
    pub control: Calls,
    /// Why it failed; empty if it did not.
    pub failures: Vec<String>,
}

/// Exception number of ADC1_2.
const CONTROL: u16 = 16 + 18;
/// Most instructions that one control interrupt may execute.
pub const CONTROL_INSTRUCTIONS: u64 = 600;

/// How long nothing may move after a fault has been reported.
pub(super) const WATCH: Ticks = 500 * TICKS_PER_MS;

/// Injects one fault into a run and judges what the chip does. No fault: the run has to end well.
///
/// # Errors
/// As [`Session::start`] and [`Session::millisecond`].
pub fn judge(
    firmware: &Firmware,
    settings: Settings,
    injected: Option<Injected>,
) -> Result<Judgement, Error> {
    let mut session = Session::start(firmware, settings, None)?;
    let stored = stored(&session);
    let Some(Injected { fault, at_s }) = injected else {
        return undisturbed(session, None);
    };
    let at = time::ticks(at_s);
    while session.machine.now() < at && session.faults.is_empty() && !session.timed_out() {
        session.millisecond()?;
    }
    let before = session.faults.len();
    let was_on = session.machine.world().bridge_on();
    session.inject(fault)?;
    let injected_at = session.machine.now();
    if let Injection::Reader(_, lasting_s) = fault.injection {
        return undisturbed(session, Some(lasting_s));
    }
    let patience = injected_at + time::ticks(1e-6 * fault.limit_us) + 2000 * TICKS_PER_MS;
    while session.faults.len() == before && session.machine.now() < patience {
        session.millisecond()?;
    }
    let reported_at = session.machine.now();
    while session.machine.now() < reported_at + WATCH {
        session.millisecond()?;
    }
    session.finish()?;
    let mut failures = Vec::new();
    let world = session.machine.world();
    let off = world
        .bridge_off_since()
        .filter(|&off| off >= injected_at && !world.bridge_on());
    let off_us = off.map(|off| (off - injected_at) as f64 / TICKS_PER_US as f64);
    match off_us {
        None => failures.push("the bridge was not switched off for good".to_owned()),
        Some(us) if us > fault.limit_us => failures.push(format!("off after {us:.0} us")),
        Some(_) => {}
    }
    if !was_on && at_s >= MOVING_S {
        failures.push("the motor was not driven when the fault came".to_owned());
    }
    let reported = names(&session.faults[before..]);
    match reported.first() {
        None => failures.push("no fault was reported".to_owned()),
        Some(name) if !fault.reported.contains(&name.as_str()) => {
            failures.push(format!("reported as {name}"))
        }
        Some(_) => {}
    }
    if self::stored(&session) != stored {
        failures.push("stored records changed".to_owned());
    }
    Ok(Judgement {
        off_us,
        reported,
        control: control(&session, &mut failures),
        failures,
    })
}

/// The control interrupt, ADC1_2, which has to keep to its budget whatever happens.
pub(super) fn control(session: &Session<'_>, failures: &mut Vec<String>) -> Calls {
    let exceptions = session.machine.account().exceptions();
    let calls = exceptions.get(&CONTROL).copied().unwrap_or_default();
    if calls.max.instructions > CONTROL_INSTRUCTIONS {
        let executed = calls.max.instructions;
        failures.push(format!(
            "the control interrupt executed {executed} instructions"
        ));
    }
    calls
}

/// Names of reported faults, in their order.
pub(super) fn names(faults: &[(u32, String)]) -> Vec<String> {
    faults.iter().map(|(_, name)| name.clone()).collect()
}

/// The pages that hold records: the last ones.
pub(super) fn stored(session: &Session<'_>) -> Vec<u8> {
    let flash = session.machine.flash();
    flash[flash.len() - PAGES * PAGE..].to_vec()
}

/// The run must end as if nothing had happened.
fn undisturbed(mut session: Session<'_>, lasting_s: Option<f64>) -> Result<Judgement, Error> {
    let back = lasting_s.map(|seconds| session.machine.time_s() + seconds);
    while !session.over() {
        session.millisecond()?;
        if back.is_some_and(|back| session.machine.time_s() >= back) {
            session.machine.set_reader(Reader::Attached);
        }
    }
    session.finish()?;
    let reported = names(&session.faults);
    let mut failures = Vec::new();
    if !reported.is_empty() {
        failures.push(format!("reported {}", reported.join(", ")));
    }
    if !session.resets.is_empty() {
        failures.push(format!("reset {} times", session.resets.len()));
    }
    let missed = session.machine.chip().missed_triggers();
    if missed > 0 {
        failures.push(format!("{missed} control periods were late"));
    }
    if lasting_s.is_none() && !session.completed() {
        failures.push("the motion did not end".to_owned());
    }
    // With half of the log lost, the motor tells that the run went on: after the grasp it rests.
    let touched = session
        .machine
        .plant()
        .is_some_and(|plant| plant.truth().first_contact.is_some());
    if lasting_s.is_some() && !session.completed() && !touched {
        failures.push("the finger did not go on to the object".to_owned());
    }
    Ok(Judgement {
        off_us: None,
        reported,
        control: control(&session, &mut failures),
        failures,
    })
}
