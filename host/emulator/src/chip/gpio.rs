// SPDX-License-Identifier: GPL-2.0-only
//! One GPIO port: modes, outputs, and inputs driven from outside or pulled.

use super::bank::{Bank, Misuse, Register};

const MODER: u32 = 0x00;
const PUPDR: u32 = 0x0C;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const AFRL: u32 = 0x20;
const AFRH: u32 = 0x24;
const BRR: u32 = 0x28;

macro_rules! port {
    ($moder:expr, $ospeedr:expr, $pupdr:expr) => {
        &[
            (MODER, "MODER", $moder),
            (0x04, "OTYPER", 0),
            (0x08, "OSPEEDR", $ospeedr),
            (PUPDR, "PUPDR", $pupdr),
            (IDR, "IDR", 0),
            (ODR, "ODR", 0),
            (BSRR, "BSRR", 0),
            (0x1C, "LCKR", 0),
            (AFRL, "AFRL", 0),
            (AFRH, "AFRH", 0),
            (BRR, "BRR", 0),
        ]
    };
}
const PORT_A: &[Register] = port!(0xABFF_FFFF, 0x0C00_0000, 0x6400_0000);
const PORT_B: &[Register] = port!(0xFFFF_FEBF, 0x0000_00C0, 0x0000_0100);
pub(super) const PORT: &[Register] = port!(0xFFFF_FFFF, 0, 0);
pub(crate) const NAMES: [&str; 7] = [
    "GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE", "GPIOF", "GPIOG",
];

/// Mode of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Input,
    Output,
    Alternate(u8),
    Analog,
}

#[derive(Debug)]
pub(crate) struct Gpio {
    bank: Bank,
    /// Pins that are driven from outside, with their levels.
    driven: u16,
    level: u16,
}

impl Gpio {
    pub(crate) fn new(port: usize) -> Self {
        let registers = match port {
            0 => PORT_A,
            1 => PORT_B,
            _ => PORT,
        };
        Self {
            bank: Bank::new(NAMES[port], registers),
            driven: 0,
            level: 0,
        }
    }

    /// Resets the port; levels from outside stay.
    pub(crate) fn reset(&mut self) {
        self.bank.reset();
    }

    /// Drives a pin from outside, or lets it float (`None`).
    pub(crate) fn drive(&mut self, pin: u8, level: Option<bool>) {
        let bit = 1 << pin;
        self.driven = if level.is_some() {
            self.driven | bit
        } else {
            self.driven & !bit
        };
        self.level = if level == Some(true) {
            self.level | bit
        } else {
            self.level & !bit
        };
    }

    pub(crate) fn mode(&self, pin: u8) -> Mode {
        match self.bank[MODER] >> (2 * pin) & 3 {
            0 => Mode::Input,
            1 => Mode::Output,
            2 => {
                let register = if pin < 8 { AFRL } else { AFRH };
                Mode::Alternate((self.bank[register] >> (4 * (pin % 8)) & 0xF) as u8)
            }
            _ => Mode::Analog,
        }
    }

    /// Input level of a pin; analogue pins read low.
    pub(crate) fn input(&self, pin: u8) -> bool {
        let bit = 1u16 << pin;
        match self.mode(pin) {
            Mode::Analog => false,
            Mode::Output => self.bank[ODR] as u16 & bit != 0,
            _ if self.driven & bit != 0 => self.level & bit != 0,
            _ => self.bank[PUPDR] >> (2 * pin) & 3 == 1,
        }
    }

    /// [`Gpio::input`] of all pins at once, a bit each.
    fn inputs(&self) -> u32 {
        let mode = self.bank[MODER];
        let (low, high) = (even_bits(mode), even_bits(mode >> 1));
        let (output, analog) = (low & !high, low & high);
        let pull = self.bank[PUPDR];
        let up = even_bits(pull) & !even_bits(pull >> 1);
        let driven = u32::from(self.driven);
        let outside = u32::from(self.level) & driven | up & !driven;
        (self.bank[ODR] & output | outside & !output) & !analog & 0xFFFF
    }

    /// Level of a general-purpose output; low if the pin is none.
    pub(crate) fn output(&self, pin: u8) -> bool {
        self.mode(pin) == Mode::Output && self.bank[ODR] >> pin & 1 != 0
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        match offset {
            IDR => Ok(self.inputs()),
            BSRR | BRR => Ok(0),
            _ => self.bank.read(offset),
        }
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        match offset {
            IDR => {}
            BSRR => self.bank[ODR] = self.bank[ODR] & !(value >> 16) | value & 0xFFFF,
            BRR => self.bank[ODR] &= !(value & 0xFFFF),
            _ => self.bank.write(offset, value)?,
        }
        Ok(())
    }
}

/// Packs bits 0, 2, 4 to 30.
fn even_bits(word: u32) -> u32 {
    let mut bits = word & 0x5555_5555;
    bits = (bits | bits >> 1) & 0x3333_3333;
    bits = (bits | bits >> 2) & 0x0F0F_0F0F;
    bits = (bits | bits >> 4) & 0x00FF_00FF;
    (bits | bits >> 8) & 0xFFFF
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_follows_its_driver_or_its_pull() {
        let mut port = Gpio::new(2);
        assert_eq!(port.mode(13), Mode::Analog);
        port.write(MODER, !(3 << 26)).unwrap();
        port.write(PUPDR, 1 << 26).unwrap();
        assert_eq!(port.read(IDR), Ok(1 << 13));
        port.drive(13, Some(false));
        assert_eq!(port.read(IDR), Ok(0));
        port.drive(13, None);
        assert!(port.input(13));
    }

    #[test]
    fn all_inputs_at_once_are_those_of_the_pins() {
        let mut port = Gpio::new(2);
        let mut random = 1u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            random
        };
        for _ in 0..200 {
            for register in [MODER, PUPDR, ODR] {
                port.write(register, next()).unwrap();
            }
            let pin = (next() >> 28) as u8;
            port.drive(
                pin,
                [None, Some(false), Some(true)][(next() >> 8) as usize % 3],
            );
            let each = (0..16).map(|pin| u32::from(port.input(pin)) << pin).sum();
            assert_eq!(port.read(IDR), Ok(each));
        }
    }

    #[test]
    fn set_wins_over_reset() {
        let mut port = Gpio::new(1);
        port.write(MODER, 1 << 10).unwrap();
        port.write(BSRR, 1 << 5 | 1 << 21).unwrap();
        assert!(port.output(5));
        port.write(BRR, 1 << 5).unwrap();
        assert!(!port.output(5));
    }
}
