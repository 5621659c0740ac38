//! Command lines in, answers out: over RTT's down channel and over the ST-LINK's serial port, the same text on both.
//!
//! Listening and executing are two tasks: while a command waits for flash or for the serial port, `stop` still arrives
//! and takes effect within two milliseconds.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Timer};

use palpate::app::command::{Command, CommandError, Lines};

use super::serial::{Receiver, Sender};
use super::{log, telemetry};

/// What a line said.
pub type Said = Result<Command, CommandError>;

/// How often both sides are asked for bytes, and the serial port for room: eleven bytes take that long.
const POLL: Duration = Duration::from_millis(1);
/// Lines waiting for their turn.
const WAITING: usize = 4;

static LINES: Channel<ThreadModeRawMutex, Said, WAITING> = Channel::new();
static STOP: AtomicBool = AtomicBool::new(false);
/// Lines ignored since boot because too many waited; wraps.
static IGNORED: AtomicU32 = AtomicU32::new(0);

/// Whether someone asked for a stop since the last call.
pub fn stop_requested() -> bool {
    STOP.swap(false, Ordering::Relaxed)
}

/// Lines ignored since boot because too many waited; wraps.
pub fn ignored() -> u32 {
    IGNORED.load(Ordering::Relaxed)
}

/// The next line.
pub async fn next() -> Said {
    LINES.receive().await
}

/// Lines from one sender.
#[derive(Default)]
struct Source {
    lines: Lines,
    #[cfg(feature = "fault-injection")]
    injector: super::inject::Injector,
}

impl Source {
    fn push(&mut self, byte: u8) {
        let said = self.lines.push(byte);
        #[cfg(feature = "fault-injection")]
        if self.injector.push(byte) {
            return;
        }
        let Some(said) = said else {
            return;
        };
        if said == Ok(Command::Stop) {
            STOP.store(true, Ordering::Relaxed);
        }
        if LINES.try_send(said).is_err() {
            IGNORED.store(ignored().wrapping_add(1), Ordering::Relaxed);
        }
    }
}

/// Puts lines together from both sides.
#[embassy_executor::task]
pub async fn listen(mut port: Receiver) {
    let mut rtt = Source::default();
    let mut serial = Source::default();
    loop {
        while let Some(byte) = log::read_byte() {
            rtt.push(byte);
        }
        while let Some(byte) = port.next() {
            serial.push(byte);
        }
        Timer::after(POLL).await;
    }
}

/// Says an answer line on both sides.
pub async fn answer(port: &mut Sender, line: &str) {
    telemetry::answer(line);
    for byte in line.bytes().chain(*b"\r\n") {
        while !port.send(byte) {
            Timer::after(POLL).await;
        }
    }
}
