// SPDX-License-Identifier: GPL-2.0-only
//! The core and its surroundings on short programs, assembled by hand: what the firmware relies on, one thing at a time.
//!
//! Programs start at 0x0800_0200; exceptions go to 0x40 behind that, or where `HANDLER` says.

mod programs;

use palpate_emulator::chip::FLASH_SIZE;
use palpate_emulator::time::{TICKS_PER_MS, TICKS_PER_S};
use palpate_emulator::{Error, Firmware, Machine, Misuse, Pause, ResetCause, Setup};
use programs::{
    ACCESS, CCM, CYCCNT, FAULT, FPU, JUMP, LOADS_IN_IT, LOCKUP, LOOP, MASK, PROGRAM, SLEEP,
    STORES_IN_IT,
};

const RAM: u32 = 0x2000_0000;
const STACK: u32 = RAM + 0x1000;
const START: u32 = 0x0800_0200;

/// A flash image: vector table, program.
fn image(program: &[u16], handler: u32) -> Firmware {
    Firmware::raw(flash(program, handler))
}

fn flash(program: &[u16], handler: u32) -> Vec<u8> {
    let mut flash = vec![0xFF; FLASH_SIZE];
    flash[..4].copy_from_slice(&STACK.to_le_bytes());
    flash[4..8].copy_from_slice(&(START | 1).to_le_bytes());
    for vector in 2..118 {
        flash[4 * vector..4 * vector + 4].copy_from_slice(&((START + handler) | 1).to_le_bytes());
    }
    for (n, halfword) in program.iter().enumerate() {
        flash[0x200 + 2 * n..0x202 + 2 * n].copy_from_slice(&halfword.to_le_bytes());
    }
    flash
}

/// Runs for at most a second of virtual time.
fn run<'f>(firmware: &'f Firmware, setup: &Setup) -> (Machine<'f>, Result<Pause, Error>) {
    let mut machine = Machine::new(firmware, None, setup).expect("the engine starts");
    let pause = machine.run_until(TICKS_PER_S);
    (machine, pause)
}

fn words<const N: usize>(machine: &Machine<'_>) -> [u32; N] {
    std::array::from_fn(|n| machine.word(RAM + 4 * n as u32).expect("it is RAM"))
}

#[test]
fn every_instruction_is_counted_once() {
    let firmware = image(LOOP, 0x40);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    // One move, ten times subtract and branch, move, load, breakpoint.
    assert_eq!(machine.account().total().instructions, 1 + 20 + 3);
}

#[test]
fn the_cycle_counter_counts_instructions_exactly_when_told_to() {
    let firmware = image(CYCCNT, 0x40);
    let setup = Setup {
        count_instructions: true,
        ..Setup::default()
    };
    let (machine, pause) = run(&firmware, &setup);
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    // From the first load to the second: itself, three nops, a branch, a nop.
    assert_eq!(words::<1>(&machine), [6]);
}

#[test]
fn an_interrupt_keeps_the_floating_point_context() {
    let firmware = image(FPU, 0x40);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    let [value, ipsr, control] = words(&machine);
    assert_eq!(f32::from_bits(value), 1.5);
    assert_eq!(ipsr, 16);
    assert_eq!(control & 4, 4, "the context is still a floating-point one");
    assert_eq!(machine.account().exceptions()[&16].count, 1);
    // vmov, mrs, ldr, str, bx
    assert_eq!(machine.account().exceptions()[&16].max.instructions, 5);
}

#[test]
fn a_load_from_nowhere_is_a_hard_fault_with_its_address() {
    let firmware = image(FAULT, 0x40);
    let (mut machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    let [ipsr, cfsr, bfar, stacked_pc] = words(&machine);
    assert_eq!(ipsr, 3);
    assert_eq!(cfsr, 1 << 15 | 1 << 9, "precise, with a valid address");
    assert_eq!(bfar, 0x6000_0000);
    assert_eq!(stacked_pc, START + 4, "the load itself");
    assert!(
        machine
            .take_notes()
            .iter()
            .any(|note| note.contains("0x60000000"))
    );
}

#[test]
fn a_stack_that_leaves_the_ram_ends_in_lockup() {
    let firmware = image(LOCKUP, 0x40);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Time);
    assert!(machine.chip().locked_up());
    let before = machine.account().total().instructions;
    assert!(
        before < 3000,
        "{before}: a core that is locked up executes nothing"
    );
}

#[test]
fn mask_registers_hold_an_interrupt_back() {
    let firmware = image(MASK, 0x80);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    // Under BASEPRI, without it, under PRIMASK, without it.
    assert_eq!(words::<4>(&machine), [0, 1, 1, 2]);
}

#[test]
fn an_event_wakes_once_and_then_the_core_sleeps() {
    let firmware = image(SLEEP, 0x40);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    assert_eq!(words::<3>(&machine), [0, 1, 2]);
    // SysTick at 16 MHz with a period of 16000: asleep for two periods, and a few dozen instructions in all.
    let milliseconds = machine.now() as f64 / TICKS_PER_MS as f64;
    assert!((2.0..2.1).contains(&milliseconds), "{milliseconds} ms");
    assert!(machine.account().total().instructions < 40);
}

#[test]
fn flash_is_programmed_by_its_controller_and_survives_a_reset() {
    let firmware = image(PROGRAM, 0x40);
    let (mut machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(
        pause.expect("a sound run"),
        Pause::Reset(ResetCause::Software)
    );
    assert_eq!(words::<2>(&machine), [0x1122_3344, 0x5566_7788]);
    assert_eq!(
        machine.flash()[0x1_E800..0x1_E808],
        0x5566_7788_1122_3344_u64.to_le_bytes()
    );
    assert_eq!(
        machine.word(RAM),
        Some(0x1122_3344),
        "a reset keeps the RAM"
    );
    machine.power_cycle().expect("the engine works");
    assert_ne!(machine.word(RAM), Some(0x1122_3344), "a power cut does not");
    assert_eq!(machine.word(0x0801_E800), Some(0x1122_3344));
}

#[test]
fn code_runs_from_ccm_sram_which_is_one_memory_at_two_addresses() {
    let firmware = image(CCM, 0x40);
    let (machine, pause) = run(&firmware, &Setup::default());
    assert_eq!(pause.expect("a sound run"), Pause::Exit(0));
    // What the first routine gave, what the one in its place gave, the first routine as the alias shows it.
    assert_eq!(words::<3>(&machine), [7, 9, 0x4770_2207]);
    let total = machine.account().total();
    assert_eq!(total.instructions, 18 + 2 * 2);
}

#[test]
fn code_in_ccm_sram_outlives_a_reset_and_not_a_power_cut() {
    let firmware = image(CCM, 0x40);
    let (mut machine, _) = run(&firmware, &Setup::default());
    let code = 0x1000_1000;
    assert_eq!(machine.word(code), Some(0x4770_2209));
    machine.reset(ResetCause::Pin).expect("the engine works");
    assert_eq!(machine.word(code), Some(0x4770_2209));
    machine.power_cycle().expect("the engine works");
    assert_ne!(machine.word(code), Some(0x4770_2209));
    // What is put there anew runs, not what was translated before the cut.
    let again = machine.run_until(2 * TICKS_PER_S);
    assert_eq!(again.expect("a sound run"), Pause::Exit(0));
    assert_eq!(words::<3>(&machine), [7, 9, 0x4770_2207]);
}

#[test]
fn code_in_other_ram_is_refused() {
    for address in [RAM + 0x100, RAM + 0x5800] {
        let mut program = JUMP.to_vec();
        program[2] = address as u16 | 1;
        let firmware = image(&program, 0x40);
        let refused = run(&firmware, &Setup::default()).1;
        assert!(
            matches!(
                refused,
                Err(Error::Misuse { misuse: Misuse::CodeInRam { address: at }, .. }) if at & !1 == address
            ),
            "{address:#x}: {refused:?}"
        );
    }
}

#[test]
fn what_is_not_modelled_is_refused_by_name() {
    let reading = |address: u32| {
        let mut program = ACCESS.to_vec();
        let literal = program
            .iter()
            .position(|&halfword| halfword == 0x5678)
            .expect("the literal");
        program[literal] = address as u16;
        program[literal + 1] = (address >> 16) as u16;
        let firmware = image(&program, 0x40);
        let result = run(&firmware, &Setup::default()).1;
        match result {
            Err(Error::Misuse { misuse, .. }) => misuse,
            other => panic!("{address:#x}: {other:?}"),
        }
    };
    assert_eq!(
        reading(0x4002_1014),
        Misuse::UnknownRegister {
            peripheral: "RCC",
            offset: 0x14
        }
    );
    assert_eq!(
        reading(0x4000_5400),
        Misuse::NoPeripheral {
            address: 0x4000_5400
        }
    );
    let unclocked = Misuse::Unclocked {
        peripheral: "TIM1",
        register: "BDTR",
        enable: "APB2ENR",
    };
    assert_eq!(reading(0x4001_2C44), unclocked);
}

/// Runs a program of IT blocks on `address`, with each of its halfwords in turn at the start of a page of code, where the
/// engine cuts blocks. What it leaves in RAM.
fn in_it(program: &[u16], address: u32, setup: &Setup) -> [u32; 5] {
    let mut program = program.to_vec();
    let literal = program
        .windows(2)
        .position(|pair| pair == [0x5678, 0x1234])
        .expect("the literal");
    program[literal] = address as u16;
    program[literal + 1] = (address >> 16) as u16;
    let handler = program
        .windows(2)
        .position(|pair| pair == [0x2000, 0x2801])
        .expect("the handler");
    let (mut results, mut interrupts) = (None, 0);
    // An even number of them: the program has literals.
    for nops in (0..=0x100)
        .step_by(2)
        .filter(|nops| nops + program.len() > 0x100)
    {
        let mut padded = vec![0xBF00; nops];
        padded.extend(&program);
        let mut flash = flash(&padded, 2 * (nops + handler) as u32);
        for at in [0x1000, 0x1_E900] {
            flash[at..at + 8].copy_from_slice(&DATA);
        }
        let firmware = Firmware::raw(flash);
        let (machine, pause) = run(&firmware, setup);
        assert_eq!(
            pause.expect("a sound run"),
            Pause::Exit(0),
            "{address:#x}, {nops}"
        );
        interrupts += machine
            .account()
            .exceptions()
            .get(&15)
            .map_or(0, |one| one.count);
        let found = words(&machine);
        assert_eq!(*results.get_or_insert(found), found, "{address:#x}, {nops}");
    }
    assert!(interrupts > 0);
    results.expect("it ran")
}

const DATA: [u8; 8] = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];

#[test]
fn loads_in_it_blocks_leave_no_condition_behind() {
    for address in [0x0800_1000, 0x0801_E900] {
        let found = in_it(LOADS_IN_IT, address, &Setup::default());
        // The first byte, the word at 4, its first byte, both write-backs and no third, what follows the block.
        assert_eq!(found, [0x11, 0x8877_6655, 0x55, 5, 84], "{address:#x}");
    }
}

#[test]
fn stores_in_it_blocks_leave_no_condition_behind() {
    // SRAM, CCM SRAM and its alias, interrupt priorities.
    for address in [RAM + 0x100, 0x1000_0100, RAM + 0x5900, 0xE000_E420] {
        let found = in_it(STORES_IN_IT, address, &Setup::default());
        assert_eq!(found, [0x50, 0, 0x60, 5, 84], "{address:#x}");
    }
}

#[test]
fn exact_counts_leave_no_condition_behind() {
    let exact = Setup {
        count_instructions: true,
        ..Setup::default()
    };
    // The cycle counter's bytes are no constants: what follows the blocks, and the write-backs.
    for address in [0xE000_1000, 0x0800_1000] {
        let [.., address_after, sum] = in_it(LOADS_IN_IT, address, &exact);
        assert_eq!((address_after, sum), (5, 84), "{address:#x}");
    }
}
