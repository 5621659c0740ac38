//! Command lines in, answers out: over RTT's down channel and over the ST-LINK's serial port, the same text on both.
//!
//! Listening and executing are two tasks: while a command waits for flash or for the serial port, `stop` still arrives
//! and takes effect within two milliseconds. The lines that wait when it comes are dropped.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_time::Duration;
use heapless::Deque;

use palpate::app::command::{Command, CommandError};
use palpate::app::input::Lines;

use super::serial::{Receiver, Sender};
use super::shared::{Shared, Turn};
use super::{log, pace, telemetry};

/// What a line said.
pub type Said = Result<Command, CommandError>;

/// How often both sides are asked for bytes, the serial port for room (eleven bytes take that long), and the queue for lines.
const POLL: Duration = Duration::from_millis(1);
/// Lines waiting for their turn.
const WAITING: usize = 4;

static LINES: Shared<Deque<Said, WAITING>> = Shared::new(Deque::new());
static STOP: AtomicBool = AtomicBool::new(false);
/// Lines ignored since boot because too many waited, or a stop came behind them; wraps.
static IGNORED: AtomicU32 = AtomicU32::new(0);

/// Whether someone asked for a stop since the last call.
pub fn stop_requested() -> bool {
    STOP.swap(false, Ordering::Relaxed)
}

/// Lines ignored since boot because too many waited, or a stop came behind them; wraps.
pub fn ignored() -> u32 {
    IGNORED.load(Ordering::Relaxed)
}

/// The next line.
pub async fn next(turn: &mut Turn) -> Said {
    loop {
        if let Some(said) = LINES.lock(turn, Deque::pop_front) {
            return said;
        }
        pace::after(POLL).await;
    }
}

/// Lines from one sender.
#[derive(Default)]
struct Source {
    lines: Lines,
    #[cfg(feature = "fault-injection")]
    injector: super::inject::Injector,
}

impl Source {
    fn push(&mut self, byte: u8, turn: &mut Turn) {
        let said = self.lines.push(byte);
        #[cfg(feature = "fault-injection")]
        if self.injector.push(byte) {
            return;
        }
        let Some(said) = said else {
            return;
        };
        let stop = said == Ok(Command::Stop);
        if stop {
            STOP.store(true, Ordering::Relaxed);
        }
        let lost = LINES.lock(turn, |lines| {
            // What waits was asked for before the stop: carried out after it, a `run` would start the motor again.
            let dropped = if stop {
                core::mem::take(lines).len()
            } else {
                0
            };
            dropped + usize::from(lines.push_back(said).is_err())
        });
        IGNORED.store(ignored().wrapping_add(lost as u32), Ordering::Relaxed);
    }
}

/// Puts lines together from both sides.
#[embassy_executor::task]
pub async fn listen(mut port: Receiver, mut turn: Turn) {
    let mut rtt = Source::default();
    let mut serial = Source::default();
    loop {
        while let Some(byte) = log::read_byte() {
            rtt.push(byte, &mut turn);
        }
        while let Some(byte) = port.next() {
            serial.push(byte, &mut turn);
        }
        pace::after(POLL).await;
    }
}

/// Says an answer line on both sides.
pub async fn answer(port: &mut Sender, line: &str) {
    telemetry::answer(line);
    for byte in line.bytes().chain(*b"\r\n") {
        while !port.send(byte) {
            pace::after(POLL).await;
        }
    }
}
