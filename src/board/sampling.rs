//! ADC1: motor current (PA1) and supply voltage (PC0), converted by hardware in every control period.
//!
//! TIM1's update starts two injected ranks of 16 conversions each. A conversion takes 12.5 + 12.5 cycles of 42.5 MHz,
//! 0.59 us, sixteen of them 9.4 us: the sum is the mean over one PWM period of 10 us. The interrupt follows 18.8 us after
//! the trigger.

use core::mem::forget;

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, SampleTime};
use embassy_stm32::pac::ADC1;
use embassy_stm32::pac::adc::vals::Trovs;
use embassy_stm32::peripherals::{PA1, PC0};
use embassy_stm32::triggers::TIM1_TRGO2;

use palpate::drive::io::AdcCode;

/// OVSR code for 16 conversions a result.
const OVERSAMPLE_16: u8 = 0b011;

/// Powers, calibrates and arms the converter; it waits for TIM1.
pub fn start(
    adc1: Peri<'static, embassy_stm32::peripherals::ADC1>,
    current: Peri<'static, PA1>,
    supply: Peri<'static, PC0>,
) {
    let adc = Adc::new(adc1, AdcConfig::default());
    // The driver cannot oversample injected conversions. The context queue would take each of its partial writes of the
    // sequence for a sequence of its own: off.
    ADC1.cfgr().modify(|w| w.set_jqdis(true));
    ADC1.cfgr2().modify(|w| {
        w.set_jovse(true);
        w.set_ovsr(OVERSAMPLE_16);
        w.set_ovss(0);
        w.set_trovs(Trovs::AUTOMATIC);
    });
    let injected = adc.setup_injected_conversions(
        [
            (current.degrade_adc(), SampleTime::CYCLES12_5),
            (supply.degrade_adc(), SampleTime::CYCLES12_5),
        ],
        TIM1_TRGO2,
        Exten::RISING_EDGE,
        true,
    );
    // Dropping it would stop the converter.
    forget(injected);
}

/// Both sums of the sequence that raised the interrupt: current, supply. Acknowledges it.
pub fn read() -> (AdcCode, AdcCode) {
    ADC1.isr().write(|w| {
        w.set_jeoc(true);
        w.set_jeos(true);
    });
    (
        AdcCode(ADC1.jdr(0).read().jdata()),
        AdcCode(ADC1.jdr(1).read().jdata()),
    )
}

/// The next sequence has finished already.
pub fn pending() -> bool {
    ADC1.isr().read().jeos()
}
