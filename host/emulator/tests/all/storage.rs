// SPDX-License-Identifier: GPL-2.0-only
//! The power goes, and bits flip, while the firmware keeps a record in flash: afterwards it has the old record or the new
//! one, whole, never something else.

use crate::support::firmware;
use palpate::app::storage::store::{PAGE, PAGES};
use palpate_emulator::chip::{FLASH_SIZE, Operation, PowerCut};
use palpate_emulator::log::Line;
use palpate_emulator::sim::{Script, Settings, end_of};
use palpate_emulator::time::{TICKS_PER_MS, Ticks};
use palpate_emulator::{Firmware, Machine, Pause, Setup};

/// Flash pages that hold records.
const RECORDS: usize = FLASH_SIZE - PAGES * PAGE;
/// The firmware is up and has read its record.
const BOOT: Ticks = 100 * TICKS_PER_MS;
/// Longest time to an answer: a save takes some 60 ms.
const ANSWER: Ticks = 500 * TICKS_PER_MS;

/// A chip on a bare board with a record in its flash.
struct Board<'f> {
    machine: Machine<'f>,
}

impl<'f> Board<'f> {
    /// Fresh from the factory.
    fn blank(firmware: &'f Firmware) -> Self {
        let mut board = Self::with(firmware, &Setup::default());
        assert_eq!(board.boot(), "none");
        board
    }

    /// With what a first run has kept: settings and a friction record.
    fn with_friction(firmware: &'f Firmware) -> Self {
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
        let mut board = Self::with(firmware, &setup);
        assert_eq!(board.boot(), "loaded");
        board
    }

    fn with(firmware: &'f Firmware, setup: &Setup) -> Self {
        Self {
            machine: Machine::new(firmware, None, setup).expect("the engine works"),
        }
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

    /// What the firmware found in flash, in which it changes nothing.
    fn boot(&mut self) -> String {
        let before = self.operations();
        let line = self
            .until(BOOT, |line| line.event().name == "record")
            .expect("the firmware starts");
        let state = line.event().field("state").unwrap_or_default().to_owned();
        let ready = self.machine.now() + 20 * TICKS_PER_MS;
        self.machine.run_until(ready).expect("a sound run");
        self.machine.take_lines();
        assert_eq!(self.operations(), before, "the start wrote to flash");
        state
    }

    /// Restarts; what the firmware found in flash.
    fn power_cycle(&mut self) -> String {
        self.machine.power_cycle().expect("the engine works");
        self.machine.take_lines();
        self.boot()
    }

    /// The first answer to a command that holds `part`; `None` if the power went first.
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

    /// False if the power went.
    fn save(&mut self) -> bool {
        match self.ask("save", "") {
            Some(answer) => {
                assert!(answer.contains("saved"), "{answer}");
                true
            }
            None => false,
        }
    }

    fn operations(&self) -> usize {
        self.machine.flash_operations().len()
    }
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 4e-4
}

/// Every operation of a save, cut before, in the middle and at its end; and then the erasing of the next try.
#[test]
fn a_power_cut_at_any_flash_operation_of_a_save_leaves_a_whole_record() {
    let Some(firmware) = firmware() else { return };
    let mut board = Board::with_friction(&firmware);
    let (mut old, mut serial, mut cuts) = (board.value(), 0, 0);
    let (mut olds, mut news) = (0, 0);
    'operations: for operation in 0.. {
        for cut in [PowerCut::Before, PowerCut::During, PowerCut::After] {
            serial += 1;
            let new = 1.0 + f64::from(serial) * 1e-3;
            board.set(new);
            let at = board.operations() + operation;
            board.machine.cut_power_at(at, cut);
            if board.save() {
                break 'operations;
            }
            assert_eq!(board.operations(), at + 1, "the power went");
            cuts += 1;
            for again in [true, false] {
                let state = board.power_cycle();
                let found = board.value();
                match state.as_str() {
                    "loaded" => assert!(same(found, old) || same(found, new), "{found}"),
                    "older" => assert!(same(found, old), "{operation}, {cut:?}: {found}"),
                    other => panic!("operation {operation}, {cut:?}: {other}"),
                }
                *(if same(found, new) {
                    &mut news
                } else {
                    &mut olds
                }) += 1;
                old = found;
                // Each third time: that takes as long as the rest.
                if !again || serial % 3 != 0 {
                    break;
                }
                let at = board.operations();
                board.machine.cut_power_at(at, PowerCut::During);
                assert!(!board.save(), "the power did not go");
                let operations = board.machine.flash_operations();
                assert!(matches!(operations.get(at), Some(Operation::Erase(_))));
            }
        }
    }
    println!("{cuts} cuts: {olds} times the old record, {news} times the new");
    // As many as a record has double words and its page erasures, over the saves above.
    assert!(cuts > 250 && olds > 300 && news > 0);
}

#[test]
fn records_survive_many_saves_with_power_cuts_among_them() {
    let Some(firmware) = firmware() else { return };
    let mut board = Board::blank(&firmware);
    board.set(2.0);
    assert!(board.save());
    let mut kept = 2.0;
    let mut random = 12_345_u32;
    let mut cuts = 0;
    for round in 0..60 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let next = f64::from(1 + round % 19);
        board.set(next);
        // A record of settings alone takes some 25 operations: now and then the save is over.
        let at = board.operations() + (random >> 24) as usize % 30;
        let cut =
            [PowerCut::Before, PowerCut::During, PowerCut::After][(random >> 16) as usize % 3];
        board.machine.cut_power_at(at, cut);
        let saved = board.save();
        cuts += usize::from(!saved);
        board.power_cycle();
        let now = board.value();
        assert!(
            same(now, next) || !saved && same(now, kept),
            "round {round}, saved {saved}: {now}, neither {next} nor {kept}"
        );
        kept = now;
    }
    assert!((6..60).contains(&cuts), "{cuts} cuts");
}

#[test]
fn a_wrong_bit_in_the_records_is_corrected_or_noticed() {
    let Some(firmware) = firmware() else { return };
    let mut board = Board::blank(&firmware);
    board.set(7.0);
    assert!(board.save());
    let used: Vec<usize> = (RECORDS..FLASH_SIZE)
        .filter(|&byte| board.machine.flash()[byte] != 0xFF)
        .collect();
    assert!(!used.is_empty());
    let setup = Setup {
        flash: Some(board.machine.flash().to_vec()),
        ..Setup::default()
    };
    let mut noticed = 0;
    for (n, &byte) in used.iter().enumerate().step_by(1 + used.len() / 40) {
        let mut board = Board::with(&firmware, &setup);
        let bit = 8 * byte + n % 8;
        board.machine.flip_flash_bit(bit).expect("the engine works");
        assert_eq!(board.boot(), "loaded", "one wrong bit, {bit}, is corrected");
        assert!(same(board.value(), 7.0));
        board
            .machine
            .flip_flash_bit(bit ^ 1)
            .expect("the engine works");
        match board.power_cycle().as_str() {
            "loaded" => assert!(same(board.value(), 7.0)),
            "unreadable" => {
                assert!(same(board.value(), 1.0), "two wrong bits at {bit}");
                noticed += 1;
            }
            other => panic!("two wrong bits at {bit}: {other}"),
        }
    }
    assert!(noticed > 20, "{noticed}");
}

/// A record of friction counts as known after a restart only if it was saved while it held: the worm's friction depends on speed.
#[test]
fn friction_of_another_speed_is_not_kept() {
    let Some(firmware) = firmware() else { return };
    for (speed, expected) in [(None, "ok"), (Some("0.200"), "no friction")] {
        let mut board = Board::with_friction(&firmware);
        if let Some(speed) = speed {
            board
                .ask(&format!("set closing-speed {speed}"), "ok")
                .expect("at rest");
        }
        assert!(board.save());
        assert_eq!(board.power_cycle(), "loaded");
        let answer = board.ask("calibrate 30", "").expect("an answer");
        assert!(answer.contains(expected), "{speed:?}: {answer}");
    }
}
