//! Successors of an instruction: just enough of the Thumb-2 encoding (ARMv7-M architecture reference manual, A5, A7.7) to
//! follow control flow without a disassembler.

/// What an instruction does to the program counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Goes on, or returns to the caller.
    Local,
    /// Branch or call to an address known from the instruction.
    To(u32),
    /// Branch or call to an address in a register or in memory.
    Indirect,
    /// Undefined instruction, breakpoint or supervisor call: a trap.
    Trap,
}

/// Length in bytes of the instruction that begins with this halfword.
pub fn length(first: u16) -> u32 {
    if first >> 11 >= 0b11101 { 4 } else { 2 }
}

fn sign_extend(value: u32, bits: u32) -> i32 {
    let shift = 32 - bits;
    (value << shift).cast_signed() >> shift
}

const PC: u16 = 15;
const LR: u16 = 14;
const SP: u16 = 13;

/// Flow of a 16-bit instruction at `address`.
pub fn flow16(instruction: u16, address: u32) -> Flow {
    let to = |offset: i32| Flow::To(address.wrapping_add(4).wrapping_add_signed(offset));
    let i = instruction;
    match i >> 12 {
        // Conditional branch; the last two conditions encode UDF and SVC.
        0b1101 => match (i >> 8) & 0xF {
            0xE | 0xF => Flow::Trap,
            _ => to(sign_extend(u32::from(i & 0xFF) << 1, 9)),
        },
        0b1110 if i >> 11 == 0b11100 => to(sign_extend(u32::from(i & 0x7FF) << 1, 12)),
        // CBZ, CBNZ: forward by up to 126 bytes.
        0b1011 if i & 0xF500 == 0xB100 => {
            let offset = (i >> 9 & 1) << 6 | (i >> 3 & 0x1F) << 1;
            to(offset.into())
        }
        0b1011 if i >> 8 == 0xBE => Flow::Trap,
        0b0100 if i & 0xFF00 == 0x4700 => {
            let register = i >> 3 & 0xF;
            let links = i & 0x80 != 0;
            if register == LR && !links {
                Flow::Local
            } else {
                Flow::Indirect
            }
        }
        // ADD and MOV between any registers, into the program counter.
        0b0100 if matches!(i >> 8, 0x44 | 0x46) && (i >> 4 & 8 | i & 7) == PC => {
            if i >> 8 == 0x46 && i >> 3 & 0xF == LR {
                Flow::Local
            } else {
                Flow::Indirect
            }
        }
        _ => Flow::Local,
    }
}

/// Flow of a 32-bit instruction at `address`.
pub fn flow32(first: u16, second: u16, address: u32) -> Flow {
    if first >> 11 == 0b11110 && second & 0x8000 != 0 {
        return branch32(first, second, address);
    }
    // LDR (word): F850 with the base in the low bits. From the stack with post-increment it is a return.
    if first & 0xFFF0 == 0xF850 || first & 0xFFF0 == 0xF8D0 {
        let pops = first & 0xF == SP && second == 0xFB04;
        return if second >> 12 == PC && !pops {
            Flow::Indirect
        } else {
            Flow::Local
        };
    }
    // LDM, LDMDB with the program counter in the list; from the stack it is a return.
    if matches!(first & 0xFFD0, 0xE890 | 0xE910) && second & 0x8000 != 0 {
        return if first & 0xF == SP {
            Flow::Local
        } else {
            Flow::Indirect
        };
    }
    Flow::Local
}

fn branch32(first: u16, second: u16, address: u32) -> Flow {
    let s = u32::from(first >> 10 & 1);
    let (j1, j2) = (u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
    let low = u32::from(second & 0x7FF) << 1;
    let to = |offset: i32| Flow::To(address.wrapping_add(4).wrapping_add_signed(offset));
    let links_or_far = second & 0x1000 != 0;
    if links_or_far {
        // BL (bit 14 set) or B.W.
        let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
        let offset = s << 24 | i1 << 23 | i2 << 22 | u32::from(first & 0x3FF) << 12 | low;
        return to(sign_extend(offset, 25));
    }
    if second & 0x4000 != 0 {
        // BLX to ARM state does not exist on this core.
        return Flow::Trap;
    }
    match first >> 6 & 0xF {
        // Barriers, status registers, hints; UDF.W among them.
        0xE | 0xF => {
            if first & 0xFFF0 == 0xF7F0 && second & 0xF000 == 0xA000 {
                Flow::Trap
            } else {
                Flow::Local
            }
        }
        _ => {
            let offset = s << 20 | j2 << 19 | j1 << 18 | u32::from(first & 0x3F) << 12 | low;
            to(sign_extend(offset, 21))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Encodings taken from an assembler's listing, not from the code above.
    #[test]
    fn lengths_follow_the_first_five_bits() {
        assert_eq!(length(0xE000), 2); // b
        assert_eq!(length(0xE890), 4); // ldm.w
        assert_eq!(length(0xF000), 4); // bl
        assert_eq!(length(0xBF00), 2); // nop
    }

    #[test]
    fn short_branches_reach_their_targets() {
        assert_eq!(flow16(0xE7FE, 0x100), Flow::To(0x100)); // b .
        assert_eq!(flow16(0xD0FE, 0x100), Flow::To(0x100)); // beq .
        assert_eq!(flow16(0xD101, 0x100), Flow::To(0x106)); // bne .+6
        assert_eq!(flow16(0xB108, 0x100), Flow::To(0x106)); // cbz r0, .+6
        assert_eq!(flow16(0xB1B0, 0x100), Flow::To(0x130)); // cbz r0, .+48
    }

    #[test]
    fn long_branches_reach_their_targets() {
        assert_eq!(flow32(0xF7FF, 0xFFFE, 0x100), Flow::To(0x100)); // bl .
        assert_eq!(flow32(0xF000, 0xF802, 0x100), Flow::To(0x108)); // bl .+8
        assert_eq!(flow32(0xF000, 0xB802, 0x100), Flow::To(0x108)); // b.w .+8
        assert_eq!(flow32(0xF43F, 0xAFFE, 0x100), Flow::To(0x100)); // beq.w .
        assert_eq!(flow32(0xF001, 0xF800, 0x100), Flow::To(0x1104)); // bl .+0x1004
    }

    #[test]
    fn returns_are_local_and_register_jumps_are_not() {
        assert_eq!(flow16(0x4770, 0), Flow::Local); // bx lr
        assert_eq!(flow16(0xBD80, 0), Flow::Local); // pop {r7, pc}
        assert_eq!(flow32(0xE8BD, 0x8010, 0), Flow::Local); // pop.w {r4, pc}
        assert_eq!(flow32(0xF85D, 0xFB04, 0), Flow::Local); // ldr pc, [sp], #4
        assert_eq!(flow16(0x4780, 0), Flow::Indirect); // blx r0
        assert_eq!(flow16(0x4718, 0), Flow::Indirect); // bx r3
        assert_eq!(flow16(0x4687, 0), Flow::Indirect); // mov pc, r0
        assert_eq!(flow32(0xF8D0, 0xF000, 0), Flow::Indirect); // ldr.w pc, [r0]
    }

    #[test]
    fn traps_are_seen() {
        assert_eq!(flow16(0xDE00, 0), Flow::Trap); // udf #0
        assert_eq!(flow16(0xDF00, 0), Flow::Trap); // svc #0
        assert_eq!(flow16(0xBE00, 0), Flow::Trap); // bkpt #0
        assert_eq!(flow32(0xF7F0, 0xA000, 0), Flow::Trap); // udf.w #0
        assert_eq!(flow32(0xF3BF, 0x8F4F, 0), Flow::Local); // dsb
        assert_eq!(flow32(0xF3EF, 0x8010, 0), Flow::Local); // mrs r0, PRIMASK
    }
}
