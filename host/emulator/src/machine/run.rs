// SPDX-License-Identifier: GPL-2.0-only
//! The run loop: runs the core from one event to the next, takes exceptions, handles stops of the core.

use super::{Machine, POLL, Pause, Sleep};
use crate::cortex::{Exit, Trap};
use crate::time::Ticks;
use crate::{Error, Misuse};

impl Machine<'_> {
    /// Runs up to a moment of virtual time.
    ///
    /// # Errors
    /// The firmware does something that is not modelled, or the engine fails.
    pub fn run_until(&mut self, end: Ticks) -> Result<Pause, Error> {
        loop {
            let limit = end.min(self.next_poll);
            let chip = self.chip_mut();
            chip.limit = limit;
            chip.reschedule();
            match self.go()? {
                Pause::Time if self.now() < end || self.next_poll <= end => {
                    if self.now() >= self.next_poll {
                        self.poll(false);
                    }
                    if self.now() >= end {
                        return Ok(Pause::Time);
                    }
                }
                pause => return Ok(pause),
            }
        }
    }

    pub(super) fn poll(&mut self, everything: bool) {
        self.next_poll = self.now() + POLL;
        let bytes = if everything {
            self.rtt.rest(&mut self.engine)
        } else {
            self.rtt.poll(&mut self.engine)
        };
        if let Some(tap) = &mut self.tap {
            tap.extend(&bytes);
        }
        let fetched_s = self.time_s();
        self.lines.extend(self.log.decode(&bytes, fetched_s));
        if !self.outbox.is_empty() {
            let sent = self.rtt.send(&mut self.engine, &self.outbox);
            self.outbox.drain(..sent);
        }
    }

    /// Runs until the chip's limit.
    fn go(&mut self) -> Result<Pause, Error> {
        loop {
            self.chip_mut().advance();
            self.engine.refresh_changed();
            let chip = self.engine.chip_mut();
            if chip.flash.power_lost {
                return Ok(Pause::PowerLost);
            }
            if let Some(cause) = chip.reset_request.take() {
                self.restart(cause)?;
                return Ok(Pause::Reset(cause));
            }
            if chip.now >= chip.limit {
                return Ok(Pause::Time);
            }
            if chip.core.locked_up {
                chip.now = chip.deadline;
                continue;
            }
            if let Some(exception) = self.engine.takes() {
                self.sleep = Sleep::No;
                if self.engine.enter(exception).is_err() {
                    self.engine.unstacked(exception);
                }
                continue;
            }
            let chip = self.engine.chip_mut();
            match self.sleep {
                Sleep::No => {}
                Sleep::ForEvent if chip.core.event => chip.core.event = false,
                Sleep::ForInterrupt if chip.core.nvic.candidate().is_some() => {}
                Sleep::ForEvent | Sleep::ForInterrupt => {
                    chip.now = chip.deadline.max(chip.now);
                    continue;
                }
            }
            self.sleep = Sleep::No;
            match self.engine.run() {
                Exit::Due => {}
                Exit::WaitForInterrupt => self.sleep = Sleep::ForInterrupt,
                Exit::Trap(Trap::Held { stepping }) => return Ok(Pause::Held { stepping }),
                Exit::Trap(trap) => {
                    if let Some(code) = self.handle(trap)? {
                        return Ok(Pause::Exit(code));
                    }
                }
            }
        }
    }

    /// Handles a stop of the core; returns an exit code if the firmware ended itself.
    fn handle(&mut self, trap: Trap) -> Result<Option<u32>, Error> {
        match trap {
            Trap::WaitForEvent => self.sleep = Sleep::ForEvent,
            Trap::Return(value) => {
                if self.engine.leave(value).is_err() {
                    self.engine.fault(&Trap::Bus {
                        address: 0,
                        fetch: false,
                    });
                }
            }
            Trap::Supervisor => self
                .engine
                .escalate(crate::cortex::nvic::exception::SV_CALL),
            Trap::Breakpoint => return Ok(self.breakpoint()),
            Trap::Bus { .. } | Trap::Undefined { .. } => {
                let stack = self.engine.registers().get(13);
                self.note(&match trap {
                    Trap::Bus { address, .. } => {
                        format!("bus error at {address:#010x}, stack at {stack:#010x}")
                    }
                    Trap::Undefined { encoding: Some(encoding) } => {
                        let pc = self.engine.registers().get(15);
                        format!("undefined instruction {encoding:#06x} at {pc:#010x}, stack at {stack:#010x}")
                    }
                    _ => format!("branch out of Thumb state, stack at {stack:#010x}"),
                });
                self.engine.fault(&trap);
                if self.chip().core.locked_up {
                    self.note("lockup");
                }
            }
            Trap::Misuse(misuse) => return Err(self.misuse(misuse)),
            // Returned by the run loop.
            Trap::Held { .. } => {}
        }
        Ok(None)
    }

    /// Semihosting exit, else a debug event, which without a debugger is a hard fault.
    fn breakpoint(&mut self) -> Option<u32> {
        const SEMIHOSTING: u32 = 0xAB;
        let pc = self.engine.registers().get(15);
        let immediate = self.engine.word(pc & !1).map_or(0, |word| word & 0xFF);
        let operation = self.engine.registers().get(0);
        if immediate == SEMIHOSTING && matches!(operation, 0x18 | 0x20) {
            let reason = self.engine.registers().get(1);
            return Some(u32::from(reason != 0x2_0026));
        }
        self.engine.fault(&Trap::Breakpoint);
        None
    }

    fn misuse(&self, misuse: Misuse) -> Error {
        Error::Misuse {
            misuse,
            place: self.position(),
            time_s: self.time_s(),
        }
    }

    /// Ends the run: reads the rest of the log.
    pub fn finish(&mut self) {
        self.poll(true);
    }
}
