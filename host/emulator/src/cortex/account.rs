// SPDX-License-Identifier: GPL-2.0-only
//! Counts executed instructions: the whole run, every exception, watched functions.

use std::collections::BTreeMap;

use super::decode::Block;

/// Executed instructions and their estimated cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Executed instructions, exact; includes those skipped by an IT condition.
    pub instructions: u64,
    /// Cycles by the core's table at zero wait states.
    pub cycles_low: u64,
    /// Cycles with an upper estimate of the flash's wait states.
    pub cycles_high: u64,
}

impl Cost {
    #[inline]
    fn add(&mut self, block: &Block) {
        self.instructions += u64::from(block.instructions);
        self.cycles_low += u64::from(block.cycles_low);
        self.cycles_high += u64::from(block.cycles_high);
    }

    fn join(&mut self, other: Self) {
        self.instructions += other.instructions;
        self.cycles_low += other.cycles_low;
        self.cycles_high += other.cycles_high;
    }

    fn since(self, start: Self) -> Self {
        Self {
            instructions: self.instructions - start.instructions,
            cycles_low: self.cycles_low - start.cycles_low,
            cycles_high: self.cycles_high - start.cycles_high,
        }
    }
}

/// Calls of one exception handler or function: its own instructions and those of its callees, without exceptions that preempt it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calls {
    /// Finished calls.
    pub count: u64,
    /// Sum over the calls.
    pub total: Cost,
    /// Fewest instructions in one call.
    pub min_instructions: u64,
    /// The call with the most instructions.
    pub max: Cost,
}

/// Calls of a watched function: all, and separately those in which a watched function set apart ran, or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Watched {
    /// All.
    pub all: Calls,
    /// Those in which no function set apart ran.
    pub without: Calls,
    /// The others.
    pub with: Calls,
}

impl Calls {
    fn record(&mut self, cost: Cost) {
        self.min_instructions = if self.count == 0 {
            cost.instructions
        } else {
            self.min_instructions.min(cost.instructions)
        };
        self.count += 1;
        self.total.instructions += cost.instructions;
        self.total.cycles_low += cost.cycles_low;
        self.total.cycles_high += cost.cycles_high;
        if cost.instructions >= self.max.instructions {
            self.max = cost;
        }
    }
}

/// A running function. It ends when its caller continues in the same context with the same stack pointer.
#[derive(Clone, Copy, Debug)]
struct Frame {
    watch: u16,
    return_to: u32,
    stack: u32,
    depth: usize,
    start: Cost,
    /// Whether a function set apart ran inside.
    with_apart: bool,
}

/// Counts of all contexts.
#[derive(Debug)]
pub struct Account {
    /// Instructions of the innermost context so far.
    own: Cost,
    /// Instructions that thread mode (first) and the preempted exceptions executed, each with the number of the exception that
    /// preempted it.
    preempted: Vec<(u16, Cost)>,
    /// Instructions of contexts that have ended.
    ended: Cost,
    frames: Vec<Frame>,
    exceptions: BTreeMap<u16, Calls>,
    functions: Vec<(String, Watched)>,
    /// By function: whether calls around it are counted apart.
    apart: Vec<bool>,
}

impl Account {
    pub(crate) fn new() -> Self {
        Self {
            own: Cost::default(),
            preempted: Vec::new(),
            ended: Cost::default(),
            frames: Vec::new(),
            exceptions: BTreeMap::new(),
            functions: Vec::new(),
            apart: Vec::new(),
        }
    }

    /// Starts watching a function; its number is stored with its first block. Watched functions that call one that is `apart`
    /// count their calls with and without it separately.
    pub(crate) fn watch(&mut self, name: String, apart: bool) -> u16 {
        self.functions.push((name, Watched::default()));
        self.apart.push(apart);
        self.functions.len() as u16
    }

    #[inline(always)]
    pub(crate) fn charge(&mut self, block: &Block) {
        self.own.add(block);
    }

    /// Subtracts the instructions that a fault within a block prevented.
    pub(crate) fn refund(&mut self, instructions: u32) {
        self.own.instructions -= u64::from(instructions);
    }

    /// Return address of the innermost watched function.
    pub(crate) fn awaited_return(&self) -> Option<u32> {
        self.frames.last().map(|frame| frame.return_to)
    }

    #[cold]
    #[inline(never)]
    pub(crate) fn call(&mut self, watch: u16, return_to: u32, stack: u32) {
        let (depth, start) = self.here();
        if self.apart.get(usize::from(watch) - 1) == Some(&true) {
            for frame in self.frames.iter_mut().filter(|frame| frame.depth == depth) {
                frame.with_apart = true;
            }
        }
        self.frames.push(Frame {
            watch,
            return_to: return_to & !1,
            stack,
            depth,
            start,
            with_apart: false,
        });
    }

    /// Called when that address is about to run.
    #[cold]
    #[inline(never)]
    pub(crate) fn returned(&mut self, stack: u32) {
        let (depth, now) = self.here();
        while let Some(frame) = self.frames.last().copied() {
            if frame.depth != depth || stack < frame.stack {
                break;
            }
            self.frames.pop();
            if let Some((_, calls)) = self.functions.get_mut(usize::from(frame.watch) - 1) {
                let cost = now.since(frame.start);
                calls.all.record(cost);
                let separate = if frame.with_apart {
                    &mut calls.with
                } else {
                    &mut calls.without
                };
                separate.record(cost);
            }
        }
    }

    fn here(&self) -> (usize, Cost) {
        (self.preempted.len(), self.own)
    }

    /// Enters an exception; the cycles of the entry (lower and upper bound) count as its own.
    pub(crate) fn enter(&mut self, exception: u16, cycles_low: u32, cycles_high: u32) {
        self.preempted
            .push((exception, std::mem::take(&mut self.own)));
        self.pass(cycles_low, cycles_high);
    }

    /// Leaves an exception, with the cycles of the return.
    pub(crate) fn leave(&mut self, cycles_low: u32, cycles_high: u32) {
        self.pass(cycles_low, cycles_high);
        if let Some((exception, before)) = self.preempted.pop() {
            let cost = std::mem::replace(&mut self.own, before);
            self.ended.join(cost);
            self.frames
                .retain(|frame| frame.depth <= self.preempted.len());
            self.exceptions.entry(exception).or_default().record(cost);
        }
    }

    fn pass(&mut self, cycles_low: u32, cycles_high: u32) {
        self.charge(&Block {
            cycles_low,
            cycles_high,
            ..Block::default()
        });
    }

    /// On a reset all contexts end without counting as calls; thread mode continues.
    pub(crate) fn reset(&mut self) {
        while let Some((_, before)) = self.preempted.pop() {
            let cost = std::mem::replace(&mut self.own, before);
            self.ended.join(cost);
        }
        self.frames.clear();
    }

    /// Everything executed since power-on.
    #[must_use]
    pub fn total(&self) -> Cost {
        let mut total = self.ended;
        total.join(self.own);
        self.preempted
            .iter()
            .for_each(|(_, before)| total.join(*before));
        total
    }

    /// By exception number; interrupt n is 16 + n.
    #[must_use]
    pub fn exceptions(&self) -> &BTreeMap<u16, Calls> {
        &self.exceptions
    }

    /// Watched functions in the order in which they were named.
    #[must_use]
    pub fn functions(&self) -> &[(String, Watched)] {
        &self.functions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(instructions: u32) -> Block {
        Block {
            instructions,
            cycles_low: instructions,
            cycles_high: 2 * instructions,
            ..Block::default()
        }
    }

    #[test]
    fn a_function_is_charged_its_callees_but_not_what_preempted_it() {
        let mut account = Account::new();
        let outer = account.watch("outer".into(), false);
        let inner = account.watch("inner".into(), true);
        account.charge(&block(100));
        account.call(outer, 0x0800_0101, 0x2000_1000);
        account.charge(&block(10));
        account.call(inner, 0x0800_0201, 0x2000_0F00);
        account.charge(&block(3));
        account.enter(40, 12, 33);
        account.charge(&block(1000));
        account.leave(10, 27);
        account.returned(0x2000_0F00);
        account.charge(&block(5));
        account.returned(0x2000_1000);
        let calls: Vec<_> = account
            .functions()
            .iter()
            .map(|(_, calls)| calls.all.total.instructions)
            .collect();
        assert_eq!(calls, [18, 3]);
        // A call without the inner function: only this one counts as the outer function's own.
        account.call(outer, 0x0800_0101, 0x2000_1000);
        account.charge(&block(7));
        account.returned(0x2000_1000);
        let outer = account.functions()[0].1;
        assert_eq!((outer.all.count, outer.without.count), (2, 1));
        assert_eq!(outer.without.total.instructions, 7);
        assert_eq!((outer.with.count, outer.with.max.instructions), (1, 18));
        assert_eq!(account.functions()[1].1.without.count, 1);
        let Cost {
            instructions,
            cycles_low,
            cycles_high,
        } = account.exceptions()[&40].max;
        assert_eq!(
            [instructions, cycles_low, cycles_high],
            [1000, 1022, 2060],
            "its own, and the way in and out"
        );
        assert_eq!(account.total().instructions, 1125);
    }

    #[test]
    fn recursion_ends_at_its_own_level() {
        let mut account = Account::new();
        let f = account.watch("f".into(), false);
        account.call(f, 0x0800_0100, 0x2000_1000);
        account.charge(&block(1));
        account.call(f, 0x0800_0200, 0x2000_0FF0);
        account.charge(&block(1));
        account.returned(0x2000_0FF0);
        assert_eq!(account.functions()[0].1.all.count, 1);
        account.charge(&block(1));
        account.returned(0x2000_1000);
        assert_eq!(account.functions()[0].1.all.count, 2);
        assert_eq!(account.functions()[0].1.all.max.instructions, 3);
    }
}
