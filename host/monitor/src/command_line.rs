//! The command line at the foot of the screen: editing, history, completion.

use std::sync::LazyLock;

use palpate::app::console::command::Verb;
use palpate::app::console::settings::Setting;
use ratatui::crossterm::event::{Event, KeyCode, KeyEvent};
use tui_input::Input;
use tui_input::backend::crossterm::EventHandler;

/// Lines that can be completed: the firmware's verbs, what some of them take, and the names of its settings.
static LINES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let verbs = Verb::ALL.iter().map(|verb| {
        // A blank where something has to follow.
        let more = if verb.usage().is_empty() { "" } else { " " };
        format!("{}{more}", verb.name())
    });
    let words = [
        "calibrate cable",
        "calibrate forget",
        "trace on",
        "trace off",
    ];
    let settings = Setting::ALL
        .iter()
        .map(|setting| format!("set {} ", setting.name()));
    let mut lines: Vec<String> = verbs
        .chain(words.map(str::to_owned))
        .chain(settings)
        .collect();
    lines.sort();
    lines
});

/// Most lines remembered.
const HISTORY: usize = 200;

/// A line being edited.
#[derive(Debug, Default)]
pub struct CommandLine {
    input: Input,
    history: Vec<String>,
    /// Where in the history the arrows are; the length is the line being written.
    at: usize,
}

impl CommandLine {
    /// Its text.
    #[must_use]
    pub fn text(&self) -> &str {
        self.input.value()
    }

    /// Column of the cursor, from 0.
    #[must_use]
    pub fn cursor(&self) -> usize {
        self.input.visual_cursor()
    }

    /// Takes a key; returns the line that was entered with it.
    pub fn key(&mut self, key: KeyEvent) -> Option<String> {
        match key.code {
            KeyCode::Enter => return self.enter(),
            KeyCode::Up => self.recall(self.at.saturating_sub(1)),
            KeyCode::Down => self.recall(self.at + 1),
            KeyCode::Tab => self.complete(),
            _ => {
                self.input.handle_event(&Event::Key(key));
            }
        }
        None
    }

    /// Verbs that begin with what is written.
    pub fn candidates(&self) -> impl Iterator<Item = &'static str> {
        let written = self.text().to_owned();
        LINES
            .iter()
            .map(String::as_str)
            .filter(move |verb| !written.is_empty() && verb.starts_with(&written))
    }

    fn enter(&mut self) -> Option<String> {
        let line = self.text().trim().to_owned();
        self.input.reset();
        if !line.is_empty() && self.history.last() != Some(&line) {
            self.history.push(line.clone());
            if self.history.len() > HISTORY {
                self.history.remove(0);
            }
        }
        self.at = self.history.len();
        (!line.is_empty()).then_some(line)
    }

    fn recall(&mut self, at: usize) {
        self.at = at.min(self.history.len());
        let line = self.history.get(self.at).cloned().unwrap_or_default();
        self.input = Input::new(line);
    }

    /// Writes as much as all candidates share.
    fn complete(&mut self) {
        let mut candidates = self.candidates();
        let Some(first) = candidates.next() else {
            return;
        };
        let shared = candidates.fold(first.len(), |shared, other| {
            first
                .bytes()
                .zip(other.bytes())
                .take(shared)
                .take_while(|(a, b)| a == b)
                .count()
        });
        if let Some(text) = first.get(..shared) {
            self.input = Input::new(text.to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::crossterm::event::KeyModifiers;

    fn press(line: &mut CommandLine, code: KeyCode) -> Option<String> {
        line.key(KeyEvent::new(code, KeyModifiers::NONE))
    }

    fn write(line: &mut CommandLine, text: &str) {
        for letter in text.chars() {
            press(line, KeyCode::Char(letter));
        }
    }

    #[test]
    fn a_line_is_entered_and_recalled() {
        let mut line = CommandLine::default();
        write(&mut line, "run");
        assert_eq!(press(&mut line, KeyCode::Enter), Some("run".to_owned()));
        assert_eq!(line.text(), "");
        press(&mut line, KeyCode::Up);
        assert_eq!(line.text(), "run");
        press(&mut line, KeyCode::Down);
        assert_eq!(line.text(), "");
        assert_eq!(press(&mut line, KeyCode::Enter), None);
    }

    #[test]
    fn every_verb_and_every_setting_is_completed() {
        for (begun, whole) in [
            ("tr", "trace "),
            ("recor", "record-friction"),
            ("set ef", "set efficiency "),
        ] {
            let mut line = CommandLine::default();
            write(&mut line, begun);
            press(&mut line, KeyCode::Tab);
            assert_eq!(line.text(), whole);
        }
    }

    #[test]
    fn tab_writes_what_is_certain() {
        let mut line = CommandLine::default();
        write(&mut line, "cal");
        press(&mut line, KeyCode::Tab);
        assert_eq!(line.text(), "calibrate ");
        write(&mut line, "f");
        press(&mut line, KeyCode::Tab);
        assert_eq!(line.text(), "calibrate forget");
        press(&mut line, KeyCode::Tab);
        assert_eq!(line.text(), "calibrate forget");
    }
}
