//! The ST-LINK's serial port: LPUART1 on PA2 and PA3, 115200 baud, 8N1.

use embassy_stm32::peripherals::{LPUART1, PA2, PA3};
use embassy_stm32::usart::{BufferedInterruptHandler, BufferedUart, Config};
use embassy_stm32::{Peri, bind_interrupts};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    LPUART1 => BufferedInterruptHandler<LPUART1>;
});

const TX_BYTES: usize = 128;
const RX_BYTES: usize = 64;

/// Opens the port.
pub fn open(
    lpuart1: Peri<'static, LPUART1>,
    tx: Peri<'static, PA2>,
    rx: Peri<'static, PA3>,
) -> BufferedUart<'static> {
    static TX: StaticCell<[u8; TX_BYTES]> = StaticCell::new();
    static RX: StaticCell<[u8; RX_BYTES]> = StaticCell::new();
    // 115200 baud divides 170 MHz within the register's range: the one way this can fail.
    BufferedUart::new(
        lpuart1,
        rx,
        tx,
        TX.init([0; TX_BYTES]),
        RX.init([0; RX_BYTES]),
        Irqs,
        Config::default(),
    )
    .expect("115200 baud from 170 MHz")
}
