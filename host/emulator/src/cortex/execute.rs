// SPDX-License-Identifier: GPL-2.0-only
//! Executes translated blocks. Each operation has a function, which ends by calling that of the next one: compiled, these calls
//! are jumps, and each has its own prediction.

mod action;
mod data;
mod float;
mod flow;
mod frequent;
mod transfer;

use super::Trap;
use super::access::Bus;
use super::decode::Block;
use super::op::Op;
use super::translate::Code;
use crate::time::CYCLES_PER_INSTRUCTION;
use action::Then;

/// How a block ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    /// The next block follows.
    Next,
    WaitForInterrupt,
    /// The chip's core holds a trap.
    Trap,
}

/// Executes an operation and those behind it.
type Handler = fn(&mut Bus, Op, &[Step], &Code) -> Ended;

/// An operation with what executes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    run: Handler,
    op: Op,
}

impl Step {
    /// The first of these operations. One that is executed with another one can still be executed alone: what leaves operations
    /// out may lead there.
    pub(super) fn first(ops: &[Op]) -> Self {
        let op = ops.first().copied().unwrap_or(Op::Nothing);
        let run = frequent::handler(ops)
            .or_else(|| data::handler(op))
            .or_else(|| transfer::handler(op))
            .or_else(|| flow::handler(op))
            .or_else(|| float::handler(op))
            .unwrap_or(missing);
        Self { run, op }
    }

    /// The others of these operations.
    pub(super) fn behind_first(ops: &[Op]) -> Box<[Self]> {
        let places = 1..ops.len();
        places
            .map(|place| Self::first(ops.get(place..).unwrap_or_default()))
            .collect()
    }
}

/// An operation that is not quick after all.
#[cold]
#[inline(never)]
fn elsewhere(bus: &mut Bus, op: Op, rest: &[Step], code: &Code) -> Ended {
    let run = transfer::handler(op).or_else(|| float::handler(op));
    run.unwrap_or(missing)(bus, op, rest, code)
}

/// There is none like this.
fn missing(bus: &mut Bus, _: Op, rest: &[Step], code: &Code) -> Ended {
    bus.trap(Trap::Undefined { encoding: None });
    At { rest, code }.stay(bus)
}

/// Place of an operation in its block.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    /// The operations behind it.
    rest: &'a [Step],
    code: &'a Code,
}

impl At<'_> {
    /// Goes on with the next operation, or ends the block.
    #[inline(always)]
    fn next(self, bus: &mut Bus) -> Ended {
        match self.rest.split_first() {
            Some((step, rest)) => (step.run)(bus, step.op, rest, self.code),
            None => Ended::Next,
        }
    }

    fn index(self) -> usize {
        self.code.steps.len() - self.rest.len()
    }

    /// Address of the instruction.
    fn address(self) -> u32 {
        let place = self.code.places.get(self.index());
        place.map_or(self.code.start, |place| place.address)
    }

    /// Instructions of the stretch from this one on.
    #[cold]
    pub(super) fn ahead(self) -> u32 {
        let place = self.code.places.get(self.index());
        place.map_or(0, |place| place.ahead.into())
    }

    /// The instruction was not executed.
    #[cold]
    #[inline(never)]
    fn stay(self, bus: &mut Bus) -> Ended {
        if let Some(place) = self.code.places.get(self.index()) {
            bus.registers.pc = self.address();
            bus.registers.it = place.it;
            // A breakpoint instruction counts as executed.
            if matches!(
                bus.chip.core.trap,
                Some(Trap::Bus { .. } | Trap::Undefined { .. } | Trap::Held { .. })
            ) {
                bus.chip.core.account.refund(self.ahead());
            }
        }
        Ended::Trap
    }
}

impl Bus {
    /// Runs a block; the program counter then stands at the next one, or at the instruction that could not be executed.
    #[inline(always)]
    pub(super) fn execute(&mut self, code: &Code) -> Ended {
        self.begin(&code.cost, code.end);
        self.registers.it = code.it_after;
        self.chip.core.event |= code.cost.sends_event;
        let Step { run, op } = code.first;
        run(self, op, &code.steps, code)
    }

    /// Begins a stretch: counts it before it runs, and advances time.
    #[inline(always)]
    fn begin(&mut self, cost: &Block, end: u32) {
        let chip = &mut self.chip;
        chip.core.account.charge(cost);
        let (numerator, denominator) = CYCLES_PER_INSTRUCTION;
        let cycles = u64::from(cost.instructions) * numerator;
        chip.now += cycles * chip.clocks().bus / denominator;
        self.registers.pc = end;
    }

    /// Goes on with the next stretch of the block, at which the program counter stands.
    #[inline(always)]
    fn cross<'a>(&mut self, rest: &'a [Step]) -> Then<'a> {
        match rest.split_first() {
            Some((step, rest)) => self.cross_by(step.op, rest),
            None => Err(Ended::Next),
        }
    }

    /// The same by the operation that stands between them. If something may be due before the stretch, the block ends.
    #[inline(always)]
    fn cross_by<'a>(&mut self, seam: Op, rest: &'a [Step]) -> Then<'a> {
        let Op::Seam(size, instructions, cycles_low, cycles_high) = seam else {
            return Err(Ended::Next);
        };
        if self.pauses() {
            return Err(Ended::Next);
        }
        let start = self.registers.pc;
        self.chip.core.block_address = start;
        let cost = Block {
            instructions: instructions.into(),
            cycles_low: cycles_low.into(),
            cycles_high: cycles_high.into(),
            ..Block::default()
        };
        self.begin(&cost, start.wrapping_add(size.into()));
        Ok(rest)
    }
}

/// Functions for operations: what each does, and how it goes on. Plain ones go on, trapping ones may end with `?`, ending ones
/// say themselves how the block ended.
macro_rules! handlers {
    (@plain $bus:ident, $at:ident, $body:expr) => {{
        $body;
        $at.next($bus)
    }};
    (@trapping $bus:ident, $at:ident, $body:expr) => {{
        let mut done = || -> Result<(), crate::cortex::access::Trapped> {
            $body;
            Ok(())
        };
        match done() {
            Ok(()) => $at.next($bus),
            Err(_) => $at.stay($bus),
        }
    }};
    (@ending $bus:ident, $at:ident, $body:expr) => {
        $body
    };
    ($kind:ident $op:ident, $bus:ident, $at:ident; $($pattern:pat => $body:expr,)+) => {
        #[allow(unused_variables, reason = "of the patterns, the functions use them")]
        match $op {
            $($pattern => Some({
                #[allow(unused_variables, reason = "not every operation needs its place")]
                fn run($bus: &mut Bus, op: Op, rest: &[Step], code: &Code) -> Ended {
                    let $pattern = op else {
                        return Ended::Next;
                    };
                    let $at = At { rest, code };
                    handlers!(@$kind $bus, $at, $body)
                }
                run as Handler
            }),)+
            _ => None,
        }
    };
}
use handlers;

/// A core register. Numbers are below 32; the mask spares the check.
macro_rules! r {
    ($bus:ident, $n:expr) => {
        $bus.registers.r[usize::from($n & 31)]
    };
}
use r;

/// A floating-point register.
macro_rules! s {
    ($bus:ident, $n:expr) => {
        $bus.registers.fpu.s[usize::from($n & 31)]
    };
}
use s;
