//! Calibration from a contact at a known place or a press on the closing stop.

use super::contact::Contact;
use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::Learned;
use crate::sensing::{Calibration, Directive, Event, Refusal};

/// Standard deviation of the closing stop's compliance, radian per newton metre (R, chosen); a fit attributes it to the cable.
const STOP_YIELD_RAD_PER_NM: f32 = 4e-3;
/// Model error of the cable in a press, as a share of its twist: it stiffens with the load, and its creep differs from the
/// nominal one (R, chosen).
const PRESS_SHARE: f32 = 0.02;
/// Share of the free travel before which nothing is the closing stop.
const BEFORE_STOP: f32 = 0.9;

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    pub(super) fn is_calibrating(&self) -> bool {
        matches!(
            self.directive,
            Directive::Calibrate { .. } | Directive::CalibrateCable
        )
    }

    /// Calibration from the curve of a contact at a known place or with the stop.
    pub(super) fn learn(&self, contact: &mut Contact<F, H, X>) -> Result<Calibration, Refusal> {
        if let Directive::CalibrateCable = self.directive {
            if !X::FLEXIBLE {
                return Err(Refusal::Uninformative);
            }
            return self.learn_from_press(contact);
        }
        if let Directive::Calibrate { phalanx, k_m } = self.directive {
            // The friction record did not fit on the way to the pin: part of the curve may be friction.
            if self.stale_told {
                return Err(Refusal::Misfit);
            }
            let length_m = self
                .finger
                .phalanx_length_m(phalanx)
                .ok_or(Refusal::NoSuchPlace)?;
            if !(phalanx > 1 && k_m > 0.0 && k_m <= length_m) {
                return Err(Refusal::NoSuchPlace);
            }
        }
        let Learned {
            calibration,
            misfit,
            strain,
        } = contact
            .locator
            .learned(&self.prior(&contact.collector))
            .ok_or(Refusal::Misfit)?;
        self.calibration.with_contact(&calibration, misfit, strain)
    }

    // Not inlined, so that its symbol shows whether a scene carries it: one without a cable must not.
    #[inline(never)]
    fn learn_from_press(&self, contact: &mut Contact<F, H, X>) -> Result<Calibration, Refusal> {
        let closed_rad = contact.collector.onset_rad[0] - self.drivetrain.opening_stop_rad;
        if closed_rad < BEFORE_STOP * self.settings.travel_rad {
            return Err(Refusal::Misfit);
        }
        let Learned {
            calibration: mut found,
            misfit,
            ..
        } = contact
            .locator
            .learned(&self.prior(&contact.collector))
            .ok_or(Refusal::Misfit)?;
        let sigma = found.cable_sigma_rad_per_nm;
        let model = PRESS_SHARE * found.cable_rad_per_nm;
        found.cable_sigma_rad_per_nm =
            sqrt(sigma * sigma + model * model + STOP_YIELD_RAD_PER_NM * STOP_YIELD_RAD_PER_NM);
        self.calibration.with_press(&found, misfit)
    }

    pub(super) fn emit_calibration(&mut self, learned: Result<Calibration, Refusal>) {
        match learned {
            Ok(calibration) => {
                self.calibration = calibration;
                self.emit(Event::Calibrated { calibration });
            }
            Err(why) => self.emit(Event::CalibrationRefused { why }),
        }
    }
}
