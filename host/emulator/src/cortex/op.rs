// SPDX-License-Identifier: GPL-2.0-only
//! Operations that blocks of instructions are translated into: operands resolved, eight bytes each.
//!
//! Why own code: no library of the kind is fast enough. The engine used before (Unicorn, with floating point in software) ran a
//! grasp 4 times faster than real time, published interpreters run fewer instructions than the chip does.

/// No destination: the result goes to a register that nothing reads.
pub(super) const NOWHERE: u8 = 16;
/// Register that [`Op::SetBase`] sets.
pub(super) const BASE: u8 = 17;
/// The program counter as a destination; a jump follows.
pub(super) const PC: u8 = 15;
pub(super) const LR: u8 = 14;
pub(super) const SP: u8 = 13;

pub(super) use super::operands::{Alu, Conversion, Rare, Shift, Width};

/// One operation. Registers above 15 are the interpreter's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    /// What a block without operations begins with.
    Nothing,
    /// Unless the condition holds, the next `skip` operations are left out.
    /// condition, skip
    If(u8, u8),
    /// Sets the carry after a logical operation with a rotated constant.
    /// set
    Carry(bool),
    /// Value of the program counter as a base address.
    /// value
    SetBase(u32),

    /// d, imm
    MovImm(u8, u32),
    /// Sets N and Z too.
    /// d, imm
    MovsImm(u8, u32),
    /// d, m
    Mov(u8, u8),
    /// d, imm
    Movt(u8, u16),
    /// d, n, imm
    AddImm(u8, u8, u32),
    /// d, n, m
    Add(u8, u8, u8),
    /// d, n, m
    Sub(u8, u8, u8),
    /// d, n, imm
    AddsImm(u8, u8, u32),
    /// d, n, imm
    SubsImm(u8, u8, u32),
    /// n, imm
    CmpImm(u8, u32),
    /// n, m
    Cmp(u8, u8),
    /// d, n, imm
    AndImm(u8, u8, u32),
    /// d, n, m
    And(u8, u8, u8),
    /// d, n, imm
    OrrImm(u8, u8, u32),
    /// d, n, m
    Orr(u8, u8, u8),
    /// d, m, amount
    LslImm(u8, u8, u8),
    /// d, m, amount
    LsrImm(u8, u8, u8),
    /// d, m, amount
    AsrImm(u8, u8, u8),
    /// d, n, m, amount
    AddShifted(u8, u8, u8, u8),
    /// Without flags.
    /// op, d, n, m, shift, amount
    Alu(Alu, u8, u8, u8, Shift, u8),
    /// With flags.
    /// op, d, n, m, shift, amount
    AluS(Alu, u8, u8, u8, Shift, u8),
    /// Frequent ones of these, one operation each; shifts are by 1 to 31.
    /// d, n, m
    Adds(u8, u8, u8),
    /// d, n, m
    Subs(u8, u8, u8),
    /// d, n, m
    Ands(u8, u8, u8),
    /// d, n, m
    Orrs(u8, u8, u8),
    /// d, n, m
    Eors(u8, u8, u8),
    /// d, m
    Movs(u8, u8),
    /// d, m, amount
    LslsImm(u8, u8, u8),
    /// d, m, amount
    LsrsImm(u8, u8, u8),
    /// d, m, amount
    AsrsImm(u8, u8, u8),
    /// d, n, imm
    AndsImm(u8, u8, u32),
    /// d, n, m
    Eor(u8, u8, u8),
    /// op, d, n, imm
    AluImm(Alu, u8, u8, u32),
    /// op, d, n, imm
    AluImmS(Alu, u8, u8, u32),
    /// Shift by a register.
    /// shift, d, n, m, flags
    ShiftBy(Shift, u8, u8, u8, bool),
    /// d, m
    Uxtb(u8, u8),
    /// d, m
    Uxth(u8, u8),
    /// d, n, lsb, width
    Ubfx(u8, u8, u8, u8),
    /// `n` inserts zeros if it is [`NOWHERE`].
    /// d, n, lsb, width
    Bfi(u8, u8, u8, u8),
    /// d, n, m
    Mul(u8, u8, u8),
    /// d, n, m
    Muls(u8, u8, u8),
    /// d, n, m, a
    Mla(u8, u8, u8, u8),
    /// d, n, m, a
    Mls(u8, u8, u8, u8),
    /// low, high, n, m
    Umull(u8, u8, u8, u8),
    /// low, high, n, m
    Smull(u8, u8, u8, u8),
    /// d, n, m
    Udiv(u8, u8, u8),
    /// d, n, m
    Sdiv(u8, u8, u8),
    /// op, d, n, m, a, x
    Rare(Rare, u8, u8, u8, u8, u8),

    /// t, n, offset
    Ldr(u8, u8, u32),
    /// t, n, offset
    Str(u8, u8, u32),
    /// t, n, offset
    Ldrb(u8, u8, u32),
    /// t, n, offset
    Strb(u8, u8, u32),
    /// t, address
    LdrLiteral(u8, u32),
    /// width, t, n, offset
    Load(Width, u8, u8, u32),
    /// width, t, n, offset
    Store(Width, u8, u8, u32),
    /// width, t, n, m, shift
    LoadIndexed(Width, u8, u8, u8, u8),
    /// width, t, n, m, shift
    StoreIndexed(Width, u8, u8, u8, u8),
    /// With write-back, before (`pre`) or after the access.
    /// width, t, n, pre, offset
    LoadUpdate(Width, u8, u8, bool, i16),
    /// width, t, n, pre, offset
    StoreUpdate(Width, u8, u8, bool, i16),
    /// t, t2, n, offset
    Ldrd(u8, u8, u8, u32),
    /// t, t2, n, offset
    Strd(u8, u8, u8, u32),
    /// t, t2, n, pre, offset
    LdrdUpdate(u8, u8, u8, bool, i16),
    /// t, t2, n, pre, offset
    StrdUpdate(u8, u8, u8, bool, i16),
    /// n, down, update, list
    Ldm(u8, bool, bool, u16),
    /// n, down, update, list
    Stm(u8, bool, bool, u16),
    /// width, t, n, offset
    Ldrex(Width, u8, u8, u32),
    /// width, d, t, n, offset
    Strex(Width, u8, u8, u8, u16),
    Clrex,

    /// Two instructions at once: a comparison and the branch that it decides.
    /// n, imm, condition, target
    CmpImmBranch(u8, u8, u8, u32),
    /// n, m, condition, target
    CmpBranch(u8, u8, u8, u32),
    /// The same, with the move of the flags between them.
    /// d, m, signals and condition, target
    VcmpBranch(u8, u8, u8, u32),
    /// d, signals and condition, target
    VcmpZeroBranch(u8, u8, u32),
    /// A comparison and the move of its flags.
    /// d, m, signals
    VcmpFlags(u8, u8, bool),
    /// d, signals
    VcmpZeroFlags(u8, bool),

    /// The next stretch of the block begins.
    /// size in bytes, instructions, cycles_low, cycles_high
    Seam(u16, u8, u16, u16),
    /// target
    Branch(u32),
    /// condition, target
    BranchIf(u8, u32),
    /// n, target
    BranchZero(u8, u32),
    /// n, target
    BranchNotZero(u8, u32),
    /// target
    Call(u32),
    /// m
    CallRegister(u8),
    /// Exchanges state, and returns from exceptions.
    /// m
    Exchange(u8),
    /// m
    Jump(u8),
    /// Entry `m` of a table of bytes or halfwords.
    /// n, m, half, from
    Table(u8, u8, bool, u32),

    /// d, special
    ReadSpecial(u8, u8),
    /// n, mask, special
    WriteSpecial(u8, u8, u8),
    /// disable, primask, faultmask
    ChangeMasks(bool, bool, bool),
    Supervisor,
    Breakpoint,
    /// The core may be halted here.
    Hold,
    /// encoding
    Undefined(u32),
    WaitForInterrupt,
    WaitForEvent,

    /// The next operations need a floating-point context.
    Context,
    /// d, n, offset
    Vldr(u8, u8, u32),
    /// d, n, offset
    Vstr(u8, u8, u32),
    /// d, address
    VldrLiteral(u8, u32),
    /// n, first, count, down, update, extra
    Vldm(u8, u8, u8, bool, bool, bool),
    /// n, first, count, down, update, extra
    Vstm(u8, u8, u8, bool, bool, bool),
    /// From and to core registers.
    /// d, t
    VmovToS(u8, u8),
    /// t, n
    VmovToR(u8, u8),
    /// d, t, t2
    VmovPairToS(u8, u8, u8),
    /// d, t, t2
    VmovPairToR(u8, u8, u8),
    /// d, imm
    VmovImm(u8, u32),
    /// d, m
    Vmov(u8, u8),
    /// d, m
    Vabs(u8, u8),
    /// d, m
    Vneg(u8, u8),
    /// d, m
    Vsqrt(u8, u8),
    /// d, n, m
    Vadd(u8, u8, u8),
    /// d, n, m
    Vsub(u8, u8, u8),
    /// d, n, m
    Vmul(u8, u8, u8),
    /// d, n, m
    Vnmul(u8, u8, u8),
    /// d, n, m
    Vdiv(u8, u8, u8),
    /// d, n, m
    Vmla(u8, u8, u8),
    /// d, n, m
    Vmls(u8, u8, u8),
    /// d, n, m
    Vnmla(u8, u8, u8),
    /// d, n, m
    Vnmls(u8, u8, u8),
    /// Fused; the sign of the addend, of the first factor.
    /// d, n, m, negate, negate_first
    Vfma(u8, u8, u8, bool, bool),
    /// d, m, signals
    Vcmp(u8, u8, bool),
    /// d, signals
    VcmpZero(u8, bool),
    /// kind, d, m, fraction
    Vcvt(Conversion, u8, u8, u8),
    VmrsFlags,
    /// t
    Vmrs(u8),
    /// t
    Vmsr(u8),
}
