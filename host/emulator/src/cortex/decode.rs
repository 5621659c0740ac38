// SPDX-License-Identifier: GPL-2.0-only
//! Cost of a translated block, decoded once and cached.
//!
//! Counted once a block; the number of instructions in it follows from the Thumb encoding alone.
//! Cycles are given as bounds. Lower: the core's table at zero wait states. Upper: its most expensive case (pipeline refill,
//! division), plus wait states of fetches from flash.

use super::Map;

/// Cost of one straight run of instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// Length in bytes.
    pub size: u32,
    /// Instructions, those skipped by an IT condition included.
    pub instructions: u32,
    /// Cycles by the core's table, no wait states, division at its shortest.
    pub cycles_low: u32,
    /// Upper bound of cycles: pipeline refill after a branch 3, division 12; from flash, as if nothing were cached, 4 more for
    /// each line of 8 bytes, taken branch and literal. The CCM SRAM has no wait states.
    pub cycles_high: u32,
    /// Contains SEV.
    pub sends_event: bool,
    /// Index of the watched function that starts here, plus one.
    pub watch: u16,
}

/// Memory that instructions are fetched from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Flash, four wait states.
    Flash,
    /// CCM SRAM by its own address, none.
    Ccm,
}

impl Memory {
    /// Memory of an address; everything but CCM SRAM is flash.
    pub(crate) fn at(address: u32) -> Self {
        if address.wrapping_sub(Map::CCM) < Map::CCM_SIZE {
            Self::Ccm
        } else {
            Self::Flash
        }
    }
}

/// Length in bytes of the instruction that starts with this halfword.
#[must_use]
pub fn length(halfword: u16) -> usize {
    if halfword >> 11 >= 0b11101 { 4 } else { 2 }
}

/// Decodes one block, fetched from `memory`.
#[must_use]
pub fn decode(code: &[u8], memory: Memory) -> Block {
    let wait = match memory {
        Memory::Flash => FLASH_WAIT,
        Memory::Ccm => 0,
    };
    let mut block = Block {
        size: code.len() as u32,
        ..Block::default()
    };
    let halfword = |at: usize| match code.get(at..at + 2) {
        Some(bytes) => u16::from_le_bytes([bytes[0], bytes[1]]),
        None => 0,
    };
    let mut at = 0;
    while at < code.len() {
        let first = halfword(at);
        let size = length(first);
        let cost = if size == 4 {
            wide(first, halfword(at + 2))
        } else {
            narrow(first)
        };
        block.instructions += 1;
        block.cycles_low += cost.cycles;
        block.cycles_high += cost.cycles + cost.more + wait * u32::from(cost.fetches);
        block.sends_event |= first == SEV;
        at += size;
    }
    block.cycles_high += wait * block.size.div_ceil(FLASH_LINE);
    block
}

const SEV: u16 = 0xBF40;

/// Wait states of the flash at 170 MHz, and the bytes that one access brings.
pub(super) const FLASH_WAIT: u32 = 4;
const FLASH_LINE: u32 = 8;

/// What an instruction costs by the core's table.
struct Cost {
    cycles: u32,
    /// Additional cycles of the upper bound.
    more: u32,
    /// Whether it fetches out of sequence (target of a branch, literal), which costs wait states again.
    fetches: bool,
}

const fn cost(cycles: u32) -> Cost {
    Cost {
        cycles,
        more: 0,
        fetches: false,
    }
}

/// A branch: one to three cycles to refill the pipeline.
const fn branch(cycles: u32) -> Cost {
    Cost {
        cycles: cycles + 1,
        more: 2,
        fetches: true,
    }
}

/// A conditional branch: the lower bound is that of a branch not taken.
const CONDITIONAL: Cost = Cost {
    cycles: 1,
    more: 3,
    fetches: true,
};

/// A load relative to the program counter.
const fn literal(cycles: u32) -> Cost {
    Cost {
        cycles,
        more: 0,
        fetches: true,
    }
}

fn narrow(op: u16) -> Cost {
    match op >> 11 {
        // Load from a literal pool.
        0b01001 => literal(2),
        0b01000 => match op >> 8 & 0x7 {
            // BX, BLX
            0b111 => branch(1),
            // ADD/MOV to PC
            0b100 | 0b110 if op & 0x87 == 0x87 => branch(1),
            _ => cost(1),
        },
        0b01010..=0b10011 => cost(2),
        0b10110 | 0b10111 => match op >> 8 & 0xF {
            // PUSH, POP
            0x4 | 0x5 => cost(1 + (op & 0x1FF).count_ones()),
            0xC => cost(1 + (op & 0xFF).count_ones()),
            0xD if op & 0x100 != 0 => branch(1 + (op & 0x1FF).count_ones()),
            0xD => cost(1 + (op & 0xFF).count_ones()),
            // CBZ, CBNZ
            0x1 | 0x3 | 0x9 | 0xB => CONDITIONAL,
            _ => cost(1),
        },
        // STM, LDM
        0b11000 | 0b11001 => cost(1 + (op & 0xFF).count_ones()),
        0b11010 | 0b11011 => CONDITIONAL,
        0b11100 => branch(1),
        _ => cost(1),
    }
}

fn wide(first: u16, second: u16) -> Cost {
    let op = u32::from(first) << 16 | u32::from(second);
    // Load and store multiple
    if op & 0xFE40_0000 == 0xE800_0000 {
        let registers = (op & 0xFFFF).count_ones();
        return if op & 0x0010_8000 == 0x0010_8000 {
            branch(1 + registers)
        } else {
            cost(1 + registers)
        };
    }
    // Table branch, then load and store double or exclusive
    if op & 0xFFF0_FFE0 == 0xE8D0_F000 {
        return branch(2);
    }
    if op & 0xFE40_0000 == 0xE840_0000 {
        return cost(3);
    }
    // Branches and barriers
    if op & 0xF800_8000 == 0xF000_8000 {
        if op & 0x5000 == 0 {
            return if op & 0x0380_0000 == 0x0380_0000 {
                cost(2)
            } else {
                CONDITIONAL
            };
        }
        return branch(1);
    }
    // Load and store single; from a literal pool
    if op & 0xFE00_0000 == 0xF800_0000 {
        if op & 0x0010_F000 == 0x0010_F000 && op & 0x0060_0000 == 0x0040_0000 {
            return branch(2);
        }
        let from_pc = op & 0x001F_0000 == 0x001F_0000;
        return if from_pc { literal(2) } else { cost(2) };
    }
    // Division: 2 to 12
    if op & 0xFFD0_F0F0 == 0xFB90_F0F0 {
        return Cost {
            more: 10,
            ..cost(2)
        };
    }
    if op & 0xEC00_0E00 == 0xEC00_0A00 {
        return floating(op);
    }
    cost(1)
}

fn floating(op: u32) -> Cost {
    if op & 0xFF00_0000 == 0xEE00_0000 {
        if op & 0x10 != 0 {
            // Between core and floating-point registers
            return cost(if op & 0x00E0_0000 == 0x00E0_0000 {
                1
            } else {
                2
            });
        }
        let opcode = op >> 20 & 0xB;
        return match opcode {
            // VMLA, VMLS, VNMLA, VNMLS, VFMA, VFMS, VFNMA, VFNMS
            0x0 | 0x1 | 0x9 | 0xA => cost(3),
            // VDIV
            0x8 => cost(14),
            // VSQRT
            0xB if op & 0x000F_00C0 == 0x0001_00C0 => cost(14),
            _ => cost(1),
        };
    }
    // VLDR, VSTR; VLDM, VSTM, VPUSH, VPOP; two core registers
    let load = op & 0x0010_0000 != 0;
    if op & 0x0120_0000 == 0x0100_0000 {
        let cycles = if op & 0x100 != 0 { 3 } else { 2 };
        let from_pc = op & 0x000F_0000 == 0x000F_0000;
        return if load && from_pc {
            literal(cycles)
        } else {
            cost(cycles)
        };
    }
    if op & 0x01E0_0000 == 0x0040_0000 {
        return cost(2);
    }
    cost(1 + (op & 0xFF))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(halfwords: &[u16]) -> Vec<u8> {
        halfwords.iter().flat_map(|h| h.to_le_bytes()).collect()
    }

    #[test]
    fn counts_narrow_and_wide_instructions() {
        // movs r0,#1; add.w r0,r0,#1; bl; nop
        let block = decode(
            &code(&[0x2001, 0xF100, 0x0001, 0xF000, 0xF801, 0xBF00]),
            Memory::Flash,
        );
        assert_eq!(block.instructions, 4);
        assert_eq!(block.size, 12);
        assert!(!block.sends_event);
    }

    #[test]
    fn follows_the_cycle_table() {
        // One instruction each with its cycles at zero wait states.
        let table: [(&[u16], u32); 14] = [
            (&[0x1840], 1),          // adds r0,r0,r1
            (&[0x6808], 2),          // ldr r0,[r1]
            (&[0x4801], 2),          // ldr r0,[pc,#4]
            (&[0xB5F0], 6),          // push {r4-r7,lr}
            (&[0x4770], 2),          // bx lr
            (&[0xEEB1, 0x0AC0], 14), // vsqrt.f32 s0,s0
            (&[0xEE80, 0x0A20], 14), // vdiv.f32 s0,s0,s1
            (&[0xEE30, 0x0A20], 1),  // vadd.f32 s0,s0,s1
            (&[0xEE20, 0x0A20], 1),  // vmul.f32 s0,s0,s1
            (&[0xEEA0, 0x0A20], 3),  // vfma.f32 s0,s0,s1
            (&[0xED90, 0x0A00], 2),  // vldr s0,[r0]
            (&[0xEE10, 0x0A10], 2),  // vmov r0,s0
            (&[0xE9D0, 0x0100], 3),  // ldrd r0,r1,[r0]
            (&[0xFBB0, 0xF0F1], 2),  // udiv r0,r0,r1
        ];
        for (instruction, cycles) in table {
            let block = decode(&code(instruction), Memory::Flash);
            assert_eq!(block.cycles_low, cycles, "{instruction:04x?}");
            assert!(block.cycles_high >= block.cycles_low + 4);
        }
    }

    #[test]
    fn flash_makes_fetches_wait_and_ccm_does_not() {
        // Upper bound of one instruction, from CCM SRAM and from flash.
        let table: [(&[u16], u32, u32); 9] = [
            (&[0x1840], 1, 5),           // adds r0,r0,r1: a line
            (&[0x6808], 2, 6),           // ldr r0,[r1]: a line, its datum is not known to be there
            (&[0x4801], 2, 10),          // ldr r0,[pc,#4]: a line and a literal
            (&[0xED9F, 0x0A01], 2, 10),  // vldr s0,[pc,#4]
            (&[0x4770], 4, 12),          // bx lr: refill, a line and the target's
            (&[0xD001], 4, 12),          // beq: taken
            (&[0xB108], 4, 12),          // cbz: taken
            (&[0xF000, 0xF800], 4, 12),  // bl
            (&[0xFBB0, 0xF0F1], 12, 16), // udiv r0,r0,r1
        ];
        for (instruction, ccm, flash) in table {
            let most = |memory| decode(&code(instruction), memory).cycles_high;
            assert_eq!(most(Memory::Ccm), ccm, "{instruction:04x?}");
            assert_eq!(most(Memory::Flash), flash, "{instruction:04x?}");
        }
        let least = |memory| decode(&code(&[0x4770]), memory).cycles_low;
        assert_eq!(least(Memory::Ccm), least(Memory::Flash));
    }

    #[test]
    fn an_address_is_fetched_from_one_memory() {
        for address in [Map::CCM, Map::CCM + Map::CCM_SIZE - 2] {
            assert_eq!(Memory::at(address), Memory::Ccm);
        }
        for address in [0, Map::FLASH, Map::CCM - 2, Map::CCM + Map::CCM_SIZE] {
            assert_eq!(Memory::at(address), Memory::Flash);
        }
    }

    #[test]
    fn finds_the_event() {
        assert!(decode(&code(&[0xBF00, SEV]), Memory::Flash).sends_event);
        assert!(!decode(&code(&[0xBF20, 0xBF30]), Memory::Flash).sends_event);
    }
}
