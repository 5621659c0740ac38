// SPDX-License-Identifier: GPL-2.0-only
//! Loads and stores of the core: selects the peripheral and applies side effects on others.

use super::map::{self, Device};
use super::{Chip, ENCODER, Misuse, pwr, tim1};
use crate::cortex::nvic::exception;
use crate::time::{TICKS_PER_US, Ticks};

/// Time for which a fault handler may access peripherals without a clock.
const PATIENCE: Ticks = 1000 * TICKS_PER_US;
impl Chip {
    /// Period of the ADC's clock; `None` while it has none.
    pub(super) fn adc_clock(&self) -> Option<Ticks> {
        let control = self.adc_common[map::ADC_CCR];
        match control >> 16 & 3 {
            0 if self.rcc.adc_from_system_clock() => {
                const PRESCALER: [u64; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
                PRESCALER
                    .get((control >> 18 & 0xF) as usize)
                    .map(|p| p * self.rcc.bus)
            }
            0 => None,
            mode => Some(self.rcc.bus << (mode - 1)),
        }
    }

    /// A load of the core from the peripheral space.
    pub(crate) fn read(&mut self, address: u32, size: usize) -> Result<u32, Misuse> {
        let word = self.read_word(address & !3)?;
        let shifted = word >> (8 * (address & 3));
        Ok(if size >= 4 {
            shifted
        } else {
            shifted & ((1 << (8 * size)) - 1)
        })
    }

    fn read_word(&mut self, address: u32) -> Result<u32, Misuse> {
        let Some((device, offset)) = self.clocked(address)? else {
            return Ok(0);
        };
        let clocks = self.clocks();
        match device {
            Device::Rcc => self.rcc.read(offset),
            Device::Pwr => self.pwr.read(offset),
            Device::Flash => self.flash.read(offset, self.now),
            Device::Gpio(port) => self.ports[port].read(offset),
            Device::Exti => self.exti.read(offset),
            Device::Syscfg => self.syscfg.read(offset),
            Device::Dbgmcu => self.dbgmcu.read(offset),
            Device::Dma(n) => self.dma[n].read(offset),
            Device::Tim1 => self.tim1.read(offset, clocks),
            Device::Timer(n) => {
                if n == ENCODER && self.encoder_connected() {
                    self.timers[n].edges = self.world.edges();
                }
                let value = self.timers[n].read(offset, clocks);
                if !self.timers[n].keeps_event() {
                    self.timers_next = None;
                }
                value
            }
            Device::Adc(n) => self.adc[n].read(offset),
            Device::AdcCommon => self.adc_common.read(offset),
            Device::Uart(n) => {
                let value = self.uarts[n].read(offset);
                self.update_line(device);
                value
            }
            Device::Iwdg => self.iwdg.read(offset),
            Device::Cordic => self.cordic.read(offset),
        }
    }

    /// A store of the core into the peripheral space.
    pub(crate) fn write(&mut self, address: u32, size: usize, value: u32) -> Result<(), Misuse> {
        let Some((device, offset)) = self.clocked(address & !3)? else {
            return Ok(());
        };
        // Timers accept 16-bit accesses, data registers of serial ports accept bytes.
        let narrow = match device {
            Device::Tim1 | Device::Timer(_) => size == 2,
            Device::Uart(_) => true,
            _ => false,
        } && address.is_multiple_of(4);
        if size != 4 && !narrow {
            return Err(Misuse::Width {
                peripheral: device.name(),
                offset: offset | address & 3,
                size,
            });
        }
        let clocks = self.clocks();
        match device {
            Device::Rcc => {
                // A store here may change their clock or reset them.
                self.timers_next = None;
                if let Some((register, bits)) = self.rcc.write(offset, value)? {
                    self.reset_devices(register, bits);
                }
                self.check_wait_states()?;
                self.check_boost()?;
            }
            Device::Pwr => {
                self.pwr.write(offset, value)?;
                self.check_boost()?;
            }
            Device::Flash => {
                let stall = self.flash.write(offset, value, self.now)?;
                self.stall(stall);
            }
            Device::Gpio(port) => self.ports[port].write(offset, value)?,
            Device::Exti => self.exti.write(offset, value)?,
            Device::Syscfg => self.syscfg.write(offset, value)?,
            Device::Dbgmcu => self.dbgmcu.write(offset, value)?,
            Device::Dma(n) => self.dma[n].write(offset, value)?,
            Device::Tim1 => {
                if self.tim1.write(offset, value, clocks)? {
                    self.trigger_adc();
                }
            }
            Device::Timer(n) => {
                if n == ENCODER && self.encoder_connected() {
                    self.timers[n].edges = self.world.edges();
                }
                self.timers_next = None;
                self.timers[n].write(offset, value, clocks)?;
            }
            Device::Adc(n) => {
                let Some(clock) = self.adc_clock() else {
                    return Err(Misuse::Unclocked {
                        peripheral: "ADC12",
                        register: "(any)",
                        enable: "CCIPR.ADC12SEL",
                    });
                };
                self.adc[n].write(offset, value, clocks, clock)?;
            }
            Device::AdcCommon => self.adc_common.write(offset, value)?,
            Device::Uart(n) => self.uarts[n].write(offset, value, clocks)?,
            Device::Iwdg => self.iwdg.write(offset, value, self.now)?,
            Device::Cordic => self.cordic.write(offset, value)?,
        }
        self.follow(device, offset);
        Ok(())
    }

    /// Applies side effects of a store: pins, interrupt lines, time of the next event.
    fn follow(&mut self, device: Device, offset: u32) {
        if matches!(
            device,
            Device::Gpio(_) | Device::Syscfg | Device::Rcc | Device::Exti
        ) {
            self.sense_pins();
        }
        let moves_pins = match device {
            Device::Gpio(_) | Device::Rcc => true,
            // The control interrupt's new duty comes with the next update event.
            Device::Tim1 => !self.tim1.buffers(offset),
            _ => false,
        };
        if moves_pins {
            self.apply_pins();
        }
        if matches!(device, Device::Flash | Device::Syscfg) {
            self.apply_system_break();
        }
        self.update_line(device);
        // Most stores of the control interrupt change no event: compare values, pins, the break register.
        let untimed = match device {
            Device::Gpio(_) | Device::Syscfg | Device::Exti => true,
            Device::Tim1 => !tim1::moves_events(offset),
            _ => false,
        };
        if !untimed {
            self.reschedule();
        }
    }

    /// A store of the core into the flash's own addresses.
    pub(crate) fn store_flash(&mut self, offset: u32, size: usize, value: u32) {
        let stall = self.flash.store(offset, size, value, self.now);
        self.stall(stall);
        self.update_line(Device::Flash);
        self.reschedule();
    }

    /// A load of the core from the flash pages that hold records.
    pub(crate) fn load_flash(&mut self, offset: u32) {
        if self.flash.load(offset) {
            self.core.nvic.set_pending(exception::NMI, true);
            self.apply_system_break();
        }
    }

    /// The core cannot fetch from flash while it is programmed or erased.
    fn stall(&mut self, ticks: Ticks) {
        self.now += ticks;
    }

    /// The peripheral at an address; `None` if its clock is off, so that it reads as zero and ignores writes.
    fn clocked(&mut self, address: u32) -> Result<Option<(Device, u32)>, Misuse> {
        match self.locate(address) {
            Err(misuse @ Misuse::Unclocked { .. }) => {
                self.unclocked.get_or_insert((misuse, self.now));
                Ok(None)
            }
            found => found.map(Some),
        }
    }

    /// Reports misuse that was tolerated for a while, once its time is over.
    pub(super) fn check_patience(&mut self) {
        if let Some((misuse, since)) = &self.unclocked
            && self.now > since + PATIENCE
        {
            self.core
                .trap
                .get_or_insert(crate::cortex::Trap::Misuse(misuse.clone()));
        }
    }

    fn locate(&self, address: u32) -> Result<(Device, u32), Misuse> {
        let (base, device, gate) = map::locate(address).ok_or(Misuse::NoPeripheral { address })?;
        let offset = address - base;
        if let Some(gate) = gate
            && !self.rcc.enabled(gate)
        {
            return Err(Misuse::Unclocked {
                peripheral: device.name(),
                register: map::register_name(device, offset),
                enable: self.rcc.name(gate.0),
            });
        }
        Ok((device, offset))
    }

    /// Checks that the wait states suffice for the clock.
    fn check_wait_states(&self) -> Result<(), Misuse> {
        let hertz = self.bus_hertz();
        if hertz > 34_000_000 * (u64::from(self.flash.latency()) + 1) {
            let what = "more flash wait states are needed (FLASH.ACR.LATENCY)";
            return Err(Misuse::Unsupported {
                peripheral: "RCC",
                register: "CFGR",
                value: hertz as u32,
                what,
            });
        }
        Ok(())
    }

    fn bus_hertz(&self) -> u64 {
        crate::time::TICKS_PER_S / self.rcc.bus
    }

    /// Above 150 MHz the core needs boost mode, from the first cycle on.
    fn check_boost(&self) -> Result<(), Misuse> {
        if self.bus_hertz() > 150_000_000 && !self.pwr.boost() {
            let what = "above 150 MHz the core needs boost mode (bit 8, R1MODE, = 0)";
            return Err(Misuse::Unsupported {
                peripheral: "PWR",
                register: "CR5",
                value: 0x100,
                what,
            });
        }
        Ok(())
    }

    fn reset_devices(&mut self, register: u32, bits: u32) {
        for &(_, device, gate) in map::DEVICES {
            let Some((at, bit)) = gate else { continue };
            if at != register || bits >> bit & 1 == 0 {
                continue;
            }
            match device {
                Device::Gpio(port) => self.ports[port].reset(),
                Device::Tim1 => self.tim1.reset(),
                Device::Timer(n) => self.timers[n].reset(),
                Device::Adc(n) => self.adc[n].reset(),
                Device::AdcCommon => self.adc_common.reset(),
                Device::Uart(n) => self.uarts[n].reset(),
                Device::Syscfg => self.syscfg.bank.reset(),
                Device::Cordic => self.cordic.reset(),
                Device::Pwr => self.pwr = pwr::Pwr::new(),
                _ => {}
            }
        }
    }
}
