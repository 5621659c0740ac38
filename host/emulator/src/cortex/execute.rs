// SPDX-License-Identifier: GPL-2.0-only
//! Executes translated blocks.

mod one;

use super::Trap;
use super::access::{Bus, Trapped};
use super::debug::Resumed;
use super::translate::Code;

/// How a block ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    /// The next block follows.
    Next,
    WaitForInterrupt,
    /// The chip's core holds a trap.
    Trap,
}

/// Least value of EXC_RETURN.
const RETURNS: u32 = 0xFF00_0000;

/// What follows an operation.
enum Flow {
    Next,
    /// So many operations are left out.
    Skip(u8),
    End(Ended),
}

impl Bus<'_> {
    /// Runs a block; the program counter then stands at the next one, or at the instruction that could not be executed.
    pub(super) fn execute(&mut self, code: &Code) -> Ended {
        self.run::<false>(code, &|_| false)
    }

    /// The same, halted before these addresses and after a step.
    pub(super) fn execute_held(&mut self, code: &Code, breakpoints: &dyn Fn(u32) -> bool) -> Ended {
        self.run::<true>(code, breakpoints)
    }

    #[inline(always)]
    fn run<const HELD: bool>(&mut self, code: &Code, breakpoints: &dyn Fn(u32) -> bool) -> Ended {
        self.registers.pc = code.end;
        self.registers.it = code.it_after;
        let mut next = 0;
        while let Some(op) = code.ops.get(next) {
            let at = next;
            next += 1;
            if HELD && self.is_held(code.address(at), breakpoints) {
                self.stay(code, at);
                return Ended::Trap;
            }
            match self.one(*op, code, at) {
                Ok(Flow::Next) => {}
                Ok(Flow::Skip(skip)) => next += usize::from(skip),
                Ok(Flow::End(ended)) => return ended,
                Err(Trapped) => {
                    self.stay(code, at);
                    return Ended::Trap;
                }
            }
        }
        Ended::Next
    }

    /// Whether the core is halted before an instruction; where it was resumed it is not.
    fn is_held(&mut self, address: u32, breakpoints: &dyn Fn(u32) -> bool) -> bool {
        let Resumed { from, step } = self.chip.core.resumed;
        if from == Some(address) {
            return false;
        }
        self.chip.core.resumed.from = None;
        let stopped = breakpoints(address);
        if stopped || step {
            self.trap(Trap::Held { stepping: !stopped });
        }
        stopped || step
    }

    /// The operation's instruction was not executed.
    #[cold]
    fn stay(&mut self, code: &Code, at: usize) {
        if let Some(place) = code.places.get(at) {
            self.registers.pc = code.address(at);
            self.registers.it = place.it;
            // A breakpoint instruction counts as executed.
            if matches!(
                self.chip.core.trap,
                Some(Trap::Bus { .. } | Trap::Undefined { .. } | Trap::Held { .. })
            ) {
                self.chip.core.account.refund(code.ahead(at));
            }
        }
    }

    fn jump(&mut self, target: u32) -> Result<Flow, Trapped> {
        self.registers.pc = target & !1;
        Ok(Flow::End(Ended::Next))
    }

    /// A jump that may return from an exception, and that must stay in Thumb state.
    fn exchange(&mut self, target: u32) -> Result<Flow, Trapped> {
        self.registers.pc = target & !1;
        if self.registers.exception != 0 && target >= RETURNS {
            self.trap(Trap::Return(target | 1));
            return Ok(Flow::End(Ended::Trap));
        }
        if target & 1 == 0 {
            self.trap(Trap::Undefined { encoding: None });
            return Ok(Flow::End(Ended::Trap));
        }
        Ok(Flow::End(Ended::Next))
    }

    /// The last operation traps after its instruction.
    fn after(&mut self, trap: Trap) -> Result<Flow, Trapped> {
        self.trap(trap);
        Ok(Flow::End(Ended::Trap))
    }
}

impl Code {
    /// Address of an operation's instruction.
    fn address(&self, at: usize) -> u32 {
        self.start
            + self
                .places
                .get(at)
                .map_or(0, |place| u32::from(place.offset))
    }

    /// Instructions of the block from that of an operation on.
    fn ahead(&self, at: usize) -> u32 {
        self.cost.instructions
            - self
                .places
                .get(at)
                .map_or(0, |place| u32::from(place.index))
    }
}
