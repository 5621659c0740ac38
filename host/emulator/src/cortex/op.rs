// SPDX-License-Identifier: GPL-2.0-only
//! Operations that blocks of instructions are translated into: operands resolved, eight bytes each.
//!
//! Why own code: no library of the kind is fast enough. The engine used before (Unicorn, with floating point in software) ran a
//! grasp 4 times faster than real time, interpreters on crates.io run fewer instructions than the chip does.

/// No destination: the result goes to a register that nothing reads.
pub(super) const NOWHERE: u8 = 16;
/// Register that [`Op::SetBase`] sets.
pub(super) const BASE: u8 = 17;
/// The program counter as a destination; a jump follows.
pub(super) const PC: u8 = 15;
pub(super) const LR: u8 = 14;
pub(super) const SP: u8 = 13;

/// Arithmetic and logic of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Alu {
    And,
    Bic,
    Orr,
    Orn,
    Eor,
    Add,
    Adc,
    Sub,
    Sbc,
    Rsb,
    /// The second operand.
    Mov,
    /// Its complement.
    Mvn,
}

/// Shift of a register; amounts are 1 to 32, `Rrx` has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shift {
    None,
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// What a load or store transfers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    Byte,
    Half,
    Word,
    SignedByte,
    SignedHalf,
}

/// Instructions of the DSP extension and other rare ones of up to four registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rare {
    /// Kind and operation in `a` as encoded, see [`super::dsp::parallel`].
    Parallel,
    Sel,
    Qadd,
    Qdadd,
    Qsub,
    Qdsub,
    Clz,
    Rbit,
    Rev,
    Rev16,
    Revsh,
    /// Extensions: rotation in `a`, addend in `n`.
    Sxtab,
    Uxtab,
    Sxtah,
    Uxtah,
    Sxtab16,
    Uxtab16,
    /// Halves are chosen by bits 0 (second) and 1 (first) of `x`.
    Smla,
    Smul,
    /// Bit 0 of `x`: second operand's half; exchanged halves; rounding.
    Smlaw,
    Smulw,
    Smlad,
    Smuad,
    Smlsd,
    Smusd,
    Smmla,
    Smmul,
    Smmls,
    Usad8,
    Usada8,
    /// Long: low part in `a`, high part in `d`.
    Smlal,
    Umlal,
    Umaal,
    SmlalHalves,
    Smlald,
    Smlsld,
    /// Saturation: bits in `a`, shift in `x` (bit 5: arithmetic right).
    Ssat,
    Usat,
    Ssat16,
    Usat16,
    /// Packs halves: shift in `x`; `a` is 1 for the variant with the top half.
    Pkh,
    Sbfx,
}

/// Floating-point operation of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Conversion {
    /// From integers.
    FromSigned,
    FromUnsigned,
    /// To integers, towards zero.
    ToSigned,
    ToUnsigned,
    /// To integers, in the mode of FPSCR.
    ToSignedRounded,
    ToUnsignedRounded,
    /// From and to fixed point.
    FromSigned16,
    FromUnsigned16,
    ToSigned16,
    ToUnsigned16,
}

/// One operation. Registers above 15 are the interpreter's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    Nop,
    /// Unless the condition holds, the next `skip` operations are left out.
    If {
        condition: u8,
        skip: u8,
    },
    /// Sets the carry after a logical operation with a rotated constant.
    Carry {
        set: bool,
    },
    /// Value of the program counter as a base address.
    SetBase {
        value: u32,
    },

    MovImm {
        d: u8,
        imm: u32,
    },
    /// Sets N and Z too.
    MovsImm {
        d: u8,
        imm: u32,
    },
    Mov {
        d: u8,
        m: u8,
    },
    Movt {
        d: u8,
        imm: u16,
    },
    AddImm {
        d: u8,
        n: u8,
        imm: u32,
    },
    Add {
        d: u8,
        n: u8,
        m: u8,
    },
    Sub {
        d: u8,
        n: u8,
        m: u8,
    },
    AddsImm {
        d: u8,
        n: u8,
        imm: u32,
    },
    SubsImm {
        d: u8,
        n: u8,
        imm: u32,
    },
    CmpImm {
        n: u8,
        imm: u32,
    },
    Cmp {
        n: u8,
        m: u8,
    },
    AndImm {
        d: u8,
        n: u8,
        imm: u32,
    },
    And {
        d: u8,
        n: u8,
        m: u8,
    },
    OrrImm {
        d: u8,
        n: u8,
        imm: u32,
    },
    Orr {
        d: u8,
        n: u8,
        m: u8,
    },
    LslImm {
        d: u8,
        m: u8,
        amount: u8,
    },
    LsrImm {
        d: u8,
        m: u8,
        amount: u8,
    },
    AsrImm {
        d: u8,
        m: u8,
        amount: u8,
    },
    AddShifted {
        d: u8,
        n: u8,
        m: u8,
        amount: u8,
    },
    /// Without flags.
    Alu {
        op: Alu,
        d: u8,
        n: u8,
        m: u8,
        shift: Shift,
        amount: u8,
    },
    /// With flags.
    AluS {
        op: Alu,
        d: u8,
        n: u8,
        m: u8,
        shift: Shift,
        amount: u8,
    },
    AluImm {
        op: Alu,
        d: u8,
        n: u8,
        imm: u32,
    },
    AluImmS {
        op: Alu,
        d: u8,
        n: u8,
        imm: u32,
    },
    /// Shift by a register.
    ShiftBy {
        shift: Shift,
        d: u8,
        n: u8,
        m: u8,
        flags: bool,
    },
    Uxtb {
        d: u8,
        m: u8,
    },
    Uxth {
        d: u8,
        m: u8,
    },
    Ubfx {
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
    },
    /// `n` inserts zeros if it is [`NOWHERE`].
    Bfi {
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
    },
    Mul {
        d: u8,
        n: u8,
        m: u8,
    },
    Muls {
        d: u8,
        n: u8,
        m: u8,
    },
    Mla {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
    },
    Mls {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
    },
    Umull {
        low: u8,
        high: u8,
        n: u8,
        m: u8,
    },
    Smull {
        low: u8,
        high: u8,
        n: u8,
        m: u8,
    },
    Udiv {
        d: u8,
        n: u8,
        m: u8,
    },
    Sdiv {
        d: u8,
        n: u8,
        m: u8,
    },
    Rare {
        op: Rare,
        d: u8,
        n: u8,
        m: u8,
        a: u8,
        x: u8,
    },

    Ldr {
        t: u8,
        n: u8,
        offset: u32,
    },
    Str {
        t: u8,
        n: u8,
        offset: u32,
    },
    Ldrb {
        t: u8,
        n: u8,
        offset: u32,
    },
    Strb {
        t: u8,
        n: u8,
        offset: u32,
    },
    LdrLiteral {
        t: u8,
        address: u32,
    },
    Load {
        width: Width,
        t: u8,
        n: u8,
        offset: u32,
    },
    Store {
        width: Width,
        t: u8,
        n: u8,
        offset: u32,
    },
    LoadIndexed {
        width: Width,
        t: u8,
        n: u8,
        m: u8,
        shift: u8,
    },
    StoreIndexed {
        width: Width,
        t: u8,
        n: u8,
        m: u8,
        shift: u8,
    },
    /// With write-back, before (`pre`) or after the access.
    LoadUpdate {
        width: Width,
        t: u8,
        n: u8,
        pre: bool,
        offset: i16,
    },
    StoreUpdate {
        width: Width,
        t: u8,
        n: u8,
        pre: bool,
        offset: i16,
    },
    Ldrd {
        t: u8,
        t2: u8,
        n: u8,
        offset: u32,
    },
    Strd {
        t: u8,
        t2: u8,
        n: u8,
        offset: u32,
    },
    LdrdUpdate {
        t: u8,
        t2: u8,
        n: u8,
        pre: bool,
        offset: i16,
    },
    StrdUpdate {
        t: u8,
        t2: u8,
        n: u8,
        pre: bool,
        offset: i16,
    },
    Ldm {
        n: u8,
        down: bool,
        update: bool,
        list: u16,
    },
    Stm {
        n: u8,
        down: bool,
        update: bool,
        list: u16,
    },
    Ldrex {
        width: Width,
        t: u8,
        n: u8,
        offset: u32,
    },
    Strex {
        width: Width,
        d: u8,
        t: u8,
        n: u8,
        offset: u16,
    },
    Clrex,

    Branch {
        target: u32,
    },
    BranchIf {
        condition: u8,
        target: u32,
    },
    BranchZero {
        n: u8,
        target: u32,
    },
    BranchNotZero {
        n: u8,
        target: u32,
    },
    Call {
        target: u32,
    },
    CallRegister {
        m: u8,
    },
    /// Exchanges state, and returns from exceptions.
    Exchange {
        m: u8,
    },
    Jump {
        m: u8,
    },
    /// Entry `m` of a table of bytes or halfwords.
    Table {
        n: u8,
        m: u8,
        half: bool,
        from: u32,
    },

    ReadSpecial {
        d: u8,
        special: u8,
    },
    WriteSpecial {
        n: u8,
        mask: u8,
        special: u8,
    },
    ChangeMasks {
        disable: bool,
        primask: bool,
        faultmask: bool,
    },
    Supervisor,
    Breakpoint,
    Undefined {
        encoding: u32,
    },
    WaitForInterrupt,
    WaitForEvent,

    /// The next operations need a floating-point context.
    Context,
    Vldr {
        d: u8,
        n: u8,
        offset: u32,
    },
    Vstr {
        d: u8,
        n: u8,
        offset: u32,
    },
    VldrLiteral {
        d: u8,
        address: u32,
    },
    Vldm {
        n: u8,
        first: u8,
        count: u8,
        down: bool,
        update: bool,
        extra: bool,
    },
    Vstm {
        n: u8,
        first: u8,
        count: u8,
        down: bool,
        update: bool,
        extra: bool,
    },
    /// From and to core registers.
    VmovToS {
        d: u8,
        t: u8,
    },
    VmovToR {
        t: u8,
        n: u8,
    },
    VmovPairToS {
        d: u8,
        t: u8,
        t2: u8,
    },
    VmovPairToR {
        d: u8,
        t: u8,
        t2: u8,
    },
    VmovImm {
        d: u8,
        imm: u32,
    },
    Vmov {
        d: u8,
        m: u8,
    },
    Vabs {
        d: u8,
        m: u8,
    },
    Vneg {
        d: u8,
        m: u8,
    },
    Vsqrt {
        d: u8,
        m: u8,
    },
    Vadd {
        d: u8,
        n: u8,
        m: u8,
    },
    Vsub {
        d: u8,
        n: u8,
        m: u8,
    },
    Vmul {
        d: u8,
        n: u8,
        m: u8,
    },
    Vnmul {
        d: u8,
        n: u8,
        m: u8,
    },
    Vdiv {
        d: u8,
        n: u8,
        m: u8,
    },
    Vmla {
        d: u8,
        n: u8,
        m: u8,
    },
    Vmls {
        d: u8,
        n: u8,
        m: u8,
    },
    Vnmla {
        d: u8,
        n: u8,
        m: u8,
    },
    Vnmls {
        d: u8,
        n: u8,
        m: u8,
    },
    /// Fused; the sign of the addend, of the first factor.
    Vfma {
        d: u8,
        n: u8,
        m: u8,
        negate: bool,
        negate_first: bool,
    },
    Vcmp {
        d: u8,
        m: u8,
        signals: bool,
    },
    VcmpZero {
        d: u8,
        signals: bool,
    },
    Vcvt {
        kind: Conversion,
        d: u8,
        m: u8,
        fraction: u8,
    },
    VmrsFlags,
    Vmrs {
        t: u8,
    },
    Vmsr {
        t: u8,
    },
}
