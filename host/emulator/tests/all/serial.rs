// SPDX-License-Identifier: GPL-2.0-only
//! A board without a probe: the log and the trace over its serial port, commands back, through a terminal of this machine.
#![cfg(unix)]

use crate::support;
use palpate_emulator::Firmware;
use palpate_emulator::clients::serial::Serial;
use palpate_emulator::sim::{Script, Session, Settings};
use palpate_monitor::source::{From, Source};
use palpate_monitor::stream::Message;

/// Simulated milliseconds that are enough for all of this.
const LONGEST_MS: usize = 20_000;
/// Every so many samples: as `cargo xtask record --from PORT` asks for.
const EVERY: u64 = 5;

fn texts(messages: &[Message]) -> Vec<String> {
    let text = |message: &Message| match message {
        Message::Event(event) => Some(event.text()),
        _ => None,
    };
    messages.iter().filter_map(text).collect()
}

#[test]
fn log_and_trace_come_over_the_serial_port_and_commands_go_back() {
    let Some(elf) = support::path(support::SERIAL) else {
        return;
    };
    let firmware = Firmware::load(&elf).expect("the image loads");
    let mut serial = Serial::open().expect("a pair of terminals");
    let from = From::Port {
        name: serial.name(),
        elf: Some(elf),
    };
    let source = Source::open(&from, 1.0).expect("the port");
    let settings = Settings {
        script: Script(Vec::new()),
        ..Settings::default()
    };
    let mut session = Session::start(&firmware, settings, None).expect("a chip");
    let mut heard: Vec<Message> = Vec::new();
    let mut typed = false;
    let stopped = |heard: &[Message]| {
        heard.iter().any(|message| {
            matches!(message, Message::Event(event) if event.text().starts_with("sequence done"))
        })
    };
    for ms in 0..LONGEST_MS {
        session.millisecond().expect("the chip runs");
        serial.serve(&mut session.machine);
        heard.extend(source.messages.try_iter());
        if ms == 300 {
            assert!(source.command(&format!("trace on {EVERY}")));
            assert!(source.command("home"));
        }
        if !typed
            && heard
                .iter()
                .filter(|m| matches!(m, Message::Sample(_)))
                .count()
                > 400
        {
            typed = true;
            assert!(source.command("stop"));
        }
        if stopped(&heard) {
            break;
        }
        // The reader is another thread.
        std::thread::yield_now();
    }
    let lines = texts(&heard);
    assert!(typed && stopped(&heard), "{lines:?}");
    assert!(lines[0].starts_with("boot version="), "{lines:?}");
    assert!(lines.iter().any(|line| line == "answer ok"), "{lines:?}");
    assert!(
        !lines.iter().any(|line| line.starts_with("log dropped")),
        "{lines:?}"
    );
    // The same lines as over RTT, in the same order.
    let own = session
        .lines
        .iter()
        .map(|line| line.message.trim_end().to_owned());
    let own: Vec<String> = own.filter(|line| !line.starts_with("sample ")).collect();
    assert_eq!(lines, own[..lines.len()]);
    // Every fifth sample, none missing.
    let times: Vec<u64> = heard
        .iter()
        .filter_map(|message| match message {
            Message::Sample(sample) => Some((1e6 * sample.time_s).round() as u64),
            _ => None,
        })
        .collect();
    assert!(
        times
            .windows(2)
            .all(|pair| pair[1] - pair[0] == 1_000 * EVERY)
    );
}
