//! The loop: messages and keys in, frames out.

use std::path::PathBuf;
use std::sync::mpsc::TryRecvError;
use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::command_line::CommandLine;
use crate::posture::FingerView;
use crate::recording::Recording;
use crate::screen::{Focus, View, draw};
use crate::source::Source;
use crate::state::State;
use crate::stream::Level;

/// Longest wait for a key; a frame follows.
const FRAME: Duration = Duration::from_millis(40);
/// Messages taken between two frames at most, so that keys are answered under any load.
const BATCH: usize = 2_000;
/// Log lines by which a page key scrolls.
const PAGE: usize = 5;

/// Finds the finger of a scene by its name.
pub type FingerOf = fn(&str) -> Option<Box<dyn FingerView>>;

/// A monitor at work.
pub struct Watch {
    source: Source,
    state: State,
    view: View,
    command: CommandLine,
    finger: Option<Box<dyn FingerView>>,
    finger_of: FingerOf,
    drawn_scene: Option<String>,
    recording: Option<Recording>,
}

impl Watch {
    /// Watches a source. `scene` is drawn until the firmware names another.
    #[must_use]
    pub fn new(source: Source, scene: Option<&str>, finger_of: FingerOf, colour: bool) -> Self {
        Self {
            source,
            state: State {
                scene: scene.map(str::to_owned),
                ..State::default()
            },
            view: View {
                level: Level::Info,
                filter: String::new(),
                back: 0,
                colour,
                help: false,
                recording: None,
                focus: Focus::Keys,
            },
            command: CommandLine::default(),
            finger: None,
            finger_of,
            drawn_scene: None,
            recording: None,
        }
    }

    /// Runs until the user leaves.
    ///
    /// # Errors
    /// The terminal cannot be drawn to or read from.
    pub fn run(&mut self, terminal: &mut DefaultTerminal) -> std::io::Result<()> {
        loop {
            self.receive();
            self.find_finger();
            terminal.draw(|frame| {
                // Reborrowed by hand: the box's own lifetime is longer than the frame's.
                let finger = self.finger.as_mut().map(|finger| &mut **finger as _);
                draw(frame, &self.state, &self.view, &self.command, finger);
            })?;
            if event::poll(FRAME)?
                && let Event::Key(key) = event::read()?
                && key.kind == KeyEventKind::Press
                && self.key(key)
            {
                self.stop_recording();
                return Ok(());
            }
        }
    }

    fn receive(&mut self) {
        for _ in 0..BATCH {
            match self.source.messages.try_recv() {
                Ok(message) => {
                    if let Some(recording) = &mut self.recording
                        && let Err(error) = recording.take(&message)
                    {
                        self.state
                            .note(Level::Error, format!("the recording ended: {error}"));
                        self.recording = None;
                        self.view.recording = None;
                    }
                    self.state.take(message);
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.state.ended = true;
                    return;
                }
            }
        }
    }

    fn find_finger(&mut self) {
        if self.state.scene != self.drawn_scene {
            self.drawn_scene.clone_from(&self.state.scene);
            self.finger = self.state.scene.as_deref().and_then(self.finger_of);
        }
    }

    /// Takes a key; `true` to leave.
    fn key(&mut self, key: KeyEvent) -> bool {
        if key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c') {
            return true;
        }
        match (self.view.focus, key.code) {
            (_, KeyCode::Esc) => self.view.focus = Focus::Keys,
            (_, KeyCode::PageUp) => {
                self.view.back =
                    (self.view.back + PAGE).min(self.state.log.len().saturating_sub(1));
            }
            (_, KeyCode::PageDown) => self.view.back = self.view.back.saturating_sub(PAGE),
            (Focus::Command, _) => {
                if let Some(line) = self.command.key(key) {
                    self.send(&line);
                }
            }
            (Focus::Filter, KeyCode::Enter) => self.view.focus = Focus::Keys,
            (Focus::Filter, KeyCode::Backspace) => {
                self.view.filter.pop();
            }
            (Focus::Filter, KeyCode::Char(letter)) => self.view.filter.push(letter),
            (Focus::Keys, KeyCode::Char(letter)) => return self.letter(letter),
            _ => {}
        }
        false
    }

    fn letter(&mut self, letter: char) -> bool {
        match letter {
            'q' => return true,
            '?' => self.view.help = !self.view.help,
            ':' => self.view.focus = Focus::Command,
            '/' => {
                self.view.filter.clear();
                self.view.focus = Focus::Filter;
            }
            'l' => {
                self.view.level = match self.view.level {
                    Level::Debug => Level::Info,
                    Level::Info => Level::Warn,
                    Level::Warn => Level::Error,
                    Level::Error => Level::Debug,
                };
            }
            'w' => self.toggle_recording(),
            'r' => self.send("run"),
            's' => self.send("stop"),
            'o' => self.send("open"),
            'c' => self.send("clear"),
            'f' => self.send("record-friction"),
            'k' => self.send("calibrate cable"),
            't' => self.send("status"),
            _ => {}
        }
        false
    }

    fn send(&mut self, line: &str) {
        if self.source.command(line) {
            self.state.note(Level::Debug, format!("> {line}"));
        } else {
            self.state.note(
                Level::Warn,
                format!("nobody takes '{line}': a file has no finger behind it"),
            );
        }
    }

    fn toggle_recording(&mut self) {
        if self.recording.is_some() {
            self.stop_recording();
            return;
        }
        let path = (1..)
            .map(|n| PathBuf::from(format!("palpate-{n}.csv")))
            .find(|path| !path.exists());
        let Some(path) = path else { return };
        match Recording::create(&path) {
            Ok(recording) => {
                self.view.recording = Some(path.display().to_string());
                self.recording = Some(recording);
            }
            Err(error) => self.state.note(
                Level::Error,
                format!("cannot write {}: {error}", path.display()),
            ),
        }
    }

    fn stop_recording(&mut self) {
        self.view.recording = None;
        if let Some(recording) = self.recording.take() {
            let path = recording.path().display().to_string();
            match recording.finish() {
                Ok(rows) => self
                    .state
                    .note(Level::Info, format!("recorded {rows} samples to {path}")),
                Err(error) => self
                    .state
                    .note(Level::Error, format!("cannot write {path}: {error}")),
            }
        }
    }
}
