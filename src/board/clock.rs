//! 170 MHz from the board's 24 MHz crystal.

use embassy_stm32::Peripherals;
use embassy_stm32::pac::{PWR, RCC};
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;

/// R1MODE in PWR_CR5 (reference manual RM0440); clear is boost mode. The register crate has it at bit 0.
const NO_BOOST: u32 = 1 << 8;

/// Starts the clocks: HSE 24 MHz / 6 x 85 / 2 = 170 MHz to core, buses and timers, 4 wait states, boost mode.
pub fn start() -> Peripherals {
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
    let peripherals = embassy_stm32::init(config);
    // `boost` above writes the wrong bit; before `init` there is no use in the right one, since `init` resets PWR.
    PWR.cr5().modify(|w| w.0 &= !NO_BOOST);
    // From here on a crystal that stops takes the bridge off through the timer's break and raises the non-maskable
    // interrupt.
    RCC.cr().modify(|w| w.set_csson(true));
    peripherals
}

/// To be called when the clock of a peripheral was enabled, before its first register is written: the clock comes two cycles
/// later (reference manual RM0440), and what was written before is lost.
pub fn settle() {
    // A read from the same bus waits for the write before it.
    let _ = RCC.cr().read();
    cortex_m::asm::dsb();
}
