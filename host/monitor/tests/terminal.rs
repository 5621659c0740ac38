//! The monitor in a real terminal: tmux sends the keys and reads the screen. Without tmux these tests say so and pass.

mod tmux;

use std::path::PathBuf;
use std::time::Duration;

use tmux::Terminal;

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
