//! TIM3 counts the encoder's edges.

use core::mem::forget;

use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::pac::TIM3;
use embassy_stm32::pac::timer::vals::FilterValue;
use embassy_stm32::peripherals::{PA6, PA7};
use embassy_stm32::timer::qei::{Config, Qei};

use palpate::drive::io::EncoderCount;

/// Starts counting.
pub fn start(
    tim3: Peri<'static, embassy_stm32::peripherals::TIM3>,
    a: Peri<'static, PA6>,
    b: Peri<'static, PA7>,
) {
    let config = Config {
        ch1_pull: Pull::Up,
        ch2_pull: Pull::Up,
        ..Config::default()
    };
    let qei = Qei::new(tim3, a, b, config);
    // 8 equal samples at 170 MHz / 16: pulses below 0.75 us are ignored. A phase lasts 9.4 us at full motor speed
    // (213,000 edges a second over two phases).
    TIM3.ccmr_input(0).modify(|w| {
        w.set_icf(0, FilterValue::FDTS_DIV16_N8);
        w.set_icf(1, FilterValue::FDTS_DIV16_N8);
    });
    forget(qei);
}

/// Counter now.
pub fn read() -> EncoderCount {
    EncoderCount(TIM3.cnt().read().cnt())
}
