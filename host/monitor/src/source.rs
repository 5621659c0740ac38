//! Sources of lines and targets of commands: a simulation, a probe, a server of RTT, a serial port, or a file.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::recording::Rows;
use crate::stream::{Message, parse};
use crate::wire::{self, Wire};

/// Messages that wait to be shown; a faster source waits for the screen.
const WAITING: usize = 4_096;
/// Baud rate of the firmware's serial port.
const BAUD: u32 = 115_200;

/// Why there is nothing to watch.
#[derive(Debug, Error)]
pub enum Failure {
    /// A file cannot be read.
    #[error(
        "cannot read {path}: {source}; is the path right? --from takes sim, probe, tcp:HOST:PORT, a serial port, a recording or a file of log lines"
    )]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A serial port cannot be opened.
    #[error(
        "cannot open the serial port {name}: {source}; is the board connected, and may you use the port?"
    )]
    Port {
        /// Which.
        name: String,
        /// Why.
        source: serialport::Error,
    },
    /// A server of RTT does not answer.
    #[error(
        "cannot connect to {address}: {source}; `cargo xtask sim --keep-running --rtt-port PORT` opens one"
    )]
    Tcp {
        /// Where.
        address: String,
        /// Why.
        source: std::io::Error,
    },
    /// A probe does not give access to the firmware.
    #[cfg(feature = "probe")]
    #[error(transparent)]
    Probe(#[from] wire::probe::Failure),
    /// The image by which the log is read.
    #[error("{0}")]
    Image(String),
    /// A program cannot be started.
    #[error("cannot start {program}: {source}; {remedy}")]
    Program {
        /// Which.
        program: String,
        /// Why.
        source: std::io::Error,
        /// What to do.
        remedy: &'static str,
    },
}

/// What is watched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum From {
    /// A program that prints the stream and reads commands: the emulator.
    Program {
        /// Its path and arguments.
        call: Vec<String>,
        /// What to do if it cannot be started.
        remedy: &'static str,
    },
    /// A serial port.
    Port {
        /// Its name.
        name: String,
        /// The image whose log comes as frames; lines of text without it.
        elf: Option<PathBuf>,
    },
    /// A server of RTT.
    Tcp {
        /// HOST:PORT.
        address: String,
        /// The image whose log it is.
        elf: PathBuf,
    },
    /// A debug probe.
    #[cfg(feature = "probe")]
    Probe {
        /// The image that runs.
        elf: PathBuf,
    },
    /// A file of log lines or a recording, shown at the pace of its times.
    File(PathBuf),
}

/// A source under way.
pub struct Source {
    /// What it says.
    pub messages: Receiver<Message>,
    /// Command lines for it; `None` where nobody reads them.
    commands: Option<Sender<String>>,
    child: Option<Child>,
}

impl Source {
    /// Opens it and begins to read. `speed` is the pace of a file, in real time.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(from: &From, speed: f64) -> Result<Self, Failure> {
        match from {
            From::Program { call, remedy } => Self::program(call, remedy),
            From::Port { name, elf } => Self::port(name, elf.as_deref()),
            From::Tcp { address, elf } => {
                let connected = wire::Tcp::connect(address);
                let wire = connected.map_err(|source| Failure::Tcp {
                    address: address.clone(),
                    source,
                })?;
                Self::wired(wire, elf)
            }
            #[cfg(feature = "probe")]
            From::Probe { elf } => Self::wired(wire::probe::Probe::attach(elf)?, elf),
            From::File(path) => Self::file(path, speed),
        }
    }

    /// The next message; none after the last one, or after so long without one.
    #[must_use]
    pub fn next(&self, patience: Option<Duration>) -> Option<Message> {
        match patience {
            Some(patience) => self.messages.recv_timeout(patience).ok(),
            None => self.messages.recv().ok(),
        }
    }

    /// Sends a command line. `false` where nobody reads it.
    pub fn command(&self, line: &str) -> bool {
        self.commands
            .as_ref()
            .is_some_and(|commands| commands.send(line.to_owned()).is_ok())
    }

    /// Whether the finger goes on when this program has ended.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        self.commands.is_some() && self.child.is_none()
    }

    fn program(call: &[String], remedy: &'static str) -> Result<Self, Failure> {
        let program = call.first().cloned().unwrap_or_default();
        let mut child = Command::new(&program)
            .args(call.iter().skip(1))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|source| Failure::Program {
                program,
                source,
                remedy,
            })?;
        let (sender, messages) = sync_channel(WAITING);
        if let Some(errors) = child.stderr.take() {
            let sender = sender.clone();
            thread::spawn(move || read_notes(errors, &sender));
        }
        if let Some(output) = child.stdout.take() {
            thread::spawn(move || read_lines(output, &sender));
        }
        let commands = child.stdin.take().map(write_lines);
        Ok(Self {
            messages,
            commands,
            child: Some(child),
        })
    }

    /// Frames over a wire, read by the table of an image.
    fn wired(wire: impl Wire + 'static, elf: &Path) -> Result<Self, Failure> {
        let table = wire::table(elf).map_err(Failure::Image)?;
        let (sender, messages) = sync_channel(WAITING);
        let (commands, lines) = channel();
        thread::spawn(move || wire::run(wire, &table, &sender, &lines));
        Ok(Self {
            messages,
            commands: Some(commands),
            child: None,
        })
    }

    fn port(name: &str, elf: Option<&Path>) -> Result<Self, Failure> {
        let failed = |source| Failure::Port {
            name: name.to_owned(),
            source,
        };
        let port = serialport::new(name, BAUD)
            .timeout(Duration::from_millis(10))
            .open()
            .map_err(failed)?;
        if let Some(elf) = elf {
            return Self::wired(wire::Serial(port), elf);
        }
        let writer = port.try_clone().map_err(failed)?;
        let (sender, messages) = sync_channel(WAITING);
        thread::spawn(move || read_lines(Patient(port), &sender));
        Ok(Self {
            messages,
            commands: Some(write_lines(writer)),
            child: None,
        })
    }

    fn file(path: &Path, speed: f64) -> Result<Self, Failure> {
        let file = std::fs::File::open(path).map_err(|source| Failure::File {
            path: path.to_owned(),
            source,
        })?;
        let (sender, messages) = sync_channel(WAITING);
        thread::spawn(move || {
            let start = Instant::now();
            let mut lines = BufReader::new(file)
                .lines()
                .map_while(Result::ok)
                .peekable();
            let rows = lines.peek().and_then(|head| Rows::of(head));
            let head = usize::from(rows.is_some());
            let messages = lines.skip(head).flat_map(|line| match &rows {
                Some(rows) => rows.messages(&line),
                None => parse(&line).into_iter().collect(),
            });
            for message in messages {
                if let Some(time_s) = time_of(&message).filter(|_| speed > 0.0) {
                    let due = Duration::from_secs_f64((time_s / speed).clamp(0.0, 1e6));
                    thread::sleep(due.saturating_sub(start.elapsed()));
                }
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        Ok(Self {
            messages,
            commands: None,
            child: None,
        })
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            // It may have ended by itself; there is nothing to do about one that cannot be ended.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn time_of(message: &Message) -> Option<f64> {
    match message {
        Message::Event(event) => event.time_s,
        Message::Sample(sample) => Some(sample.time_s),
        Message::Truth { .. } | Message::Note(_) => None,
    }
}

fn read_lines(from: impl Read, to: &SyncSender<Message>) {
    let mut reader = BufReader::new(from);
    let mut bytes = Vec::new();
    // Bytes, not text: what a wire brings need not be UTF-8.
    while matches!(reader.read_until(b'\n', &mut bytes), Ok(count) if count > 0) {
        if let Some(message) = parse(&String::from_utf8_lossy(&bytes))
            && to.send(message).is_err()
        {
            return;
        }
        bytes.clear();
    }
}

fn read_notes(from: impl Read, to: &SyncSender<Message>) {
    for line in BufReader::new(from).lines().map_while(Result::ok) {
        if to.send(Message::Note(line)).is_err() {
            return;
        }
    }
}

fn write_lines(mut to: impl Write + Send + 'static) -> Sender<String> {
    let (sender, lines) = channel::<String>();
    thread::spawn(move || {
        for line in lines {
            if writeln!(to, "{line}").and_then(|()| to.flush()).is_err() {
                return;
            }
        }
    });
    sender
}

/// A port whose reads wait instead of ending at a time-out.
struct Patient(Box<dyn serialport::SerialPort>);

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            match self.0.read(buffer) {
                Err(error) if error.kind() == std::io::ErrorKind::TimedOut => {}
                other => return other,
            }
        }
    }
}

#[cfg(test)]
impl Source {
    /// A program that says what it is told.
    pub fn echo() -> Self {
        let from = From::Program {
            call: vec!["cat".to_owned()],
            remedy: "",
        };
        Self::open(&from, 1.0).expect("cat")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_to_its_end() {
        let path = std::env::temp_dir().join(format!("palpate-monitor-{}.log", std::process::id()));
        std::fs::write(&path, b"1.0 [INFO ] boot scene=p70\n\xff\xfe\n").expect("a temporary file");
        let source = Source::open(&From::File(path.clone()), 0.0).expect("the file");
        assert!(!source.command("run"));
        let first = source.messages.recv().expect("a line");
        assert!(matches!(first, Message::Event(event) if event.name == "boot"));
        std::fs::remove_file(path).expect("the file is there");
    }

    #[test]
    fn a_program_gets_commands_and_is_ended() {
        let source = Source::echo();
        assert!(source.command("state name=close from=idle"));
        let echo = source
            .messages
            .recv_timeout(Duration::from_secs(10))
            .expect("an echo");
        assert!(matches!(echo, Message::Event(event) if event.name == "state"));
    }

    #[cfg(unix)]
    #[test]
    fn a_serial_port_is_read_and_written() {
        use serialport::{SerialPort, TTYPort};

        let (mut chip, port) = TTYPort::pair().expect("a pair of terminals");
        let name = port.name().expect("its name");
        let source = Source::open(&From::Port { name, elf: None }, 1.0).expect("the port");
        chip.write_all(b"1.5 INFO  state name=close from=idle\r\n")
            .expect("room");
        let first = source.messages.recv_timeout(Duration::from_secs(10));
        assert!(
            matches!(&first, Ok(Message::Event(event)) if event.field("name") == Some("close")),
            "{first:?}"
        );
        assert!(source.command("stop"));
        chip.set_timeout(Duration::from_secs(10)).expect("a limit");
        let mut typed = [0; 5];
        chip.read_exact(&mut typed).expect("the command");
        assert_eq!(&typed, b"stop\n");
    }

    #[test]
    fn what_is_missing_is_named() {
        let file = Source::open(&From::File("no/such/file".into()), 1.0).err();
        assert!(file.is_some_and(|error| error.to_string().contains("no/such/file")));
    }
}
