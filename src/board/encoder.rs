//! TIM3 counts the encoder's edges.

use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::pac::TIM3;
use embassy_stm32::pac::timer::vals::FilterValue;
use embassy_stm32::peripherals::{self, PA6, PA7};
use embassy_stm32::timer::qei::{self, Qei};

use palpate::drive::io::EncoderCount;

/// The motor's encoder. Every edge of both channels counts.
pub struct Encoder(Qei<'static, peripherals::TIM3>);

impl Encoder {
    /// Starts counting.
    pub fn new(
        timer: Peri<'static, peripherals::TIM3>,
        a: Peri<'static, PA6>,
        b: Peri<'static, PA7>,
    ) -> Self {
        // The encoder's outputs may be open collectors.
        let config = qei::Config {
            ch1_pull: Pull::Up,
            ch2_pull: Pull::Up,
            ..qei::Config::default()
        };
        let counter = Qei::new(timer, a, b, config);
        // By register: the driver has no input filter. 8 equal samples at 170 MHz / 16: pulses below 0.75 us are ignored. A
        // phase lasts 9.4 us at full motor speed (213,000 edges a second over two phases).
        TIM3.ccmr_input(0).modify(|w| {
            for channel in 0..2 {
                w.set_icf(channel, FilterValue::FDTS_DIV16_N8);
            }
        });
        Self(counter)
    }

    /// Counter now.
    pub fn read(&self) -> EncoderCount {
        EncoderCount(self.0.count())
    }
}
