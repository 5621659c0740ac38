//! A recording is read as it was written, and the monitor plays it.

mod tmux;

use palpate_monitor::recording::{Recording, Rows};
use palpate_monitor::stream::{Message, Sample, parse};
use tmux::Terminal;

/// What the firmware logs before a sample, and of another after it.
const BEFORE: [&str; 4] = [
    "boot version=0.1.0 scene=p70",
    "state name=close from=idle",
    "touch time_us=2300000 theta_a_mrad=780 torque_mnm=2.4",
    "answer \"ok\" n=1, 2",
];
const AFTER: &str =
    "located phalanx=2 k_mm=30.5 sigma_mm=0.6 force_n=0.8 radius_mm=11 settled=true p_phalanx=1";

/// A recording of two samples; the messages that it was made of.
fn recorded(name: &str) -> (std::path::PathBuf, Vec<Message>) {
    let path = std::env::temp_dir().join(format!("palpate-{name}-{}.csv", std::process::id()));
    let sample = Sample {
        time_s: 2.3,
        counts: 140_000.0,
        current_a: 0.0151,
        duty: -1.0,
        ..Sample::default()
    };
    let with_joint = Sample {
        time_s: 2.301,
        joint_rad: Some(0.25),
        ..sample
    };
    let line = |text: &str| parse(text).expect("a line");
    let mut messages: Vec<Message> = BEFORE.iter().map(|text| line(text)).collect();
    messages.push(Message::Sample(sample));
    messages.push(line(AFTER));
    messages.push(Message::Sample(with_joint));
    let mut recording = Recording::create(&path).expect("a temporary file");
    for message in &messages {
        recording.take(message).expect("room on the disk");
    }
    recording.finish().expect("written");
    (path, messages)
}

#[test]
fn what_was_written_is_read() {
    let (path, messages) = recorded("read");
    let text = std::fs::read_to_string(&path).expect("the file");
    std::fs::remove_file(path).expect("the file is there");
    let mut lines = text.lines();
    let rows = Rows::of(lines.next().expect("a head")).expect("a recording");
    let read: Vec<Message> = lines.flat_map(|row| rows.messages(row)).collect();
    assert_eq!(read.len(), messages.len(), "{read:?}");
    for (read, written) in read.iter().zip(&messages) {
        match (read, written) {
            (Message::Event(read), Message::Event(written)) => {
                assert_eq!(read.text(), written.text());
                // The file tells the sample that a line came with.
                assert!(
                    read.time_s
                        .is_some_and(|time_s| (time_s - 2.3).abs() < 0.01)
                );
            }
            (read, written) => assert_eq!(read, written),
        }
    }
}

#[test]
fn what_is_no_recording_is_not_read_as_one() {
    assert!(Rows::of("0.1 INFO  boot version=0.1.0 scene=p70").is_none());
    let rows = Rows::of("time_s,encoder_counts,current_a").expect("the least");
    assert!(rows.messages("1,x,0").is_empty() && rows.messages("").is_empty());
    let opening = rows.messages("1,2,-0.1");
    assert!(
        matches!(opening[..], [Message::Sample(sample)] if sample.duty == -1.0),
        "{opening:?}"
    );
}

#[test]
fn the_monitor_plays_a_recording() {
    let Some(terminal) = Terminal::open("play") else {
        return;
    };
    let (path, _) = recorded("play");
    let program = env!("CARGO_BIN_EXE_palpate-monitor");
    terminal.type_line(&format!(
        "{program} watch --speed 0 --from {}",
        path.display()
    ));
    terminal.shows(&["p70", "finger, ", "phalanx 2 30.5 ± 0.6 mm", "source ended"]);
    terminal.keys(&["q"]);
    terminal.is_as_before();
    std::fs::remove_file(path).expect("the file is there");
}
