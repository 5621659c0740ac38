// SPDX-License-Identifier: GPL-2.0-only
//! The Cortex-M4F: instructions, exceptions, interrupt controller, instruction counts.
//!
//! Straight runs of instructions are translated once into operations with resolved operands (`translate` and the modules that it
//! calls, by encoding) and then executed from a cache (`blocks`, `execute`).

mod access;
pub mod account;
mod alu;
mod blocks;
mod data32;
pub(crate) mod debug;
pub mod decode;
mod dsp;
mod engine;
mod exception;
mod execute;
mod float;
mod fuse;
mod memory;
mod names;
pub(crate) mod nvic;
mod op;
mod operands;
#[cfg(feature = "reference")]
pub mod reference;
mod state;
mod system;
mod systick;
mod thumb16;
mod thumb32;
mod translate;
mod vfp;

pub use names::exception_name;

pub(crate) use engine::{Engine, Exit};

use crate::chip::{Bank, Misuse};
use account::Account;
use nvic::Nvic;

/// The memories.
pub(crate) struct Map;

impl Map {
    pub(crate) const FLASH: u32 = 0x0800_0000;
    pub(crate) const FLASH_SIZE: u32 = crate::chip::FLASH_SIZE as u32;
    /// SRAM1, SRAM2 and the alias of the CCM SRAM, contiguous.
    pub(crate) const RAM: u32 = 0x2000_0000;
    pub(crate) const RAM_SIZE: u32 = 32 * 1024;
    /// The CCM SRAM at its own address.
    pub(crate) const CCM: u32 = 0x1000_0000;
    pub(crate) const CCM_SIZE: u32 = 10 * 1024;
    /// Offset in the RAM of the alias of the CCM SRAM.
    pub(crate) const CCM_ALIAS: u32 = 0x5800;
    /// System memory with the unique identity and the flash size.
    pub(crate) const SYSTEM: u32 = 0x1FFF_0000;
    pub(crate) const SYSTEM_SIZE: u32 = 0x8000;

    /// Offset into the RAM of an address in it or in the CCM SRAM.
    pub(crate) fn ram_offset(address: u32) -> Option<u32> {
        let ram = address.wrapping_sub(Self::RAM);
        let ccm = address.wrapping_sub(Self::CCM);
        if ram < Self::RAM_SIZE {
            Some(ram)
        } else {
            (ccm < Self::CCM_SIZE).then(|| ccm + Self::CCM_ALIAS)
        }
    }
}

/// Event of the core that the run loop must handle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trap {
    /// An exception handler returned with this value in the program counter.
    Return(u32),
    Supervisor,
    Breakpoint,
    WaitForEvent,
    /// An instruction that does not exist or is not implemented, or no Thumb state.
    Undefined {
        /// The first halfword above the second, if it has two.
        encoding: Option<u32>,
    },
    /// No memory at this address.
    Bus {
        address: u32,
        fetch: bool,
    },
    Misuse(Misuse),
    /// The core is halted before an instruction: a breakpoint, or the end of a step.
    Held {
        stepping: bool,
    },
}

/// State of the core apart from its registers, and the emulation's accounts.
#[derive(Debug)]
pub struct Core {
    pub(crate) nvic: Nvic,
    pub(crate) systick: systick::SysTick,
    scs: Bank,
    dwt: Bank,
    /// Instruction counts.
    pub(crate) account: Account,
    /// Start of the block that runs or was about to run.
    pub(crate) block_address: u32,
    /// Set by SEV and by exception entry and return; consumed by WFE.
    pub(crate) event: bool,
    pub(crate) locked_up: bool,
    pub(crate) trap: Option<Trap>,
    /// What the run loop has to look at between blocks may have changed: an access outside of the memories, a mask register.
    attention: bool,
    pub(crate) resumed: debug::Resumed,
    /// CYCCNT counts executed instructions exactly.
    pub(crate) count_instructions: bool,
    /// Instructions of the running block from the current load on.
    instructions_ahead: u64,
    /// Level of nFAULT when the pins were last looked at.
    pub(crate) fault_was_low: bool,
}

impl Core {
    pub(crate) fn new() -> Self {
        Self {
            nvic: Nvic::new(),
            systick: systick::SysTick::default(),
            scs: Bank::new("SCS", system::SCS),
            dwt: Bank::new("DWT", system::DWT),
            account: Account::new(),
            block_address: 0,
            event: false,
            locked_up: false,
            trap: None,
            attention: true,
            resumed: debug::Resumed::default(),
            count_instructions: false,
            instructions_ahead: 0,
            fault_was_low: false,
        }
    }

    pub(crate) fn reset(&mut self) {
        self.nvic = Nvic::new();
        self.systick = systick::SysTick::default();
        self.scs.reset();
        self.dwt.reset();
        self.account.reset();
        self.event = false;
        self.locked_up = false;
        self.trap = None;
    }

    /// Instructions executed before the current load.
    fn exact_instructions(&self) -> u64 {
        self.account.total().instructions - self.instructions_ahead
    }
}
