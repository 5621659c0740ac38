// SPDX-License-Identifier: GPL-2.0-only
//! Loads and stores.

use super::super::access::Bus;
use super::super::op::{Op, Width};
use super::super::translate::Code;
use super::{At, Ended, Handler, Step, handlers, missing, r, s};

/// What executes a frequent operation in RAM or on constants of the program, and leaves everything else to [`handler`]: a function
/// that calls nothing that comes back needs no registers saved.
pub(super) fn quick(op: Op) -> Option<Handler> {
    handlers! { ending op, bus, at;
        Op::Ldr(t, n, offset) => match bus.known(r!(bus, n).wrapping_add(offset)) {
            Some(bytes) => {
                r!(bus, t) = u32::from_le_bytes(bytes);
                at.next(bus)
            }
            None => elsewhere(bus, Op::Ldr(t, n, offset), at.rest, at.code),
        },
        Op::Ldrb(t, n, offset) => match bus.known(r!(bus, n).wrapping_add(offset)) {
            Some([byte]) => {
                r!(bus, t) = byte.into();
                at.next(bus)
            }
            None => elsewhere(bus, Op::Ldrb(t, n, offset), at.rest, at.code),
        },
        Op::Vldr(d, n, offset) => match bus.known(r!(bus, n).wrapping_add(offset)) {
            Some(bytes) => {
                s!(bus, d) = u32::from_le_bytes(bytes);
                at.next(bus)
            }
            None => elsewhere(bus, Op::Vldr(d, n, offset), at.rest, at.code),
        },
        Op::LoadIndexed(Width::Word, t, n, m, shift) => {
            let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
            match bus.known(address) {
                Some(bytes) => {
                    r!(bus, t) = u32::from_le_bytes(bytes);
                    at.next(bus)
                }
                None => elsewhere(bus, Op::LoadIndexed(Width::Word, t, n, m, shift), at.rest, at.code),
            }
        },
        Op::LoadIndexed(Width::Byte, t, n, m, shift) => {
            let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
            match bus.known(address) {
                Some([byte]) => {
                    r!(bus, t) = byte.into();
                    at.next(bus)
                }
                None => elsewhere(bus, Op::LoadIndexed(Width::Byte, t, n, m, shift), at.rest, at.code),
            }
        },
        Op::Load(Width::Half, t, n, offset) => match bus.known(r!(bus, n).wrapping_add(offset)) {
            Some(bytes) => {
                r!(bus, t) = u16::from_le_bytes(bytes).into();
                at.next(bus)
            }
            None => elsewhere(bus, Op::Load(Width::Half, t, n, offset), at.rest, at.code),
        },
        Op::Str(t, n, offset) => {
            let address = r!(bus, n).wrapping_add(offset);
            match bus.memory.store(address, r!(bus, t).to_le_bytes()) {
                Some(()) => at.next(bus),
                None => elsewhere(bus, Op::Str(t, n, offset), at.rest, at.code),
            }
        },
        Op::Strb(t, n, offset) => {
            let address = r!(bus, n).wrapping_add(offset);
            match bus.memory.store(address, [r!(bus, t) as u8]) {
                Some(()) => at.next(bus),
                None => elsewhere(bus, Op::Strb(t, n, offset), at.rest, at.code),
            }
        },
        Op::Vstr(d, n, offset) => {
            let address = r!(bus, n).wrapping_add(offset);
            match bus.memory.store(address, s!(bus, d).to_le_bytes()) {
                Some(()) => at.next(bus),
                None => elsewhere(bus, Op::Vstr(d, n, offset), at.rest, at.code),
            }
        },
        Op::Ldrd(t, t2, n, offset) => {
            let address = r!(bus, n).wrapping_add(offset);
            match (bus.known(address), bus.known(address.wrapping_add(4))) {
                (Some(first), Some(second)) => {
                    r!(bus, t) = u32::from_le_bytes(first);
                    r!(bus, t2) = u32::from_le_bytes(second);
                    at.next(bus)
                }
                _ => elsewhere(bus, Op::Ldrd(t, t2, n, offset), at.rest, at.code),
            }
        },
        Op::Stm(n, down, update, list) => {
            let count = list.count_ones();
            let (address, after) = block(r!(bus, n), down, count);
            let Some(words) = bus.memory.words_mut(address, count) else {
                return elsewhere(bus, Op::Stm(n, down, update, list), at.rest, at.code);
            };
            for (t, word) in Numbers(list).zip(words) {
                *word = r!(bus, t).to_le_bytes();
            }
            if update {
                r!(bus, n) = after;
            }
            at.next(bus)
        },
        Op::Ldm(n, down, update, list) => {
            let count = list.count_ones();
            let (address, after) = block(r!(bus, n), down, count);
            let Some(words) = bus.memory.words(address, count) else {
                return elsewhere(bus, Op::Ldm(n, down, update, list), at.rest, at.code);
            };
            for (t, word) in Numbers(list).zip(words) {
                r!(bus, t) = u32::from_le_bytes(*word);
            }
            if update {
                r!(bus, n) = after;
            }
            at.next(bus)
        },
    }
}

/// An operation that is not quick after all.
#[cold]
#[inline(never)]
fn elsewhere(bus: &mut Bus, op: Op, rest: &[Step], code: &Code) -> Ended {
    let run = handler(op).unwrap_or(missing);
    run(bus, op, rest, code)
}

/// What executes an operation, if it is one of these.
pub(super) fn handler(op: Op) -> Option<Handler> {
    handlers! { trapping op, bus, at;
        Op::Ldr(t, n, offset) => r!(bus, t) = bus.word(r!(bus, n).wrapping_add(offset), at)?,
        Op::Str(t, n, offset) => bus.store_word(r!(bus, n).wrapping_add(offset), r!(bus, t))?,
        Op::Ldrb(t, n, offset) => r!(bus, t) = bus.byte(r!(bus, n).wrapping_add(offset), at)?,
        Op::Strb(t, n, offset) => bus.store(Width::Byte, r!(bus, n).wrapping_add(offset), r!(bus, t))?,
        Op::LdrLiteral(t, address) => r!(bus, t) = bus.word(address, at)?,
        Op::Load(width, t, n, offset) => {
                r!(bus, t) = bus.load(width, r!(bus, n).wrapping_add(offset), at)?
            },
        Op::Store(width, t, n, offset) => {
                bus.store(width, r!(bus, n).wrapping_add(offset), r!(bus, t))?
            },
        Op::LoadIndexed(width, t, n, m, shift) => {
                let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
                r!(bus, t) = bus.load(width, address, at)?;
            },
        Op::StoreIndexed(width, t, n, m, shift) => {
                let address = r!(bus, n).wrapping_add(r!(bus, m) << (shift & 3));
                bus.store(width, address, r!(bus, t))?;
            },
        Op::LoadUpdate(width, t, n, pre, offset) => {
                let (address, after) = updated(r!(bus, n), pre, offset);
                let value = bus.load(width, address, at)?;
                r!(bus, n) = after;
                r!(bus, t) = value;
            },
        Op::StoreUpdate(width, t, n, pre, offset) => {
                let (address, after) = updated(r!(bus, n), pre, offset);
                bus.store(width, address, r!(bus, t))?;
                r!(bus, n) = after;
            },
        Op::Ldrd(t, t2, n, offset) => {
                let address = r!(bus, n).wrapping_add(offset);
                let first = bus.word(address, at)?;
                let second = bus.word(address.wrapping_add(4), at)?;
                (r!(bus, t), r!(bus, t2)) = (first, second);
            },
        Op::Strd(t, t2, n, offset) => {
                let address = r!(bus, n).wrapping_add(offset);
                bus.store_word(address, r!(bus, t))?;
                bus.store_word(address.wrapping_add(4), r!(bus, t2))?;
            },
        Op::LdrdUpdate(t, t2, n, pre, offset) => {
                let (address, after) = updated(r!(bus, n), pre, offset);
                let first = bus.word(address, at)?;
                let second = bus.word(address.wrapping_add(4), at)?;
                (r!(bus, t), r!(bus, t2)) = (first, second);
                r!(bus, n) = after;
            },
        Op::StrdUpdate(t, t2, n, pre, offset) => {
                let (address, after) = updated(r!(bus, n), pre, offset);
                bus.store_word(address, r!(bus, t))?;
                bus.store_word(address.wrapping_add(4), r!(bus, t2))?;
                r!(bus, n) = after;
            },
        Op::Ldm(n, down, update, list) => {
                let count = list.count_ones();
                let (mut address, after) = block(r!(bus, n), down, count);
                for t in Numbers(list) {
                    r!(bus, t) = bus.word(address, at)?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(bus, n) = after;
                }
            },
        Op::Stm(n, down, update, list) => {
                let count = list.count_ones();
                let (mut address, after) = block(r!(bus, n), down, count);
                for t in Numbers(list) {
                    bus.store_word(address, r!(bus, t))?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(bus, n) = after;
                }
            },
        Op::Ldrex(width, t, n, offset) => {
                let address = r!(bus, n).wrapping_add(offset);
                let value = bus.load(width, address, at)?;
                bus.registers.exclusive = Some((address, value));
                r!(bus, t) = value;
            },
        Op::Strex(width, d, t, n, offset) => {
                let address = r!(bus, n).wrapping_add(offset.into());
                let exclusive = bus.registers.exclusive.take();
                let unchanged = match exclusive {
                    Some((last, value)) if last == address => {
                        bus.load(width, address, at)? == value
                    }
                    _ => false,
                };
                if unchanged {
                    bus.store(width, address, r!(bus, t))?;
                }
                r!(bus, d) = u32::from(!unchanged);
            },
        Op::Clrex => bus.registers.exclusive = None,
        Op::Vldr(d, n, offset) => s!(bus, d) = bus.word(r!(bus, n).wrapping_add(offset), at)?,
        Op::Vstr(d, n, offset) => bus.store_word(r!(bus, n).wrapping_add(offset), s!(bus, d))?,
        Op::VldrLiteral(d, address) => s!(bus, d) = bus.word(address, at)?,
        Op::Vldm(n, first, count, down, update, extra) => {
                let words = u32::from(count) + u32::from(extra);
                let (mut address, after) = block(r!(bus, n), down, words);
                for d in first..first + count {
                    s!(bus, d) = bus.word(address, at)?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(bus, n) = after;
                }
            },
        Op::Vstm(n, first, count, down, update, extra) => {
                let words = u32::from(count) + u32::from(extra);
                let (mut address, after) = block(r!(bus, n), down, words);
                for d in first..first + count {
                    bus.store_word(address, s!(bus, d))?;
                    address = address.wrapping_add(4);
                }
                if update {
                    r!(bus, n) = after;
                }
            },
    }
}

/// Address of an access with write-back, and the base after it.
fn updated(base: u32, pre: bool, offset: i16) -> (u32, u32) {
    let after = base.wrapping_add_signed(offset.into());
    (if pre { after } else { base }, after)
}

/// Numbers of the registers in a list.
struct Numbers(u16);

impl Iterator for Numbers {
    type Item = u8;

    #[inline(always)]
    fn next(&mut self) -> Option<u8> {
        let lowest = self.0.trailing_zeros() as u8;
        let more = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        more.then_some(lowest)
    }
}

/// First address of an access to several words, and the base after it.
fn block(base: u32, down: bool, words: u32) -> (u32, u32) {
    if down {
        let start = base.wrapping_sub(4 * words);
        (start, start)
    } else {
        (base, base.wrapping_add(4 * words))
    }
}
