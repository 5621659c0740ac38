// SPDX-License-Identifier: GPL-2.0-only
//! Tools of others at the emulated chip: a reader of RTT over TCP, and a debugger.
//!
//! `cargo xtask test` gets a GDB for Arm, finds the `defmt-print` that `cargo xtask setup` built, and names them in `PALPATE_GDB` and
//! `PALPATE_DEFMT_PRINT`; without these they are looked for on the path. The same is tested without either, by the crate that
//! `defmt-print` is made of and by a few packets of the remote protocol.

use crate::support;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::support::firmware;
use palpate_emulator::Firmware;
use palpate_emulator::clients::gdb::GdbServer;
use palpate_emulator::clients::rtt::RttServer;
use palpate_emulator::sim::{Script, Session, Settings};

/// A client that has not finished by then never will.
const PATIENCE: Duration = Duration::from_secs(120);

fn image() -> Option<(PathBuf, Firmware)> {
    Some((support::path(support::DEFAULT)?, firmware()?))
}

fn session(firmware: &Firmware) -> Session<'_> {
    let settings = Settings {
        script: Script::parse("status"),
        ..Settings::default()
    };
    Session::start(firmware, settings, None).expect("a chip")
}

/// A program that a variable of the environment names, or one of these on the path; the one that is named must run.
fn program(variable: &str, on_path: &[&str], remedy: &str) -> Option<OsString> {
    let runs = |program: &OsString| {
        let mut version = Command::new(program);
        version.arg("--version").stdout(Stdio::null());
        version.status().is_ok_and(|status| status.success())
    };
    if let Some(named) = std::env::var_os(variable) {
        assert!(
            runs(&named),
            "{variable} names {}, which does not run",
            named.display()
        );
        return Some(named);
    }
    let found = on_path.iter().map(OsString::from).find(runs);
    if found.is_none() {
        eprintln!("none of {on_path:?} is on the path: nothing tested ({remedy})");
    }
    found
}

/// Runs the chip until a client has finished, and hands over what that found.
fn run_until<'f, T>(
    session: &mut Session<'f>,
    client: JoinHandle<T>,
    mut serve: impl FnMut(&mut Session<'f>) -> bool,
) -> T {
    let start = Instant::now();
    while !client.is_finished() {
        assert!(start.elapsed() < PATIENCE, "the client does not finish");
        if serve(session) {
            session.millisecond().expect("the chip runs");
        } else {
            thread::sleep(Duration::from_millis(1));
        }
    }
    client.join().expect("the client ends well")
}

/// The same with a client of RTT.
fn run_with<T>(session: &mut Session<'_>, client: JoinHandle<T>, server: &mut RttServer) -> T {
    run_until(session, client, |session| {
        server.serve(&mut session.machine);
        true
    })
}

#[test]
fn a_reader_of_rtt_decodes_the_log_and_types_a_command() {
    let Some((path, firmware)) = image() else {
        return;
    };
    let mut server = RttServer::listen(0).expect("a free port");
    let port = server.port();
    let client = thread::spawn(move || {
        let data = std::fs::read(path).expect("the image");
        let table = defmt_decoder::Table::parse(&data)
            .expect("tables")
            .expect("a table");
        let mut decoder = table.new_stream_decoder();
        let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("the port is open");
        stream.write_all(b"help\n").expect("the chip listens");
        let mut lines: Vec<String> = Vec::new();
        let mut bytes = [0; 512];
        while !lines.iter().any(|line| line.starts_with("answer trace")) {
            let count = stream.read(&mut bytes).expect("the chip talks");
            assert!(count > 0, "the server has hung up");
            decoder.received(&bytes[..count]);
            while let Ok(frame) = decoder.decode() {
                lines.push(frame.display_message().to_string());
            }
        }
        lines
    });
    let mut session = session(&firmware);
    let lines = run_with(&mut session, client, &mut server);
    assert!(lines[0].starts_with("boot version="), "{lines:?}");
    let own: Vec<&str> = session
        .lines
        .iter()
        .map(|line| line.message.as_str())
        .collect();
    assert_eq!(
        lines,
        own[..lines.len()],
        "every record, and nothing but them"
    );
}

#[test]
fn defmt_print_decodes_the_stream() {
    let Some((path, firmware)) = image() else {
        return;
    };
    let remedy = "cargo install defmt-print --locked";
    let Some(program) = program("PALPATE_DEFMT_PRINT", &["defmt-print"], remedy) else {
        return;
    };
    let mut server = RttServer::listen(0).expect("a free port");
    let port = server.port().to_string();
    let client = thread::spawn(move || {
        let mut printer = Command::new(program)
            .arg("-e")
            .arg(path)
            .args(["tcp", "--host", "127.0.0.1", "--port", &port])
            .stdout(Stdio::piped())
            .spawn()
            .expect("defmt-print starts");
        let output = BufReader::new(printer.stdout.take().expect("its output"));
        let found = output
            .lines()
            .map_while(Result::ok)
            .find(|line| line.contains("status state=idle"));
        printer.kill().expect("it is still there");
        printer.wait().expect("it ends");
        found
    });
    let mut session = session(&firmware);
    let found = run_with(&mut session, client, &mut server);
    assert!(found.is_some_and(|line| line.contains("INFO")));
}

#[test]
fn gdb_sets_a_breakpoint_reads_steps_and_goes_on() {
    let Some((path, firmware)) = image() else {
        return;
    };
    let debuggers = ["gdb-multiarch", "arm-none-eabi-gdb"];
    let Some(gdb) = program("PALPATE_GDB", &debuggers, "apt-get install gdb-multiarch") else {
        return;
    };
    let mut server = GdbServer::listen(0).expect("a free port");
    let target = format!("target remote :{}", server.port());
    let client = thread::spawn(move || {
        let mut command = Command::new(gdb);
        command.args(["-q", "-nx", "-batch"]);
        for line in [
            "set confirm off",
            &target,
            "break ADC1_2",
            "continue",
            "monitor time",
            "stepi",
            "info registers pc",
            "x/2xw 0x08000000",
            "continue",
            "monitor time",
            "delete",
            "detach",
        ] {
            command.args(["-ex", line]);
        }
        let output = command.arg(path).output().expect("GDB runs");
        // What the stub says itself goes to the other stream.
        let both = [output.stdout, output.stderr].concat();
        String::from_utf8_lossy(&both).into_owned()
    });
    let mut session = session(&firmware);
    let told = run_until(&mut session, client, |session| {
        server.serve(session).expect("the chip can be held")
    });
    println!("{told}");
    assert_eq!(told.matches("Breakpoint 1, ").count(), 2, "{told}");
    let handler = firmware.symbol("ADC1_2").expect("the control interrupt") & !1;
    let stepped = told
        .lines()
        .find_map(|line| line.strip_prefix("pc ")?.split_whitespace().next())
        .expect("the register");
    // The breakpoint stands behind the prologue: one instruction on from there.
    let stepped = u32::from_str_radix(stepped.trim_start_matches("0x"), 16).expect("an address");
    assert!((handler..handler + 64).contains(&stepped), "{told}");
    let times: Vec<f64> = told
        .lines()
        .filter_map(|line| {
            line.strip_suffix(" s since power-on")?
                .rsplit(' ')
                .next()?
                .parse()
                .ok()
        })
        .collect();
    assert_eq!(times.len(), 2, "{told}");
    // From one control interrupt to the next; the core's time advances by whole runs of instructions.
    assert!(
        (times[1] - times[0] - 50e-6).abs() < 2e-6,
        "{times:?}\n{told}"
    );
    let stack = firmware.symbol("_stack_start").expect("a linker symbol");
    assert!(told.contains(&format!("{stack:#010x}")), "{told}");
}

/// The least that GDB's remote protocol asks for.
struct Remote(TcpStream);

impl Remote {
    fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("the port is open");
        stream
            .set_read_timeout(Some(PATIENCE))
            .expect("a time limit");
        Self(stream)
    }

    fn byte(&mut self) -> u8 {
        let mut byte = [0];
        self.0.read_exact(&mut byte).expect("the stub answers");
        byte[0]
    }

    /// Sends a packet and returns the answer's text.
    fn ask(&mut self, packet: &str) -> String {
        let sum = packet.bytes().fold(0u8, u8::wrapping_add);
        write!(self.0, "${packet}#{sum:02x}").expect("the stub listens");
        while self.byte() != b'$' {}
        let mut answer = String::new();
        loop {
            match self.byte() {
                b'#' => break,
                // Run lengths: the last character so many times more.
                b'*' => {
                    let more = usize::from(self.byte() - 29);
                    let last = answer.pop().expect("a character");
                    answer.extend(std::iter::repeat_n(last, more + 1));
                }
                byte => answer.push(byte.into()),
            }
        }
        let _sum = (self.byte(), self.byte());
        write!(self.0, "+").expect("the stub listens");
        answer
    }

    /// The program counter, out of all registers.
    fn pc(&mut self) -> u32 {
        let all = self.ask("g");
        let word = all.get(15 * 8..16 * 8).expect("sixteen registers");
        u32::from_str_radix(word, 16)
            .expect("hexadecimal")
            .swap_bytes()
    }
}

#[test]
fn the_remote_protocol_holds_steps_and_releases_the_core() {
    let Some((_, firmware)) = image() else {
        return;
    };
    let mut server = GdbServer::listen(0).expect("a free port");
    let port = server.port();
    let handler = firmware.symbol("ADC1_2").expect("the control interrupt") & !1;
    let client = thread::spawn(move || {
        let mut remote = Remote::connect(port);
        assert!(remote.ask("?").starts_with(['S', 'T']));
        let features = remote.ask("qXfer:features:read:target.xml:0,fff");
        assert!(features.contains("org.gnu.gdb.arm.m-profile"), "{features}");
        assert_eq!(remote.ask(&format!("Z0,{handler:x},2")), "OK");
        for _ in 0..3 {
            let stop = remote.ask("c");
            assert!(stop.starts_with("T05"), "{stop}");
            assert_eq!(remote.pc(), handler);
        }
        assert!(remote.ask("s").starts_with(['S', 'T']));
        let next = remote.pc();
        assert!(next == handler + 2 || next == handler + 4, "{next:#x}");
        assert_eq!(remote.ask("m8000000,4").len(), 8);
        assert!(
            remote.ask("m40000000,4").starts_with('E'),
            "registers of peripherals are not read: reading changes some"
        );
        assert_eq!(remote.ask(&format!("z0,{handler:x},2")), "OK");
        assert_eq!(remote.ask("D"), "OK");
    });
    let mut session = session(&firmware);
    run_until(&mut session, client, |session| {
        server.serve(session).expect("the chip can be held")
    });
    // It runs on as if nobody had looked: the watchdog has not bitten, and the command is answered.
    while !session.completed() {
        assert!(server.serve(&mut session).expect("nobody holds it"));
        session.millisecond().expect("the chip runs");
    }
    assert_eq!(session.resets, []);
    assert!(
        session
            .lines
            .iter()
            .any(|line| line.message.starts_with("status state=idle"))
    );
}
