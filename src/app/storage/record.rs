//! The record that survives a power cut: settings, friction record and calibration, with a version and the ID of the scene
//! that it belongs to.
//!
//! All is kept in one record, so that a save either happened or did not: no mix of old and new can be read back. Where it
//! is kept, how damage is noticed and wear is levelled, is the [store](super::store)'s task.

use zerocopy::{FromBytes, IntoBytes};

use super::store::CHECKSUM;
use crate::app::console::settings::Overrides;
use crate::drive::identify::Identified;
use crate::scene::Scene;
use crate::sensing::{Calibration, Friction};

/// Layout of the record. Raise it whenever what is kept changes its meaning or its shape.
pub const VERSION: u8 = 12;

const IDENTIFIED_BYTES: usize = size_of::<Identified>();

/// Settings, calibration and friction record, borrowed: together they are long, and each move would be a copy on the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<'a> {
    /// What the user has set.
    pub overrides: &'a Overrides,
    /// What was calibrated.
    pub calibration: &'a Calibration,
    /// The friction record.
    pub friction: Option<&'a Friction>,
    /// What was identified of the motor; a record ends before it where nothing was.
    pub identified: Option<&'a Identified>,
}

/// Why a record is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError {
    /// Too short, too long, or no value of its type: never written by this firmware.
    Damaged,
    /// Written by a firmware with another layout.
    Version {
        /// Its layout.
        found: u8,
    },
    /// Written by a firmware for another finger or drivetrain.
    OtherScene,
    /// Whole, but a value in it is out of its range.
    Implausible,
}

impl RecordError {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Damaged => "damaged",
            Self::Version { .. } => "other-version",
            Self::OtherScene => "other-scene",
            Self::Implausible => "implausible",
        }
    }
}

impl Record<'_> {
    /// Writes the record, byte by byte: numbers as the chip has them, the least byte first.
    pub fn encode(&self, scene: u32, mut put: impl FnMut(u8)) {
        let friction = self.friction.map_or::<&[u8], _>(&[], IntoBytes::as_bytes);
        let parts: [&[u8]; 7] = [
            &[VERSION],
            scene.as_bytes(),
            self.overrides.as_bytes(),
            self.calibration.as_bytes(),
            &[u8::from(self.friction.is_some())],
            friction,
            self.identified.map_or::<&[u8], _>(&[], IntoBytes::as_bytes),
        ];
        for byte in parts.into_iter().flatten() {
            put(*byte);
        }
    }

    /// Reads a record and hands it over; with what was identified, or, in a firmware that does not use it, without.
    ///
    /// # Errors
    /// Why it must not be used.
    pub fn decode<const IDENTIFIED: bool, R>(
        bytes: &[u8],
        scene: u32,
        take: impl FnOnce(&Record<'_>) -> R,
    ) -> Result<R, RecordError> {
        let (found, bytes) = bytes.split_first().ok_or(RecordError::Damaged)?;
        let (id, bytes) = bytes.split_first_chunk().ok_or(RecordError::Damaged)?;
        // The layout decides how to read on.
        if *found != VERSION {
            return Err(RecordError::Version { found: *found });
        }
        if u32::from_le_bytes(*id) != scene {
            return Err(RecordError::OtherScene);
        }
        // One after the other, as they were written: the friction record stays where it was read to.
        let (overrides, bytes) = next(bytes)?;
        let (calibration, bytes) = next(bytes)?;
        let (friction, bytes) = match bytes.split_first() {
            Some((0, bytes)) => (&None, bytes),
            Some((1, bytes)) => {
                let (friction, bytes) = next::<Friction>(bytes)?;
                (&Some(friction), bytes)
            }
            _ => return Err(RecordError::Damaged),
        };
        let identified = match bytes.len() {
            0 => None,
            IDENTIFIED_BYTES if IDENTIFIED => {
                let (identified, _) = next::<Identified>(bytes)?;
                if !identified.is_valid() {
                    return Err(RecordError::Implausible);
                }
                Some(identified)
            }
            IDENTIFIED_BYTES => None,
            _ => return Err(RecordError::Damaged),
        };
        let record = Record {
            overrides: &overrides,
            calibration: &calibration,
            friction: friction.as_ref(),
            identified: identified.as_ref(),
        };
        if record.is_plausible() {
            Ok(take(&record))
        } else {
            Err(RecordError::Implausible)
        }
    }

    /// Whether every value is finite and in its range.
    fn is_plausible(&self) -> bool {
        self.overrides.is_valid()
            && self.calibration.is_valid()
            && self.friction.is_none_or(Friction::is_valid)
    }
}

/// A part of a record, and the bytes behind it.
fn next<T: FromBytes>(bytes: &[u8]) -> Result<(T, &[u8]), RecordError> {
    T::read_from_prefix(bytes).map_err(|_| RecordError::Damaged)
}

/// ID of a scene: its name and every number that a friction record or a calibration depends on. A firmware that was built for
/// another finger, or for the same one with other dimensions, does not take the record.
pub const fn scene_id<S: Scene>() -> u32 {
    let mut digest = CHECKSUM.digest();
    digest.update(S::NAME.as_bytes());
    digest.update(S::DIMENSIONS.as_bytes());
    digest.finalize()
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::app::console::settings::Setting;
    use crate::app::storage::store::RECORD_MAX;
    use crate::drive::identify::Estimate;
    use crate::scene::P70;
    use proptest::prelude::*;

    const ID: u32 = scene_id::<P70>();

    /// What a record borrows.
    #[derive(Clone, Debug, PartialEq)]
    struct StoredRecord {
        overrides: Overrides,
        calibration: Calibration,
        friction: Option<Friction>,
        identified: Option<Identified>,
    }

    impl StoredRecord {
        fn of(record: &Record<'_>) -> Self {
            Self {
                overrides: *record.overrides,
                calibration: *record.calibration,
                friction: record.friction.cloned(),
                identified: record.identified.copied(),
            }
        }

        fn record(&self) -> Record<'_> {
            Record {
                overrides: &self.overrides,
                calibration: &self.calibration,
                friction: self.friction.as_ref(),
                identified: self.identified.as_ref(),
            }
        }
    }

    fn empty() -> StoredRecord {
        StoredRecord {
            overrides: Overrides::default(),
            calibration: P70::UNCALIBRATED,
            friction: None,
            identified: None,
        }
    }

    fn record() -> StoredRecord {
        let mut overrides = Overrides::default();
        overrides.set(Setting::HoldForce, 2.5).expect("in range");
        let drivetrain = P70::drivetrain(&P70::MECHANISM);
        let mut friction = Friction::empty(240_000, &drivetrain);
        for (index, torque) in friction.closing_nm.mean.iter_mut().enumerate() {
            *torque = 0.01 + 1e-4 * index as f32;
        }
        friction.closing_nm.count.fill(3);
        friction.speed_rad_per_s = 0.3;
        friction.worm_nm.fill(-1e-3);
        friction.opening_nm = -0.02;
        friction.white_nm2_s = 2e-8;
        friction.evidence.ln_likelihood.fill(-1.5);
        let mut calibration = P70::UNCALIBRATED;
        calibration.torque_factor = 0.9;
        calibration.contacts = 2;
        StoredRecord {
            overrides,
            calibration,
            friction: Some(friction),
            identified: Some(Identified {
                estimates: [Estimate {
                    value: 35.0,
                    sigma: 1.0,
                }; 5],
            }),
        }
    }

    fn encoded(kept: &StoredRecord) -> Vec<u8> {
        let mut bytes = Vec::new();
        kept.record().encode(ID, |byte| bytes.push(byte));
        bytes
    }

    fn decoded(bytes: &[u8]) -> Result<StoredRecord, RecordError> {
        Record::decode::<true, _>(bytes, ID, StoredRecord::of)
    }

    #[test]
    fn what_is_kept_comes_back_and_fits() {
        let mut longest = record();
        for setting in Setting::ALL {
            let range = setting.range();
            let value_si = range.to_si(range.min).expect("in range");
            longest.overrides.set(setting, value_si).expect("in range");
        }
        for record in [record(), empty(), longest] {
            let bytes = encoded(&record);
            assert!(bytes.len() <= RECORD_MAX, "{} bytes", bytes.len());
            assert_eq!(decoded(&bytes), Ok(record));
        }
    }

    #[test]
    fn every_truncation_and_every_excess_is_noticed() {
        let bytes = encoded(&record());
        // Without what was identified it is a record of before that was kept.
        let before = bytes.len() - 5 * 8;
        for length in 0..bytes.len() {
            let read = decoded(&bytes[..length]);
            if length == before {
                let identified = None;
                assert_eq!(
                    read,
                    Ok(StoredRecord {
                        identified,
                        ..record()
                    })
                );
            } else {
                assert!(read.is_err(), "{length}");
            }
        }
        assert_eq!(
            decoded(&[&bytes[..], &[0]].concat()),
            Err(RecordError::Damaged)
        );
    }

    #[test]
    fn a_firmware_that_identifies_nothing_reads_the_rest() {
        let identified = None;
        let without = Ok(StoredRecord {
            identified,
            ..record()
        });
        let bytes = encoded(&record());
        assert_eq!(
            Record::decode::<false, _>(&bytes, ID, StoredRecord::of),
            without
        );
        let mut nonsense = bytes;
        let value = nonsense.len() - 40;
        nonsense[value..value + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(decoded(&nonsense), Err(RecordError::Implausible));
    }

    #[test]
    fn a_foreign_scene_another_layout_and_nonsense_are_told_apart() {
        let bytes = encoded(&record());
        assert_eq!(
            Record::decode::<true, _>(&bytes, ID ^ 1, |_| ()),
            Err(RecordError::OtherScene)
        );
        let mut newer = bytes;
        newer[0] = VERSION + 1;
        assert_eq!(
            decoded(&newer),
            Err(RecordError::Version { found: VERSION + 1 })
        );
        let mut nonsense = record();
        nonsense.calibration.torque_factor = -1.0;
        assert_eq!(decoded(&encoded(&nonsense)), Err(RecordError::Implausible));
        let mut nonsense = record();
        if let Some(friction) = &mut nonsense.friction {
            friction.closing_nm.mean[127] = f32::NAN;
        }
        assert_eq!(decoded(&encoded(&nonsense)), Err(RecordError::Implausible));
    }

    proptest! {
        #[test]
        fn any_bytes_are_refused_or_plausible(noise in proptest::collection::vec(any::<u8>(), 0..1500)) {
            let mut bytes = vec![VERSION];
            bytes.extend(ID.to_le_bytes());
            bytes.extend(noise);
            if let Ok(record) = decoded(&bytes) {
                prop_assert!(record.record().is_plausible());
            }
        }

        /// A few wrong bytes in a whole record: most decode, some to nonsense.
        #[test]
        fn a_damaged_record_is_refused_or_plausible(
            wrong in proptest::collection::vec((5_usize..1200, any::<u8>()), 1..4),
        ) {
            let mut bytes = encoded(&record());
            for (at, value) in wrong {
                let at = at % bytes.len();
                if at >= 5 {
                    bytes[at] = value;
                }
            }
            if let Ok(record) = decoded(&bytes) {
                prop_assert!(record.record().is_plausible());
            }
        }
    }
}
