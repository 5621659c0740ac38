//! What survives a power cut, as one record.

use super::record::{Bytes, Keep, scene_mark};
use super::settings::Overrides;
use crate::scene::Scene;
use crate::sensing::friction::{Bins, Evidence};
use crate::sensing::{Calibration, Friction};

/// Settings, friction record and calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// What the user has set.
    pub overrides: Overrides,
    /// The friction record.
    pub friction: Option<Friction>,
    /// Torque factor and cable.
    pub calibration: Calibration,
}

impl Kept {
    /// Nothing set, nothing recorded, the scene's calibration: what a record is read into.
    pub fn nothing<S: Scene>() -> Self {
        Self {
            overrides: Overrides::default(),
            friction: None,
            calibration: S::UNCALIBRATED,
        }
    }
}

impl Keep for Kept {
    // Taken apart field by field, so that none that is added can be forgotten.
    fn bytes(&mut self, bytes: &mut impl Bytes) {
        let Self {
            overrides: Overrides { values_si },
            friction,
            calibration,
        } = self;
        for value in values_si {
            if let Some(value) = bytes.option(value, || 0.0) {
                bytes.float(value);
            }
        }
        if let Some(friction) = bytes.option(friction, || Friction::EMPTY) {
            let Friction {
                travel_counts,
                bin_counts,
                worm_counts,
                rad_per_count,
                speed_rad_per_s,
                closing_nm: Bins { mean, count },
                worm_nm,
                opening_nm,
                white_nm2_s,
                evidence: Evidence { ln_likelihood },
            } = friction;
            bytes.integer(travel_counts);
            for counts in [bin_counts, worm_counts] {
                let mut signed = counts.cast_signed();
                bytes.integer(&mut signed);
                *counts = signed.cast_unsigned();
            }
            for count in count {
                bytes.byte(count);
            }
            for value in [rad_per_count, speed_rad_per_s, opening_nm, white_nm2_s] {
                bytes.float(value);
            }
            for value in mean.iter_mut().chain(worm_nm).chain(ln_likelihood) {
                bytes.float(value);
            }
        }
        let Calibration {
            torque_factor,
            torque_factor_sigma,
            cable_rad_per_nm,
            cable_sigma_rad_per_nm,
            correlation,
            contacts,
            presses,
        } = calibration;
        bytes.float(torque_factor);
        bytes.float(torque_factor_sigma);
        bytes.float(cable_rad_per_nm);
        bytes.float(cable_sigma_rad_per_nm);
        bytes.float(correlation);
        bytes.byte(contacts);
        bytes.byte(presses);
    }

    fn is_plausible(&self) -> bool {
        self.overrides.is_valid()
            && self.calibration.is_valid()
            && self.friction.as_ref().is_none_or(Friction::is_valid)
    }
}

/// Mark of a scene, for [`encode`](super::record::encode) and [`decode`](super::record::decode): what a friction record and a
/// calibration depend on.
pub const fn mark<S: Scene>() -> u32 {
    let drive = &S::DRIVE;
    scene_mark(
        S::NAME,
        &[
            drive.motor.torque_constant_nm_per_a,
            drive.drivetrain.counts_per_motor_rev,
            drive.drivetrain.reduction,
            drive.sense.volt_per_a,
            drive.sense.reference_v,
            S::TRAVEL_RAD,
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::record::{RecordError, decode, encode};
    use crate::app::settings::Setting;
    use crate::app::store::RECORD_MAX;
    use crate::scene::P70;

    fn kept() -> Kept {
        let mut overrides = Overrides::default();
        overrides.set(Setting::HoldForce, 2.5).expect("in range");
        let drivetrain = P70::drivetrain(&P70::MECHANISM);
        let mut friction = Friction::empty(240_000, &drivetrain);
        for (index, torque) in friction.closing_nm.mean.iter_mut().enumerate() {
            *torque = 0.01 + 1e-4 * index as f32;
        }
        friction.closing_nm.count.fill(3);
        friction.speed_rad_per_s = 0.3;
        friction.worm_nm = [-1e-3; _];
        friction.opening_nm = -0.02;
        friction.white_nm2_s = 2e-8;
        friction.evidence.ln_likelihood = [-1.5; _];
        let mut calibration = P70::UNCALIBRATED;
        calibration.torque_factor = 0.9;
        calibration.contacts = 2;
        Kept {
            overrides,
            friction: Some(friction),
            calibration,
        }
    }

    fn encoded(kept: &mut Kept) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(kept, mark::<P70>(), |byte| bytes.push(byte));
        bytes
    }

    fn decoded(bytes: &[u8]) -> Result<Kept, RecordError> {
        let mut read = Kept::nothing::<P70>();
        decode(bytes, mark::<P70>(), &mut read).map(|()| read)
    }

    #[test]
    fn what_is_kept_comes_back_and_fits() {
        let mut longest = kept();
        for setting in Setting::ALL {
            let range = setting.range();
            let value_si = range.to_si(range.min).expect("in range");
            longest.overrides.set(setting, value_si).expect("in range");
        }
        for mut kept in [kept(), Kept::nothing::<P70>(), longest] {
            let bytes = encoded(&mut kept);
            assert!(bytes.len() <= RECORD_MAX, "{} bytes", bytes.len());
            assert_eq!(decoded(&bytes), Ok(kept));
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let mut nonsense = kept();
        nonsense.calibration.torque_factor = -1.0;
        assert_eq!(
            decoded(&encoded(&mut nonsense)),
            Err(RecordError::Implausible)
        );
        let mut nonsense = kept();
        if let Some(friction) = &mut nonsense.friction {
            friction.closing_nm.mean[127] = f32::NAN;
        }
        assert_eq!(
            decoded(&encoded(&mut nonsense)),
            Err(RecordError::Implausible)
        );
    }
}
