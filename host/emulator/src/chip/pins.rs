// SPDX-License-Identifier: GPL-2.0-only
//! Pins: outputs to the bridge, inputs to the chip.

use palpate_plant::Pins;

use super::gpio::Mode;
use super::{Chip, simple};
use crate::time::Ticks;

/// Pins of the board, as (port, pin).
const EN: (usize, u8) = (0, 8);
const PH: (usize, u8) = (0, 9);
const NSLEEP: (usize, u8) = (1, 5);
const NFAULT: (usize, u8) = (1, 10);
/// The user button, high when pressed.
pub(super) const BUTTON: (usize, u8) = (2, 13);
const PHASES: [(usize, u8); 2] = [(0, 6), (0, 7)];

impl Chip {
    /// Presses or releases the user button, high when pressed.
    pub(crate) fn button(&mut self, pressed: bool) {
        self.ports[BUTTON.0].drive(BUTTON.1, Some(pressed));
        self.sense_pins();
        self.update_lines();
    }

    /// The core has locked up.
    pub(crate) fn lock_up(&mut self) {
        self.core.locked_up = true;
        self.apply_system_break();
        self.reschedule();
    }

    /// What SYSCFG connects to the timers' breaks: a locked-up core, a double error of the flash.
    pub(super) fn apply_system_break(&mut self) {
        let connected = self.syscfg.bank[simple::SYSCFG_CFGR2];
        self.tim1.system_break = connected & 1 != 0 && self.core.locked_up
            || connected & 8 != 0 && self.flash.double_error();
        self.tim1.apply_break();
        self.apply_pins();
    }

    /// Pulls nFAULT low for a moment.
    pub(crate) fn pulse_fault_pin(&mut self, length: Ticks) {
        self.sync_world();
        if self.ports[NFAULT.0].mode(NFAULT.1) == Mode::Alternate(12) {
            self.tim1.pulse_break_pin(length, self.clocks());
        }
        self.apply_pins();
        self.update_lines();
    }

    /// Locks the core up; only a reset starts it again.
    #[must_use]
    pub fn locked_up(&self) -> bool {
        self.core.locked_up
    }

    /// Main output enable of the bridge's timer.
    #[must_use]
    pub fn bridge_enabled(&self) -> bool {
        self.tim1.main_output()
    }

    /// Whether PA2 carries the oscillator of 32 kHz instead of the serial port's answers.
    #[must_use]
    pub fn serial_port_is_taken(&self) -> bool {
        self.rcc.drives_low_speed()
    }

    /// Updates the bridge's inputs and the break input from the pins.
    pub(super) fn apply_pins(&mut self) {
        let (port, number) = NFAULT;
        let low = self.world.fault_low();
        let driven = if self.fault_pin_held_high {
            Some(true)
        } else {
            low.then_some(false)
        };
        self.ports[port].drive(number, driven);
        let connected = self.ports[port].mode(number) == Mode::Alternate(12);
        let level = self.ports[port].input(number);
        self.tim1.set_break_pin(connected.then_some(level));
        let (port, number) = EN;
        let enable = match self.ports[port].mode(number) {
            Mode::Alternate(6) => self.tim1.duty(),
            Mode::Output => Some(f64::from(u8::from(self.ports[port].output(number)))),
            _ => None,
        };
        let pins = Pins {
            outputs_enabled: enable.is_some(),
            awake: self.ports[NSLEEP.0].output(NSLEEP.1),
            duty: enable.unwrap_or(0.0),
            closing: self.ports[PH.0].output(PH.1),
        };
        self.world.set_pins(pins, self.now);
    }

    /// Passes input levels to the edge detectors.
    pub(super) fn sense_pins(&mut self) {
        if !self.exti.armed() {
            self.exti.ignore();
            return;
        }
        let mut levels = 0;
        for line in 0..16u8 {
            let select = self.syscfg.bank[simple::SYSCFG_EXTICR1 + 4 * u32::from(line / 4)];
            let port = (select >> (4 * (line % 4)) & 0xF) as usize;
            let high = self.ports.get(port).is_some_and(|port| port.input(line));
            levels |= u16::from(high) << line;
        }
        self.exti.sense(levels);
    }

    /// To be called after a wire was changed from outside.
    pub(crate) fn rewired(&mut self) {
        self.sync_world();
        self.apply_pins();
        self.sense_pins();
        self.update_lines();
        self.reschedule();
    }

    /// Whether the encoder's pins are connected to the timer.
    #[must_use]
    pub(super) fn encoder_connected(&self) -> bool {
        PHASES
            .iter()
            .all(|&(port, number)| self.ports[port].mode(number) == Mode::Alternate(2))
    }
}
