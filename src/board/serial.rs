//! The ST-LINK's serial port: LPUART1 on PA2 and PA3, 115200 baud, 8N1.
//!
//! Bytes that come are fetched by interrupt and wait in a queue. Bytes that go are handed to the port's own FIFO, whenever
//! the sender looks: nothing of that needs a buffer, an interrupt or a waker.

use core::cell::Cell;

use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::{LPUART1 as PORT, RCC};
use embassy_stm32::peripherals::{PA2, PA3};
use embassy_stm32::{Peri, peripherals};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::StaticCell;

use super::clock;
use super::pins::{self, Use};

/// Baud rate divider: 256 clocks of 170 MHz over 115200 baud, 377,777.8 rounded.
const DIVIDER: u32 = 377_778;
/// LPUART1 on both pins.
const FUNCTION: Use = Use::function(12);
/// Bytes that wait for the command task: 5 ms at full speed, longer than it is ever kept from looking, but for writing flash.
const WAITING: usize = 64;

/// The interrupt's end of the queue; taken out while it is used.
static RECEIVED: Mutex<CriticalSectionRawMutex, Cell<Option<Producer<'static, u8>>>> =
    Mutex::new(Cell::new(None));

/// The receiving half.
pub struct Receiver {
    queue: Consumer<'static, u8>,
}

impl Receiver {
    /// The oldest byte that has come, if there is one.
    pub fn next(&mut self) -> Option<u8> {
        self.queue.dequeue()
    }
}

/// The sending half.
pub struct Sender(());

impl Sender {
    /// Sends a byte; false, and nothing sent, while the FIFO is full. It drains at its own pace, whether someone listens or
    /// not.
    pub fn send(&mut self, byte: u8) -> bool {
        let room = PORT.isr().read().txe();
        if room {
            PORT.tdr().write(|w| w.set_dr(byte.into()));
        }
        room
    }
}

/// Opens the port, once.
pub fn open(
    _lpuart1: Peri<'static, peripherals::LPUART1>,
    tx: Peri<'static, PA2>,
    rx: Peri<'static, PA3>,
) -> Option<(Sender, Receiver)> {
    static QUEUE: StaticCell<Queue<u8, WAITING>> = StaticCell::new();
    let (received, queue) = QUEUE.try_init(Queue::new())?.split();
    RECEIVED.lock(|cell| cell.set(Some(received)));
    pins::set_up(tx, FUNCTION);
    // Without an ST-LINK the line would float.
    pins::set_up(rx, FUNCTION.pulled_up());
    RCC.apb1enr2().modify(|w| w.set_lpuart1en(true));
    clock::settle();
    PORT.brr().write(|w| w.0 = DIVIDER);
    PORT.cr1().write(|w| {
        w.set_fifoen(true);
        w.set_te(true);
        w.set_re(true);
        w.set_rxneie(true);
    });
    PORT.cr1().modify(|w| w.set_ue(true));
    interrupt::LPUART1.set_priority(Priority::P10);
    // SAFETY: what the handler needs is in place.
    unsafe { interrupt::LPUART1.enable() };
    Some((Sender(()), Receiver { queue }))
}

#[interrupt]
fn LPUART1() {
    let Some(mut received) = RECEIVED.lock(Cell::take) else {
        return;
    };
    while PORT.isr().read().rxne() {
        // What finds no room is lost, as on a line without flow control: it spoils a command, which is answered.
        let _ = received.enqueue(PORT.rdr().read().dr() as u8);
    }
    RECEIVED.lock(|cell| cell.set(Some(received)));
    // An overrun would raise the interrupt again and again; noise and framing errors are what the parser is there for.
    PORT.icr().write(|w| w.set_ore(true));
}
