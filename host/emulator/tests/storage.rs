// SPDX-License-Identifier: GPL-2.0-only
//! Power cuts and wrong bits while the firmware keeps its settings in flash: afterwards it has the old record or the new
//! one, whole, never something else.
//!
//! The image comes from `PALPATE_ELF` (`cargo xtask test` sets it); without it these tests say so and pass.

use palpate_emulator::chip::{Cut, FLASH_SIZE};
use palpate_emulator::time::TICKS_PER_MS;
use palpate_emulator::{Firmware, Machine, Pause, Setup};

/// Flash pages that hold records.
const RECORDS: usize = FLASH_SIZE - 16 * 1024;

fn firmware() -> Option<Firmware> {
    let Some(path) = std::env::var_os("PALPATE_ELF") else {
        eprintln!("PALPATE_ELF is not set: nothing tested");
        return None;
    };
    Some(Firmware::load(path.as_ref()).expect("the image loads"))
}

/// A chip at its bench, without a finger.
struct Bench<'f> {
    machine: Machine<'f>,
}

impl<'f> Bench<'f> {
    fn new(firmware: &'f Firmware) -> Self {
        let mut bench = Self {
            machine: Machine::new(firmware, None, &Setup::default()).expect("a sound start"),
        };
        bench.wait(60);
        bench
    }

    /// Lets time pass; false if the power went.
    fn wait(&mut self, milliseconds: u64) -> bool {
        let end = self.machine.now() + milliseconds * TICKS_PER_MS;
        while self.machine.now() < end {
            match self
                .machine
                .run_until(end)
                .expect("the firmware keeps to the rules of the chip")
            {
                Pause::Time => {}
                Pause::PowerLost => return false,
                other => panic!("{other:?}: {:?}", self.machine.take_notes()),
            }
        }
        true
    }

    /// Types a command and waits for a line that begins with `answer`; false if the power went.
    fn command(&mut self, command: &str, answer: &str) -> bool {
        self.machine.command(&format!("{command}\n"));
        let mut heard = Vec::new();
        for _ in 0..200 {
            if !self.wait(5) {
                return false;
            }
            heard.extend(self.machine.take_lines());
            if heard.iter().any(|line| line.message.starts_with(answer)) {
                return true;
            }
        }
        panic!(
            "'{command}' was not answered with '{answer}' but {heard:?}; {:?} {} {:?}",
            self.machine.take_notes(),
            self.machine.position(),
            self.machine.account().exceptions()
        );
    }

    fn save(&mut self, hold_force_n: u32) -> bool {
        self.command(&format!("set hold-force {hold_force_n}"), "answer ok")
            && self.command("save", "answer saved")
    }

    fn power_cycle(&mut self) {
        self.machine.power_cycle().expect("the engine works");
        self.machine.take_lines();
        assert!(self.wait(60));
        let lines = self.machine.take_lines();
        assert!(
            lines.iter().any(|line| line.event().name == "boot"),
            "{lines:?}"
        );
    }

    /// The setting as the firmware has it.
    fn hold_force_n(&mut self) -> f64 {
        self.machine.command("show\n");
        assert!(self.wait(60));
        let lines = self.machine.take_lines();
        let value = lines.iter().find_map(|line| {
            line.message
                .strip_prefix("answer hold-force ")?
                .split(' ')
                .next()
        });
        value
            .and_then(|value| value.parse().ok())
            .unwrap_or_else(|| panic!("no setting in {lines:?}"))
    }
}

#[test]
fn a_power_cut_at_any_flash_operation_leaves_the_old_or_the_new_record() {
    let Some(firmware) = firmware() else { return };
    let mut bench = Bench::new(&firmware);
    assert!(bench.save(2));
    let before = bench.machine.flash_operations().len();
    assert!(bench.save(3));
    let operations = bench.machine.flash_operations().len() - before;
    assert!(operations > 0);
    for operation in 0..operations {
        for cut in [Cut::Before, Cut::During, Cut::After] {
            let mut bench = Bench::new(&firmware);
            assert!(bench.save(2));
            let first = bench.machine.flash_operations().len();
            bench.machine.cut_power_at(first + operation, cut);
            assert!(
                !bench.save(3),
                "operation {operation} {cut:?}: the power did not go"
            );
            bench.power_cycle();
            let kept = bench.hold_force_n();
            assert!(
                kept == 2.0 || kept == 3.0,
                "operation {operation} {cut:?}: {kept}"
            );
        }
    }
}

#[test]
fn records_survive_many_saves_with_power_cuts_among_them() {
    let Some(firmware) = firmware() else { return };
    let mut bench = Bench::new(&firmware);
    assert!(bench.save(2));
    let mut kept = 2.0;
    let mut random = 12_345_u32;
    let mut cuts = 0;
    for round in 0..60 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let next = 1 + round % 19;
        let at = bench.machine.flash_operations().len() + (random >> 24) as usize % 120;
        let cut = [Cut::Before, Cut::During, Cut::After][(random >> 16) as usize % 3];
        bench.machine.cut_power_at(at, cut);
        let saved = bench.save(next);
        cuts += usize::from(!saved);
        bench.power_cycle();
        let now = bench.hold_force_n();
        let expected = if saved {
            [f64::from(next); 2]
        } else {
            [kept, f64::from(next)]
        };
        assert!(
            expected.contains(&now),
            "round {round}, saved {saved}: {now}, not one of {expected:?}"
        );
        kept = now;
    }
    assert!(cuts > 5, "{cuts} cuts");
}

#[test]
fn a_wrong_bit_in_the_records_is_corrected_or_noticed() {
    let Some(firmware) = firmware() else { return };
    let mut bench = Bench::new(&firmware);
    assert!(bench.save(7));
    let used: Vec<usize> = (RECORDS..FLASH_SIZE)
        .filter(|&byte| bench.machine.flash()[byte] != 0xFF)
        .collect();
    assert!(!used.is_empty());
    for (n, &byte) in used.iter().enumerate().step_by(1 + used.len() / 40) {
        let mut bench = Bench::new(&firmware);
        assert!(bench.save(7));
        let bit = 8 * byte + n % 8;
        bench.machine.flip_flash_bit(bit).expect("the engine works");
        bench.power_cycle();
        assert_eq!(
            bench.hold_force_n(),
            7.0,
            "one wrong bit, {bit}, is corrected"
        );
        bench
            .machine
            .flip_flash_bit(bit ^ 1)
            .expect("the engine works");
        bench.power_cycle();
        let now = bench.hold_force_n();
        assert!(
            now == 7.0 || now == 1.0,
            "two wrong bits at {bit}: {now} is neither the record nor the default"
        );
    }
}
