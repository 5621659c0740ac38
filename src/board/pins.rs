//! Pins: what each is for, set once; then levels in and out, a register access each.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AnyPin, Pin};
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Idr, Moder, Pupdr};

/// What a pin is for.
#[derive(Clone, Copy)]
pub struct Use {
    mode: Moder,
    pull: Pupdr,
    function: u8,
}

impl Use {
    /// To the converters.
    pub const ANALOG: Self = Self::of(Moder::ANALOG);
    /// A level out. The level is set before: it is low after a reset.
    pub const OUTPUT: Self = Self::of(Moder::OUTPUT);
    /// A level in, pulled by the board.
    pub const INPUT: Self = Self::of(Moder::INPUT);

    /// A peripheral's, by the number of the function in the datasheet's table.
    pub const fn function(number: u8) -> Self {
        let mut function = Self::of(Moder::ALTERNATE);
        function.function = number;
        function
    }

    /// Pulled up by the chip.
    pub const fn pulled_up(mut self) -> Self {
        self.pull = Pupdr::PULL_UP;
        self
    }

    const fn of(mode: Moder) -> Self {
        Self {
            mode,
            pull: Pupdr::FLOATING,
            function: 0,
        }
    }
}

/// Gives the pin its use, for good.
pub fn set_up(pin: Peri<'_, impl Pin>, what: Use) {
    apply(pin.into(), what);
}

/// All pins through the same code.
#[inline(never)]
fn apply(pin: Peri<'_, AnyPin>, what: Use) {
    let (port, pin) = (pin.block(), usize::from(pin.pin()));
    port.afr(pin / 8)
        .modify(|w| w.set_afr(pin % 8, what.function));
    port.pupdr().modify(|w| w.set_pupdr(pin, what.pull));
    port.moder().modify(|w| w.set_moder(pin, what.mode));
}

/// One pin's level through the set/reset register: no read, no lost update of its neighbours.
#[inline(always)]
pub fn write(port: Gpio, pin: usize, high: bool) {
    // The lower half of the register sets, the upper resets.
    let bit = 1 << pin;
    port.bsrr()
        .write(|w| w.0 = if high { bit } else { bit << 16 });
}

/// The level at a pin.
#[inline(always)]
pub fn is_high(port: Gpio, pin: usize) -> bool {
    port.idr().read().idr(pin) == Idr::HIGH
}
