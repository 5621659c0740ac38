//! ADC1: motor current (PA1) and supply voltage (PC0), converted by hardware in every control period; beside it ADC2: the
//! sensor of joint 2 (PC1), in a scene that has one.
//!
//! TIM1's update starts two injected ranks of 16 conversions each. A conversion takes 12.5 + 12.5 cycles of 42.5 MHz,
//! 0.59 us, sixteen of them 9.4 us: the sum is the mean over one PWM period of 10 us. The interrupt follows 18.8 us after
//! the trigger. ADC2 takes 64 conversions of its one rank from the same trigger, 37.6 us: the mean of most of a control
//! period, which the interrupt finds finished in the next.

use core::mem::forget;

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, SampleTime};
use embassy_stm32::pac::adc::vals::Trovs;
use embassy_stm32::pac::{self, ADC1, ADC2};
use embassy_stm32::peripherals::{PA1, PC0, PC1};
use embassy_stm32::triggers::TIM1_TRGO2;

use palpate::drive::io::AdcCode;

/// OVSR codes for so many conversions a result.
const OVERSAMPLE_16: u8 = 0b011;
const OVERSAMPLE_64: u8 = 0b101;

/// Powers, calibrates and arms the converter; it waits for TIM1.
pub fn start(
    adc1: Peri<'static, embassy_stm32::peripherals::ADC1>,
    current: Peri<'static, PA1>,
    supply: Peri<'static, PC0>,
) {
    let adc = Adc::new(adc1, AdcConfig::default());
    oversample(ADC1, OVERSAMPLE_16, 0);
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

/// Powers, calibrates and arms the converter of joint 2. Before [`start`]: both share a clock, which must be set while
/// neither is enabled.
// A symbol of its own: its absence shows that a scene without the sensor does not carry this.
#[inline(never)]
pub fn start_joint(
    adc2: Peri<'static, embassy_stm32::peripherals::ADC2>,
    angle: Peri<'static, PC1>,
) {
    let adc = Adc::new(adc2, AdcConfig::default());
    // A sum of 64, divided by four: the scale of a sum of 16.
    oversample(ADC2, OVERSAMPLE_64, 2);
    forget(adc.setup_injected_conversions(
        [(angle.degrade_adc(), SampleTime::CYCLES12_5)],
        TIM1_TRGO2,
        Exten::RISING_EDGE,
        false,
    ));
}

/// Makes every result the sum over several conversions, shifted right: the driver cannot, for injected ones. The context
/// queue would take each of the driver's partial writes of the sequence for a sequence of its own: off.
fn oversample(adc: pac::adc::Adc, ratio: u8, shift: u8) {
    adc.cfgr().modify(|w| w.set_jqdis(true));
    adc.cfgr2().modify(|w| {
        w.set_jovse(true);
        w.set_ovsr(ratio);
        w.set_ovss(shift);
        w.set_trovs(Trovs::AUTOMATIC);
    });
}

/// The last result of joint 2.
pub fn read_joint() -> AdcCode {
    AdcCode(ADC2.jdr(0).read().jdata())
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
