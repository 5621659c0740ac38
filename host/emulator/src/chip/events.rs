// SPDX-License-Identifier: GPL-2.0-only
//! Events in time: timers, conversions, characters, the world; and the interrupt lines that follow.

use super::adc::Adc;
use super::map::Device;
use super::{Chip, GENERAL, IDLE_STEP, ResetCause};
use crate::cortex::nvic::exception;
use crate::time::Ticks;

impl Chip {
    pub(super) fn trigger_adc(&mut self) {
        self.sync_world();
        if let Some(clock) = self.adc_clock() {
            for adc in &mut self.adc {
                adc.trigger(self.now, clock);
            }
        }
    }

    pub(super) fn sync_world(&mut self) {
        self.world.sync(self.now);
        self.next_idle_step = self.now + IDLE_STEP;
        if self.world.fault_low() != self.core.fault_was_low {
            self.core.fault_was_low = self.world.fault_low();
            self.apply_pins();
            self.sense_pins();
        }
    }

    /// Interrupt lines of all peripherals.
    pub(super) fn update_lines(&mut self) {
        for device in [
            Device::Flash,
            Device::Adc(0),
            Device::Tim1,
            Device::Exti,
            Device::Uart(0),
            Device::Uart(1),
        ] {
            self.update_line(device);
        }
        (0..GENERAL.len()).for_each(|n| self.update_line(Device::Timer(n)));
    }

    /// Interrupt lines of one peripheral.
    pub(super) fn update_line(&mut self, device: Device) {
        let nvic = &mut self.core.nvic;
        match device {
            Device::Flash => nvic.set_line(4, self.flash.interrupt()),
            Device::Adc(_) => nvic.set_line(18, self.adc.iter().any(Adc::interrupt)),
            Device::Timer(n @ 0..=4) => nvic.set_line(GENERAL[n].2, self.timers[n].interrupt()),
            // TIM15 to TIM17 share their lines with TIM1.
            Device::Tim1 | Device::Timer(_) => {
                let [break_line, update, trigger, compare] = self.tim1.lines();
                for (n, line) in [(5, break_line), (6, update), (7, trigger)] {
                    nvic.set_line(GENERAL[n].2, line || self.timers[n].interrupt());
                }
                nvic.set_line(27, compare);
            }
            Device::Uart(0) => nvic.set_line(91, self.uarts[0].interrupt()),
            Device::Uart(_) => nvic.set_line(38, self.uarts[1].interrupt()),
            Device::Exti | Device::Gpio(_) | Device::Syscfg => {
                for (interrupt, level) in self.exti.lines() {
                    nvic.set_line(interrupt, level);
                }
            }
            _ => {}
        }
    }

    /// The next event of the general-purpose timers.
    fn timers_next(&mut self) -> Option<Ticks> {
        let clocks = self.clocks();
        *self.timers_next.get_or_insert_with(|| {
            let events = self.timers.iter();
            events.filter_map(|t| t.next_event(clocks)).min()
        })
    }

    /// Recomputes the time of the next event.
    pub(crate) fn reschedule(&mut self) {
        let clocks = self.clocks();
        let timers = self.timers_next();
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
        self.deadline = others
            .map(|at| at.unwrap_or(Ticks::MAX))
            .into_iter()
            .fold(self.next_idle_step.min(self.limit), Ticks::min);
    }

    /// Carries out all due events in order of time.
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

    /// Carries out the events of one moment.
    fn happen(&mut self) {
        let clocks = self.clocks();
        let now = self.now;
        let due = |event: Option<Ticks>| event.is_some_and(|at| at <= now);
        if due(self.tim1.next_event()) {
            self.pwm_update();
        }
        if self.next_idle_step <= now {
            self.sync_world();
            self.check_patience();
        }
        if due(self.timers_next()) {
            for n in 0..self.timers.len() {
                if due(self.timers[n].next_event(clocks)) {
                    self.timers[n].settle(clocks);
                    self.update_line(Device::Timer(n));
                }
            }
            self.timers_next = None;
        }
        for n in 0..self.adc.len() {
            if due(self.adc[n].next_event()) {
                self.convert(n);
            }
        }
        for n in 0..self.uarts.len() {
            if due(self.uarts[n].next_event()) {
                self.uarts[n].advance(clocks);
                self.update_line(Device::Uart(n));
            }
        }
        if self.core.systick.advance(clocks) {
            self.core.nvic.set_pending(exception::SYS_TICK, true);
        }
        if due(self.iwdg.next_event()) {
            self.reset_request = Some(ResetCause::Watchdog);
        }
    }

    /// The PWM timer's update event: new compare values, the ADC's trigger.
    fn pwm_update(&mut self) {
        let duty = self.tim1.duty();
        if self.tim1.update(self.clocks()) {
            self.trigger_adc();
        } else {
            self.sync_world();
        }
        self.world.align_pwm();
        if self.tim1.duty() != duty {
            self.apply_pins();
        }
        self.update_line(Device::Tim1);
    }

    /// A conversion completes.
    fn convert(&mut self, n: usize) {
        let Some(clock) = self.adc_clock() else {
            return;
        };
        let mut channels = self.world.channels();
        self.adc[n].finish(self.now, clock, &mut channels);
        self.update_line(Device::Adc(n));
    }
}
