//! TIM3 counts the encoder's edges.

use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue, Sms};
use embassy_stm32::pac::{RCC, TIM3};
use embassy_stm32::peripherals::{PA6, PA7};
use embassy_stm32::{Peri, peripherals};

use palpate::drive::io::EncoderCount;

use super::clock;
use super::pins::{self, Use};

/// TIM3's channels 1 and 2; the encoder's outputs may be open collectors.
const CHANNEL: Use = Use::function(2).pulled_up();

/// Starts counting.
pub fn start(
    _tim3: Peri<'static, peripherals::TIM3>,
    a: Peri<'static, PA6>,
    b: Peri<'static, PA7>,
) {
    pins::set_up(a, CHANNEL);
    pins::set_up(b, CHANNEL);
    RCC.apb1enr1().modify(|w| w.set_tim3en(true));
    clock::settle();
    // 8 equal samples at 170 MHz / 16: pulses below 0.75 us are ignored. A phase lasts 9.4 us at full motor speed
    // (213,000 edges a second over two phases).
    TIM3.ccmr_input(0).write(|w| {
        for channel in 0..2 {
            w.set_ccs(channel, CcmrInputCcs::TI4);
            w.set_icf(channel, FilterValue::FDTS_DIV16_N8);
        }
    });
    TIM3.ccer().write(|w| {
        w.set_cce(0, true);
        w.set_cce(1, true);
    });
    // Every edge of both channels.
    TIM3.smcr().write(|w| w.set_sms(Sms::ENCODER_MODE_3));
    TIM3.arr().write(|w| w.set_arr(u16::MAX));
    TIM3.cr1().write(|w| w.set_cen(true));
}

/// Counter now.
pub fn read() -> EncoderCount {
    EncoderCount(TIM3.cnt().read().cnt())
}
