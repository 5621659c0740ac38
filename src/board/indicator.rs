//! The board's button and LED.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{PA5, PC13};

use palpate::drive::sequence::State;

/// The user button (PC13, high when pressed), debounced.
pub struct Button {
    pin: Input<'static>,
    /// Last samples, one a millisecond, newest in bit 0.
    history: u32,
}

impl Button {
    /// Takes the pin. The chip pulls it down as well as the board, whose solder bridge may be open.
    pub fn new(pin: Peri<'static, PC13>) -> Self {
        Self {
            pin: Input::new(pin, Pull::Down),
            // Rest must be seen first: a button held through a reset is no press.
            history: u32::MAX,
        }
    }

    /// Call once a millisecond: true once a press, when it has lasted 16 ms after 15 ms of rest.
    pub fn pressed(&mut self) -> bool {
        self.history = self.history << 1 | u32::from(self.pin.is_high());
        self.history == 0x0000_FFFF
    }
}

/// The LED (PA5): dark while the bridge is off, lit while it is not, blinking after a fault.
pub struct Led {
    pin: Output<'static>,
    state: State,
    ticks: u32,
}

impl Led {
    /// Half a blink, milliseconds.
    const BLINK: u32 = 125;

    /// Takes the pin.
    pub fn new(pin: Peri<'static, PA5>) -> Self {
        Self {
            pin: Output::new(pin, Level::Low, Speed::Low),
            state: State::Idle,
            ticks: 0,
        }
    }

    /// Shows a state from now on.
    pub fn show(&mut self, state: State) {
        self.state = state;
    }

    /// Call once a millisecond, with whether the motor is driven: a self-test drives it in the state of rest.
    pub fn tick(&mut self, driven: bool) {
        self.ticks = self.ticks.wrapping_add(1);
        let lit = match self.state {
            State::Idle => driven,
            State::Fault => (self.ticks / Self::BLINK).is_multiple_of(2),
            _ => true,
        };
        self.pin.set_level(lit.into());
    }
}
