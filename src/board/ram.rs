//! Reads a word of each block of SRAM before anything is written: the first write to a block after a reset may be lost if no read came
//! before it (errata sheet ES0431, SRAM write error).

use core::arch::global_asm;

/// First addresses of SRAM1, SRAM2 and the alias of the CCM SRAM (RM0440).
const BLOCKS: [u32; 3] = [0x2000_0000, 0x2000_4000, 0x2000_5800];

// Assembly, because no Rust may run before RAM is set up. The start code calls this first, and has written nothing yet.
global_asm!(
    ".section .text.__pre_init, \"ax\", %progbits",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "mov.w r0, #{first}",
    "ldr r1, [r0]",
    "add.w r0, r0, #{second}",
    "ldr r1, [r0]",
    "add.w r0, r0, #{third}",
    "ldr r1, [r0]",
    "bx lr",
    ".size __pre_init, . - __pre_init",
    first = const BLOCKS[0],
    second = const BLOCKS[1] - BLOCKS[0],
    third = const BLOCKS[2] - BLOCKS[1],
);
