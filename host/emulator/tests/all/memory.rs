// SPDX-License-Identifier: GPL-2.0-only
//! The functions of the firmware that copy and fill memory. They are assembly, of which the compiler checks nothing, and a grasp
//! calls them with few lengths.
//!
//! They are taken from the firmware's image and stay at their addresses. A driver of one call is in the pages of records, where no
//! image has code, and the rest of the flash is erased: what leaves a function but by its return is a fault.

use palpate::app::storage::store::{PAGE, PAGES};
use palpate_emulator::chip::FLASH_SIZE;
use palpate_emulator::firmware::Function;
use palpate_emulator::time::TICKS_PER_MS;
use palpate_emulator::{Firmware, Machine, Pause, Setup};

use crate::support;

const FLASH: u32 = 0x0800_0000;
const FLASH_END: u32 = FLASH + FLASH_SIZE as u32;
const RAM: u32 = 0x2000_0000;
const STACK: u32 = RAM + 0x4000;
/// Where destinations lie, away from the results and the stack.
const DESTINATION: u32 = RAM + 0x1000;
/// What is compared before and behind a destination, bytes.
const GUARD: u32 = 64;
/// Where the driver is in flash.
const DRIVER: usize = FLASH_SIZE - PAGES * PAGE;
const HANDLER: u32 = 0x20;
const RECORD: usize = 0x2C;
/// A page of bytes to copy, the last of the flash: what reads behind its end is a fault.
const SOURCE: usize = FLASH_SIZE - PAGE;
/// What to fill with. Of an int, the lowest byte counts: were it extended with its sign, or more of it taken, that would show.
const VALUE: u32 = 0x5A96_C3A4;
/// More than a byte holds, and no multiple of four.
const LONG: u32 = 1027;

/// Instructions that a call may take, the driver's included, beside two for each byte: one that moves single bytes where words would
/// do takes four for each.
const OVERHEAD: u32 = 50;

/// Calls a function with the registers of a record and stores the registers that it leaves: r0 to r11 and the stack pointer.
/// Of the flags, the carry is set.
///
/// ```text
/// adr.w r12, record
/// ldm r12, {r0-r11}
/// ldr.w r12, record+48
/// cmp r0, r0
/// blx r12
/// mov r12, #0x20000000
/// stm r12, {r0-r11}
/// str sp, [r12, #48]
/// ldr r1, =0x20026
/// b 1f
/// handler: movs r1, #0
/// 1: movs r0, #0x18
/// bkpt #0xab
/// record:
/// ```
const CALL: &[u16] = &[
    0xf20f, 0x0c28, 0xe89c, 0x0fff, 0xf8df, 0xc050, 0x4280, 0x47e0, 0xf04f, 0x5c00, 0xe88c, 0x0fff,
    0xf8cc, 0xd030, 0x4902, 0xe000, 0x2100, 0x2018, 0xbeab, 0xbf00, 0x0026, 0x0002,
];

/// What a function does with r0 to r2.
#[derive(Clone, Copy)]
enum Kind {
    /// Destination, source, length.
    Copy,
    /// Destination, value, length.
    Fill,
    /// Destination, length, value.
    FillLengthFirst,
    /// Destination, length.
    Clear,
}

/// Name, kind, alignment that its callers promise, whether it returns the destination.
const FUNCTIONS: [(&str, Kind, u32, bool); 11] = [
    ("memcpy", Kind::Copy, 1, true),
    ("memset", Kind::Fill, 1, true),
    ("__aeabi_memcpy", Kind::Copy, 1, false),
    ("__aeabi_memcpy4", Kind::Copy, 4, false),
    ("__aeabi_memcpy8", Kind::Copy, 8, false),
    ("__aeabi_memset", Kind::FillLengthFirst, 1, false),
    ("__aeabi_memset4", Kind::FillLengthFirst, 4, false),
    ("__aeabi_memset8", Kind::FillLengthFirst, 8, false),
    ("__aeabi_memclr", Kind::Clear, 1, false),
    ("__aeabi_memclr4", Kind::Clear, 4, false),
    ("__aeabi_memclr8", Kind::Clear, 8, false),
];

/// One call.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    kind: Kind,
    returns: bool,
    /// Address of the function.
    function: u32,
    destination: u32,
    source: u32,
    length: u32,
}

impl Case {
    /// r0 to r11. Those which the function has no use for hold what shows when it uses or changes them.
    fn registers(&self) -> [u32; 12] {
        let mut registers = std::array::from_fn(|n| 0x9111_1111 * n as u32 + 0x5A5A);
        registers[0] = self.destination;
        match self.kind {
            Kind::Copy => (registers[1], registers[2]) = (self.source, self.length),
            Kind::Fill => (registers[1], registers[2]) = (VALUE, self.length),
            Kind::FillLengthFirst => (registers[1], registers[2]) = (self.length, VALUE),
            Kind::Clear => registers[1] = self.length,
        }
        registers
    }

    /// What the destination holds afterwards.
    fn filled(&self, flash: &[u8]) -> Vec<u8> {
        let length = self.length as usize;
        match self.kind {
            Kind::Copy => flash[(self.source - FLASH) as usize..][..length].to_vec(),
            Kind::Fill | Kind::FillLengthFirst => vec![VALUE as u8; length],
            Kind::Clear => vec![0; length],
        }
    }

    /// Runs it on a chip of its own. What is wrong, if anything.
    fn check(&self, flash: &[u8]) -> Result<(), String> {
        let registers = self.registers();
        let mut flash = flash.to_vec();
        for (n, word) in registers.iter().chain([&(self.function | 1)]).enumerate() {
            flash[DRIVER + RECORD + 4 * n..][..4].copy_from_slice(&word.to_le_bytes());
        }
        let firmware = Firmware::raw(flash);
        let fail = |what: String| {
            Err(format!(
                "{}, {:x?} in r0 to r2: {what}",
                self.name,
                &registers[..3]
            ))
        };
        let mut machine =
            Machine::new(&firmware, None, &Setup::default()).expect("the engine starts");
        let mut expected = self.surroundings(&machine);
        let start = (GUARD + self.destination % 4) as usize;
        expected[start..start + self.length as usize]
            .copy_from_slice(&self.filled(machine.flash()));
        match machine.run_until(TICKS_PER_MS) {
            Ok(Pause::Exit(0)) => {}
            other => return fail(format!("{other:?}, {:?}", machine.take_notes())),
        }
        let found = self.surroundings(&machine);
        if let Some(at) = (0..found.len()).find(|&at| found[at] != expected[at]) {
            let place = at as i64 - start as i64;
            return fail(format!(
                "{:#x} in place of {:#x} at {place}",
                found[at], expected[at]
            ));
        }
        let instructions = machine.account().total().instructions;
        if instructions > u64::from(2 * self.length + OVERHEAD) {
            return fail(format!("{instructions} instructions"));
        }
        let after: [u32; 13] =
            std::array::from_fn(|n| machine.word(RAM + 4 * n as u32).expect("it is RAM"));
        if after[4..12] != registers[4..] || after[12] != STACK {
            return fail(format!("{after:x?} in r0 to r11 and sp"));
        }
        if self.returns && after[0] != self.destination {
            return fail(format!("returns {:#x}", after[0]));
        }
        Ok(())
    }

    /// The destination, with what is before and behind it, from and to a multiple of four.
    fn surroundings(&self, machine: &Machine<'_>) -> Vec<u8> {
        let from = self.destination - self.destination % 4 - GUARD;
        let to = (self.destination + self.length + GUARD).next_multiple_of(4);
        let words = (from..to).step_by(4);
        words
            .flat_map(|address| machine.word(address).expect("it is RAM").to_le_bytes())
            .collect()
    }
}

/// The functions' code. The last three are one piece, entered at three places.
fn bodies(firmware: &Firmware) -> [&Function; 4] {
    ["memcpy", "__aeabi_memclr", "__aeabi_memset", "memset"].map(|name| {
        let mut found = firmware.functions(name).filter(|f| f.name == name);
        found.next().expect(name)
    })
}

/// A flash with the functions, the driver, and bytes to copy that repeat after 251: a byte from another place shows.
fn prepared(firmware: &Firmware) -> Vec<u8> {
    let image = firmware.flashed_over(&[]);
    let mut flash = vec![0xFF; FLASH_SIZE];
    for body in bodies(firmware) {
        let start = (body.address - FLASH) as usize;
        let code = start..start + body.size as usize;
        flash[code.clone()].copy_from_slice(&image[code]);
    }
    let driver = FLASH + DRIVER as u32;
    let handler = (driver + HANDLER) | 1;
    let vectors = [STACK, driver | 1].into_iter().chain([handler; 116]);
    for (n, vector) in vectors.enumerate() {
        flash[4 * n..4 * n + 4].copy_from_slice(&vector.to_le_bytes());
    }
    for (n, halfword) in CALL.iter().enumerate() {
        flash[DRIVER + 2 * n..][..2].copy_from_slice(&halfword.to_le_bytes());
    }
    for (n, byte) in flash[SOURCE..].iter_mut().enumerate() {
        *byte = (n % 251) as u8;
    }
    flash
}

/// Calls of every function: every length with every alignment, and what is copied also from the very end of the flash.
fn cases(firmware: &Firmware) -> Vec<Case> {
    let mut cases = vec![];
    for (name, kind, aligned, returns) in FUNCTIONS {
        let copies = matches!(kind, Kind::Copy);
        let lengths = (0..=40).chain([LONG]);
        let places = |base: u32| (base..base + 4).step_by(aligned as usize);
        let function = firmware.symbol(name).expect(name) & !1;
        for length in lengths {
            let mut case = Case {
                name,
                kind,
                returns,
                function,
                destination: 0,
                source: 0,
                length,
            };
            for destination in places(DESTINATION) {
                case.destination = destination;
                let sources = places(FLASH + SOURCE as u32 + 32).take(if copies { 4 } else { 1 });
                let last = (FLASH_END - length).is_multiple_of(aligned) && copies;
                for source in sources.chain(last.then_some(FLASH_END - length)) {
                    cases.push(Case { source, ..case });
                }
            }
        }
    }
    cases
}

#[test]
fn memory_is_copied_and_filled_to_the_byte() {
    let Some(firmware) = support::firmware() else {
        return;
    };
    let flash = prepared(&firmware);
    let cases = cases(&firmware);
    // Per length: 4 destinations and 4 sources and the end for two copies, 4 destinations for three fills; the rest is aligned.
    assert!(cases.len() > 42 * (2 * 20 + 3 * 4), "{}", cases.len());
    for case in cases {
        case.check(&flash).unwrap();
    }
}

/// The test above is worth something only if it fails when a function is wrong: it does for want of any one instruction.
#[test]
fn not_one_instruction_of_copying_and_filling_can_be_left_out() {
    let Some(firmware) = support::firmware() else {
        return;
    };
    let flash = prepared(&firmware);
    let cases = cases(&firmware);
    for body in bodies(&firmware) {
        let mut at = (body.address - FLASH) as usize;
        let end = at + body.size as usize;
        while at < end {
            // Those that begin with 0b11101, 0b11110, 0b11111 are of two halfwords.
            let size = if flash[at + 1] >= 0xE8 { 4 } else { 2 };
            let mut broken = flash.clone();
            for halfword in broken[at..at + size].chunks_mut(2) {
                halfword.copy_from_slice(&0xBF00_u16.to_le_bytes());
            }
            assert!(
                cases.iter().any(|case| case.check(&broken).is_err()),
                "{} + {:#x} is a nop, and nothing shows it",
                body.name,
                FLASH as usize + at - body.address as usize
            );
            at += size;
        }
    }
}
