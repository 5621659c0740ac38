// SPDX-License-Identifier: GPL-2.0-only
//! What a translated block costs, decoded once and kept.
//!
//! The engine calls back once a block; the number of instructions in it follows from the Thumb encoding alone.
//! Cycles are a bracket: the core's table for zero wait states below, flash wait states on top above.

use super::Map;

/// Cost of one straight run of instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// Length in bytes: the engine may cut the same start into blocks of several lengths.
    pub size: u32,
    /// Instructions, those skipped by an IT condition included.
    pub instructions: u32,
    /// Cycles by the core's table, no wait states, division at its shortest.
    pub cycles_low: u32,
    /// Cycles with flash wait states: 4 a flash line of 8 bytes, 4 a taken branch, 4 a literal.
    pub cycles_high: u32,
    /// Contains SEV.
    pub sends_event: bool,
    /// Index of the watched function that starts here, plus one.
    pub watch: u16,
}

/// Decoded blocks by start address in the flash.
#[derive(Debug)]
pub struct Blocks {
    flash: Vec<Block>,
}

impl Blocks {
    pub(crate) fn new() -> Self {
        Self {
            flash: vec![Block::default(); (Map::FLASH_SIZE / 2) as usize],
        }
    }

    /// The slot of a start address; `None` outside the flash.
    pub(crate) fn slot(&mut self, address: u32) -> Option<&mut Block> {
        self.flash
            .get_mut((address.wrapping_sub(Map::FLASH) / 2) as usize)
    }
}

/// Length in bytes of the instruction that starts with this halfword.
#[must_use]
pub fn length(halfword: u16) -> usize {
    if halfword >> 11 >= 0b11101 { 4 } else { 2 }
}

/// Decodes one block.
#[must_use]
pub fn decode(code: &[u8]) -> Block {
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
        block.cycles_high += cost.cycles + cost.stall;
        block.sends_event |= first == SEV;
        at += size;
    }
    block.cycles_high += 4 * (block.size.div_ceil(8));
    block
}

/// Instructions in the first `bytes` of a block.
#[must_use]
pub fn count(code: &[u8]) -> u32 {
    decode(code).instructions
}

pub(crate) const WFE: u16 = 0xBF20;
pub(crate) const WFI: u16 = 0xBF30;
pub(crate) const SEV: u16 = 0xBF40;

struct Cost {
    cycles: u32,
    stall: u32,
}

const fn cost(cycles: u32) -> Cost {
    Cost { cycles, stall: 0 }
}

/// A branch: pipeline refill of one to three cycles, and the target's line from flash.
const fn branch(cycles: u32) -> Cost {
    Cost {
        cycles: cycles + 1,
        stall: 2 + 4,
    }
}

fn narrow(op: u16) -> Cost {
    match op >> 11 {
        // Load from a literal pool.
        0b01001 => Cost {
            cycles: 2,
            stall: 4,
        },
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
            // CBZ, CBNZ: not taken is the lower bound
            0x1 | 0x3 | 0x9 | 0xB => Cost {
                cycles: 1,
                stall: 3 + 4,
            },
            _ => cost(1),
        },
        // STM, LDM
        0b11000 | 0b11001 => cost(1 + (op & 0xFF).count_ones()),
        // Conditional branch: not taken is the lower bound
        0b11010 | 0b11011 => Cost {
            cycles: 1,
            stall: 3 + 4,
        },
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
                Cost {
                    cycles: 1,
                    stall: 3 + 4,
                }
            };
        }
        return branch(1);
    }
    // Load and store single; from a literal pool
    if op & 0xFE00_0000 == 0xF800_0000 {
        if op & 0x0010_F000 == 0x0010_F000 && op & 0x0060_0000 == 0x0040_0000 {
            return branch(2);
        }
        let literal = op & 0x001F_0000 == 0x001F_0000;
        return Cost {
            cycles: 2,
            stall: if literal { 4 } else { 0 },
        };
    }
    // Division: 2 to 12
    if op & 0xFFD0_F0F0 == 0xFB90_F0F0 {
        return Cost {
            cycles: 2,
            stall: 10,
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
        let double = op & 0x100 != 0;
        let literal = op & 0x000F_0000 == 0x000F_0000;
        return Cost {
            cycles: if double { 3 } else { 2 },
            stall: if load && literal { 4 } else { 0 },
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
        let block = decode(&code(&[0x2001, 0xF100, 0x0001, 0xF000, 0xF801, 0xBF00]));
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
            let block = decode(&code(instruction));
            assert_eq!(block.cycles_low, cycles, "{instruction:04x?}");
            assert!(block.cycles_high >= block.cycles_low + 4);
        }
    }

    #[test]
    fn finds_the_event() {
        assert!(decode(&code(&[0xBF00, SEV])).sends_event);
        assert!(!decode(&code(&[WFE, WFI])).sends_event);
    }
}
