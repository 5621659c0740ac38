//! Command lines in, answers out: over RTT's down channel and over the ST-LINK's serial port, the same text on both.
//!
//! Listening and executing are two tasks: while a command waits for flash or for the serial port, `stop` still arrives
//! and takes effect within a millisecond.

use core::convert::Infallible;
use core::fmt::Write;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_futures::select::{Either, select};
use embassy_stm32::usart::{BufferedUartRx, BufferedUartTx};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Timer};
use embedded_io_async::{Read, Write as _};

use palpate::app::command::{Command, CommandError, Lines};

use super::{log, telemetry};

/// What a line said.
pub type Said = Result<Command, CommandError>;

/// How often RTT, which cannot interrupt, is asked for bytes.
const POLL: Duration = Duration::from_millis(2);
/// Longest answer line; longer ones are cut.
const ANSWER_BYTES: usize = 120;
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
pub async fn listen(mut port: BufferedUartRx<'static>) {
    let mut rtt = Source::default();
    let mut serial = Source::default();
    let mut bytes = [0; 16];
    loop {
        while let Some(byte) = log::read_byte() {
            rtt.push(byte);
        }
        // An error of the port is noise on the line: what it cost is no command.
        if let Either::First(Ok(count)) = select(port.read(&mut bytes), Timer::after(POLL)).await {
            bytes.iter().take(count).for_each(|&byte| serial.push(byte));
        }
    }
}

/// Says answers on both sides.
pub struct Speaker {
    port: BufferedUartTx<'static>,
}

impl Speaker {
    /// Takes the sending half of the port.
    pub fn new(port: BufferedUartTx<'static>) -> Self {
        Self { port }
    }

    /// Says one line.
    pub async fn answer(&mut self, text: core::fmt::Arguments<'_>) {
        let mut line = heapless::String::<ANSWER_BYTES>::new();
        // A line that does not fit is cut.
        let _ = line.write_fmt(text);
        telemetry::answer(&line);
        // The port drains at its own pace, whether someone listens or not: this ends, and it cannot fail.
        let _ = polled(self.port.write_all(line.as_bytes())).await;
        let _ = polled(self.port.write_all(b"\r\n")).await;
    }
}

/// Awaits a write to the serial port, asking again every millisecond: embassy-stm32 0.6.0 leaves no waker behind when its
/// buffer has too little room, so that a write that has to wait would wait for ever.
async fn polled<F: Future>(write: F) -> F::Output {
    match select(write, tick()).await {
        Either::First(output) => output,
        Either::Second(never) => match never {},
    }
}

async fn tick() -> Infallible {
    loop {
        Timer::after(Duration::from_millis(1)).await;
    }
}
