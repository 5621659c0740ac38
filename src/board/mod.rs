//! The chip: what moves bits between registers and the library.

mod bridge;
mod clock;
mod control;
mod encoder;
mod log;
mod sampling;

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_executor::Spawner;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_time::{Duration, Ticker};

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(clock::config());
    interrupt::TIM2.set_priority(Priority::P8);
    defmt::info!("boot");

    let bridge = bridge::Bridge::new(
        p.TIM1,
        bridge::Pins {
            enable: p.PA8,
            phase: p.PA9,
            sleep: p.PB5,
            fault: p.PB10,
        },
    );
    encoder::start(p.TIM3, p.PA6, p.PA7);
    sampling::start(p.ADC1, p.PA1, p.PC0);
    control::start(bridge);

    let mut led = Output::new(p.PA5, Level::Low, Speed::Low);
    let button = Input::new(p.PC13, Pull::Down);
    let mut ticker = Ticker::every(Duration::from_millis(100));
    loop {
        ticker.next().await;
        led.toggle();
        defmt::info!(
            "alive periods={=u32} button={=bool} command_byte={} dropped={=u32}",
            control::periods(),
            button.is_high(),
            log::read_byte(),
            log::dropped()
        );
    }
}

#[panic_handler]
fn panic(_info: &PanicInfo) -> ! {
    bridge::off();
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    bridge::off();
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn DefaultHandler(_irqn: i16) {
    bridge::off();
    cortex_m::peripheral::SCB::sys_reset()
}
