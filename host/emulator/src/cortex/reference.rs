// SPDX-License-Identifier: GPL-2.0-only
//! The core against another implementation, the Unicorn engine: random instructions on random registers.

mod random;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use random::{CLASSES, Class, state};
use unicorn_engine::{Arch, ArmCpuModel, Mode, Prot, RegisterARM as R, Unicorn, uc_error};

use super::access::Bus;
use super::execute::Ended;
use super::state::{FPCA, Registers};
use super::translate::{How, translate};
use super::{Map, Trap};
use crate::Quirks;
use crate::chip::Chip;

const CORE: [R; 15] = [
    R::R0,
    R::R1,
    R::R2,
    R::R3,
    R::R4,
    R::R5,
    R::R6,
    R::R7,
    R::R8,
    R::R9,
    R::R10,
    R::R11,
    R::R12,
    R::SP,
    R::LR,
];
const DOUBLE: [R; 16] = [
    R::D0,
    R::D1,
    R::D2,
    R::D3,
    R::D4,
    R::D5,
    R::D6,
    R::D7,
    R::D8,
    R::D9,
    R::D10,
    R::D11,
    R::D12,
    R::D13,
    R::D14,
    R::D15,
];
/// Where instructions are put, one after the other, so that none is taken from the engine's cache.
const FIRST: u32 = 0x4000;
const LAST: u32 = 0x1_C000;
const BREAK: u16 = 0xBE00;

/// Everything that an instruction may change but memory.
#[derive(Clone, Debug, PartialEq)]
struct State {
    core: [u32; 15],
    pc: u32,
    xpsr: u32,
    double: [u64; 16],
    fpscr: u32,
}

struct Both {
    unicorn: Unicorn<'static, ()>,
    bus: Bus,
    at: u32,
}

/// What became of an instruction.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Done(State),
    /// Not executed: no memory, or no such instruction.
    Refused,
    /// Not executed: no memory there but flash.
    Elsewhere,
}

impl Both {
    fn new(random: &mut Pcg64) -> Self {
        let mut image = vec![0; Map::FLASH_SIZE as usize];
        random.fill_bytes(&mut image);
        let mut unicorn = Unicorn::new(Arch::ARM, Mode::THUMB | Mode::MCLASS).expect("an engine");
        unicorn
            .ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)
            .expect("a core");
        unicorn
            .mem_map(
                Map::FLASH.into(),
                Map::FLASH_SIZE.into(),
                Prot::READ | Prot::EXEC,
            )
            .expect("flash");
        unicorn
            .mem_map(0, Map::FLASH_SIZE.into(), Prot::READ | Prot::EXEC)
            .expect("the flash's other address");
        unicorn.mem_write(0, &image).expect("an image");
        unicorn
            .mem_map(
                Map::RAM.into(),
                Map::RAM_SIZE.into(),
                Prot::READ | Prot::WRITE,
            )
            .expect("RAM");
        unicorn
            .mem_write(Map::FLASH.into(), &image)
            .expect("an image");
        let mut bus = Bus::new(Chip::new(image.clone(), None, 32_000, Quirks::default()));
        let mut ram = vec![0; Map::RAM_SIZE as usize];
        random.fill_bytes(&mut ram);
        bus.memory.write(Map::RAM, &ram).expect("RAM");
        unicorn.mem_write(Map::RAM.into(), &ram).expect("RAM");
        unicorn
            .add_intr_hook(|engine, _| {
                let _ = engine.emu_stop();
            })
            .expect("a hook");
        Self {
            unicorn,
            bus,
            at: FIRST,
        }
    }

    /// Puts code where neither has seen any.
    fn place(&mut self, code: &[u16]) -> u32 {
        if self.at + 32 > LAST {
            self.at = FIRST;
        }
        // A branch may have made the engine translate what was here.
        self.unicorn.ctl_flush_tb().expect("a flush");
        let start = self.at;
        self.at += 32;
        let bytes: Vec<u8> = code
            .iter()
            .chain([&BREAK; 4])
            .flat_map(|half| half.to_le_bytes())
            .collect();
        self.bus.chip.flash.image[start as usize..][..bytes.len()].copy_from_slice(&bytes);
        for base in [0, Map::FLASH] {
            self.unicorn
                .mem_write((base + start).into(), &bytes)
                .expect("code");
        }
        Map::FLASH + start
    }

    fn theirs(&mut self, before: &State, instructions: usize) -> Outcome {
        let engine = &mut self.unicorn;
        let mut set = |register, value: u32| {
            engine
                .reg_write(register, value.into())
                .expect("a register")
        };
        set(R::XPSR, before.xpsr);
        set(R::XPSR_G, before.xpsr);
        // The reference takes itself for a later core, in secure state, whose contexts have another bit.
        set(R::CONTROL, FPCA | 8);
        // Makes the engine look at CONTROL.
        set(R::APSR_NZCV, before.xpsr);
        for (register, value) in CORE.into_iter().zip(before.core) {
            set(register, value);
        }
        for (register, value) in DOUBLE.into_iter().zip(before.double) {
            engine.reg_write(register, value).expect("a register");
        }
        engine
            .reg_write(R::FPSCR, before.fpscr.into())
            .expect("a register");
        let result = engine.emu_start(u64::from(before.pc | 1), 0, 0, instructions);
        let get = |register| engine.reg_read(register).expect("a register");
        let after = State {
            core: CORE.map(|register| get(register) as u32),
            pc: get(R::PC) as u32 & !1,
            xpsr: get(R::XPSR) as u32 & !(1 << 24),
            double: DOUBLE.map(get),
            fpscr: get(R::FPSCR) as u32,
        };
        match result {
            Ok(()) if after.pc != before.pc => Outcome::Done(after),
            Ok(()) | Err(uc_error::INSN_INVALID | uc_error::EXCEPTION) => Outcome::Refused,
            Err(uc_error::WRITE_PROT | uc_error::READ_UNMAPPED | uc_error::WRITE_UNMAPPED) => {
                Outcome::Elsewhere
            }
            Err(uc_error::FETCH_UNMAPPED | uc_error::FETCH_PROT) => Outcome::Done(after),
            Err(other) => panic!("{other:?}"),
        }
    }

    fn ours(&mut self, before: &State) -> Outcome {
        let mut registers = Registers::new();
        registers.set_xpsr(before.xpsr);
        registers.set_mode(0, FPCA);
        registers.r[..15].copy_from_slice(&before.core);
        for (n, double) in before.double.into_iter().enumerate() {
            registers.set_double(n, double);
        }
        registers.fpu.set_status(before.fpscr);
        registers.pc = before.pc;
        let image = &self.bus.chip.flash.image;
        let fetch = |address: u32| {
            let at = (address - Map::FLASH) as usize;
            Some(u16::from_le_bytes([image[at], image[at + 1]]))
        };
        let code = translate(before.pc, 0, How::Single, &fetch).expect("code");
        self.bus.registers = registers;
        let ended = self.bus.execute(&code);
        let registers = &self.bus.registers;
        let trap = self.bus.chip.core.trap.take();
        match (ended, trap) {
            (Ended::Trap, Some(Trap::Breakpoint | Trap::Undefined { encoding: None })) => {}
            (Ended::Next, None) => {}
            (_, Some(Trap::Bus { .. } | Trap::Misuse(_))) => return Outcome::Elsewhere,
            _ => return Outcome::Refused,
        }
        Outcome::Done(State {
            core: std::array::from_fn(|n| registers.r[n]),
            pc: registers.pc,
            xpsr: registers.xpsr() & !(1 << 24),
            double: std::array::from_fn(|n| registers.double(n)),
            fpscr: registers.fpu.status(),
        })
    }

    fn same_memory(&self) -> bool {
        let (mut ours, mut theirs) = (
            vec![0; Map::RAM_SIZE as usize],
            vec![0; Map::RAM_SIZE as usize],
        );
        self.bus.memory.read(Map::RAM, &mut ours).expect("RAM");
        self.unicorn
            .mem_read(Map::RAM.into(), &mut theirs)
            .expect("RAM");
        ours == theirs
    }

    fn share_memory(&mut self) {
        let mut theirs = vec![0; Map::RAM_SIZE as usize];
        self.unicorn
            .mem_read(Map::RAM.into(), &mut theirs)
            .expect("RAM");
        self.bus.memory.write(Map::RAM, &theirs).expect("RAM");
    }
}

/// Whether an encoding names the program counter or the stack pointer where the architecture may leave the effect open.
fn is_open(encoding: u32) -> bool {
    let high = |low: u32| matches!(encoding >> low & 0xF, 13 | 15);
    // Instructions of later architectures, half precision, which the core does not have; BLX of an address; more
    // bits of fraction than there are bits; registers of the floating-point unit other than FPSCR.
    let later = encoding & 0xFF10_0000 == 0xF900_0000
        || encoding & 0xFFE0_0000 == 0xE8C0_0000
        || encoding & 0xF800_D000 == 0xF000_C000
        || encoding & 0xFFBA_0E50 == 0xEEB2_0A40
        || encoding & 0xFFBA_0ED0 == 0xEEBA_0A40
        || encoding & 0xFF60_70D0 == 0xF320_0010
        || encoding & 0xFFE0_0FFF == 0xEEE0_0A10;
    if encoding > 0xFFFF {
        later || high(0) || high(8) || high(12) || high(16)
    } else {
        // Operations with high registers; lists.
        encoding >> 10 == 0b010001 || encoding >> 12 == 0b1100 || encoding >> 12 == 0b1011
    }
}

fn run(class: &Class, cases: usize, conditional: bool, modes: bool) -> Vec<String> {
    let mut random = Pcg64::seed_from_u64(u64::from(class.given) ^ u64::from(class.drawn) << 32);
    let mut both = Both::new(&mut random);
    let mut wrong = Vec::new();
    let (mut done, mut neither, mut open) = (0, 0, 0);
    for _ in 0..cases {
        let encoding = class.given | random.random::<u32>() & class.drawn;
        let mut code = match (encoding >> 16) as u16 {
            0 if super::decode::length(encoding as u16) == 4 => continue,
            0 => vec![encoding as u16],
            first => vec![first, encoding as u16],
        };
        let mut instructions = 1;
        if conditional {
            let condition = random.random_range(0..14);
            code.insert(0, 0xBF08 | condition << 4);
            instructions = 2;
        }
        // Branches between security states change the reference for good.
        let security = encoding & 0xFFFF_FF00 == 0x4700 && encoding & 7 != 0;
        // A call of the supervisor ends in the engine's user. From fixed point is rounded to nearest in every mode, which the
        // reference does not.
        let supervisor = encoding & 0xFFFF_FF00 == 0xDF00;
        let fixed = modes && encoding & 0xFFBE_0E50 == 0xEEBA_0A40;
        if security || supervisor || fixed {
            continue;
        }
        let mut before = state(&mut random, modes);
        before.pc = both.place(&code);
        let theirs = both.theirs(&before, instructions);
        let ours = both.ours(&before);
        let same = ours == theirs && both.same_memory();
        let elsewhere = theirs == Outcome::Elsewhere
            || theirs == Outcome::Refused && ours == Outcome::Elsewhere
            || conditional && theirs == Outcome::Refused
            || conditional && matches!(&theirs, Outcome::Done(state) if state.pc == before.pc + 2);
        let refused = ours == Outcome::Refused || theirs == Outcome::Refused;
        match (&ours, same) {
            (_, false) if elsewhere => open += 1,
            (_, false) if refused && is_open(encoding) => open += 1,
            (Outcome::Done(_), true) => done += 1,
            (_, true) => neither += 1,
            (_, false) => {
                wrong.push(format!(
                    "{}: {code:04x?}\n  {before:x?}\n  ours   {ours:x?}\n  theirs {theirs:x?}",
                    class.name
                ));
            }
        }
        if !same || ours == Outcome::Refused {
            both.share_memory();
        }
    }
    println!(
        "{}: {done} done, {neither} refused, {open} refused by one, {} differ",
        class.name,
        wrong.len()
    );
    wrong
}

/// Runs random instructions of every class, so many of each, and returns what differs.
///
/// `conditional`: in IT blocks; `modes`: with any rounding, flushing and NaN mode.
#[must_use]
pub fn differences(cases: usize, conditional: bool, modes: bool) -> Vec<String> {
    CLASSES
        .iter()
        .flat_map(|class| run(class, cases, conditional, modes))
        .collect()
}
