//! Wires that carry the log as the firmware writes it, defmt frames, and command lines back: TCP, the serial port, a probe.
//!
//! All are read by the same loop; a wire only moves bytes.

#[cfg(feature = "probe")]
pub mod probe;

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use defmt_decoder::{DecodeError, Table};

use crate::stream::{Message, parse};

/// Pause where there is nothing to read.
const PAUSE: Duration = Duration::from_millis(2);
/// Silence, or noise, after which it is said what may be wrong.
const SILENCE: Duration = Duration::from_secs(5);
const UNREADABLE: &str = "nothing readable has come yet: is the firmware of this image on the board, with the log on this \
                          wire (over a serial port: built with --features serial-log)?";

/// Bytes in and out.
pub trait Wire: Send {
    /// Reads what there is, without waiting long; 0 if there is nothing yet.
    ///
    /// # Errors
    /// The other end is gone.
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize>;

    /// Sends all of it.
    ///
    /// # Errors
    /// The other end is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;
}

/// Reads a firmware's table of log lines.
///
/// # Errors
/// The file cannot be read, or is no image with such a table; what to do.
pub fn table(elf: &Path) -> std::result::Result<Table, String> {
    let named = |what: &dyn std::fmt::Display| {
        format!(
            "{}: {what}; `cargo xtask build` makes an image",
            elf.display()
        )
    };
    let data = std::fs::read(elf).map_err(|error| named(&error))?;
    let table = Table::parse(&data).map_err(|error| named(&error))?;
    table.ok_or_else(|| named(&"no log in this image"))
}

/// Passes messages on and command lines back until one end is gone.
pub fn run(
    mut wire: impl Wire,
    table: &Table,
    messages: &SyncSender<Message>,
    commands: &Receiver<String>,
) {
    if let Err(error) = exchange(&mut wire, table, messages, commands) {
        // Where nobody listens any more nothing needs to be told.
        let _ = messages.send(Message::Note(format!("the source has ended: {error}")));
    }
}

fn exchange(
    wire: &mut impl Wire,
    table: &Table,
    messages: &SyncSender<Message>,
    commands: &Receiver<String>,
) -> Result<()> {
    let mut decoder = table.new_stream_decoder();
    let mut bytes = [0; 1024];
    let mut unheard = Some(Instant::now());
    loop {
        match commands.try_recv() {
            Ok(line) => wire.send(format!("{line}\n").as_bytes())?,
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        let count = wire.receive(&mut bytes)?;
        decoder.received(bytes.get(..count).unwrap_or_default());
        loop {
            let text = match decoder.decode() {
                Ok(frame) => frame.display(false).to_string(),
                Err(DecodeError::UnexpectedEof) => break,
                // The end of a record whose begin came before the connection; the next one is whole.
                Err(DecodeError::Malformed) => continue,
            };
            unheard = None;
            if let Some(message) = parse(&text)
                && messages.send(message).is_err()
            {
                return Ok(());
            }
        }
        if unheard.is_some_and(|since| since.elapsed() > SILENCE) {
            unheard = None;
            let _ = messages.send(Message::Note(UNREADABLE.to_owned()));
        }
        if count == 0 {
            thread::sleep(PAUSE);
        }
    }
}

/// A server of RTT over TCP: the emulator's, OpenOCD's, or a J-Link's.
pub struct Tcp(TcpStream);

impl Tcp {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// Nobody listens there.
    pub fn connect(address: &str) -> Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nonblocking(true)?;
        Ok(Self(stream))
    }
}

impl Wire for Tcp {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        match self.0.read(bytes) {
            Ok(0) => Err(Error::new(
                ErrorKind::UnexpectedEof,
                "the server has hung up",
            )),
            other => or_nothing(other),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        // Some bytes: there is always room.
        self.0.write_all(bytes)
    }
}

/// A serial port, opened with a short limit on each read.
pub struct Serial(pub Box<dyn serialport::SerialPort>);

impl Wire for Serial {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        or_nothing(self.0.read(bytes))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.0.write_all(bytes)
    }
}

/// No bytes yet is no error.
fn or_nothing(read: Result<usize>) -> Result<usize> {
    match read {
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
            ) =>
        {
            Ok(0)
        }
        other => other,
    }
}
