// SPDX-License-Identifier: GPL-2.0-only
//! Branches and what else ends a block; system instructions.

use super::super::Trap;
use super::super::access::{Bus, Trapped};
use super::super::debug::Resumed;
use super::super::op::{LR, Op, Width};
use super::super::translate::Code;
use super::{At, Ended, Handler, Step, handlers, r};

/// Least value of EXC_RETURN.
const RETURNS: u32 = 0xFF00_0000;

/// What executes an operation, if it is one of these.
pub(super) fn handler(op: Op) -> Option<Handler> {
    branch(op).or_else(|| system(op))
}

fn branch(op: Op) -> Option<Handler> {
    handlers! { ending op, bus, at;
        Op::CallRegister(m) => {
            let target = r!(bus, m);
            r!(bus, LR) = bus.registers.pc | 1;
            bus.registers.pc = target & !1;
            if target & 1 == 0 {
                return bus.after(Trap::Undefined { encoding: None });
            }
            Ended::Next
        },
        Op::Jump(m) => bus.jump(r!(bus, m)),
        Op::Table(n, m, half, from) => {
            let (width, index) = if half {
                (Width::Half, r!(bus, m) << 1)
            } else {
                (Width::Byte, r!(bus, m))
            };
            match bus.load(width, r!(bus, n).wrapping_add(index), at) {
                Ok(entry) => bus.jump(from.wrapping_add(2 * entry)),
                Err(Trapped) => at.stay(bus),
            }
        },
        Op::Supervisor => bus.after(Trap::Supervisor),
        Op::Breakpoint => {
            bus.trap(Trap::Breakpoint);
            at.stay(bus)
        },
        Op::Undefined(encoding) => {
            bus.trap(Trap::Undefined {
                encoding: Some(encoding),
            });
            at.stay(bus)
        },
        Op::Hold => {
            if bus.is_held(at.address()) {
                at.stay(bus)
            } else {
                at.next(bus)
            }
        },
        Op::WaitForInterrupt => Ended::WaitForInterrupt,
        Op::WaitForEvent => {
            if std::mem::take(&mut bus.chip.core.event) {
                at.next(bus)
            } else {
                bus.after(Trap::WaitForEvent)
            }
        },
    }
}

fn system(op: Op) -> Option<Handler> {
    handlers! { plain op, bus, at;
        Op::ReadSpecial(d, special) => r!(bus, d) = bus.registers.special(special),
        Op::WriteSpecial(n, mask, special) => {
                bus.chip.core.attention = true;
                bus.registers.set_special(special, mask, r!(bus, n));
            },
        Op::ChangeMasks(disable, primask, faultmask) => {
                bus.chip.core.attention = true;
                if primask {
                    bus.registers.primask = disable;
                }
                if faultmask {
                    bus.registers.faultmask = disable;
                }
            },
    }
}

impl Bus {
    #[inline(always)]
    pub(super) fn jump(&mut self, target: u32) -> Ended {
        self.registers.pc = target & !1;
        Ended::Next
    }

    /// A jump that may return from an exception, and that must stay in Thumb state.
    pub(super) fn exchange(&mut self, target: u32) -> Ended {
        self.registers.pc = target & !1;
        if self.registers.exception != 0 && target >= RETURNS {
            return self.after(Trap::Return(target | 1));
        }
        if target & 1 == 0 {
            return self.after(Trap::Undefined { encoding: None });
        }
        Ended::Next
    }

    /// The last operation traps after its instruction.
    fn after(&mut self, trap: Trap) -> Ended {
        self.trap(trap);
        Ended::Trap
    }

    /// Whether the core is halted before an instruction; where it was resumed it is not.
    fn is_held(&mut self, address: u32) -> bool {
        let Resumed { from, step } = self.chip.core.resumed;
        if from == Some(address) {
            return false;
        }
        self.chip.core.resumed.from = None;
        let stopped = self.breakpoints.at(address);
        if stopped || step {
            self.trap(Trap::Held { stepping: !stopped });
        }
        stopped || step
    }
}
