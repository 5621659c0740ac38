//! The record that a scene's firmware keeps in flash, read by a program that knows every scene.

use palpate::app::console::settings::Setting;
use palpate::app::storage::record::{Record, RecordError, scene_id};
use palpate::finger::Mechanics;
use palpate::scene::Scene;

/// Version and scene's ID before the settings.
const HEAD: usize = 5;
/// The last settings are those of a weight that the scene states. Firmware without one does not have them, this program does.
const OF_WEIGHT: usize = 2;
/// Bytes of a setting.
const VALUE: usize = 4;

/// Reads the record of a scene's firmware and hands it over.
///
/// # Errors
/// Why it must not be used; pieces that are still missing are one reason.
pub fn kept<S: Scene, R>(
    bytes: &[u8],
    take: impl FnOnce(&Record<'_>) -> R,
) -> Result<R, RecordError> {
    let mut whole = bytes.to_vec();
    if !<S::Finger as Mechanics>::WEIGHS {
        let end = HEAD + VALUE * (Setting::ALL.len() - OF_WEIGHT);
        if end <= whole.len() {
            // A missing value is infinite.
            let missing = [f32::INFINITY.to_le_bytes(); OF_WEIGHT];
            whole.splice(end..end, missing.concat());
        }
    }
    Record::decode::<true, _>(&whole, scene_id::<S>(), take)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{P70, Tendon2};
    use palpate::app::console::settings::Overrides;

    fn written<S: Scene>(overrides: &Overrides) -> Vec<u8> {
        let record = Record {
            overrides,
            calibration: &S::UNCALIBRATED,
            friction: None,
            identified: None,
        };
        let mut bytes = Vec::new();
        record.encode(scene_id::<S>(), |byte| bytes.push(byte));
        bytes
    }

    #[test]
    fn firmware_without_settings_of_a_weight_is_read() {
        let mut set = Overrides::default();
        set.set(Setting::ClosingSpeed, 0.2).expect("in range");
        set.set(Setting::SupplyMax, 13.0).expect("in range");
        let mut bytes = written::<P70>(&set);
        // The chip's firmware ends with the settings before.
        let end = HEAD + VALUE * Setting::ALL.len();
        bytes.drain(end - VALUE * OF_WEIGHT..end);
        let read = kept::<P70, _>(&bytes, |record| (*record.overrides, *record.calibration));
        assert_eq!(read, Ok((set, P70::UNCALIBRATED)));
        // Pieces that are missing are no record.
        for length in 0..bytes.len() {
            assert!(kept::<P70, _>(&bytes[..length], |_| ()).is_err());
        }
    }

    #[test]
    fn firmware_with_them_is_read_as_it_is() {
        let mut set = Overrides::default();
        set.set(Setting::Weight, 0.5).expect("in range");
        let read = kept::<Tendon2, _>(&written::<Tendon2>(&set), |record| *record.overrides);
        assert_eq!(read, Ok(set));
    }
}
