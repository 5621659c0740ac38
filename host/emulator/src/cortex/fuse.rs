// SPDX-License-Identifier: GPL-2.0-only
//! Two operations as one.

use super::decode::Block;
use super::op::Op;

/// In the condition of a floating-point comparison: every NaN is invalid.
pub(super) const SIGNALS: u8 = 0x80;

impl Op {
    /// Where the program goes on behind this last operation of a stretch that ends at `end`, unless it jumps; none if that is
    /// not known.
    pub(super) fn next(self, end: u32) -> Option<u32> {
        match self {
            Self::Branch(target) | Self::Call(target) => Some(target),
            Self::BranchIf(..)
            | Self::BranchZero(..)
            | Self::BranchNotZero(..)
            | Self::CmpImmBranch(..)
            | Self::CmpBranch(..)
            | Self::VcmpBranch(..)
            | Self::VcmpZeroBranch(..) => Some(end),
            _ => None,
        }
    }

    /// The beginning of a stretch of this cost; none if it cannot be part of a block.
    pub(super) fn seam(cost: Block) -> Option<Self> {
        let operands = (
            cost.size.try_into(),
            cost.instructions.try_into(),
            cost.cycles_low.try_into(),
            cost.cycles_high.try_into(),
        );
        match operands {
            (Ok(size), Ok(instructions), Ok(low), Ok(high)) if !cost.sends_event => {
                Some(Self::Seam(size, instructions, low, high))
            }
            _ => None,
        }
    }

    /// This operation and the one of the next instruction as one, if there is such a one. Neither of them can trap.
    pub(super) fn with(self, next: Self) -> Option<Self> {
        let signalling = |signals| if signals { SIGNALS } else { 0 };
        Some(match (self, next) {
            (Self::MovImm(d, low), Self::Movt(t, high)) if d == t => {
                Self::MovImm(d, low & 0xFFFF | u32::from(high) << 16)
            }
            (Self::CmpImm(n, imm), Self::BranchIf(condition, target)) if imm <= 0xFF => {
                Self::CmpImmBranch(n, imm as u8, condition, target)
            }
            (Self::Cmp(n, m), Self::BranchIf(condition, target)) => {
                Self::CmpBranch(n, m, condition, target)
            }
            (Self::Vcmp(d, m, signals), Self::VmrsFlags) => Self::VcmpFlags(d, m, signals),
            (Self::VcmpZero(d, signals), Self::VmrsFlags) => Self::VcmpZeroFlags(d, signals),
            (Self::VcmpFlags(d, m, signals), Self::BranchIf(condition, target)) => {
                Self::VcmpBranch(d, m, condition | signalling(signals), target)
            }
            (Self::VcmpZeroFlags(d, signals), Self::BranchIf(condition, target)) => {
                Self::VcmpZeroBranch(d, condition | signalling(signals), target)
            }
            _ => return None,
        })
    }
}
