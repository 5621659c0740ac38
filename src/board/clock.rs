//! 170 MHz from the board's 24 MHz crystal, or from the chip's own oscillator where the crystal does not start.

use embassy_stm32::pac::{PWR, RCC};
use embassy_stm32::rcc::{
    self, Hse, HseMode, LsConfig, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, RtcClockSource,
    Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, Peripherals, peripherals};

/// R1MODE in PWR_CR5 (reference manual RM0440); clear is boost mode. The register crate has it at bit 0, and so has the
/// driver's own `boost`.
const NO_BOOST: u32 = 1 << 8;
/// Looks at the crystal, of about ten cycles of 16 MHz each: 10 ms at least. The data sheet (DS12589) has 2 ms typical for
/// its start. All looks must end within 32 ms: when half a turn of the tasks' timer has been counted, setting it up anew for
/// the faster clock leaves its driver out of step.
const CRYSTAL_LOOKS: u32 = 16_000;

/// The crystal, and the internal oscillator, hertz, each with what divides it for the PLL.
const CRYSTAL: (u32, PllPreDiv) = (24_000_000, PllPreDiv::DIV6);
const INTERNAL: (u32, PllPreDiv) = (16_000_000, PllPreDiv::DIV4);
const MULTIPLIER: PllMul = PllMul::MUL85;
const DIVIDER: PllRDiv = PllRDiv::DIV2;

// Limits of the PLL (data sheet DS12589): its input 2.66 to 16 MHz, its oscillator 96 to 344 MHz. The driver would look at them on the
// chip, for 320 bytes (feature `unchecked-overclocking`).
const _: () = {
    let mut sources = [CRYSTAL, INTERNAL].as_slice();
    while let [(source_hz, divider), rest @ ..] = sources {
        let input_hz = *source_hz / (*divider as u32 + 1);
        let oscillator_hz = input_hz * MULTIPLIER as u32;
        assert!(input_hz >= 2_660_000 && input_hz <= 16_000_000);
        assert!(oscillator_hz >= 96_000_000 && oscillator_hz <= 344_000_000);
        assert!(oscillator_hz / (2 * (DIVIDER as u32 + 1)) == 170_000_000);
        sources = rest;
    }
};

/// Where the clock comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The crystal: within 50 ppm.
    Crystal,
    /// The internal oscillator, because the crystal did not start: within 1 % at room temperature.
    Internal,
}

/// Takes the chip over at 16 MHz, as it is after a reset.
pub fn start() -> Peripherals {
    let mut config = embassy_stm32::Config::default();
    config.rcc.ls = low_speed();
    let peripherals = embassy_stm32::init(config);
    // Reset the backup domain: after a short loss of supply it may have missed its own reset and hold random bits (errata ES0431), which can
    // drive 32 kHz out on PA2 in place of the serial port. The driver has just unlocked it, and checks four of its bits alone.
    RCC.bdcr().write(|w| w.set_bdrst(true));
    RCC.bdcr().write(|_| {});
    peripherals
}

/// The internal oscillator of 32 kHz, for the watchdog alone. The driver's default clocks the RTC with it as well, which nobody
/// uses here: then it can run up to twice as fast after a dip of the supply (errata ES0431), and the watchdog with it.
fn low_speed() -> LsConfig {
    LsConfig {
        rtc: RtcClockSource::DISABLE,
        ..LsConfig::new()
    }
}

/// Speeds up: 24 MHz / 6 x 85 / 2 (or 16 MHz / 4 x 85 / 2) = 170 MHz to core, buses and timers, 4 wait states, boost mode.
pub fn speed_up(rcc: &mut Peri<'_, peripherals::RCC>) -> Source {
    // Boost mode must be on before the clock is faster than 150 MHz (RM0440, voltage range 1), and not before `start`, which
    // resets the power control.
    PWR.cr5().modify(|w| w.0 &= !NO_BOOST);
    let source = if crystal_starts() {
        Source::Crystal
    } else {
        Source::Internal
    };
    rcc::reinit(config(source), rcc);
    if source == Source::Crystal {
        // From here on a crystal that stops takes the bridge off through the timer's break and raises the non-maskable
        // interrupt.
        RCC.cr().modify(|w| w.set_csson(true));
    }
    source
}

/// Starts the crystal. The driver would wait for it forever.
fn crystal_starts() -> bool {
    RCC.cr().modify(|w| w.set_hseon(true));
    let starts = (0..CRYSTAL_LOOKS).any(|_| RCC.cr().read().hserdy());
    if !starts {
        RCC.cr().modify(|w| w.set_hseon(false));
    }
    starts
}

fn config(source: Source) -> rcc::Config {
    let (pll_source, (source_hz, prediv)) = match source {
        Source::Crystal => (PllSource::HSE, CRYSTAL),
        Source::Internal => (PllSource::HSI, INTERNAL),
    };
    let mut config = rcc::Config::default();
    config.hse = (source == Source::Crystal).then_some(Hse {
        freq: Hertz(source_hz),
        mode: HseMode::Oscillator,
    });
    config.pll = Some(Pll {
        source: pll_source,
        prediv,
        mul: MULTIPLIER,
        divp: None,
        divq: None,
        divr: Some(DIVIDER),
    });
    config.sys = Sysclk::PLL1_R;
    // Wait states and steps of boost mode; its bit is set above.
    config.boost = true;
    config.hsi48 = None;
    config.ls = low_speed();
    config.mux.adc12sel = rcc::mux::Adcsel::SYS;
    config
}
