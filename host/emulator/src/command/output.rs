// SPDX-License-Identifier: GPL-2.0-only
//! Output of `sim`: the log, aligned and on a terminal in colour; JSON for programs; progress; the summary.

use std::fs::File;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anstyle::{AnsiColor, Style};
use palpate_cli::progress::{self, ProgressBar};
use palpate_emulator::Error;
use palpate_emulator::log::Line;
use palpate_emulator::sim::{Calibration, Session, Summary, event_json};
use palpate_plant::Parameters;
use serde_json::{Value, json};

/// What is typed before everything else where a page is wanted: samples and settings stand in it.
pub const FOR_THE_PAGE: [&str; 2] = ["trace on 2", "show"];
/// Cells of the drawn phalanx.
const CELLS: usize = 60;

/// Form of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Log and summary, for people.
    Text,
    /// The summary alone.
    Summary,
    /// One object a line.
    Json,
}

/// Output of a run.
pub struct Output {
    form: Form,
    /// An additional file for the JSON lines.
    events: Option<(PathBuf, BufWriter<File>)>,
    printed: usize,
    progress: ProgressBar,
}

impl Output {
    pub fn new(form: Form, events: Option<&Path>) -> Result<Self, Error> {
        let events = match events {
            Some(path) => {
                let file = File::create(path).map_err(|source| Error::Write {
                    path: path.to_owned(),
                    source,
                })?;
                Some((path.to_owned(), BufWriter::new(file)))
            }
            None => None,
        };
        Ok(Self {
            form,
            events,
            printed: 0,
            progress: progress::spinner(),
        })
    }

    /// Prints what is new.
    pub fn show(&mut self, session: &mut Session<'_>, start: Instant) -> Result<(), Error> {
        for line in &session.lines[self.printed..] {
            let judged = matches!(line.event().name, "located" | "ambiguous" | "not-located");
            let truth = judged.then(|| truth(session)).flatten();
            if self.form == Form::Json || self.events.is_some() {
                self.write(&event_json(line))?;
                if let Some(truth) = truth {
                    self.write(&truth)?;
                }
            }
            // What is asked for a page only is not for a reader; what the user's own commands are answered is.
            let for_the_page = self.events.is_some()
                && (line.event().name == "sample"
                    || session.entered() <= FOR_THE_PAGE.len()
                        && line.message.starts_with("answer"));
            if self.form == Form::Text && !for_the_page {
                self.progress
                    .suspend(|| anstream::println!("{}", coloured(line)));
            }
        }
        self.printed = session.lines.len();
        for note in session.machine.take_notes() {
            self.progress.suspend(|| eprintln!("chip: {note}"));
        }
        for note in session.notes.drain(..) {
            self.progress.suspend(|| eprintln!("sim: {note}"));
        }
        let emulated_s = session.machine.time_s();
        // Not every millisecond: writing the text takes longer than simulating a millisecond.
        if ((1e3 * emulated_s) as u64).is_multiple_of(100) {
            let faster = emulated_s / start.elapsed().as_secs_f64();
            let state = &session.state;
            self.progress.set_message(format!(
                "{emulated_s:.1} s simulated, {faster:.1} times real time, {state}"
            ));
        }
        Ok(())
    }

    /// Clears the progress from the terminal.
    pub fn end_progress(&self) {
        self.progress.finish_and_clear();
    }

    /// Prints the result.
    pub fn conclude(
        &mut self,
        summary: &Summary,
        calibration: Option<&Calibration>,
        world: &Parameters,
        wall_s: f64,
    ) -> Result<(), Error> {
        if let Some(calibration) = calibration {
            self.write(&calibration.json())?;
        }
        self.write(&summary.json(wall_s))?;
        if let Some((path, file)) = &mut self.events {
            file.flush().map_err(|source| Error::Write {
                path: path.clone(),
                source,
            })?;
        }
        if self.form == Form::Json {
            return Ok(());
        }
        if let Some(calibration) = calibration {
            print!("\n{}", calibration.text());
        }
        if std::io::stdout().is_terminal()
            && let Some(picture) = picture(summary, world)
        {
            anstream::print!("\n{picture}");
        }
        let gap = if self.form == Form::Text { "\n" } else { "" };
        print!("{gap}{}", summary.text(wall_s));
        Ok(())
    }

    /// Writes a JSON line, if requested.
    fn write(&mut self, object: &Value) -> Result<(), Error> {
        if self.form == Form::Json {
            println!("{object}");
        }
        if let Some((path, file)) = &mut self.events {
            writeln!(file, "{object}").map_err(|source| Error::Write {
                path: path.clone(),
                source,
            })?;
        }
        Ok(())
    }
}

/// The true contact.
fn truth(session: &Session<'_>) -> Option<Value> {
    let truth = session.machine.plant()?.truth();
    let contact = truth.first_contact.as_ref()?.contact;
    let force_n = truth.strongest().map_or(0.0, |contact| contact.force_n);
    Some(json!({
        "type": "truth",
        "phalanx": contact.phalanx,
        "k_mm": 1e3 * contact.k_m,
        "force_n": force_n,
    }))
}

/// The colour of a level.
fn style(level: &str) -> Style {
    match level {
        "warn" => AnsiColor::Yellow.on_default(),
        "error" => AnsiColor::Red.on_default().bold(),
        _ => Style::new(),
    }
}

/// A line with aligned columns; colours are removed if the output has none.
fn coloured(line: &Line) -> String {
    let (level, dim) = (style(&line.level), Style::new().dimmed());
    let name = if line.level.is_empty() {
        String::new()
    } else {
        format!("[{:<5}] ", line.level.to_uppercase())
    };
    // Without the place in the source: it is the same for every line.
    format!(
        "{dim}{:>12}{dim:#} {level}{name}{}{level:#}",
        line.timestamp, line.message
    )
}

/// The phalanx with estimate, band of two deviations and truth, seen from the palm side.
fn picture(summary: &Summary, world: &Parameters) -> Option<String> {
    let phalanx = summary.phalanx.or(summary.true_phalanx)?;
    let length_m = *world
        .finger
        .length_m
        .get(usize::try_from(phalanx).ok()?.checked_sub(1)?)?;
    let cell = |k_mm: f64| {
        let share = k_mm / (1e3 * length_m);
        ((share * CELLS as f64) as usize).min(CELLS - 1)
    };
    let (green, magenta) = (
        AnsiColor::Green.on_default().bold(),
        AnsiColor::Magenta.on_default().bold(),
    );
    let mut cells = vec!["─".to_owned(); CELLS];
    if let (Some(k_mm), Some(sigma_mm)) = (summary.k_mm, summary.sigma_mm) {
        let band = cell((k_mm - 2.0 * sigma_mm).max(0.0))..=cell(k_mm + 2.0 * sigma_mm);
        for at in band {
            cells[at] = format!("{green}━{green:#}");
        }
        cells[cell(k_mm)] = format!("{green}┃{green:#}");
    }
    let mut above = vec![" ".to_owned(); CELLS];
    if let Some(k_mm) = summary
        .true_k_mm
        .filter(|_| summary.true_phalanx == Some(phalanx))
    {
        above[cell(k_mm)] = format!("{magenta}×{magenta:#}");
    }
    Some(format!(
        "           {}\nphalanx {phalanx}  ○{}  {:.0} mm   {green}┃{green:#} estimate ± 2 deviations  {magenta}×{magenta:#} truth\n",
        above.concat(),
        cells.concat(),
        1e3 * length_m
    ))
}
