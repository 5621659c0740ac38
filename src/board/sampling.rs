//! ADC1: motor current (PA1) and supply voltage (PC0), converted by hardware in every control period. ADC2: the
//! sensor of joint 2 (PC1), in a scene that has one.
//!
//! TIM1's update, in the middle of the on-time, starts three injected ranks of 8 conversions each: current, current, supply. A
//! conversion takes 12.5 + 12.5 cycles of 42.5 MHz, 0.59 us, eight of them 4.7 us: the current's two sums are the means over both
//! halves of one PWM period of 10 us. Together they are the current, their difference tells its sign
//! ([`palpate::drive::sign`]). The interrupt follows 14.1 us after the trigger. ADC2 takes 64 conversions of its one rank from the
//! same trigger, 37.6 us: the mean of most of a control period, which the interrupt finds finished in the next.

use cortex_m::peripheral::NVIC;
use embassy_stm32::Peri;
use embassy_stm32::adc::{
    Adc, AdcChannel, AdcConfig, AnyAdcChannel, Exten, InjectedAdc, Rovsm, SampleTime, Trovs,
};
use embassy_stm32::pac::{ADC1, ADC2, Interrupt};
use embassy_stm32::peripherals::{self, PA1, PC0, PC1};
use embassy_stm32::triggers::TIM1_TRGO2;

use palpate::drive::io::AdcCode;

/// OVSR codes for so many conversions a result.
const OVERSAMPLE_8: u8 = 0b010;
const OVERSAMPLE_64: u8 = 0b101;

/// The converters, armed: they wait for TIM1. Dropping one of the drivers would stop it.
pub struct Sampling {
    _current_and_supply: InjectedAdc<'static, peripherals::ADC1, 3>,
    _joint: Option<InjectedAdc<'static, peripherals::ADC2, 1>>,
}

impl Sampling {
    /// Powers, calibrates and arms ADC1.
    pub fn new(
        adc: Peri<'static, peripherals::ADC1>,
        current: Peri<'static, PA1>,
        supply: Peri<'static, PC0>,
    ) -> Self {
        let adc = Adc::new(adc, oversampled(OVERSAMPLE_8, 0));
        // By register, here and below: the driver has no oversampling of injected conversions.
        ADC1.cfgr2().modify(|w| w.set_jovse(true));
        // SAFETY: the second handle of the pin goes into the same sequence, which only converts it.
        let again = unsafe { current.clone_unchecked() };
        let ranks = [rank(current), rank(again), rank(supply)];
        let interrupt = true;
        Self {
            _current_and_supply: adc.setup_injected_conversions(
                ranks,
                TIM1_TRGO2,
                Exten::RISING_EDGE,
                interrupt,
            ),
            _joint: None,
        }
    }

    /// Powers, calibrates and arms ADC2 for the sensor of joint 2.
    // A symbol of its own: its absence shows that a scene without the sensor does not carry this.
    #[inline(never)]
    pub fn start_joint(
        &mut self,
        adc: Peri<'static, peripherals::ADC2>,
        angle: Peri<'static, PC1>,
    ) {
        // A sum of 64, divided by four: the scale of a sum of 16.
        let adc = Adc::new(adc, oversampled(OVERSAMPLE_64, 2));
        ADC2.cfgr2().modify(|w| w.set_jovse(true));
        let interrupt = false;
        self._joint = Some(adc.setup_injected_conversions(
            [rank(angle)],
            TIM1_TRGO2,
            Exten::RISING_EDGE,
            interrupt,
        ));
    }
}

/// Every result is the sum over several conversions, shifted right.
fn oversampled(ratio: u8, shift: u8) -> AdcConfig {
    AdcConfig {
        oversampling_ratio: Some(ratio),
        oversampling_shift: Some(shift),
        // Of regular conversions, which there are none of; one trigger starts all conversions of a result.
        oversampling_mode: Some((Rovsm::CONTINUED, Trovs::AUTOMATIC, false)),
        ..AdcConfig::default()
    }
}

fn rank<T>(pin: impl AdcChannel<T> + 'static) -> (AnyAdcChannel<'static, T>, SampleTime)
where
    T: embassy_stm32::adc::Instance,
{
    (pin.degrade_adc(), SampleTime::CYCLES12_5)
}

/// The last result of joint 2. By register, as all that the control interrupt does.
pub fn read_joint() -> u16 {
    ADC2.jdr(0).read().jdata()
}

/// Readings of the sequence that raised the interrupt.
#[derive(Clone, Copy)]
pub struct Readings {
    /// Motor current over a PWM period.
    pub current: AdcCode,
    /// What its second half has more than the first.
    pub late_excess: i16,
    /// Supply.
    pub supply: AdcCode,
}

/// Readings of the sequence that raised the interrupt. Acknowledges it.
pub fn read() -> Readings {
    acknowledge();
    // One by one: of an array the compiler makes a loop.
    let early = ADC1.jdr(0).read().jdata();
    let late = ADC1.jdr(1).read().jdata();
    let supply = ADC1.jdr(2).read().jdata();
    // Eight conversions of 12 bits: no sum overflows.
    Readings {
        current: AdcCode(early.wrapping_add(late)),
        late_excess: late.wrapping_sub(early).cast_signed(),
        supply: AdcCode(supply.wrapping_mul(2)),
    }
}

/// Drops a sequence that has finished while nobody looked.
pub fn drop_pending() {
    acknowledge();
    // The write is buffered: read the converter, or its line still stands and pends the interrupt again.
    let _ = ADC1.isr().read();
    NVIC::unpend(Interrupt::ADC1_2);
}

/// Clears the flags of a finished sequence.
// Part of the control interrupt, which calls nothing in flash.
#[inline(always)]
fn acknowledge() {
    ADC1.isr().write(|w| {
        w.set_jeoc(true);
        w.set_jeos(true);
    });
}

/// The next sequence has finished already.
pub fn pending() -> bool {
    ADC1.isr().read().jeos()
}
