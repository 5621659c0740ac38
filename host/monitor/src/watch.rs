//! The loop: messages and keys in, frames out.

use std::path::PathBuf;
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::command_line::CommandLine;
use crate::posture::FingerView;
use crate::recording::Recording;
use crate::screen::{Focus, View, draw};
use crate::source::Source;
use crate::state::State;
use crate::stream::{Level, Message};

/// Longest wait for a key; a frame follows.
const FRAME: Duration = Duration::from_millis(40);
/// Messages taken between two frames at most, so that keys are answered under any load.
const BATCH: usize = 2_000;
/// Longest wait for the answer to the last command.
const FAREWELL: Duration = Duration::from_millis(300);
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
    /// The command that has samples streamed; what the user has typed last of that kind.
    trace: String,
    /// Samples have come since it was sent.
    streams: bool,
}

impl Watch {
    /// Watches a source. `scene` is drawn until the firmware names another; `trace` has samples streamed, as fast as the source carries
    /// them.
    #[must_use]
    pub fn new(
        source: Source,
        scene: Option<&str>,
        finger_of: FingerOf,
        colour: bool,
        trace: &str,
    ) -> Self {
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
            trace: trace.to_owned(),
            streams: false,
        }
    }

    /// Runs until the user leaves.
    ///
    /// # Errors
    /// The terminal cannot be drawn to or read from.
    pub fn run(&mut self, terminal: &mut DefaultTerminal) -> std::io::Result<()> {
        self.ask_for_samples();
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
                self.leave();
                return Ok(());
            }
        }
    }

    /// Without samples there is no posture, no curve, no evidence, and nothing to record. A file has its own.
    fn ask_for_samples(&mut self) {
        self.streams = false;
        if self.source.command(&self.trace) {
            self.state.note(Level::Debug, format!("> {}", self.trace));
        }
    }

    /// Ends the stream of a finger that goes on: nobody reads it any more, and the next reader would find old samples.
    fn leave(&self) {
        if !self.source.goes_on() || !self.source.command("trace off") {
            return;
        }
        let end = Instant::now() + FAREWELL;
        while let Some(message) = self
            .source
            .next(Some(end.saturating_duration_since(Instant::now())))
        {
            if matches!(&message, Message::Event(event) if event.name == "answer ok") {
                return;
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
                    let restarted = self.streams
                        && matches!(&message, Message::Event(event) if event.name == "boot");
                    self.streams |= matches!(message, Message::Sample(_));
                    self.state.take(message);
                    if restarted {
                        self.ask_for_samples();
                    }
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
        if line.trim_start().starts_with("trace") {
            line.clone_into(&mut self.trace);
        }
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
                // Told again what is known of friction and calibration, which `replay` needs.
                self.ask_for_samples();
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
                Ok(0) => {
                    // Nothing is left that looks like a recording; one that cannot be removed has its head alone.
                    let _ = std::fs::remove_file(&path);
                    self.state.note(
                        Level::Warn,
                        "no sample came, so no file is left: `trace on` streams them",
                    );
                }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::From;

    const SAMPLE: &str = "sample time_us=1000 counts=0 current_a=0 drive=1";

    /// What the echo of `trace on 5` looks like: its first word is a level.
    const ASKED: &str = "on 5";

    /// A watch of a source that says what it is told.
    fn watch() -> Watch {
        Watch::new(Source::echo(), None, |_| None, false, "trace on 5")
    }

    /// Receives until a line has come so many times, and no more of them.
    fn until(watch: &mut Watch, text: &str, times: usize) {
        let end = Instant::now() + Duration::from_secs(10);
        let count = |watch: &Watch| {
            let lines = watch.state.log.iter();
            lines.filter(|line| line.text == text).count()
        };
        while count(watch) < times {
            assert!(Instant::now() < end, "{text}: {:?}", watch.state.log);
            watch.receive();
        }
        assert_eq!(count(watch), times, "{text}");
    }

    #[test]
    fn samples_are_asked_for_at_once_and_after_a_restart() {
        let mut watch = watch();
        watch.ask_for_samples();
        // The lines from the start of a firmware come behind it.
        watch.send("boot version=1 scene=p70");
        watch.send("status");
        until(&mut watch, "status", 1);
        until(&mut watch, ASKED, 1);
        watch.send(SAMPLE);
        watch.send("boot version=1 scene=p70");
        until(&mut watch, ASKED, 2);
        assert_eq!(watch.state.samples.len(), 1);
        // Who has chosen otherwise is not overruled.
        watch.send("trace on 9");
        watch.send(SAMPLE);
        watch.send("boot version=1 scene=p70");
        until(&mut watch, "on 9", 2);
        until(&mut watch, ASKED, 2);
    }

    #[test]
    fn a_recording_without_a_sample_leaves_no_file() {
        let mut watch = watch();
        watch.letter('w');
        let path = watch.recording.as_ref().expect("begun").path().to_owned();
        assert!(path.exists());
        until(&mut watch, ASKED, 1);
        watch.letter('w');
        assert!(!path.exists() && watch.recording.is_none());
        let told = watch.state.log.back().expect("a line");
        assert!(told.text.contains("no sample came"), "{told:?}");
        // With one there is a file.
        watch.letter('w');
        watch.send(SAMPLE);
        watch.send("status");
        until(&mut watch, "status", 1);
        watch.letter('w');
        assert!(path.exists());
        std::fs::remove_file(path).expect("the file is there");
    }

    #[cfg(unix)]
    #[test]
    fn a_board_that_is_left_streams_no_more() {
        use serialport::{SerialPort, TTYPort};
        use std::io::{Read, Write};

        let (mut chip, port) = TTYPort::pair().expect("a pair of terminals");
        let name = port.name().expect("its name");
        let source = Source::open(&From::Port { name, elf: None }, 1.0).expect("the port");
        let watch = Watch::new(source, None, |_| None, false, "trace on 5");
        chip.write_all(b"answer ok\r\n").expect("room");
        watch.leave();
        chip.set_timeout(Duration::from_secs(10)).expect("a limit");
        let mut typed = [0; 10];
        chip.read_exact(&mut typed).expect("the command");
        assert_eq!(&typed, b"trace off\n");
        // A simulation ends with the monitor.
        assert!(!self::watch().source.goes_on());
    }
}
