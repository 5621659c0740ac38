// SPDX-License-Identifier: GPL-2.0-only
//! A run from power-on to the end of the script, with the whole log of the firmware.

mod ending;
mod placing;

use palpate::app::console::settings::Overrides;
use palpate_plant::{Grasp, Parameters, Truth};

use super::grasp::Object;
use super::in_force;
use super::script::{Script, Step};
use super::trace::Trace;
use placing::Closing;

use crate::log::Line;
use crate::machine::{Machine, Pause, Setup};
use crate::time::{TICKS_PER_MS, Ticks};
use crate::{Error, Firmware, ResetCause};

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The finger in its world.
    pub parameters: Parameters,
    /// What the finger meets; nothing on a free closing.
    pub object: Option<Object>,
    /// What the user does.
    pub script: Script,
    /// Of the plant's noise.
    pub seed: u64,
    /// Simulated seconds after which a run is given up.
    pub max_s: f64,
    /// The chip's.
    pub setup: Setup,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            parameters: Parameters::default(),
            object: None,
            script: Script::button(),
            seed: 1,
            max_s: 120.0,
            setup: Setup::default(),
        }
    }
}

/// When the user begins after boot: the firmware has set itself up by then.
const FIRST_STEP: Ticks = 100 * TICKS_PER_MS;
/// How long the button is held.
const PRESS: Ticks = 100 * TICKS_PER_MS;
/// Pause before a step, and the silence that ends an answer.
const PAUSE: Ticks = 50 * TICKS_PER_MS;
/// Longest wait for an answer.
const ANSWER: Ticks = 3000 * TICKS_PER_MS;
/// The same where the self-test or the identification moves the motor first.
const TEST: Ticks = 20_000 * TICKS_PER_MS;

/// What answers to commands that are not carried out begin with.
const REFUSALS: [&str; 2] = ["refused:", "error:"];

/// Where the user is in the script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// The next step comes at this time.
    Next(Ticks),
    /// A motion was asked for; until its first answer it may still be refused.
    Moving { answered: bool },
    /// A command that moves nothing was typed: its answer is awaited until then.
    Answering(Ticks),
    /// Every step is done.
    Done,
}

/// A run under way.
pub struct Session<'f> {
    /// The chip in its world.
    pub machine: Machine<'f>,
    settings: Settings,
    next: usize,
    progress: Progress,
    release: Option<Ticks>,
    placed: bool,
    closing: Closing,
    /// Every log line so far.
    pub lines: Vec<Line>,
    /// What the simulation itself has to say.
    pub notes: Vec<String>,
    /// Resets so far, with their time in seconds.
    pub resets: Vec<(f64, ResetCause)>,
    /// The last `state` reported, empty before the first.
    pub state: String,
    /// Faults reported so far, by number and name.
    pub faults: Vec<(u32, String)>,
    /// How many of them were reported before the user last typed `clear`.
    cleared: usize,
    /// What is set in the firmware.
    in_force: Overrides,
    /// The same when the firmware last told of a calibration.
    pub calibrated_with: Overrides,
    /// Steps that the firmware has not carried out, each with its answer.
    pub refused: Vec<(Step, String)>,
    /// The true state when the last estimate was fetched.
    pub truth_at_estimate: Option<Truth>,
    trace: Option<Trace>,
    /// A debugger has held the core since the last look: after a step, or else at a breakpoint.
    pub(crate) held: Option<bool>,
}

impl<'f> Session<'f> {
    /// Switches the chip on.
    ///
    /// # Errors
    /// The plant refuses its parameters or the object, or the machine cannot be set up.
    pub fn start(
        firmware: &'f Firmware,
        settings: Settings,
        trace: Option<Trace>,
    ) -> Result<Self, Error> {
        let mut plant = palpate_mujoco::plant(&settings.parameters, &Grasp::Free, settings.seed)?;
        if let Some(object) = settings.object {
            // An impossible object is better refused now than in the middle of the run.
            plant.place(&object.grasp())?;
            plant.place(&Grasp::Free)?;
        }
        let machine = Machine::new(firmware, Some(plant), &settings.setup)?;
        Ok(Self {
            machine,
            settings,
            next: 0,
            progress: Progress::Next(FIRST_STEP),
            release: None,
            placed: false,
            closing: Closing::Grasp,
            lines: Vec::new(),
            notes: Vec::new(),
            resets: Vec::new(),
            state: String::new(),
            faults: Vec::new(),
            cleared: 0,
            in_force: Overrides::default(),
            calibrated_with: Overrides::default(),
            refused: Vec::new(),
            truth_at_estimate: None,
            trace,
            held: None,
        })
    }

    /// The user does one thing more, after what is still to be done.
    pub fn enter(&mut self, step: Step) {
        self.settings.script.0.push(step);
        if self.progress == Progress::Done {
            self.progress = Progress::Next(self.machine.now());
        }
    }

    /// The user waits for no motion any more.
    pub fn abandon(&mut self) {
        self.progress = Progress::Done;
        self.next = self.settings.script.0.len();
    }

    /// Types a line at once, whatever is going on.
    pub fn interrupt(&mut self, line: &str) {
        self.machine.command(&format!("{line}\n"));
    }

    /// Types `stop` at once.
    pub fn stop(&mut self) {
        self.interrupt("stop");
        // A command that had not begun is dropped without a word of its own: the answer is the end of either. Where nothing moves it is
        // still waited for, or it would be taken for that of the next line.
        self.progress = Progress::Answering(self.machine.now() + ANSWER);
    }

    fn moving(&self) -> bool {
        matches!(self.progress, Progress::Moving { .. })
    }

    /// One millisecond of simulated time, or up to where a debugger holds the core. New log lines are in `lines`.
    ///
    /// # Errors
    /// The firmware misuses the chip, the object cannot be placed, or the trace cannot be written.
    pub fn millisecond(&mut self) -> Result<(), Error> {
        let end = self.machine.now() / TICKS_PER_MS * TICKS_PER_MS + TICKS_PER_MS;
        while self.machine.now() < end {
            match self.machine.run_until(end)? {
                Pause::Time => {}
                Pause::Reset(cause) => self.resets.push((self.machine.time_s(), cause)),
                Pause::PowerLost | Pause::Exit(_) => break,
                Pause::Held { stepping } => {
                    self.held = Some(stepping);
                    return Ok(());
                }
            }
        }
        for line in self.machine.take_lines() {
            self.hear(&line)?;
            self.lines.push(line);
        }
        self.act();
        if let (Some(trace), Some(plant)) = (&mut self.trace, self.machine.plant()) {
            trace
                .row(self.machine.time_s(), plant)
                .map_err(Error::Trace)?;
        }
        Ok(())
    }

    fn hear(&mut self, line: &Line) -> Result<(), Error> {
        let event = line.event();
        // Other lines may come before an answer.
        if let Some(answer) = line.message.strip_prefix("answer ") {
            let refused = REFUSALS.iter().any(|word| answer.starts_with(word));
            // Later answers, and those between two steps, are to what others typed.
            let own = matches!(
                self.progress,
                Progress::Answering(_) | Progress::Moving { answered: false }
            );
            if let Some(step) = self.typed().filter(|_| refused && own) {
                self.refused.push((step.clone(), answer.to_owned()));
            }
            match &mut self.progress {
                Progress::Answering(_) => {
                    self.progress = Progress::Answering(self.machine.now() + PAUSE);
                    self.note_setting(answer);
                }
                // Nothing will move, and nothing will say `sequence done`.
                Progress::Moving { answered: false } if refused => {
                    self.progress = Progress::Next(self.machine.now() + PAUSE);
                }
                Progress::Moving { answered } => *answered = true,
                Progress::Next(_) | Progress::Done => {}
            }
        }
        match event.name {
            "record" => {
                self.in_force = match event.field("state") {
                    Some("loaded" | "older") => {
                        in_force::kept(self.machine.flash(), &self.settings.parameters.scene)
                    }
                    _ => Overrides::default(),
                }
            }
            "calibrated" => self.calibrated_with = self.in_force,
            // Count a calibration that taught nothing as refused, though its motion was carried out.
            "calibration-refused" if self.moving() => {
                if let Some(step) = self.typed() {
                    self.refused.push((step.clone(), line.message.clone()));
                }
            }
            // Told right before the closing begins.
            "calibrating" => {
                let pin_m = event.number("pin_m");
                self.closing = pin_m.map_or(Closing::Press, |k_m| Closing::Pin { k_m });
            }
            "state" => {
                event
                    .field("name")
                    .unwrap_or_default()
                    .clone_into(&mut self.state);
                match self.state.as_str() {
                    // The finger is at its opening stop and about to close: now the object is put there.
                    "close" => {
                        let closing = std::mem::replace(&mut self.closing, Closing::Grasp);
                        self.place(closing)?;
                    }
                    // Whoever records friction takes the object away.
                    "record-closing" => {
                        if let Some(plant) = self.machine.plant_mut() {
                            plant.place(&Grasp::Free)?;
                        }
                        self.placed = false;
                    }
                    "idle" => self.placed = false,
                    _ => {}
                }
            }
            "sequence done" if self.moving() => {
                self.progress = Progress::Next(self.machine.now() + PAUSE);
            }
            "fault" => {
                // The motion has ended, without a word of its own.
                if self.moving() {
                    self.progress = Progress::Next(self.machine.now() + PAUSE);
                }
                let number = event.number("number").map_or(0, |n| n as u32);
                self.faults
                    .push((number, event.field("name").unwrap_or_default().to_owned()));
            }
            "located" | "ambiguous" | "not-located" => {
                self.truth_at_estimate = self.machine.plant().map(palpate_plant::Plant::truth);
            }
            _ => {}
        }
        Ok(())
    }

    /// The last step of the script that the user has come to.
    fn typed(&self) -> Option<&Step> {
        self.next.checked_sub(1).map(|n| &self.settings.script.0[n])
    }

    /// Takes note of a setting that the firmware has accepted.
    fn note_setting(&mut self, answer: &str) {
        if let Some((setting, value_si)) = self.typed().and_then(Step::sets)
            && answer.starts_with("ok;")
        {
            // In its range, or the line would not have been read as one that sets it.
            let _ = self.in_force.set(setting, value_si);
        } else if answer.starts_with("forgotten") {
            self.in_force = Overrides::default();
        }
    }

    /// What the user does now.
    fn act(&mut self) {
        let now = self.machine.now();
        if self.release.is_some_and(|at| at <= now) {
            self.release = None;
            self.machine.button(false);
        }
        match self.progress {
            Progress::Next(at) | Progress::Answering(at) if now >= at => {}
            _ => return,
        }
        let Some(step) = self.settings.script.0.get(self.next) else {
            self.progress = Progress::Done;
            return;
        };
        self.next += 1;
        if step.clears() {
            self.cleared = self.faults.len();
        }
        self.progress = match step {
            Step::Button => Progress::Moving { answered: true },
            _ if step.moves() => Progress::Moving { answered: false },
            Step::Command(line) if line == "selftest" || line == "identify" => {
                Progress::Answering(now + TEST)
            }
            _ => Progress::Answering(now + ANSWER),
        };
        match step {
            Step::Button => {
                self.machine.button(true);
                self.release = Some(now + PRESS);
            }
            Step::Command(line) => self.machine.command(&format!("{line}\n")),
        }
    }

    /// Ends the run: what is left of the log, and the trace.
    ///
    /// # Errors
    /// The trace cannot be written.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.machine.finish();
        for line in self.machine.take_lines() {
            self.hear(&line)?;
            self.lines.push(line);
        }
        self.trace
            .take()
            .map_or(Ok(()), Trace::finish)
            .map_err(Error::Trace)
    }
}

/// Runs to the end; the session holds what was said.
///
/// # Errors
/// As [`Session::start`] and [`Session::millisecond`].
pub fn end_of(firmware: &Firmware, settings: Settings) -> Result<Session<'_>, Error> {
    let mut session = Session::start(firmware, settings, None)?;
    while !session.over() {
        session.millisecond()?;
    }
    session.finish()?;
    Ok(session)
}
