//! Command lines in, answers out: over RTT's down channel and over the ST-LINK's serial port, the same text on both.
//!
//! Listening and executing are separate tasks: while a command waits for flash or for the serial port, `stop` still arrives
//! and takes effect within two milliseconds, or up to 5 ms later while a step of a fit runs (10 ms on three phalanges). The lines that
//! wait when it comes are dropped.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_stm32::usart::{BufferedUartRx, BufferedUartTx};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Ticker};
use embedded_io_async::{Read, Write};

use palpate::app::console::command::{Command, CommandError};
use palpate::app::console::lines::Lines;
use palpate::app::log::Log;

use super::rtt;
use super::serial::SEND_BYTES;
use super::telemetry::Telemetry;

/// What a line says.
pub type Parsed = Result<Command, CommandError>;

/// How often RTT is asked for bytes: its host writes memory and raises no interrupt.
const POLL: Duration = Duration::from_millis(1);
/// Lines waiting to be carried out.
const WAITING: usize = 4;

static LINES: Channel<ThreadModeRawMutex, Parsed, WAITING> = Channel::new();
static STOP: AtomicBool = AtomicBool::new(false);
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
#[cfg(not(feature = "serial-log"))]
pub fn next(_port: &mut BufferedUartTx<'static>) -> impl Future<Output = Parsed> {
    LINES.receive()
}

/// The next line. Until it comes, the log goes out over the serial port, a buffer at a time, so that a command does not wait
/// longer than for an answer.
#[cfg(feature = "serial-log")]
pub async fn next(port: &mut BufferedUartTx<'static>) -> Parsed {
    loop {
        if let Ok(parsed) = LINES.try_receive() {
            return parsed;
        }
        if !send(port, "").await {
            embassy_time::Timer::after(POLL).await;
        }
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
    fn push(&mut self, byte: u8) {
        let parsed = self.lines.push(byte);
        #[cfg(feature = "fault-injection")]
        if self.injector.push(byte) {
            return;
        }
        let Some(parsed) = parsed else {
            return;
        };
        let mut lost = 0;
        if parsed == Ok(Command::Stop) {
            STOP.store(true, Ordering::Relaxed);
            // What waits was asked for before the stop: carried out after it, a `run` would start the motor again.
            lost += LINES.len();
            LINES.clear();
        }
        lost += usize::from(LINES.try_send(parsed).is_err());
        IGNORED.store(ignored().wrapping_add(lost as u32), Ordering::Relaxed);
    }
}

/// Puts lines together from RTT.
#[embassy_executor::task]
pub async fn listen_rtt() {
    let mut source = Source::default();
    let mut ticker = Ticker::every(POLL);
    loop {
        ticker.next().await;
        while let Some(byte) = rtt::read_byte() {
            source.push(byte);
        }
    }
}

/// Puts lines together from the serial port.
#[embassy_executor::task]
pub async fn listen_serial(mut port: BufferedUartRx<'static>) {
    let mut source = Source::default();
    let mut bytes = [0; 16];
    loop {
        // A framing or noise error spoils a line, which is then answered; the next bytes count again.
        let count = port.read(&mut bytes).await.unwrap_or(0);
        for &byte in bytes.iter().take(count) {
            source.push(byte);
        }
    }
}

/// Says an answer line on both sides.
pub async fn answer(port: &mut BufferedUartTx<'static>, line: &str) {
    Telemetry.answer(line);
    send(port, line).await;
    send(port, "\r\n").await;
}

/// Sends text over the serial port.
#[cfg(not(feature = "serial-log"))]
pub async fn send(port: &mut BufferedUartTx<'static>, text: &str) {
    for chunk in text.as_bytes().chunks(SEND_BYTES) {
        // Into an empty buffer: a write that finds too little room is never woken (embassy-stm32 0.6.0). The port drains
        // whether someone listens or not, and its driver has no other error than a chunk longer than the buffer: it takes all
        // of it or nothing.
        let _ = port.flush().await;
        let _ = port.write(chunk).await;
    }
}

/// Sends a piece of the log instead, which has the same text; false where there is none.
#[cfg(feature = "serial-log")]
pub async fn send(port: &mut BufferedUartTx<'static>, _text: &str) -> bool {
    let chunk = rtt::serial::chunk(SEND_BYTES);
    // The driver would wait for the end of sending nothing.
    if chunk.is_empty() {
        return false;
    }
    // Into an empty buffer, as above.
    let _ = port.flush().await;
    let _ = port.write(chunk).await;
    rtt::serial::sent(chunk.len());
    true
}
