// SPDX-License-Identifier: GPL-2.0-only
//! The chip with its firmware: set-up, power, pins, log and access from outside.

mod run;

use palpate_plant::Plant;

use crate::Error;
use crate::chip::{Chip, Operation, PowerCut, Quirks, ResetCause};
use crate::cortex::account::Account;
use crate::cortex::{Engine, Map};
use crate::firmware::{Firmware, place};
use crate::log::{Line, Log};
use crate::rtt::{Reader, Rtt};
use crate::time::{self, TICKS_PER_MS, Ticks};
use crate::world::{WiringFaults, World};

/// How the machine is set up.
#[derive(Clone, Debug)]
pub struct Setup {
    /// How the log is read.
    pub reader: Reader,
    /// Contents of the flash, bit for bit, program included, instead of a freshly programmed chip;
    /// [`Firmware::flashed_over`] puts the firmware over what an earlier run left.
    pub flash: Option<Vec<u8>>,
    /// Behaviour of real parts beyond their registers.
    pub quirks: Quirks,
    /// Frequency of the watchdog's oscillator: 32 kHz nominal, 29.5 to 34 kHz over temperature and supply.
    pub lsi_hz: u64,
    /// The cycle counter counts executed instructions exactly, for benchmarks.
    pub count_instructions: bool,
    /// Parts of names of functions whose calls are counted.
    pub watch: Vec<String>,
    /// Parts of names of watched functions: calls of others in which one of these runs are counted apart from those in which
    /// none does.
    pub apart: Vec<String>,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            reader: Reader::Attached,
            flash: None,
            quirks: Quirks::default(),
            lsi_hz: 32_000,
            count_instructions: false,
            watch: Vec::new(),
            apart: Vec::new(),
        }
    }
}

/// Why the machine paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// The requested time is reached.
    Time,
    /// The chip was reset and starts again.
    Reset(ResetCause),
    /// The power failed at the flash operation set by [`Machine::cut_power_at`].
    PowerLost,
    /// The firmware ended itself by a semihosting exit with this code.
    Exit(u32),
    /// The core is halted at a breakpoint or after a step.
    Held {
        /// Whether it was a step; otherwise a breakpoint.
        stepping: bool,
    },
}

/// Use of a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stack {
    /// `process` or `main`.
    pub name: &'static str,
    /// Size, bytes.
    pub size: usize,
    /// Largest use, bytes.
    pub used: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sleep {
    No,
    ForEvent,
    ForInterrupt,
}

/// A running chip.
pub struct Machine<'f> {
    firmware: &'f Firmware,
    engine: Engine,
    rtt: Rtt,
    log: Log<'f>,
    sleep: Sleep,
    next_poll: Ticks,
    lines: Vec<Line>,
    outbox: Vec<u8>,
    notes: Vec<String>,
    /// The log's bytes as they came, for clients that decode them themselves.
    tap: Option<Vec<u8>>,
}

/// How often a probe polls the log.
const POLL: Ticks = TICKS_PER_MS;

impl<'f> Machine<'f> {
    /// Programs the firmware into a chip wired to `plant` (or to nothing) and switches it on.
    ///
    /// # Errors
    /// The engine cannot be set up, or a watched function does not exist.
    pub fn new(firmware: &'f Firmware, plant: Option<Plant>, setup: &Setup) -> Result<Self, Error> {
        let image = setup
            .flash
            .clone()
            .unwrap_or_else(|| firmware.image.clone());
        let mut engine = Engine::new(Chip::new(image, plant, setup.lsi_hz, setup.quirks));
        if setup.count_instructions {
            engine.count_instructions();
        }
        for part in &setup.watch {
            let mut any = false;
            for function in firmware.functions(part) {
                let apart = setup.apart.iter().any(|part| function.name.contains(part));
                engine.watch(function.address, function.name.clone(), apart);
                any = true;
            }
            if !any {
                return Err(Error::NoFunction(part.clone()));
            }
        }
        let mut machine = Self {
            firmware,
            engine,
            rtt: Rtt::new(firmware.symbol("_SEGGER_RTT"), setup.reader),
            log: Log::new(firmware),
            sleep: Sleep::No,
            next_poll: POLL,
            lines: Vec::new(),
            outbox: Vec::new(),
            notes: Vec::new(),
            tap: None,
        };
        machine.forget_ram();
        machine.engine.start();
        Ok(machine)
    }

    /// Fills the RAM with a pattern, as power-on leaves it: neither zero nor an old value.
    fn forget_ram(&mut self) {
        self.engine.forget_ram(UNTOUCHED);
    }

    /// Switches the power off and on again. The flash keeps its contents, the RAM does not.
    ///
    /// # Errors
    /// The engine fails.
    pub fn power_cycle(&mut self) -> Result<(), Error> {
        self.chip_mut().flash.power_lost = false;
        self.chip_mut().flash.cut = None;
        self.forget_ram();
        self.restart(ResetCause::PowerOn)
    }

    /// Resets the chip from outside.
    ///
    /// # Errors
    /// The engine fails.
    pub fn reset(&mut self, cause: ResetCause) -> Result<(), Error> {
        self.restart(cause)
    }

    fn restart(&mut self, cause: ResetCause) -> Result<(), Error> {
        self.poll(true);
        self.note(&format!("reset ({cause:?})"));
        self.chip_mut().reset(cause);
        self.engine.refresh_changed();
        self.sleep = Sleep::No;
        self.log.restart();
        self.engine.start();
        Ok(())
    }

    /// Virtual time since power-on.
    #[must_use]
    pub fn now(&self) -> Ticks {
        self.chip().now
    }

    /// Virtual time since power-on in seconds.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        time::seconds(self.now())
    }

    /// The chip.
    #[must_use]
    pub fn chip(&self) -> &Chip {
        self.engine.chip()
    }

    pub(crate) fn chip_mut(&mut self) -> &mut Chip {
        self.engine.chip_mut()
    }

    /// Instruction counts.
    #[must_use]
    pub fn account(&self) -> &Account {
        &self.chip().core.account
    }

    /// The simulated world, if one is wired.
    #[must_use]
    pub fn plant(&self) -> Option<&Plant> {
        self.chip().world.plant()
    }

    /// The simulated world, for injecting faults.
    pub fn plant_mut(&mut self) -> Option<&mut Plant> {
        self.chip_mut().world.plant_mut()
    }

    /// Faults between world and chip.
    pub fn rewire(&mut self, change: impl FnOnce(&mut WiringFaults)) {
        let chip = self.chip_mut();
        change(&mut chip.world.wires);
        chip.rewired();
    }

    /// The world at the pins.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.chip().world
    }

    /// Changes how the log is read from now on.
    pub fn set_reader(&mut self, reader: Reader) {
        self.rtt.reader = reader;
    }

    /// A word of flash or RAM, as a debugger would read it; `None` where there is no memory.
    #[must_use]
    pub fn word(&self, address: u32) -> Option<u32> {
        self.engine.word(address)
    }

    /// Pulls nFAULT low for a moment, as noise on its wire does.
    pub fn pulse_fault_pin(&mut self, seconds: f64) {
        self.chip_mut().pulse_fault_pin(time::ticks(seconds));
    }

    /// Presses or releases the user button.
    pub fn button(&mut self, pressed: bool) {
        self.chip_mut().button(pressed);
    }

    /// Keeps the log's bytes from now on, for [`Machine::take_log_bytes`].
    pub fn tap_log(&mut self) {
        self.tap.get_or_insert_default();
    }

    /// The log's bytes since the last call, as the firmware wrote them: whole records.
    pub fn take_log_bytes(&mut self) -> Vec<u8> {
        self.tap.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Access for a debugger.
    pub(crate) fn engine_mut(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Queues bytes for the log's down channel; they are passed on as the firmware makes room.
    pub fn command(&mut self, text: &str) {
        self.outbox.extend(text.as_bytes());
    }

    /// Sends bytes over the serial port.
    pub fn serial(&mut self, text: &str) {
        self.chip_mut().serial_in(text.as_bytes());
    }

    /// Bytes that the firmware sent over the serial port since the last call.
    pub fn serial_output(&mut self) -> Vec<u8> {
        self.chip_mut().serial_out()
    }

    /// Log lines fetched since the last call.
    pub fn take_lines(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.lines)
    }

    /// Events of the chip that the firmware's log does not show (faults, lockup, resets), since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    fn note(&mut self, what: &str) {
        self.notes.push(format!(
            "{:.6} s: {what}, {}",
            self.time_s(),
            self.position()
        ));
    }

    /// Log frames that arrived damaged.
    #[must_use]
    pub fn malformed_frames(&self) -> u64 {
        self.log.malformed
    }

    /// Contents of the flash.
    #[must_use]
    pub fn flash(&self) -> &[u8] {
        &self.chip().flash.image
    }

    /// Flash operations carried out so far.
    #[must_use]
    pub fn flash_operations(&self) -> &[Operation] {
        &self.chip().flash.operations
    }

    /// Makes the power fail at the flash operation with this index in [`Machine::flash_operations`].
    pub fn cut_power_at(&mut self, operation: usize, cut: PowerCut) {
        self.chip_mut().flash.cut = Some((operation, cut));
    }

    /// Whether the power has failed at the operation set by [`Machine::cut_power_at`].
    #[must_use]
    pub fn power_lost(&self) -> bool {
        self.chip().flash.power_lost
    }

    /// Flips a bit of the flash, counted from its first.
    ///
    /// # Errors
    /// The engine fails.
    pub fn flip_flash_bit(&mut self, bit: usize) -> Result<(), Error> {
        self.chip_mut().flash.flip(bit);
        self.engine.refresh_changed();
        Ok(())
    }

    /// Deepest use of the stacks since power-on, from the untouched pattern below: the process stack of a firmware that
    /// has one (`_process_stack_end`, `_process_stack_start`), and the main stack.
    #[must_use]
    pub fn stacks(&self) -> Vec<Stack> {
        let symbol = |name| self.firmware.symbol(name);
        let main_end = symbol("_stack_end").unwrap_or(Map::RAM);
        [
            (
                "process",
                symbol("_process_stack_end"),
                symbol("_process_stack_start"),
            ),
            ("main", Some(main_end), symbol("_stack_start")),
        ]
        .into_iter()
        .filter_map(|(name, end, start)| {
            let (end, start) = (end?, start?);
            let bytes = self.engine.read(end, start.checked_sub(end)? as usize)?;
            let free = bytes.iter().take_while(|&&byte| byte == UNTOUCHED).count();
            Some(Stack {
                name,
                size: bytes.len(),
                used: bytes.len() - free,
            })
        })
        .collect()
    }

    /// Current place of the core, for messages.
    #[must_use]
    pub fn position(&self) -> String {
        place(self.firmware, self.chip().core.block_address)
    }
}

/// Pattern of unused RAM.
const UNTOUCHED: u8 = 0xA7;
