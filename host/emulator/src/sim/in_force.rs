// SPDX-License-Identifier: GPL-2.0-only
//! The settings that the firmware has loaded from its flash.

use palpate::app::console::settings::Overrides;
use palpate::app::storage::store::{Found, Memory, PAGE, PAGES, Store, WORD};
use palpate::scene::Scene;

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

/// Reads the settings that a flash keeps for a scene's firmware; none where it keeps no record of that scene.
pub fn kept(flash: &[u8], scene: &str) -> Overrides {
    palpate_scenes::for_scene!(scene, |S| read::<S>(flash)).unwrap_or_default()
}

fn read<S: Scene>(flash: &[u8]) -> Overrides {
    let pages = flash
        .len()
        .checked_sub(PAGES * PAGE)
        .and_then(|at| flash.get(at..));
    Store::new(Pages(pages.unwrap_or_default())).load(|found| match found {
        Found::Record { bytes, .. } => settings::<S>(bytes),
        Found::Nothing | Found::Unreadable => Overrides::default(),
    })
}

fn settings<S: Scene>(record: &[u8]) -> Overrides {
    palpate_scenes::kept::<S, _>(record, |record| *record.overrides).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::app::console::settings::Setting;
    use palpate::app::storage::record::{Record, scene_id};
    use palpate_scenes::Tendon2;

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
            calibration: &Tendon2::UNCALIBRATED,
            friction: None,
            identified: None,
        };
        let mut bytes = Vec::new();
        record.encode(scene_id::<Tendon2>(), |byte| bytes.push(byte));
        assert_eq!(settings::<Tendon2>(&bytes), set);
        for flash in [&[0xFF; PAGES * PAGE][..], &[]] {
            assert_eq!(kept(flash, "p70"), Overrides::default());
        }
    }
}
