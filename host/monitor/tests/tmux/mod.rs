//! A terminal of its own by tmux: keys are sent, the screen is read.
#![allow(dead_code, reason = "not every test uses all of it")]

use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// What cannot be seen by then will not be.
const PATIENCE: Duration = Duration::from_secs(30);

/// A terminal of its own, gone with the value.
pub struct Terminal {
    socket: String,
}

impl Terminal {
    /// A shell at 80 by 24; `None` without tmux.
    pub fn open(name: &str) -> Option<Self> {
        let version = Command::new("tmux").arg("-V").output();
        if !version.is_ok_and(|output| output.status.success()) {
            eprintln!("tmux is not on the path: apt-get install tmux");
            return None;
        }
        let socket = format!("palpate-{name}-{}", std::process::id());
        let terminal = Self { socket };
        terminal.tmux(&["new-session", "-d", "-x", "80", "-y", "24", "sh"]);
        Some(terminal)
    }

    pub fn tmux(&self, words: &[&str]) -> Output {
        Command::new("tmux")
            .args(["-L", &self.socket, "-f", "/dev/null"])
            .args(words)
            .env_remove("TMUX")
            .output()
            .expect("tmux runs")
    }

    pub fn type_line(&self, line: &str) {
        self.tmux(&["send-keys", "-l", line]);
        self.keys(&["Enter"]);
    }

    pub fn keys(&self, keys: &[&str]) {
        self.tmux(&[&["send-keys"], keys].concat());
    }

    /// The screen, with its escape sequences if wanted.
    pub fn screen(&self, escapes: bool) -> String {
        let words: &[&str] = if escapes {
            &["capture-pane", "-p", "-e"]
        } else {
            &["capture-pane", "-p"]
        };
        String::from_utf8_lossy(&self.tmux(words).stdout).into_owned()
    }

    /// The screen once it shows every text.
    pub fn shows(&self, texts: &[&str]) -> String {
        let start = Instant::now();
        loop {
            let screen = self.screen(false);
            if texts.iter().all(|text| screen.contains(text)) {
                return screen;
            }
            assert!(start.elapsed() < PATIENCE, "no {texts:?} on\n{screen}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// The shell is there again: main screen, lines edited and echoed.
    pub fn is_as_before(&self) {
        // What is typed before the monitor has ended goes to the monitor.
        let start = Instant::now();
        while self.is_alternate() {
            assert!(start.elapsed() < PATIENCE, "still on the other screen");
            std::thread::sleep(Duration::from_millis(50));
        }
        // Of two words, so that the line that is typed does not show it.
        self.type_line(
            "clear; stty -a | tr ' ' '\\n' | grep -x -e icanon -e echo | sort; echo all' 'done",
        );
        let screen = self.shows(&["all done"]);
        let modes: Vec<&str> = screen.lines().map(str::trim).collect();
        assert!(
            modes.contains(&"icanon") && modes.contains(&"echo"),
            "{screen}"
        );
    }

    /// A program shows the terminal's other screen.
    fn is_alternate(&self) -> bool {
        let answer = self.tmux(&["display-message", "-p", "#{alternate_on}"]);
        String::from_utf8_lossy(&answer.stdout).trim() != "0"
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.tmux(&["kill-server"]);
    }
}
