//! What survives a power cut: one record with a version and the mark of the scene it belongs to.
//!
//! Settings, friction record and calibration are kept in one record, so that a save either happened or did not: no mix
//! of old and new can be read back. Where it is kept, how damage is noticed and wear is levelled, is the
//! [store](super::store)'s business.

use crc::{CRC_32_ISCSI, Crc, NoTable};
use postcard::ser_flavors::Flavor;
use serde::{Serialize, de::DeserializeOwned};

/// Layout of the record. Raise it whenever what is kept changes its meaning or its shape.
pub const VERSION: u8 = 2;

/// Bytes in front of the content: version and scene.
const HEADER: usize = 5;

const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Why a record is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum RecordError {
    /// The room for it is too small.
    TooLarge,
    /// Its shape does not fit: never written by this firmware.
    Damaged,
    /// Written by a firmware with another layout.
    Version {
        /// Its layout.
        found: u8,
    },
    /// Written by a firmware for another finger or drivetrain.
    OtherScene,
    /// Whole, but a value in it makes no sense.
    Implausible,
}

/// Something that can be kept.
pub trait Keep: Serialize + DeserializeOwned {
    /// Whether every value is finite and in its range. Asked after reading, before anything is used.
    fn is_plausible(&self) -> bool;
}

/// Mark of a scene: its name and every number that a friction record or a calibration depends on.
///
/// A firmware that was built for another finger, or for the same one with other dimensions, does not take the record.
pub fn scene_mark(name: &str, numbers: impl IntoIterator<Item = f32>) -> u32 {
    let mut digest = CHECKSUM.digest();
    digest.update(name.as_bytes());
    for number in numbers {
        digest.update(&number.to_bits().to_le_bytes());
    }
    digest.finalize()
}

/// Writes a record.
///
/// # Errors
/// [`RecordError::TooLarge`] where there is too little room.
pub fn encode<O>(
    content: &impl Keep,
    scene: u32,
    mut room: impl Flavor<Output = O>,
) -> Result<O, RecordError> {
    let [a, b, c, d] = scene.to_le_bytes();
    room.try_extend(&[VERSION, a, b, c, d])
        .and_then(|()| postcard::serialize_with_flavor(content, room))
        .map_err(|_| RecordError::TooLarge)
}

/// Reads a record.
///
/// # Errors
/// Why it must not be used: nothing of it is, then.
pub fn decode<T: Keep>(bytes: &[u8], scene: u32) -> Result<T, RecordError> {
    let ([found, mark @ ..], content) = bytes
        .split_first_chunk::<HEADER>()
        .ok_or(RecordError::Damaged)?;
    // The layout decides how to read on.
    if *found != VERSION {
        return Err(RecordError::Version { found: *found });
    }
    if u32::from_le_bytes(*mark) != scene {
        return Err(RecordError::OtherScene);
    }
    let (kept, rest): (T, &[u8]) =
        postcard::take_from_bytes(content).map_err(|_| RecordError::Damaged)?;
    if !rest.is_empty() {
        return Err(RecordError::Damaged);
    }
    kept.is_plausible()
        .then_some(kept)
        .ok_or(RecordError::Implausible)
}

#[cfg(test)]
mod tests {
    use super::*;
    use postcard::ser_flavors::Slice;
    use proptest::prelude::*;
    use serde::Deserialize;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Sheet {
        gain: f32,
        table: heapless::Vec<f32, 64>,
        note: Option<u16>,
    }

    impl Keep for Sheet {
        fn is_plausible(&self) -> bool {
            self.gain > 0.0 && self.table.iter().all(|value| value.is_finite())
        }
    }

    fn sheet() -> Sheet {
        Sheet {
            gain: 0.33,
            table: (0..48).map(|i| i as f32 * 0.01).collect(),
            note: Some(7),
        }
    }

    fn encoded(content: &Sheet, scene: u32) -> Vec<u8> {
        let mut buffer = [0; 512];
        encode(content, scene, Slice::new(&mut buffer))
            .expect("fits")
            .to_vec()
    }

    #[test]
    fn what_was_written_is_read_back() {
        assert_eq!(decode::<Sheet>(&encoded(&sheet(), 99), 99), Ok(sheet()));
    }

    #[test]
    fn every_truncation_and_every_excess_is_noticed() {
        let bytes = encoded(&sheet(), 99);
        for length in 0..bytes.len() {
            assert!(decode::<Sheet>(&bytes[..length], 99).is_err(), "{length}");
        }
        assert_eq!(
            decode::<Sheet>(&[&bytes[..], &[0]].concat(), 99),
            Err(RecordError::Damaged)
        );
    }

    #[test]
    fn a_foreign_scene_another_layout_and_nonsense_are_told_apart() {
        let bytes = encoded(&sheet(), 99);
        assert_eq!(decode::<Sheet>(&bytes, 98), Err(RecordError::OtherScene));
        let mut newer = bytes;
        newer[0] = VERSION + 1;
        assert_eq!(
            decode::<Sheet>(&newer, 99),
            Err(RecordError::Version { found: VERSION + 1 })
        );
        let nonsense = Sheet {
            gain: f32::NAN,
            ..sheet()
        };
        assert_eq!(
            decode::<Sheet>(&encoded(&nonsense, 99), 99),
            Err(RecordError::Implausible)
        );
    }

    #[test]
    fn a_buffer_that_is_too_small_is_said() {
        let length = encoded(&sheet(), 99).len();
        for room in 0..length {
            let mut buffer = vec![0; room];
            assert_eq!(
                encode(&sheet(), 99, Slice::new(&mut buffer)),
                Err(RecordError::TooLarge),
                "{room}"
            );
        }
        assert!(encode(&sheet(), 99, Slice::new(&mut vec![0; length])).is_ok());
    }

    #[test]
    fn the_mark_of_a_scene_tells_every_number() {
        let mark = scene_mark("p70", [0.09, 0.07]);
        assert_eq!(mark, scene_mark("p70", [0.09, 0.07]));
        assert_ne!(mark, scene_mark("p71", [0.09, 0.07]));
        assert_ne!(mark, scene_mark("p70", [0.07, 0.09]));
        assert_ne!(mark, scene_mark("p70", [0.09, 0.070_000_01]));
    }

    proptest! {
        #[test]
        fn any_bytes_are_refused_or_plausible(bytes in proptest::collection::vec(any::<u8>(), 0..600), scene: u32) {
            if let Ok(kept) = decode::<Sheet>(&bytes, scene) {
                prop_assert!(kept.is_plausible());
            }
        }
    }
}
