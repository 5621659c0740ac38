// SPDX-License-Identifier: GPL-2.0-only
//! What an [operation](super::op::Op) does with its operands, of operations that come in several kinds.

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
