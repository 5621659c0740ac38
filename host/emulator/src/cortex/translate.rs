// SPDX-License-Identifier: GPL-2.0-only
//! Translates straight runs of instructions into operations.
//!
//! A stretch ends where the flow of control or the masks of interrupts may change, and at the end of a page: events and exceptions
//! are looked for between stretches only, and time advances by whole stretches. A block is a stretch with those that are known to
//! follow it, unless it jumps.

mod emit;

use super::Map;
use super::decode::{self, Block, Memory};
use super::execute::Step;
use super::memory::PROGRAM_SIZE;
use super::op::Op;

/// Stretches do not go beyond the page in which they start, bytes.
pub(super) const PAGE: u32 = 1024;
/// Operations of a block after which no other stretch follows.
const LONG: usize = 64;

/// What a block consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    /// One stretch, in which the core can be halted before every instruction.
    Steps,
    /// One stretch: calls and returns are looked for before each.
    Single,
    /// Stretches that follow each other.
    Joined,
}

/// Whether an instruction is the last of its stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    No,
    Yes,
}

/// Instruction that an operation belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) address: u32,
    /// Instructions of the stretch from this one on.
    pub(super) ahead: u16,
    /// IT state before it.
    pub(super) it: u8,
}

/// A translated block. What a run reads of it is one line of the cache.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Code {
    pub(super) first: Step,
    /// Those behind the first one.
    pub(super) steps: Box<[Step]>,
    /// Address behind its first stretch, the cost of that, and the IT state there.
    pub(super) end: u32,
    pub(super) cost: Block,
    pub(super) it_after: u8,
    pub(super) start: u32,
    /// Of each operation.
    pub(super) places: Box<[Place]>,
    /// Addresses between which it and its literals lie, as far as they are in the memory of its start.
    pub(super) taken: (u32, u32),
}

/// What cannot be fetched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoCode {
    pub(super) address: u32,
}

/// Builds one block.
pub(super) struct Translator<'a> {
    fetch: &'a dyn Fn(u32) -> Option<u16>,
    how: How,
    /// Of the block, and of the stretch.
    begin: u32,
    start: u32,
    address: u32,
    /// Between which addresses it and the literals of its memory lie.
    taken: (u32, u32),
    /// IT state of the instruction.
    it: u8,
    /// State that IT sets.
    it_begins: Option<u8>,
    /// The floating-point context exists from here on.
    in_context: bool,
    /// Instructions of the stretch before this one.
    index: u16,
    /// What follows the stretch unless it jumps, if that is known.
    follows: Option<u32>,
    ops: Vec<Op>,
    places: Vec<Place>,
}

/// Translates the block at `start`, which begins in this IT state.
pub(super) fn translate(
    start: u32,
    it: u8,
    how: How,
    fetch: &dyn Fn(u32) -> Option<u16>,
) -> Result<Code, NoCode> {
    let translator = Translator {
        fetch,
        how,
        begin: start,
        start,
        address: start,
        taken: (start, start),
        it,
        it_begins: None,
        in_context: false,
        index: 0,
        follows: None,
        ops: Vec::new(),
        places: Vec::new(),
    };
    translator.run()
}

impl Translator<'_> {
    fn run(mut self) -> Result<Code, NoCode> {
        let cost = self.stretch()?;
        let (end, it_after) = (self.address, self.it);
        let mut starts = vec![self.begin];
        while let Some(next) = self.follows.filter(|&next| self.may_follow(next))
            && !starts.contains(&next)
        {
            starts.push(next);
            let seam = self.ops.len();
            (self.start, self.address, self.index) = (next, next, 0);
            // Until its cost is known.
            self.push(Op::Nothing);
            let cost = self.stretch();
            if let Some(op) = cost.ok().and_then(Op::seam).filter(|_| self.it == 0)
                && let Some(place) = self.ops.get_mut(seam)
            {
                *place = op;
            } else {
                self.ops.truncate(seam);
                self.places.truncate(seam);
                break;
            }
        }
        Ok(Code {
            first: Step::first(&self.ops),
            steps: Step::behind_first(&self.ops),
            end,
            cost,
            it_after,
            start: self.begin,
            places: self.places.into_boxed_slice(),
            taken: self.taken,
        })
    }

    /// Whether a stretch can be part of this block: in the program or in the CCM SRAM as it, because changed code is dropped by
    /// memory.
    fn may_follow(&self, next: u32) -> bool {
        let within = |start: u32, size| {
            self.begin.wrapping_sub(start) < size && next.wrapping_sub(start) < size
        };
        let beside = within(Map::FLASH, PROGRAM_SIZE) || within(Map::CCM, Map::CCM_SIZE);
        beside && self.how == How::Joined && self.ops.len() < LONG
    }

    /// Translates up to where the flow of control may change; returns the cost.
    fn stretch(&mut self) -> Result<Block, NoCode> {
        let mut code = Vec::new();
        let first_op = self.ops.len();
        self.follows = None;
        loop {
            let fetched = match self.instruction() {
                Ok(fetched) => fetched,
                // The fault comes when the stretch that starts there is to run.
                Err(_) if self.index != 0 => break,
                Err(no_code) => return Err(no_code),
            };
            let size = if fetched > 0xFFFF { 4 } else { 2 };
            let halfwords = if size == 4 {
                vec![(fetched >> 16) as u16, fetched as u16]
            } else {
                vec![fetched as u16]
            };
            code.extend(halfwords.iter().flat_map(|half| half.to_le_bytes()));
            let conditional = !self.flags();
            let ends = self.one(fetched);
            self.address = self.address.wrapping_add(size);
            self.index += 1;
            if ends == Ends::Yes {
                let last = self.ops.last().filter(|_| !conditional);
                self.follows = last.and_then(|op| op.next(self.address));
                break;
            }
            if self.page_ends() {
                self.follows = (self.it == 0).then_some(self.address);
                break;
            }
        }
        let (from, to) = self.taken;
        self.taken = (from.min(self.start), to.max(self.address));
        let cost = decode::decode(&code, Memory::at(self.start));
        for place in self.places.iter_mut().skip(first_op) {
            place.ahead = (cost.instructions as u16).saturating_sub(place.ahead);
        }
        Ok(cost)
    }

    /// The instruction at the address: its first halfword above if it has two.
    fn instruction(&self) -> Result<u32, NoCode> {
        let fetch = |address| (self.fetch)(address).ok_or(NoCode { address });
        let first = fetch(self.address)?;
        if decode::length(first) == 2 {
            return Ok(first.into());
        }
        let second = fetch(self.address.wrapping_add(2))?;
        Ok(u32::from(first) << 16 | u32::from(second))
    }

    /// Whether the next instruction lies in the next page, or reaches into it.
    fn page_ends(&self) -> bool {
        let used = self.address.wrapping_sub(self.start & !(PAGE - 1));
        used >= PAGE
            || used >= PAGE - 3
                && (self.fetch)(self.address).is_none_or(|half| decode::length(half) == 4)
    }

    fn one(&mut self, op: u32) -> Ends {
        let condition = self.it >> 4;
        if self.how == How::Steps {
            self.emit(Op::Hold);
        }
        let before = self.ops.len();
        // BKPT has no condition.
        let conditional = self.it & 0xF != 0 && condition < 14 && op & 0xFFFF_FF00 != 0xBE00;
        if conditional {
            self.emit(Op::If(condition, 0));
        }
        let ends = if op > 0xFFFF {
            self.wide(op)
        } else {
            self.narrow(op as u16)
        };
        let emitted = self.ops.len() - before;
        if conditional && emitted == 1 {
            self.ops.pop();
            self.places.pop();
        } else if conditional && let Some(Op::If(_, skip)) = self.ops.get_mut(before) {
            *skip = (emitted - 1) as u8;
        }
        self.it = match self.it_begins.take() {
            Some(it) => it,
            None if self.it & 7 == 0 => 0,
            None => self.it & 0xE0 | self.it << 1 & 0x1F,
        };
        ends
    }

    pub(super) fn begin_it(&mut self, it: u8) {
        self.it_begins = Some(it);
    }

    pub(super) fn emit(&mut self, op: Op) {
        if let Some(last) = self.ops.last_mut()
            && self.how != How::Steps
            && self.it == 0
            && self.places.last().is_some_and(|place| place.it == 0)
            && let Some(both) = last.with(op)
        {
            *last = both;
            return;
        }
        self.push(op);
    }

    fn push(&mut self, op: Op) {
        self.ops.push(op);
        self.places.push(Place {
            address: self.address,
            // Those before it, until their number is known.
            ahead: self.index,
            it: self.it,
        });
    }

    /// The program counter as instructions read it.
    pub(super) fn pc(&self) -> u32 {
        self.address.wrapping_add(4)
    }

    /// The program counter as a base of literals.
    pub(super) fn literal_base(&self) -> u32 {
        self.pc() & !3
    }

    /// Whether a data operation of 16 bits sets flags.
    pub(super) fn flags(&self) -> bool {
        self.it & 0xF == 0
    }
}
