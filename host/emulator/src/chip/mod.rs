// SPDX-License-Identifier: GPL-2.0-only
//! The STM32G431RB around its core: which peripheral lives where, what they do to each other, what happens next.

mod adc;
mod bank;
mod dma;
mod exti;
mod flash;
mod gpio;
mod iwdg;
mod map;
mod pwr;
mod rcc;
mod simple;
mod tim1;
mod timer;
mod uart;

pub use bank::Misuse;
pub use flash::{Cut, FLASH_SIZE, Operation, PAGE_SIZE};
pub use rcc::ResetCause;

pub(crate) use bank::{Bank, Clocks, Register};

use crate::cortex::{Core, nvic::exception};
use crate::time::{TICKS_PER_US, Ticks};
use crate::world::World;
use gpio::Mode;
use map::Device;
use palpate_plant::{Pins, Plant};

/// Pins of the board, as (port, pin).
mod pin {
    pub(super) const EN: (usize, u8) = (0, 8);
    pub(super) const PH: (usize, u8) = (0, 9);
    pub(super) const NSLEEP: (usize, u8) = (1, 5);
    pub(super) const NFAULT: (usize, u8) = (1, 10);
    pub(super) const BUTTON: (usize, u8) = (2, 13);
    pub(super) const ENCODER: [(usize, u8); 2] = [(0, 6), (0, 7)];
}

/// How long the core may run fast before boost mode is on, and a fault handler may touch what has no clock.
const PATIENCE: Ticks = 1000 * TICKS_PER_US;
/// Longest step of the world while the PWM timer does not set the pace.
const IDLE_STEP: Ticks = 50 * TICKS_PER_US;

const GENERAL: [(&str, bool, u16); 8] = [
    ("TIM2", true, 28),
    ("TIM3", false, 29),
    ("TIM4", false, 30),
    ("TIM6", false, 54),
    ("TIM7", false, 55),
    ("TIM15", false, 24),
    ("TIM16", false, 25),
    ("TIM17", false, 26),
];
/// Index of TIM3 in [`GENERAL`].
const ENCODER: usize = 1;

/// The chip.
#[derive(Debug)]
pub struct Chip {
    /// Virtual time since power-on.
    pub(crate) now: Ticks,
    /// The core's private peripherals and the emulation's books.
    pub(crate) core: Core,
    rcc: rcc::Rcc,
    pwr: pwr::Pwr,
    pub(crate) flash: flash::Flash,
    ports: [gpio::Gpio; 7],
    exti: exti::Exti,
    syscfg: simple::Plain,
    dbgmcu: simple::Plain,
    dma: [dma::Dma; 3],
    tim1: tim1::Tim1,
    timers: Vec<timer::Timer>,
    adc: [adc::Adc; 2],
    adc_common: Bank,
    uarts: [uart::Uart; 2],
    iwdg: iwdg::Iwdg,
    /// What the pins are wired to.
    pub(crate) world: World,
    next_idle_step: Ticks,
    unboosted_since: Option<Ticks>,
    /// An access to a peripheral without clock, forgiven if the chip is reset soon: a fault handler switches the bridge
    /// off before it knows what is on.
    unclocked: Option<(Misuse, Ticks)>,
    /// The next moment at which something happens by itself.
    pub(crate) deadline: Ticks,
    /// An end set from outside.
    pub(crate) limit: Ticks,
    pub(crate) reset_request: Option<ResetCause>,
    /// Oscillator of the watchdog.
    lsi_hz: u64,
}

impl Chip {
    pub(crate) fn new(image: Vec<u8>, plant: Option<Plant>, lsi_hz: u64) -> Self {
        let mut chip = Self {
            now: 0,
            core: Core::new(),
            rcc: rcc::Rcc::new(),
            pwr: pwr::Pwr::new(),
            flash: flash::Flash::new(image),
            ports: std::array::from_fn(gpio::Gpio::new),
            exti: exti::Exti::new(),
            syscfg: simple::Plain::new("SYSCFG", simple::SYSCFG),
            dbgmcu: simple::Plain::new("DBGMCU", simple::DBGMCU),
            dma: [
                dma::Dma::controller("DMA1"),
                dma::Dma::controller("DMA2"),
                dma::Dma::multiplexer(),
            ],
            tim1: tim1::Tim1::new(),
            timers: GENERAL
                .iter()
                .map(|&(name, wide, _)| timer::Timer::new(name, wide))
                .collect(),
            adc: [adc::Adc::new("ADC1"), adc::Adc::new("ADC2")],
            adc_common: Bank::new("ADC12_COMMON", map::ADC_COMMON),
            uarts: [
                uart::Uart::new("LPUART1", true),
                uart::Uart::new("USART2", false),
            ],
            iwdg: iwdg::Iwdg::new(lsi_hz),
            world: World::new(plant),
            next_idle_step: 0,
            unboosted_since: None,
            unclocked: None,
            deadline: 0,
            limit: Ticks::MAX,
            reset_request: None,
            lsi_hz,
        };
        chip.ports[pin::BUTTON.0].drive(pin::BUTTON.1, Some(false));
        chip.reset(ResetCause::PowerOn);
        chip
    }

    /// Puts everything but the RAM into its reset state.
    pub(crate) fn reset(&mut self, cause: ResetCause) {
        self.reset_request = None;
        self.unclocked = None;
        self.unboosted_since = None;
        self.rcc.reset(cause);
        self.pwr = pwr::Pwr::new();
        self.flash.reset();
        self.ports.iter_mut().for_each(gpio::Gpio::reset);
        self.exti = exti::Exti::new();
        self.syscfg.bank.reset();
        self.dma = [
            dma::Dma::controller("DMA1"),
            dma::Dma::controller("DMA2"),
            dma::Dma::multiplexer(),
        ];
        self.tim1.reset();
        self.timers.iter_mut().for_each(timer::Timer::reset);
        self.adc.iter_mut().for_each(adc::Adc::reset);
        self.adc_common.reset();
        self.uarts.iter_mut().for_each(uart::Uart::reset);
        self.iwdg = iwdg::Iwdg::new(self.lsi_hz);
        self.core.reset();
        self.apply_pins();
        self.reschedule();
    }

    pub(crate) fn clocks(&self) -> Clocks {
        Clocks {
            now: self.now,
            bus: self.rcc.bus,
        }
    }

    /// Presses or releases the user button, high when pressed.
    pub(crate) fn button(&mut self, pressed: bool) {
        self.ports[pin::BUTTON.0].drive(pin::BUTTON.1, Some(pressed));
        self.sense_pins();
        self.update_lines();
    }

    /// Bytes into the ST-LINK serial port.
    pub(crate) fn serial_in(&mut self, bytes: &[u8]) {
        let clocks = self.clocks();
        self.uarts[0].receive(bytes, clocks);
        self.reschedule();
    }

    /// Bytes the firmware sent over the ST-LINK serial port.
    pub(crate) fn serial_out(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.uarts[0].sent)
    }

    /// The core has locked up.
    pub(crate) fn lock_up(&mut self) {
        self.core.locked_up = true;
        self.tim1.lockup = self.syscfg.bank[simple::SYSCFG_CFGR2] & 1 != 0;
        self.tim1.apply_break();
        self.apply_pins();
        self.reschedule();
    }

    /// Main output enable of the bridge's timer.
    #[must_use]
    pub fn bridge_enabled(&self) -> bool {
        self.tim1.main_output()
    }

    /// Period of the ADC's clock; `None` while it has none.
    fn adc_clock(&self) -> Option<Ticks> {
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
                if n == ENCODER {
                    self.timers[n].edges = self.world.edges();
                }
                self.timers[n].read(offset, clocks)
            }
            Device::Adc(n) => self.adc[n].read(offset),
            Device::AdcCommon => self.adc_common.read(offset),
            Device::Uart(n) => {
                let value = self.uarts[n].read(offset);
                self.update_lines();
                value
            }
            Device::Iwdg => self.iwdg.read(offset),
        }
    }

    /// A store of the core into the peripheral space.
    pub(crate) fn write(&mut self, address: u32, size: usize, value: u32) -> Result<(), Misuse> {
        let Some((device, offset)) = self.clocked(address & !3)? else {
            return Ok(());
        };
        // The registers of timers are 16 bits wide, or may be written as if they were.
        let narrow = matches!(device, Device::Tim1 | Device::Timer(_))
            && size == 2
            && address.is_multiple_of(4);
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
                if let Some((register, bits)) = self.rcc.write(offset, value)? {
                    self.reset_devices(register, bits);
                }
                self.check_wait_states()?;
            }
            Device::Pwr => self.pwr.write(offset, value)?,
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
                if n == ENCODER {
                    self.timers[n].edges = self.world.edges();
                }
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
        }
        if matches!(device, Device::Gpio(_) | Device::Syscfg | Device::Rcc) {
            self.sense_pins();
        }
        if matches!(device, Device::Gpio(_) | Device::Tim1 | Device::Rcc) {
            self.apply_pins();
        }
        self.update_lines();
        self.reschedule();
        Ok(())
    }

    /// A store of the core into the flash's own addresses.
    pub(crate) fn store_flash(&mut self, offset: u32, size: usize, value: u32) {
        let stall = self.flash.store(offset, size, value, self.now);
        self.stall(stall);
        self.update_lines();
        self.reschedule();
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

    /// Misuse that was forgiven for a while, and no longer is.
    fn check_patience(&mut self) {
        if let Some((misuse, since)) = &self.unclocked
            && self.now > since + PATIENCE
        {
            self.core
                .trap
                .get_or_insert(crate::cortex::Trap::Misuse(misuse.clone()));
        }
        self.check_boost();
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

    /// What the flash can follow.
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

    /// Above 150 MHz the core needs boost mode. The switch may come shortly before, or the bit shortly after.
    fn check_boost(&mut self) {
        let unsafe_speed = self.bus_hertz() > 150_000_000 && !self.pwr.boost();
        let since = *self.unboosted_since.get_or_insert(self.now);
        if !unsafe_speed {
            self.unboosted_since = None;
        } else if self.now > since + PATIENCE {
            let what = "above 150 MHz the core needs boost mode (bit 8, R1MODE, = 0)";
            let misuse = Misuse::Unsupported {
                peripheral: "PWR",
                register: "CR5",
                value: 0x100,
                what,
            };
            self.core
                .trap
                .get_or_insert(crate::cortex::Trap::Misuse(misuse));
        }
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
                Device::Pwr => self.pwr = pwr::Pwr::new(),
                _ => {}
            }
        }
    }

    /// What the pins now ask of the bridge, and what the break input sees.
    fn apply_pins(&mut self) {
        let (port, number) = pin::NFAULT;
        let low = self.world.fault_low();
        self.ports[port].drive(number, low.then_some(false));
        let connected = self.ports[port].mode(number) == Mode::Alternate(12);
        // The board pulls the open-drain pin up.
        self.tim1.set_break_pin(connected.then_some(!low));
        let (port, number) = pin::EN;
        let enable = match self.ports[port].mode(number) {
            Mode::Alternate(6) => self.tim1.duty(),
            Mode::Output => Some(f64::from(u8::from(self.ports[port].output(number)))),
            _ => None,
        };
        let pins = Pins {
            outputs_enabled: enable.is_some(),
            awake: self.ports[pin::NSLEEP.0].output(pin::NSLEEP.1),
            duty: enable.unwrap_or(0.0),
            closing: self.ports[pin::PH.0].output(pin::PH.1),
        };
        self.world.set_pins(pins, self.now);
    }

    /// Input levels to the edge detectors.
    fn sense_pins(&mut self) {
        for line in 0..16u8 {
            let select = self.syscfg.bank[simple::SYSCFG_EXTICR1 + 4 * u32::from(line / 4)];
            let port = (select >> (4 * (line % 4)) & 0xF) as usize;
            if let Some(port) = self.ports.get(port) {
                self.exti.sense(line, port.input(line));
            }
        }
    }

    fn trigger_adc(&mut self) {
        self.sync_world();
        if let Some(clock) = self.adc_clock() {
            for adc in &mut self.adc {
                adc.trigger(self.now, clock);
            }
        }
    }

    fn sync_world(&mut self) {
        self.world.sync(self.now);
        self.next_idle_step = self.now + IDLE_STEP;
        if self.world.fault_low() != self.core.fault_was_low {
            self.core.fault_was_low = self.world.fault_low();
            self.apply_pins();
            self.sense_pins();
        }
    }

    /// A wire was changed from outside.
    pub(crate) fn rewired(&mut self) {
        self.sync_world();
        self.apply_pins();
        self.sense_pins();
        self.update_lines();
        self.reschedule();
    }

    /// Interrupt lines of all peripherals.
    fn update_lines(&mut self) {
        let [break_line, update, trigger, compare] = self.tim1.lines();
        let general = |n: usize| self.timers[n].interrupt();
        let lines = [
            (4, self.flash.interrupt()),
            (18, self.adc.iter().any(adc::Adc::interrupt)),
            (24, break_line || general(5)),
            (25, update || general(6)),
            (26, trigger || general(7)),
            (27, compare),
            (28, general(0)),
            (29, general(1)),
            (30, general(2)),
            (38, self.uarts[1].interrupt()),
            (54, general(3)),
            (55, general(4)),
            (91, self.uarts[0].interrupt()),
        ];
        for (interrupt, level) in lines.into_iter().chain(self.exti.lines()) {
            self.core.nvic.set_line(interrupt, level);
        }
    }

    /// Recomputes when the next thing happens by itself.
    pub(crate) fn reschedule(&mut self) {
        let clocks = self.clocks();
        let timers = self
            .timers
            .iter()
            .filter_map(|t| t.next_event(clocks))
            .min();
        let others = [
            self.tim1.next_event(),
            self.adc[0].next_event(),
            self.adc[1].next_event(),
            self.uarts[0].next_event(),
            self.uarts[1].next_event(),
            self.iwdg.next_event(),
            self.flash.next_event(self.now),
            self.core.systick.next_event(clocks),
            timers,
        ];
        let soonest = others.into_iter().flatten().min().unwrap_or(Ticks::MAX);
        self.deadline = soonest.min(self.next_idle_step).min(self.limit);
    }

    /// Carries out everything due up to now, in order of time.
    pub(crate) fn advance(&mut self) {
        let reached = self.now;
        loop {
            let due = self.deadline;
            if due > reached || due >= self.limit {
                break;
            }
            self.now = due;
            self.happen();
            self.reschedule();
            if self.deadline <= due && self.deadline < self.limit && self.reset_request.is_some() {
                break;
            }
        }
        self.now = reached.max(self.now);
    }

    fn happen(&mut self) {
        let clocks = self.clocks();
        if self.tim1.next_event().is_some_and(|at| at <= self.now) {
            let duty = self.tim1.duty();
            let trigger = self.tim1.update(clocks);
            if trigger {
                self.trigger_adc();
            } else {
                self.sync_world();
            }
            if self.tim1.duty() != duty {
                self.apply_pins();
            }
        }
        if self.next_idle_step <= self.now {
            self.sync_world();
            self.check_patience();
        }
        self.timers
            .iter_mut()
            .for_each(|timer| timer.settle(clocks));
        if let Some(clock) = self.adc_clock() {
            let Self {
                adc, world, now, ..
            } = self;
            for adc in adc {
                adc.finish(*now, clock, |channel| match channel {
                    2 => world.current_v(),
                    6 => world.supply_v(),
                    7 => world.hall_v(),
                    // Internal reference, 1.212 V.
                    18 => 1.212,
                    _ => 0.0,
                });
            }
        }
        self.uarts.iter_mut().for_each(|uart| uart.advance(clocks));
        if self.core.systick.advance(clocks) {
            self.core.nvic.set_pending(exception::SYS_TICK, true);
        }
        if self.iwdg.next_event().is_some_and(|at| at <= self.now) {
            self.reset_request = Some(ResetCause::Watchdog);
        }
        self.update_lines();
    }

    /// The encoder's wires reach the timer.
    #[must_use]
    pub fn encoder_connected(&self) -> bool {
        pin::ENCODER
            .iter()
            .all(|&(port, number)| self.ports[port].mode(number) == Mode::Alternate(2))
    }

    /// Triggers of the ADC that came while it was still converting.
    #[must_use]
    pub fn missed_triggers(&self) -> u64 {
        self.adc.iter().map(|adc| adc.missed_triggers).sum()
    }
}
