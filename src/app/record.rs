//! What survives a power cut: one record with a version and the mark of the scene it belongs to.
//!
//! Settings, friction record and calibration are kept in one record, so that a save either happened or did not: no mix
//! of old and new can be read back. Where it is kept, how damage is noticed and wear is levelled, is the
//! [store](super::store)'s business.

use crc::{CRC_32_ISCSI, Crc, NoTable};

/// Layout of the record. Raise it whenever what is kept changes its meaning or its shape.
pub const VERSION: u8 = 2;

const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Why a record is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError {
    /// Too short or too long: never written by this firmware.
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
pub trait Keep {
    /// Hands over every value that is kept, in the order in which they are kept, to be written or to be replaced by what is
    /// read: one description for both ways.
    fn bytes(&mut self, bytes: &mut impl Bytes);

    /// Whether every value is finite and in its range. Asked after reading, before anything is used.
    fn is_plausible(&self) -> bool;
}

/// What takes the bytes of a record, or gives them.
pub trait Bytes {
    /// A byte.
    fn byte(&mut self, byte: &mut u8);

    /// Four bytes, the lowest first.
    fn word(&mut self, word: &mut u32) {
        let mut bytes = word.to_le_bytes();
        for byte in &mut bytes {
            self.byte(byte);
        }
        *word = u32::from_le_bytes(bytes);
    }

    /// A number.
    fn float(&mut self, value: &mut f32) {
        let mut word = value.to_bits();
        self.word(&mut word);
        *value = f32::from_bits(word);
    }

    /// A number.
    fn integer(&mut self, value: &mut i32) {
        let mut word = value.cast_unsigned();
        self.word(&mut word);
        *value = word.cast_signed();
    }

    /// Whether there is a value, which is to follow if there is; `blank` makes the place that it is read into.
    fn option<'v, T>(
        &mut self,
        value: &'v mut Option<T>,
        blank: impl FnOnce() -> T,
    ) -> Option<&'v mut T> {
        let mut known = u8::from(value.is_some());
        self.byte(&mut known);
        if known == 0 {
            *value = None;
        } else if value.is_none() {
            *value = Some(blank());
        }
        value.as_mut()
    }
}

/// Mark of a scene: its name and every number that a friction record or a calibration depends on.
///
/// A firmware that was built for another finger, or for the same one with other dimensions, does not take the record.
pub const fn scene_mark(name: &str, numbers: &[f32]) -> u32 {
    let mut digest = CHECKSUM.digest();
    digest.update(name.as_bytes());
    let mut rest = numbers;
    while let [number, behind @ ..] = rest {
        digest.update(&number.to_bits().to_le_bytes());
        rest = behind;
    }
    digest.finalize()
}

/// Writes a record, byte by byte. `content` stays as it is.
pub fn encode(content: &mut impl Keep, scene: u32, put: impl FnMut(u8)) {
    let mut writer = Writer(put);
    let (mut version, mut scene) = (VERSION, scene);
    writer.byte(&mut version);
    writer.word(&mut scene);
    content.bytes(&mut writer);
}

struct Writer<F>(F);

impl<F: FnMut(u8)> Bytes for Writer<F> {
    fn byte(&mut self, byte: &mut u8) {
        (self.0)(*byte);
    }
}

/// Reads a record into `content`.
///
/// # Errors
/// Why it must not be used: what is in `content` is of no use, then.
pub fn decode(bytes: &[u8], scene: u32, content: &mut impl Keep) -> Result<(), RecordError> {
    let mut reader = Reader {
        rest: bytes,
        short: false,
    };
    let (mut found, mut mark) = (0, 0);
    reader.byte(&mut found);
    reader.word(&mut mark);
    if reader.short {
        return Err(RecordError::Damaged);
    }
    // The layout decides how to read on.
    if found != VERSION {
        return Err(RecordError::Version { found });
    }
    if mark != scene {
        return Err(RecordError::OtherScene);
    }
    content.bytes(&mut reader);
    if reader.short || !reader.rest.is_empty() {
        return Err(RecordError::Damaged);
    }
    if content.is_plausible() {
        Ok(())
    } else {
        Err(RecordError::Implausible)
    }
}

struct Reader<'b> {
    rest: &'b [u8],
    /// More was asked for than is there.
    short: bool,
}

impl Bytes for Reader<'_> {
    #[inline(never)]
    fn byte(&mut self, byte: &mut u8) {
        *byte = match self.rest {
            [first, rest @ ..] => {
                self.rest = rest;
                *first
            }
            [] => {
                self.short = true;
                0
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Clone, Debug, Default, PartialEq)]
    struct Sheet {
        gain: f32,
        steps: i32,
        note: Option<u8>,
        table: Option<Vec<f32>>,
    }

    impl Keep for Sheet {
        fn bytes(&mut self, bytes: &mut impl Bytes) {
            bytes.float(&mut self.gain);
            bytes.integer(&mut self.steps);
            if let Some(note) = bytes.option(&mut self.note, || 0) {
                bytes.byte(note);
            }
            if let Some(table) = bytes.option(&mut self.table, || vec![0.0; 48]) {
                table.iter_mut().for_each(|value| bytes.float(value));
            }
        }

        fn is_plausible(&self) -> bool {
            let mut table = self.table.iter().flatten();
            self.gain > 0.0 && table.all(|value| value.is_finite())
        }
    }

    fn sheet() -> Sheet {
        Sheet {
            gain: 0.33,
            steps: -1_234_567,
            note: Some(7),
            table: Some((0..48).map(|i| i as f32 * 0.01).collect()),
        }
    }

    fn encoded(content: &Sheet, scene: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut copy = content.clone();
        encode(&mut copy, scene, |byte| bytes.push(byte));
        assert!(copy == *content || !content.gain.is_finite());
        bytes
    }

    fn decoded(bytes: &[u8], scene: u32) -> Result<Sheet, RecordError> {
        let mut read = Sheet::default();
        decode(bytes, scene, &mut read).map(|()| read)
    }

    #[test]
    fn what_was_written_is_read_back() {
        assert_eq!(decoded(&encoded(&sheet(), 99), 99), Ok(sheet()));
        for sheet in [
            Sheet {
                note: None,
                ..sheet()
            },
            Sheet {
                table: None,
                ..sheet()
            },
        ] {
            let bytes = encoded(&sheet, 99);
            assert_eq!(decoded(&bytes, 99), Ok(sheet.clone()));
            // Whatever was there before.
            let mut read = self::sheet();
            assert_eq!(decode(&bytes, 99, &mut read), Ok(()));
            assert_eq!(read, sheet);
        }
    }

    #[test]
    fn every_truncation_and_every_excess_is_noticed() {
        let bytes = encoded(&sheet(), 99);
        for length in 0..bytes.len() {
            assert!(decoded(&bytes[..length], 99).is_err(), "{length}");
        }
        assert_eq!(
            decoded(&[&bytes[..], &[0]].concat(), 99),
            Err(RecordError::Damaged)
        );
    }

    #[test]
    fn a_foreign_scene_another_layout_and_nonsense_are_told_apart() {
        let bytes = encoded(&sheet(), 99);
        assert_eq!(decoded(&bytes, 98), Err(RecordError::OtherScene));
        let mut newer = bytes;
        newer[0] = VERSION + 1;
        assert_eq!(
            decoded(&newer, 99),
            Err(RecordError::Version { found: VERSION + 1 })
        );
        let nonsense = Sheet {
            gain: f32::NAN,
            ..sheet()
        };
        assert_eq!(
            decoded(&encoded(&nonsense, 99), 99),
            Err(RecordError::Implausible)
        );
    }

    #[test]
    fn the_mark_of_a_scene_tells_every_number() {
        let mark = scene_mark("p70", &[0.09, 0.07]);
        assert_eq!(mark, scene_mark("p70", &[0.09, 0.07]));
        assert_ne!(mark, scene_mark("p71", &[0.09, 0.07]));
        assert_ne!(mark, scene_mark("p70", &[0.07, 0.09]));
        assert_ne!(mark, scene_mark("p70", &[0.09, 0.070_000_01]));
    }

    proptest! {
        #[test]
        fn any_bytes_are_refused_or_plausible(bytes in proptest::collection::vec(any::<u8>(), 0..600), scene: u32) {
            if let Ok(kept) = decoded(&bytes, scene) {
                prop_assert!(kept.is_plausible());
            }
        }
    }
}
