// SPDX-License-Identifier: GPL-2.0-only
//! The STM32G431RB around its core: address map, connections between peripherals, events in time.

mod adc;
mod bank;
mod bus;
mod cordic;
mod dma;
mod ecc;
mod events;
mod exti;
mod flash;
mod gpio;
mod iwdg;
mod map;
mod pins;
mod pwr;
mod quirks;
mod rcc;
mod simple;
mod tim1;
mod timer;
mod uart;

pub use bank::Misuse;
pub use flash::{FLASH_SIZE, Operation, PAGE_SIZE, PowerCut};
pub use quirks::Quirks;
pub use rcc::ResetCause;

pub(crate) use adc::Voltages;
pub(crate) use bank::{Bank, Clocks, Register};

use crate::cortex::Core;
use crate::time::{TICKS_PER_US, Ticks};
use crate::world::World;
use palpate_plant::Plant;

/// Longest step of the world while the PWM timer does not run.
const IDLE_STEP: Ticks = 50 * TICKS_PER_US;

/// General-purpose and basic timers: name, 32 bits wide, interrupt.
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
    /// The core's private peripherals and the instruction accounts.
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
    /// Their next event, until one of them or their clock may have changed.
    timers_next: Option<Option<Ticks>>,
    adc: [adc::Adc; 2],
    adc_common: Bank,
    uarts: [uart::Uart; 2],
    iwdg: iwdg::Iwdg,
    cordic: cordic::Cordic,
    /// What the pins are wired to.
    pub(crate) world: World,
    fault_pin_held_high: bool,
    next_idle_step: Ticks,
    /// An access to a peripheral without clock, tolerated if the chip is reset soon: a fault handler switches the bridge off
    /// before it knows which clocks are on.
    unclocked: Option<(Misuse, Ticks)>,
    /// Time of the next event.
    pub(crate) deadline: Ticks,
    /// Limit set from outside.
    pub(crate) limit: Ticks,
    pub(crate) reset_request: Option<ResetCause>,
    /// Oscillator of the watchdog.
    lsi_hz: u64,
}

impl Chip {
    pub(crate) fn new(image: Vec<u8>, plant: Option<Plant>, lsi_hz: u64, quirks: Quirks) -> Self {
        let mut chip = Self {
            now: 0,
            core: Core::new(),
            rcc: rcc::Rcc::new(quirks),
            pwr: pwr::Pwr::new(),
            flash: flash::Flash::new(image, quirks),
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
            timers_next: None,
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
            cordic: cordic::Cordic::new(),
            world: World::new(plant, quirks.wake_fault_s),
            fault_pin_held_high: quirks.fault_pin_held_high,
            next_idle_step: 0,
            unclocked: None,
            deadline: 0,
            limit: Ticks::MAX,
            reset_request: None,
            lsi_hz,
        };
        chip.ports[pins::BUTTON.0].drive(pins::BUTTON.1, Some(false));
        chip.reset(ResetCause::PowerOn);
        chip
    }

    /// Resets everything but the RAM.
    pub(crate) fn reset(&mut self, cause: ResetCause) {
        self.reset_request = None;
        self.unclocked = None;
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
        self.timers_next = None;
        self.adc.iter_mut().for_each(adc::Adc::reset);
        self.adc_common.reset();
        self.uarts.iter_mut().for_each(uart::Uart::reset);
        self.iwdg = iwdg::Iwdg::new(self.lsi_hz);
        self.cordic.reset();
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

    /// Number of ADC triggers during a conversion.
    #[must_use]
    pub fn missed_triggers(&self) -> u64 {
        self.adc.iter().map(|adc| adc.missed_triggers).sum()
    }
}
