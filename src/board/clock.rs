//! 170 MHz from the board's 24 MHz crystal.

use embassy_stm32::pac::{PWR, RCC};
use embassy_stm32::rcc::mux::Adcsel;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;

/// Clock tree: HSE 24 MHz / 6 x 85 / 2 = 170 MHz to core, buses, timers; boost mode and 4 wait states follow.
pub fn config() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse {
        freq: Hertz(24_000_000),
        mode: HseMode::Oscillator,
    });
    rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    rcc.sys = Sysclk::PLL1_R;
    rcc.boost = true;
    rcc.hsi48 = None;
    // The driver divides it by 4: 42.5 MHz, below the converter's limit of 60 MHz.
    rcc.mux.adc12sel = Adcsel::SYS;
    config
}

/// Boost mode of the core's regulator, which a clock above 150 MHz needs: R1MODE, bit 8 of PWR_CR5, cleared (RM0440).
/// The driver clears bit 0 of that register instead. Call it right after the clock is set up.
pub fn boost() {
    PWR.cr5().modify(|w| w.0 &= !(1 << 8));
}

/// From here on a crystal that stops takes the bridge off through the timer's break and raises the non-maskable
/// interrupt.
pub fn watch_crystal() {
    RCC.cr().modify(|w| w.set_csson(true));
}
