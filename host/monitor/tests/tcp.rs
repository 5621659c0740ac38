//! `--from tcp:HOST:PORT` of monitor and record, at an emulator that is left running with its RTT port open.
//!
//! `cargo xtask test` names the image in `PALPATE_ELF` and builds the emulator beside the monitor; without one of them these tests say
//! so and pass.

mod tmux;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::Duration;

use tmux::Terminal;

const MONITOR: &str = env!("CARGO_BIN_EXE_palpate-monitor");

/// An emulated chip that waits for commands; gone with the value.
struct Emulator {
    child: Child,
    elf: PathBuf,
    port: String,
}

impl Emulator {
    fn start() -> Option<Self> {
        Self::start_with(&[])
    }

    /// The same with further options of `sim`.
    fn start_with(options: &[&str]) -> Option<Self> {
        let Some(elf) = std::env::var_os("PALPATE_ELF") else {
            eprintln!("PALPATE_ELF is not set: nothing tested");
            return None;
        };
        let program = Path::new(MONITOR).with_file_name("palpate-emulator");
        if !program.exists() {
            eprintln!("{} is not built: nothing tested", program.display());
            return None;
        }
        let mut child = Command::new(program)
            .args(["sim", "--keep-running", "--rtt-port", "0"])
            .args(["--commands", "status", "--elf"])
            .arg(&elf)
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the emulator starts");
        let mut told = BufReader::new(child.stderr.take().expect("its messages")).lines();
        let port = told
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| {
                let (_, rest) = line.split_once("rtt: port ")?;
                Some(rest.split(';').next()?.to_owned())
            })
            .expect("the emulator names its port");
        // What it says further is read and forgotten, so that it never waits for a reader.
        thread::spawn(move || told.for_each(drop));
        Some(Self {
            child,
            elf: elf.into(),
            port,
        })
    }

    /// What leads a program to it.
    fn source(&self) -> [String; 4] {
        [
            "--from".to_owned(),
            format!("tcp:127.0.0.1:{}", self.port),
            "--elf".to_owned(),
            self.elf.display().to_string(),
        ]
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn record(file: &Path, source: &[String]) -> Output {
    record_with(file, source, &["trace on;home", "--seconds", "1"])
}

/// The same with other commands, and options after them.
fn record_with(file: &Path, source: &[String], commands: &[&str]) -> Output {
    Command::new(MONITOR)
        .arg("record")
        .arg(file)
        .args(source)
        .arg("--commands")
        .args(commands)
        .output()
        .expect("the program starts")
}

#[test]
fn a_recording_comes_over_tcp() {
    let Some(emulator) = Emulator::start() else {
        return;
    };
    let file = std::env::temp_dir().join(format!("palpate-tcp-{}.csv", std::process::id()));
    let recorded = record(&file, &emulator.source());
    assert!(recorded.status.success(), "{recorded:?}");
    let text = std::fs::read_to_string(&file).expect("the recording");
    std::fs::remove_file(&file).expect("the file is there");
    let times: Vec<f64> = text
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().expect("a column"))
        .map(|time_s| time_s.parse().expect("a number"))
        .collect();
    assert!(times.len() > 1_000, "{} samples", times.len());
    // One a millisecond, none missing.
    let even = |pair: &[f64]| (pair[1] - pair[0] - 1e-3).abs() < 1e-6;
    assert!(times.windows(2).all(even));
    // From the first line on, though it came late, and with the answers to its commands.
    for part in ["boot version=", "scene=p70", "answer ok", "state name=home"] {
        assert!(text.contains(part), "{part}");
    }
}

/// Nothing moves, so no `sequence done` would end it.
#[test]
fn a_refused_motion_ends_a_recording() {
    let Some(emulator) = Emulator::start() else {
        return;
    };
    let file = std::env::temp_dir().join(format!("palpate-no-{}.csv", std::process::id()));
    for commands in ["trace on;calibrate 21;status", "trace off;wlak"] {
        let refused = record_with(&file, &emulator.source(), &[commands]);
        let told = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success(), "{told}");
        assert!(
            ["answer refused:", "no sample came"]
                .iter()
                .any(|part| told.contains(part)),
            "{told}"
        );
        // Samples of the finger at rest, where there are some.
        let _ = std::fs::remove_file(&file);
    }
}

/// The firmware as it is says what has ended the motion, in whatever order it tells state and fault.
#[test]
fn a_fault_ends_a_recording_and_is_named() {
    let Some(emulator) = Emulator::start_with(&["--fault", "stalled-rotor@0.05"]) else {
        return;
    };
    let file = std::env::temp_dir().join(format!("palpate-fault-{}.csv", std::process::id()));
    let ended = record_with(&file, &emulator.source(), &["trace on;run"]);
    let told = String::from_utf8_lossy(&ended.stderr);
    assert!(!ended.status.success(), "{told}");
    let named = told
        .lines()
        .find_map(|line| line.split_once("a fault ended the motion: "))
        .map(|(_, name)| name);
    assert!(
        named.is_some_and(|name| told.contains(&format!("name={name}"))),
        "{told}"
    );
    std::fs::remove_file(&file).expect("samples came before it");
}

#[test]
fn the_monitor_watches_and_commands_over_tcp() {
    let Some(mut emulator) = Emulator::start() else {
        return;
    };
    let Some(terminal) = Terminal::open("tcp") else {
        return;
    };
    let source = emulator.source().join(" ");
    terminal.type_line(&format!("{MONITOR} watch {source}"));
    terminal.shows(&["p70", "boot version=", "finger, "]);
    terminal.keys(&[":", "h", "e", "l", "p", "Enter"]);
    terminal.shows(&["answer trace"]);
    terminal.keys(&["Escape"]);
    // tmux waits whether a sequence follows an escape.
    std::thread::sleep(Duration::from_millis(700));
    // Samples come without being asked for by hand.
    terminal.keys(&["w"]);
    terminal.shows(&["recording to palpate-"]);
    std::thread::sleep(Duration::from_millis(300));
    terminal.keys(&["w"]);
    let screen = terminal.shows(&["samples to palpate-"]);
    let (_, file) = screen.split_once("samples to ").expect("shown");
    let file = file.split(".csv").next().expect("a name");
    std::fs::remove_file(format!("{file}.csv")).expect("the file is there");
    // The server goes: that is told, and the monitor stays to be read.
    emulator.child.kill().expect("it is still there");
    terminal.shows(&["source ended", "the server has hung up"]);
    terminal.keys(&["q"]);
    terminal.is_as_before();
}

/// A source that ends without a sample leaves no file that looks like a recording.
#[test]
fn a_recording_without_a_sample_is_none() {
    let file = std::env::temp_dir().join(format!("palpate-none-{}.csv", std::process::id()));
    let log = file.with_extension("log");
    std::fs::write(&log, "1.0 INFO  boot version=0.1.0 scene=p70\n").expect("a temporary file");
    let source = ["--speed", "0", "--from", &log.to_string_lossy()].map(str::to_owned);
    let refused = record(&file, &source);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert!(
        !refused.status.success() && told.contains("trace on"),
        "{told}"
    );
    assert!(!file.exists());
    // A recording that is there stays.
    std::fs::write(&file, "earlier").expect("a temporary file");
    let refused = record(&file, &source);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && told.contains("--force"));
    let kept = std::fs::read_to_string(&file).expect("still there");
    assert_eq!(kept, "earlier");
    let forced = record_with(&file, &source, &["run", "--force"]);
    assert!(String::from_utf8_lossy(&forced.stderr).contains("no sample came"));
    assert!(!file.exists());
    std::fs::remove_file(&log).expect("the file is there");
}

#[test]
fn a_port_where_nobody_listens_is_named_with_what_opens_one() {
    let elf = std::env::current_exe().expect("a file");
    let source = ["--from", "tcp:127.0.0.1:1", "--elf"].map(str::to_owned);
    let source = [&source[..], &[elf.display().to_string()]].concat();
    let file = std::env::temp_dir().join("palpate-tcp-none.csv");
    let refused = record(&file, &source);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success());
    for part in ["127.0.0.1:1", "--keep-running", "--rtt-port"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(
        !file.exists(),
        "nothing is left of a recording that never began"
    );
}
