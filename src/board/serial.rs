//! The ST-LINK's serial port: LPUART1 on PA2 and PA3, 115200 baud, 8N1.

use embassy_stm32::peripherals::{self, PA2, PA3};
use embassy_stm32::usart::{
    BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx, Config,
};
use embassy_stm32::{Peri, bind_interrupts};
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    LPUART1 => BufferedInterruptHandler<peripherals::LPUART1>;
});

/// Bytes that wait to be sent: a line of an answer, so that most commands do not wait for the port.
pub const SEND_BYTES: usize = 128;
/// Bytes that wait for the console: 11 ms at full speed, longer than it is ever kept from looking (10 ms by a step of a fit on three
/// phalanges), except while flash is written. What finds no room is lost, as on a line without flow control: it spoils a command,
/// which is answered.
const RECEIVE_BYTES: usize = 128;

/// Opens the port: `None` the second time, and otherwise never with this configuration.
pub fn open(
    port: Peri<'static, peripherals::LPUART1>,
    tx: Peri<'static, PA2>,
    rx: Peri<'static, PA3>,
) -> Option<(BufferedUartTx<'static>, BufferedUartRx<'static>)> {
    static SEND: ConstStaticCell<[u8; SEND_BYTES]> = ConstStaticCell::new([0; SEND_BYTES]);
    static RECEIVE: ConstStaticCell<[u8; RECEIVE_BYTES]> = ConstStaticCell::new([0; RECEIVE_BYTES]);
    let mut config = Config::default();
    // Every byte: the driver's own rule, half a buffer or a pause, would let a command wait for the next one.
    config.eager_reads = Some(1);
    // Without an ST-LINK the line would float.
    config.rx_pull = embassy_stm32::gpio::Pull::Up;
    let port = BufferedUart::new(
        port,
        rx,
        tx,
        SEND.try_take()?,
        RECEIVE.try_take()?,
        Interrupts,
        config,
    )
    .ok()?;
    Some(port.split())
}
