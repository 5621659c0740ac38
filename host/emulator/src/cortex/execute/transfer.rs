// SPDX-License-Identifier: GPL-2.0-only
//! Loads and stores.

use super::super::access::Bus;
use super::super::op::{Op, Width};
use super::super::translate::Code;
use super::{At, Ended, Handler, Step, handlers, r, s};

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
pub(super) struct Numbers(pub(super) u16);

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
pub(super) fn block(base: u32, down: bool, words: u32) -> (u32, u32) {
    if down {
        let start = base.wrapping_sub(4 * words);
        (start, start)
    } else {
        (base, base.wrapping_add(4 * words))
    }
}
