//! The monitor in a real terminal: tmux sends the keys and reads the screen. Without tmux these tests say so and pass.

use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// What cannot be seen by then will not be.
const PATIENCE: Duration = Duration::from_secs(30);

const LOG: &str = "\
0.1 INFO  boot version=0.1.0 scene=p70
1.0 INFO  friction-recorded closing_mnm=164 opening_mnm=-165 residual_mnm=0.5 coverage=0.97
2.0 INFO  state name=close from=idle
2.1 INFO  sample time_us=2100000 counts=60000 current_a=0.014 drive=1 evidence=1.5 threshold=16
2.2 INFO  sample time_us=2200000 counts=140000 current_a=0.030 drive=1
2.3 INFO  touch time_us=2300000 theta_a_mrad=780 torque_mnm=2.4
2.4 WARN  friction-stale misfit_mnm=1.5
2.5 INFO  located phalanx=2 k_mm=30.5 sigma_mm=0.6 force_n=0.8 radius_mm=11 settled=true p_phalanx=1
";

/// A terminal of its own, gone with the value.
struct Terminal {
    socket: String,
}

impl Terminal {
    /// A shell at 80 by 24; `None` without tmux.
    fn open(name: &str) -> Option<Self> {
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

    fn tmux(&self, words: &[&str]) -> Output {
        Command::new("tmux")
            .args(["-L", &self.socket, "-f", "/dev/null"])
            .args(words)
            .env_remove("TMUX")
            .output()
            .expect("tmux runs")
    }

    fn type_line(&self, line: &str) {
        self.tmux(&["send-keys", "-l", line]);
        self.keys(&["Enter"]);
    }

    fn keys(&self, keys: &[&str]) {
        self.tmux(&[&["send-keys"], keys].concat());
    }

    /// The screen, with its escape sequences if wanted.
    fn screen(&self, escapes: bool) -> String {
        let words: &[&str] = if escapes {
            &["capture-pane", "-p", "-e"]
        } else {
            &["capture-pane", "-p"]
        };
        String::from_utf8_lossy(&self.tmux(words).stdout).into_owned()
    }

    /// The screen once it shows every text.
    fn shows(&self, texts: &[&str]) -> String {
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
    fn is_as_before(&self) {
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
        let alternate = self.tmux(&["display-message", "-p", "#{alternate_on}"]);
        assert_eq!(String::from_utf8_lossy(&alternate.stdout).trim(), "0");
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.tmux(&["kill-server"]);
    }
}

/// A file with a log, removed with the value.
struct LogFile(PathBuf);

impl Drop for LogFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A terminal, and a log for the monitor to show in it; `None` without tmux.
fn open(name: &str) -> Option<(Terminal, LogFile)> {
    let terminal = Terminal::open(name)?;
    let path = std::env::temp_dir().join(format!("palpate-{name}-{}.log", std::process::id()));
    std::fs::write(&path, LOG).expect("a temporary file");
    Some((terminal, LogFile(path)))
}

fn watch(log: &LogFile, more: &str) -> String {
    format!(
        "{} watch --speed 0 --from {} {more}",
        env!("CARGO_BIN_EXE_palpate-monitor"),
        log.0.display()
    )
}

#[test]
fn keys_are_answered_on_eighty_by_twenty_four_and_the_terminal_comes_back() {
    let Some((terminal, log)) = open("keys") else {
        return;
    };
    terminal.type_line(&watch(&log, ""));
    // Every part is there.
    terminal.shows(&[
        "p70",
        "finger, ",
        "phalanx 2 30.5 ± 0.6 mm",
        "force    0.80 N",
        "k on phalanx 2",
        "friction-stale misfit_mnm=1.5",
        "source ended",
        "? help",
    ]);
    // The level: only warnings and errors are left.
    terminal.keys(&["l"]);
    let screen = terminal.shows(&["log, from WARN"]);
    assert!(!screen.contains("located phalanx=2"), "{screen}");
    terminal.keys(&["l", "l", "l"]);
    // The filter.
    terminal.keys(&["/", "t", "o", "u", "c", "h", "Enter"]);
    let screen = terminal.shows(&["with 'touch'"]);
    assert!(!screen.contains("boot version"), "{screen}");
    // The command line: completed, refused by a file, recalled.
    terminal.keys(&[":", "s", "t", "a", "Tab"]);
    terminal.shows(&[":status"]);
    terminal.keys(&["Enter", "Up"]);
    terminal.shows(&[":status"]);
    terminal.keys(&["Escape"]);
    // tmux waits whether a sequence follows an escape.
    std::thread::sleep(Duration::from_millis(700));
    terminal.keys(&["/", "Enter"]);
    terminal.shows(&["nobody takes 'status'"]);
    terminal.keys(&["?"]);
    terminal.shows(&["record friction"]);
    // A larger and a smaller window.
    for (width, height) in [("120", "40"), ("60", "16"), ("80", "24")] {
        terminal.tmux(&["resize-window", "-x", width, "-y", height]);
        terminal.shows(&["palpate", "? help"]);
    }
    terminal.keys(&["q"]);
    terminal.is_as_before();
}

#[test]
fn without_colour_no_colour_is_sent() {
    let Some((terminal, log)) = open("plain") else {
        return;
    };
    terminal.type_line(&format!("NO_COLOR=1 {}", watch(&log, "")));
    terminal.shows(&["phalanx 2 30.5"]);
    let plain = terminal.screen(true);
    // Colours are 30 to 37, 90 to 97 and 38; bold and reverse are none.
    let coloured = |screen: &str| {
        screen.split("\x1b[").skip(1).any(|sequence| {
            let numbers = sequence.split('m').next().unwrap_or_default();
            numbers
                .split(';')
                .any(|number| matches!(number.as_bytes(), [b'3' | b'9', b'0'..=b'8']))
        })
    };
    assert!(!coloured(&plain), "{plain:?}");
    terminal.keys(&["q"]);
    terminal.is_as_before();
    // The check itself can fail: with colours it finds some.
    terminal.type_line(&format!("unset NO_COLOR; clear; {}", watch(&log, "")));
    terminal.shows(&["phalanx 2 30.5"]);
    assert!(coloured(&terminal.screen(true)));
}

#[test]
fn the_terminal_comes_back_after_a_panic() {
    let Some((terminal, log)) = open("panic") else {
        return;
    };
    terminal.type_line(&format!("RUST_BACKTRACE=0 {}", watch(&log, "--fail")));
    terminal.shows(&["as asked for"]);
    terminal.is_as_before();
}
