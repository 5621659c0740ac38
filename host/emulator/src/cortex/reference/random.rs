// SPDX-License-Identifier: GPL-2.0-only
//! Random registers and the classes of instructions.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::super::Map;
use super::State;

/// A number that is often at a limit.
fn number(random: &mut Pcg64) -> u32 {
    const LIMITS: [u32; 8] = [
        0,
        1,
        0x7FFF_FFFF,
        0x8000_0000,
        0xFFFF_FFFF,
        0x8000,
        0xFFFF,
        0x7FFF_8000,
    ];
    match random.random_range(0..6) {
        0 => LIMITS[random.random_range(0..LIMITS.len())],
        1 => random.random_range(0..64),
        2 => Map::RAM + random.random_range(0x200..Map::RAM_SIZE - 0x200),
        3 => Map::RAM + 4 * random.random_range(0x80..Map::RAM_SIZE / 4 - 0x80),
        4 => u32::from(random.random::<u16>()) << 16 | u32::from(random.random::<u8>()),
        _ => random.random(),
    }
}

/// A floating-point number: of every kind, near others.
fn float(random: &mut Pcg64) -> u32 {
    const KINDS: [u32; 14] = [
        0,
        0x0000_0001,
        0x007F_FFFF,
        0x0080_0000,
        0x3F80_0000,
        0x3F80_0001,
        0x7F7F_FFFF,
        0x7F80_0000,
        0x7F80_0001,
        0x7FC0_0000,
        0x7FC1_2345,
        0x4F00_0000,
        0x4F80_0000,
        0x3F00_0000,
    ];
    let sign = u32::from(random.random::<bool>()) << 31;
    sign ^ match random.random_range(0..5) {
        0 => KINDS[random.random_range(0..KINDS.len())],
        1 => random.random::<u32>() & 0x807F_FFFF | random.random_range(0x60..0xA0) << 23,
        2 => (random.random_range(-2000..2000) as f32 / 4.0).to_bits(),
        3 => random.random::<u32>() & 0x807F_FFFF | random.random_range(0..0x20) << 23,
        _ => random.random(),
    }
}

pub(super) fn state(random: &mut Pcg64, modes: bool) -> State {
    let mut core: [u32; 15] = std::array::from_fn(|_| number(random));
    core[13] = Map::RAM + 4 * random.random_range(0x100..0x1E00);
    let words: [u32; 32] = std::array::from_fn(|_| float(random));
    let mode = if modes {
        random.random::<u32>() & 0x03C0_0000
    } else {
        0
    };
    State {
        core,
        pc: 0,
        xpsr: random.random::<u32>() & 0xF80F_0000 | 1 << 24,
        double: std::array::from_fn(|n| {
            u64::from(words[2 * n]) | u64::from(words[2 * n + 1]) << 32
        }),
        fpscr: random.random::<u32>() & 0xF000_009F | mode,
    }
}

/// Bits that are given, and those among which the others are drawn.
pub(super) struct Class {
    pub(super) name: &'static str,
    pub(super) given: u32,
    pub(super) drawn: u32,
}

const fn class(name: &'static str, given: u32, drawn: u32) -> Class {
    Class { name, given, drawn }
}

pub(super) const CLASSES: &[Class] = &[
    class("16 bits", 0, 0xFFFF),
    class("16 bits, data", 0x4000, 0x07FF),
    class("16 bits, miscellaneous", 0xB000, 0x0FFF),
    class("load and store multiple", 0xE800_0000, 0x01BF_5FFF),
    class("dual, exclusive, table", 0xE840_0000, 0x01BF_FFFF),
    class("exclusive", 0xE840_0F00, 0x0010_F0FF),
    class("shifted register", 0xEA00_0000, 0x01FF_7FFF),
    class("modified constant", 0xF000_0000, 0x05FF_7FFF),
    class("plain constant", 0xF200_0000, 0x05FF_7FFF),
    class("bit fields", 0xF300_0000, 0x00FF_7FDF),
    class("branches", 0xF000_8000, 0x07FF_7FFF),
    class("single", 0xF800_0000, 0x01FF_FFFF),
    class("single, short", 0xF800_0800, 0x017F_F7FF),
    class("single, indexed", 0xF800_0000, 0x017F_F03F),
    class("register", 0xFA00_F000, 0x00FF_0FFF),
    class("parallel", 0xFA80_F000, 0x007F_0F7F),
    class("multiply", 0xFB00_0000, 0x007F_FF3F),
    class("multiply long", 0xFB80_0000, 0x007F_FFFF),
    class("divide", 0xFB90_F0F0, 0x002F_0F0F),
    class("floating transfers", 0xEC00_0A00, 0x01FF_F1FF),
    class("floating load and store", 0xED00_0A00, 0x009F_F13F),
    class("floating arithmetic", 0xEE00_0A00, 0x00FF_F0EF),
    class("floating one operand", 0xEEB0_0A40, 0x004F_F0AF),
    class("floating and core", 0xEE00_0A10, 0x00FF_F1EF),
];
