// SPDX-License-Identifier: GPL-2.0-only
//! One case: the faults come, and what the finger can do after they were cleared.
//!
//! Whatever happens: the first fault named is the first cause, the bridge is then off and stays off until `clear` whoever asks for
//! a motion, no stored record changes, and the grasp after `clear` works. A fault that the phase lets nobody see (an encoder's
//! broken wire while the motor stands) may be found later or not at all; the stated time counts where it can be seen at once, and
//! where no second fault comes before that time is over.

use super::{Case, When};
use crate::rtt::Reader;
use crate::sim::fault::Fault;
use crate::sim::judge::{WATCH, control, names, stored};
use crate::sim::script::{Script, Step};
use crate::sim::session::{Session, Settings};
use crate::time::{self, TICKS_PER_MS, TICKS_PER_US, Ticks};
use crate::world::WiringFaults;
use crate::{Error, Firmware};

/// Longest grasp.
const GRASP: Ticks = 45_000 * TICKS_PER_MS;
/// Deviations by which a place after the fault may be off, and millimetres besides: nothing is calibrated.
const DEVIATIONS: f64 = 4.0;
const SLACK_MM: f64 = 1.0;

/// How far a finger may be pressed into its stop, radian.
const AT_STOP_RAD: f64 = 0.02;

/// What came of a case.
#[derive(Clone, Debug, Default)]
pub struct Aftermath {
    /// Phase in which the first fault came.
    pub phase: String,
    /// Faults reported, the first cause first.
    pub reported: Vec<String>,
    /// From the injection of the one that was reported first until the bridge was off.
    pub off_us: Option<f64>,
    /// The stated time applies: the first fault is one that its phase lets be seen at once, and it came alone.
    pub timed: bool,
    /// Grasps it took after `clear` until one went through: a second one where friction had to be recorded anew, none where the
    /// finger had left its stops.
    pub grasps: u32,
    /// By how much the place that the grasp after it told was off, and the deviation told with it, millimetre.
    pub place_mm: Option<(f64, f64)>,
    /// Most instructions of a control interrupt.
    pub instructions: u64,
    /// What the injected faults may be reported as.
    expected: Vec<&'static str>,
    /// Why it failed; empty if it did not.
    pub failures: Vec<String>,
    /// What the firmware said, of a run that failed.
    pub log: Vec<String>,
}

/// A fault that has happened.
struct Injection<'c> {
    fault: &'static Fault,
    at: Ticks,
    phase: &'c str,
}

impl Injection<'_> {
    /// The stated time counts for this fault in this phase.
    fn is_seen_at_once(&self) -> bool {
        let moving = ["record-closing", "record-opening", "close", "open"].contains(&self.phase);
        match self.fault.name {
            "sense-offset" => self.phase == "calibrate-offset",
            // Its time is that of the way to where the stop was.
            "missing-stop" => false,
            name if name.starts_with("encoder") => moving,
            "stalled-rotor" | "adc-stuck-zero" | "adc-stuck-last" => moving,
            // At rest the bridge is off, and most faults cannot show.
            _ => !self.fault.reported.is_empty() && !self.phase.is_empty(),
        }
    }

    /// When the bridge must be off.
    fn deadline(&self) -> Ticks {
        self.at + time::ticks(1e-6 * self.fault.limit_us)
    }
}

impl Aftermath {
    fn fail(&mut self, why: impl Into<String>) {
        self.failures.push(why.into());
    }

    /// Runs the case and judges it.
    ///
    /// # Errors
    /// The engine fails, or the firmware misuses the chip.
    pub(super) fn follow(
        &mut self,
        firmware: &Firmware,
        settings: &Settings,
        flash: &[u8],
        case: &Case,
    ) -> Result<(), Error> {
        let mut settings = settings.clone();
        settings.seed = case.seed;
        settings.script = Script::parse("run");
        if !case.records() {
            settings.setup.flash = Some(flash.to_vec());
        }
        let mut session = Session::start(firmware, settings, None)?;
        let kept = stored(&session);
        self.disturb(&mut session, case)?;
        if stored(&session) != kept {
            self.fail("stored records changed");
        }
        let is_beyond = is_beyond_stops(&session);
        self.recover(&mut session)?;
        // Who puts a stop back puts the finger back first; here it would be caught behind it.
        if !is_beyond {
            self.grasp_again(&mut session)?;
        }
        self.start_again(&mut session, case, &kept)?;
        session.finish()?;
        if !self.failures.is_empty() {
            self.log = session.lines.iter().map(ToString::to_string).collect();
        }
        self.instructions = control(&session, &mut self.failures).max.instructions;
        Ok(())
    }

    /// A grasp into which the faults come, until half a second after the first was reported.
    fn disturb(&mut self, session: &mut Session<'_>, case: &Case) -> Result<(), Error> {
        let end = session.machine.now() + GRASP;
        let mut pending = case.faults.clone();
        let mut injected = Vec::new();
        let (mut phase, mut since) = ("", 0);
        let mut told_at: Option<Ticks> = None;
        let mut on_again = false;
        // Go on for this long after the last injection: the firmware may report it, and the finger comes to rest.
        let mut watched = 0;
        while session.machine.now() < end
            && told_at.is_none_or(|told_at| session.machine.now() < told_at + WATCH)
            && !(session.completed() && pending.is_empty() && session.machine.now() >= watched)
        {
            session.millisecond()?;
            let now = session.machine.now();
            if session.state != phase {
                let known = super::PHASES.iter().find(|name| **name == session.state);
                (phase, since) = (known.copied().unwrap_or_default(), now);
            }
            let due = |when: &When| match *when {
                When::Phase(wanted, ms) => {
                    phase == wanted && now >= since + Ticks::from(ms) * TICKS_PER_MS
                }
                When::At(s) => now >= time::ticks(s),
            };
            while let Some(index) = pending.iter().position(|(_, when)| due(when)) {
                let (fault, _) = pending.remove(index);
                session.inject(fault)?;
                let at = session.machine.now();
                injected.push(Injection { fault, at, phase });
                watched = at + WATCH;
            }
            on_again |= told_at.is_some() && session.machine.world().bridge_on();
            if told_at.is_none() && !session.faults.is_empty() {
                told_at = Some(now);
            }
        }
        if on_again {
            self.fail("the bridge was on after the fault was told");
        }
        self.judge(session, &injected);
        Ok(())
    }

    /// Name, bridge and time.
    fn judge(&mut self, session: &Session<'_>, injected: &[Injection<'_>]) {
        self.reported = names(&session.faults);
        let injected_names = injected.iter().flat_map(|one| one.fault.reported);
        self.expected = injected_names.copied().collect();
        let world = session.machine.world();
        let Some(first) = injected.first() else {
            self.fail("no fault was injected");
            return;
        };
        first.phase.clone_into(&mut self.phase);
        // A second fault that comes before the first one's time is over may hide it.
        let alone = (injected.get(1)).is_none_or(|second| second.at > first.deadline());
        self.timed = alone && first.is_seen_at_once();
        let Some(name) = self.reported.first() else {
            if injected.iter().any(Injection::is_seen_at_once) {
                self.fail("no fault was reported");
            }
            return;
        };
        let suspects = if self.timed { &injected[..1] } else { injected };
        let cause = suspects
            .iter()
            .find(|one| one.fault.reported.contains(&name.as_str()));
        self.off_us = world
            .bridge_off_since()
            .map(|off| off.saturating_sub(cause.unwrap_or(first).at))
            .map(|ticks| ticks as f64 / TICKS_PER_US as f64);
        if cause.is_none() {
            let name = name.clone();
            self.fail(format!("reported as {name}"));
        }
        if world.bridge_on() {
            self.fail("the bridge was on half a second later");
        }
        if let Some(us) = self.off_us
            && self.timed
            && us > first.fault.limit_us
        {
            self.fail(format!("off after {us:.0} us"));
        }
    }

    /// What was broken is mended and the fault cleared.
    fn recover(&mut self, session: &mut Session<'_>) -> Result<(), Error> {
        if let Some(plant) = session.machine.plant_mut() {
            plant.faults = palpate_plant::Faults::default();
        }
        session
            .machine
            .rewire(|wires| *wires = WiringFaults::default());
        session.machine.set_reader(Reader::Attached);
        if !session.faults.is_empty() {
            let counts = |session: &Session<'_>| {
                let plant = session.machine.plant();
                plant.map(palpate_plant::Plant::encoder_count)
            };
            let before = counts(session);
            let mut on = false;
            for command in ["run", "home", "open"] {
                session.interrupt(command);
                on |= wait(session, 60)?;
            }
            // Either clears the fault, and neither moves anything: half of the runs take the button.
            if before.is_some_and(|count| count % 2 == 0) {
                session.machine.button(true);
                on |= wait(session, 100)?;
                session.machine.button(false);
            } else {
                session.interrupt("clear");
            }
            on |= wait(session, 300)?;
            if on || counts(session) != before {
                self.fail("moved while the fault stood, or by clearing it");
            }
        }
        // A motion that nothing disturbed, or that a reset ended without a word.
        session.interrupt("stop");
        wait(session, 300)?;
        session.abandon();
        Ok(())
    }

    /// The finger grasps as before.
    fn grasp_again(&mut self, session: &mut Session<'_>) -> Result<(), Error> {
        let mut tries = 2;
        while tries > 0 {
            tries -= 1;
            let (faults, lines) = (session.faults.len(), session.lines.len());
            self.grasps += 1;
            session.enter(Step::Command("run".to_owned()));
            let end = session.machine.now() + GRASP;
            session.millisecond()?;
            while !session.completed() && session.machine.now() < end {
                session.millisecond()?;
            }
            if let Some((_, name)) = session.faults.get(faults) {
                // Noise at rest is reported when the next motion starts, because counts may be lost.
                if self.reported.is_empty() && self.expected.contains(&name.as_str()) {
                    self.reported.push(name.clone());
                    session.interrupt("clear");
                    wait(session, 300)?;
                    session.abandon();
                    tries = 2;
                    continue;
                }
                self.fail(format!("the next grasp ended in {name}"));
                return Ok(());
            }
            if self.felt(session, lines) {
                return Ok(());
            }
        }
        self.fail("the grasps after it felt nothing");
        Ok(())
    }

    /// The firmware told of the object in the lines from this one on; of a place it must be right.
    fn felt(&mut self, session: &Session<'_>, from: usize) -> bool {
        let events: Vec<_> = session.lines[from..]
            .iter()
            .map(|line| line.event())
            .collect();
        let truth = session.truth_at_estimate.as_ref();
        let contact = truth.and_then(|truth| truth.first_contact);
        if let Some(located) = events.iter().rfind(|event| event.name == "located")
            && let Some(contact) = contact.map(|first| first.contact)
            && let (Some(k_mm), Some(sigma_mm)) =
                (located.number("k_mm"), located.number("sigma_mm"))
        {
            let off_mm = (k_mm - 1e3 * contact.k_m).abs();
            self.place_mm = Some((off_mm, sigma_mm));
            if located.number("phalanx") != Some(f64::from(contact.phalanx)) {
                self.fail("the next grasp told the wrong phalanx");
            } else if off_mm > DEVIATIONS * sigma_mm + SLACK_MM {
                self.fail(format!("the next place was off by {off_mm:.1} mm"));
            }
        }
        let told = ["located", "ambiguous", "not-located", "unusual"];
        events.iter().any(|event| told.contains(&event.name))
    }

    /// What is kept is still there, and is what the firmware starts with.
    fn start_again(
        &mut self,
        session: &mut Session<'_>,
        case: &Case,
        kept: &[u8],
    ) -> Result<(), Error> {
        if stored(session) != kept {
            self.fail("stored records changed with the next grasp");
        }
        let lines = session.lines.len();
        session.machine.power_cycle()?;
        wait(session, 200)?;
        let wanted = if case.records() { "none" } else { "loaded" };
        let mut events = session.lines[lines..].iter().map(|line| line.event());
        if !events.any(|event| event.name == "record" && event.field("state") == Some(wanted)) {
            self.fail("the kept record was not loaded at the next start");
        }
        Ok(())
    }
}

/// Whether the finger stands where its stops would not let it.
fn is_beyond_stops(session: &Session<'_>) -> bool {
    let plant = session.machine.plant();
    plant.map(palpate_plant::Plant::truth).is_some_and(|truth| {
        let stops_rad = truth.opening_stop_rad - AT_STOP_RAD..truth.closing_stop_rad + AT_STOP_RAD;
        !stops_rad.contains(&truth.theta_a_rad)
    })
}

/// So many milliseconds; whether the bridge was on.
fn wait(session: &mut Session<'_>, ms: u64) -> Result<bool, Error> {
    let mut on = false;
    for _ in 0..ms {
        session.millisecond()?;
        on |= session.machine.world().bridge_on();
    }
    Ok(on)
}
