// SPDX-License-Identifier: GPL-2.0-only
//! The settings that are in force in the firmware, as far as what a calibration is measured in depends on them: from the record in
//! flash, and from what the user has set since.

use palpate::app::console::settings::{Overrides, Setting};
use palpate::app::storage::store::{Found, Memory, PAGE, PAGES, Store, WORD};

/// Version and scene's ID, which stand in a record before the settings.
const HEAD: usize = 5;
/// Settings that are read: the first ones, which the firmware of every scene has.
const READ: usize = Setting::Efficiency as usize + 1;

/// The pages of records of a flash that nobody writes to.
struct Pages<'p>(&'p [u8]);

impl Memory for Pages<'_> {
    type Error = ();

    fn read<R>(&mut self, look: impl FnOnce(&[u8]) -> R) -> R {
        look(self.0)
    }

    fn undisturbed(&mut self, _: impl FnOnce(&mut Self) -> Result<(), ()>) -> Result<(), ()> {
        Err(())
    }

    fn erase(&mut self, _: usize) -> Result<(), ()> {
        Err(())
    }

    fn program(&mut self, _: usize, _: [u8; WORD]) -> Result<(), ()> {
        Err(())
    }

    async fn rest(&mut self) {}
}

/// What a flash keeps of the settings up to the efficiency. Of a record that the firmware has loaded: whether it is whole, and of which
/// version, is not looked at again.
pub fn kept(flash: &[u8]) -> Overrides {
    let pages = flash
        .len()
        .checked_sub(PAGES * PAGE)
        .and_then(|at| flash.get(at..));
    Store::new(Pages(pages.unwrap_or_default())).load(|found| match found {
        Found::Record { bytes, .. } => settings(bytes.get(HEAD..).unwrap_or_default()),
        Found::Nothing | Found::Unreadable => Overrides::default(),
    })
}

/// One that was set is a one and four bytes, else it is a zero.
fn settings(mut bytes: &[u8]) -> Overrides {
    let mut overrides = Overrides::default();
    for setting in Setting::ALL.into_iter().take(READ) {
        bytes = match bytes {
            [1, a, b, c, d, rest @ ..] => {
                // Out of its range, it is none that a firmware has in force.
                let _ = overrides.set(setting, f32::from_le_bytes([*a, *b, *c, *d]));
                rest
            }
            [_, rest @ ..] => rest,
            [] => break,
        };
    }
    overrides
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::app::storage::record::{Record, scene_id};
    use palpate::scene::Scene;
    use palpate_scenes::P70;

    #[test]
    fn settings_of_a_record_are_read() {
        let mut set = Overrides::default();
        for (setting, value_si) in [
            (Setting::ClosingSpeed, 0.2),
            (Setting::HoldTime, 0.0),
            (Setting::Efficiency, 0.4),
        ] {
            set.set(setting, value_si).expect("in range");
        }
        let record = Record {
            overrides: &set,
            calibration: &P70::UNCALIBRATED,
            friction: None,
            identified: None,
        };
        let mut bytes = Vec::new();
        record.encode(scene_id::<P70>(), |byte| bytes.push(byte));
        assert_eq!(settings(&bytes[HEAD..]), set);
        assert_eq!(kept(&[0xFF; PAGES * PAGE]), Overrides::default());
        assert_eq!(kept(&[]), Overrides::default());
    }
}
