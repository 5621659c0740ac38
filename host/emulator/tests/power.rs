// SPDX-License-Identifier: GPL-2.0-only
//! The power goes, and bits flip, while the firmware keeps a record in flash.
//!
//! The image comes from `PALPATE_ELF` (`cargo xtask test` sets it); without it these tests say so and pass.

use palpate_emulator::chip::{Cut, Operation};
use palpate_emulator::log::Line;
use palpate_emulator::sim::{Script, Settings, end_of};
use palpate_emulator::time::{TICKS_PER_MS, Ticks};
use palpate_emulator::{Firmware, Machine, Pause, Setup};

/// The firmware is up and has read its record, even if it had to erase pages first.
const BOOT: Ticks = 300 * TICKS_PER_MS;
/// Longest time to an answer: a save takes some 60 ms.
const ANSWER: Ticks = 500 * TICKS_PER_MS;

fn firmware() -> Option<Firmware> {
    let Some(path) = std::env::var_os("PALPATE_ELF") else {
        eprintln!("PALPATE_ELF is not set: nothing tested");
        return None;
    };
    Some(Firmware::load(path.as_ref()).expect("the image loads"))
}

/// A chip on a bare board with a record in its flash.
struct Board<'f> {
    machine: Machine<'f>,
}

impl<'f> Board<'f> {
    /// With what a first run has kept: settings and a friction record.
    fn new(firmware: &'f Firmware) -> Self {
        let settings = Settings {
            script: Script::parse("record-friction; save; save"),
            ..Settings::default()
        };
        let session = end_of(firmware, settings).expect("a sound run");
        assert!(session.completed() && session.faults.is_empty());
        let setup = Setup {
            flash: Some(session.machine.flash().to_vec()),
            ..Setup::default()
        };
        let machine = Machine::new(firmware, None, &setup).expect("the engine works");
        let mut board = Self { machine };
        assert_eq!(board.boot().as_deref(), Some("loaded"));
        board
    }

    /// Runs until a line that passes, or the time is up. `None`, too, if the power went.
    fn until(&mut self, patience: Ticks, wanted: impl Fn(&Line) -> bool) -> Option<Line> {
        let end = self.machine.now() + patience;
        while self.machine.now() < end {
            let pause = self
                .machine
                .run_until(self.machine.now() + TICKS_PER_MS)
                .expect("the firmware keeps to the rules of the chip");
            let found = self.machine.take_lines().into_iter().find(&wanted);
            if found.is_some() || pause == Pause::PowerLost {
                return found;
            }
        }
        None
    }

    /// What the firmware found in flash; `None` if the power went first.
    fn boot(&mut self) -> Option<String> {
        let line = self.until(BOOT, |line| line.event().name == "record")?;
        let state = line.event().field("state").map(str::to_owned);
        let ready = self.machine.now() + 20 * TICKS_PER_MS;
        self.machine.run_until(ready).expect("a sound run");
        self.machine.take_lines();
        state
    }

    fn power_cycle(&mut self) {
        self.machine.power_cycle().expect("the engine works");
    }

    /// The first answer to a command that holds `part`.
    fn ask(&mut self, command: &str, part: &str) -> Option<String> {
        self.machine.command(&format!("{command}\n"));
        let line = self.until(ANSWER, |line| {
            line.message.starts_with("answer ") && line.message.contains(part)
        })?;
        Some(line.message)
    }

    /// The setting that tells one record from another, newton.
    fn value(&mut self) -> f64 {
        let answer = self.ask("show", "hold-force").expect("an answer");
        // Let the rest of the list pass.
        self.until(100 * TICKS_PER_MS, |_| false);
        let mut words = answer.split_whitespace();
        words.find(|word| *word == "hold-force");
        let value = words.next().and_then(|word| word.parse().ok());
        value.expect("a number")
    }

    fn set(&mut self, value: f64) {
        self.ask(&format!("set hold-force {value:.3}"), "ok")
            .expect("at rest");
    }

    fn operations(&self) -> usize {
        self.machine.flash_operations().len()
    }
}

/// Every operation of a save, cut before, in the middle and at its end; and what follows a reboot, cut again.
#[test]
fn a_power_cut_at_any_flash_operation_of_a_save_leaves_a_whole_record() {
    let Some(firmware) = firmware() else { return };
    let mut board = Board::new(&firmware);
    let (mut old, mut serial, mut cuts, mut mended) = (board.value(), 0, 0, 0);
    let (mut olds, mut news) = (0, 0);
    'operations: for operation in 0.. {
        for cut in [Cut::Before, Cut::During, Cut::After] {
            serial += 1;
            let new = 1.0 + f64::from(serial) * 1e-3;
            board.set(new);
            let at = board.operations() + operation;
            board.machine.cut_power_at(at, cut);
            if let Some(answer) = board.ask("save", "") {
                assert!(answer.contains("saved"), "{answer}");
                break 'operations;
            }
            assert_eq!(board.operations(), at + 1, "the power went");
            cuts += 1;
            // Whatever the firmware mends at start is cut short, too.
            board.power_cycle();
            let mend = board.operations();
            board.machine.cut_power_at(mend, Cut::During);
            let mut state = board.boot();
            if state.is_none() {
                assert!(matches!(
                    board.machine.flash_operations()[mend],
                    Operation::Erase(_)
                ));
                mended += 1;
                board.power_cycle();
                state = board.boot();
            }
            let found = board.value();
            let is = |value: f64| (found - value).abs() < 4e-4;
            match state.as_deref() {
                Some("loaded") => assert!(is(old) || is(new), "{found}"),
                Some("older") => assert!(is(old), "operation {operation}, {cut:?}: {found}"),
                other => panic!("operation {operation}, {cut:?}: {other:?}"),
            }
            *(if is(new) { &mut news } else { &mut olds }) += 1;
            old = found;
        }
    }
    println!(
        "{cuts} cuts: {olds} times the old record, {news} times the new; {mended} cut again while mending"
    );
    assert!(cuts > 450 && olds > 300 && news > 0 && mended > 0);
}
