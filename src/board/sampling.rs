//! ADC1: motor current (PA1) and supply voltage (PC0), converted by hardware in every control period; beside it ADC2: the
//! sensor of joint 2 (PC1), in a scene that has one.
//!
//! TIM1's update starts two injected ranks of 16 conversions each. A conversion takes 12.5 + 12.5 cycles of 42.5 MHz,
//! 0.59 us, sixteen of them 9.4 us: the sum is the mean over one PWM period of 10 us. The interrupt follows 18.8 us after
//! the trigger. ADC2 takes 64 conversions of its one rank from the same trigger, 37.6 us: the mean of most of a control
//! period, which the interrupt finds finished in the next.

use cortex_m::asm;
use embassy_stm32::pac::adc::Adc;
use embassy_stm32::pac::adc::regs::Jsqr;
use embassy_stm32::pac::adc::vals::{Exten, SampleTime, Trovs};
use embassy_stm32::pac::adccommon::vals::Presc;
use embassy_stm32::pac::rcc::vals::Adcsel;
use embassy_stm32::pac::{ADC1, ADC2, ADC12_COMMON, RCC};
use embassy_stm32::peripherals::{PA1, PC0, PC1};
use embassy_stm32::{Peri, peripherals};

use palpate::drive::io::AdcCode;

use super::clock;
use super::pins::{self, Use};

/// Inputs of the converters that the pins lead to.
const CURRENT: u8 = 2;
const SUPPLY: u8 = 6;
const ANGLE: u8 = 7;

/// The injected trigger TIM1_TRGO2 (reference manual RM0440, table of the injected channels' triggers).
const TIM1_TRGO2: u8 = 8;

/// OVSR codes for so many conversions a result.
const OVERSAMPLE_16: u8 = 0b011;
const OVERSAMPLE_64: u8 = 0b101;

/// The regulator's start, at most, core clock cycles: 20 us (datasheet).
const REGULATOR_CYCLES: u32 = 20 * 170;
/// From calibration to enabling, core clock cycles: four of the converter.
const CALIBRATED_CYCLES: u32 = 4 * 4;

/// Powers, calibrates and arms the converter; it waits for TIM1.
pub fn start(
    _adc1: Peri<'static, peripherals::ADC1>,
    current: Peri<'static, PA1>,
    supply: Peri<'static, PC0>,
) {
    pins::set_up(current, Use::ANALOG);
    pins::set_up(supply, Use::ANALOG);
    // Of both converters, while neither is enabled: 170 MHz over 4, below their limit of 60 MHz.
    RCC.ccipr().modify(|w| w.set_adc12sel(Adcsel::SYS));
    RCC.ahb2enr().modify(|w| w.set_adc12en(true));
    clock::settle();
    ADC12_COMMON.ccr().write(|w| w.set_presc(Presc::DIV4));

    let mut ranks = Jsqr(0);
    ranks.set_jl(1);
    ranks.set_jsq(0, CURRENT);
    ranks.set_jsq(1, SUPPLY);
    ADC1.ier().write(|w| w.set_jeosie(true));
    arm(ADC1, ranks, OVERSAMPLE_16, 0);
}

/// Powers, calibrates and arms the converter of joint 2. After [`start`], which sets the clock of both.
// A symbol of its own: its absence shows that a scene without the sensor does not carry this.
#[inline(never)]
pub fn start_joint(_adc2: Peri<'static, peripherals::ADC2>, angle: Peri<'static, PC1>) {
    pins::set_up(angle, Use::ANALOG);
    let mut ranks = Jsqr(0);
    ranks.set_jsq(0, ANGLE);
    // A sum of 64, divided by four: the scale of a sum of 16.
    arm(ADC2, ranks, OVERSAMPLE_64, 2);
}

/// Every result is the sum over several conversions, shifted right.
fn arm(adc: Adc, mut ranks: Jsqr, ratio: u8, shift: u8) {
    // Out of deep power-down, then the regulator.
    adc.cr().write(|_| ());
    adc.cr().write(|w| w.set_advregen(true));
    asm::delay(REGULATOR_CYCLES);
    adc.cr().write(|w| {
        w.set_advregen(true);
        w.set_adcal(true);
    });
    while adc.cr().read().adcal() {}
    asm::delay(CALIBRATED_CYCLES);
    adc.cr().write(|w| {
        w.set_advregen(true);
        w.set_aden(true);
    });
    while !adc.isr().read().adrdy() {}

    adc.cfgr2().write(|w| {
        w.set_jovse(true);
        w.set_ovsr(ratio);
        w.set_ovss(shift);
        w.set_trovs(Trovs::AUTOMATIC);
    });
    adc.smpr().write(|w| {
        for input in 0..10 {
            w.set_smp(input, SampleTime::CYCLES12_5);
        }
    });
    ranks.set_jextsel(TIM1_TRGO2);
    ranks.set_jexten(Exten::RISING_EDGE);
    // At once: the queue of sequences is off after a reset.
    adc.jsqr().write_value(ranks);
    adc.cr().write(|w| {
        w.set_advregen(true);
        w.set_aden(true);
        w.set_jadstart(true);
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
